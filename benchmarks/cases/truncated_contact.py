"""Ellipses longer than the flank: laws of laminae and of edges, half-spaces on the true flanks."""

from typing import Literal, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import largest_pressure, pressure_ratio, stage_contact
from prsm_jax.fields import as_scalar
from prsm_jax.geometry import mesh
from prsm_jax.halfspace import flank_contact
from prsm_jax.mechanism import Material, Stage, Thread
from prsm_jax.strength import side_edges, side_onsets

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references.meshing import Design
from ..references.truncated import contact_pressure, hertz_pressure, pressures

_MODULUS = 210e9 / (1 - 0.3**2) / 2
_LABEL = "pressure at the contact point"
#: Leads of a 30 mm screw with five starts [m], Hertz pressures [Pa]; addenda 0.2 pitch. They cut
#: between a tenth and three quarters of the half-extent.
_INSTANCES = (
    (5e-3, 3.5e9),
    (2e-3, 2.0e9),
    (5e-3, 4.2e9),
    (3e-3, 3.5e9),
    (2e-3, 3.0e9),
    (2e-3, 4.2e9),
)
_ADDENDUM = 0.2
#: Of the crests' edges, where they are rounded [m].
_EDGE_RADIUS = 0.2e-3
_AT_EDGE = "largest pressure, crests rounded by 0.2 mm"


def _design(lead: float) -> Design:
    return Design(lead, 5.0, 5e-3, np.pi / 4, 5e-3 / np.sin(np.pi / 4))


def _stage(lead: float) -> Stage:
    height = as_scalar(_ADDENDUM * lead / 5)
    thread = Thread(
        as_scalar(lead),
        as_scalar(5.0),
        as_scalar(5e-3),
        as_scalar(np.pi / 4),
        screw_addendum=height,
        roller_addendum=height,
        edge_radius=as_scalar(_EDGE_RADIUS),
    )
    steel = Material(as_scalar(210e9), as_scalar(0.3), as_scalar(7850.0))
    return Stage(thread, 10, material=steel, engaged_threads=as_scalar(20.0))


def _forces(side: str, instances) -> list[float]:
    """Axial forces of one contact that give the Hertz pressures [N]."""
    forces = []
    for lead, pressure in instances:
        unit, _, _ = hertz_pressure(_design(lead), side, 100.0, _MODULUS)
        forces.append(100.0 * (pressure / unit) ** 3)
    return forces


def _stacked(instances, forces):
    stages = [_stage(lead) for lead, _ in instances]
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves), *stages)
    # 10 rollers of 20 threads.
    return stacked, jnp.asarray(forces) * 200


def _named(label: str):
    return lambda values: {label: np.asarray(values)}


_Law: TypeAlias = Literal["Hertz, whole ellipse", "prsm_jax, laminae", "prsm_jax, rounded edge"]


def _law(side: str, instances, forces, law: _Law, label: str) -> Method:
    stages, loads = _stacked(instances, forces)

    def one(stage, load):
        meshing = mesh(stage.thread)
        pressure = getattr(stage_contact(stage, load, meshing), side).hertz.max_pressure
        if law == "Hertz, whole ellipse":
            return pressure
        sides = side_onsets(stage, meshing)
        assert sides is not None
        onset = sides[("screw", "nut").index(side)]
        assert onset is not None
        if law == "prsm_jax, rounded edge":
            edges = side_edges(stage, meshing)[("screw", "nut").index(side)]
            return largest_pressure(pressure, onset.onsets, edges)
        return pressure * pressure_ratio(pressure, onset.onsets)

    def prepare(_):
        solver = eqx.filter_jit(eqx.filter_vmap(one))
        return Prepared(lambda: solver(stages, loads), len(instances), _named(label))

    return Method(law, prepare, kind="approximation")


def _half_spaces(side: str, instances, forces, cells, label: str = _LABEL) -> Method:
    stages, loads = _stacked(instances, forces)

    def prepare(count):
        def one(given):
            stage, load = given
            if label != _AT_EDGE:
                stage = eqx.tree_at(lambda s: s.thread.edge_radius, stage, None)
            found = flank_contact(stage, side, load, (count, count), extent=1.45, tolerance=1e-6)
            if label == _AT_EDGE:
                return found.surface.max_pressure
            near = slice(count // 2 - 1, count // 2 + 1)
            return jnp.sqrt(jnp.mean(found.surface.pressure[near, near] ** 2))

        solver = eqx.filter_jit(lambda s, f: jax.lax.map(one, (s, f)))
        return Prepared(lambda: solver(stages, loads), len(instances), _named(label))

    return Method("prsm_jax, half-spaces on the flanks", prepare, cells, "cells along a side")


def _reference(label: str, side: str, instances, forces, ratio_of, cells: int):
    """Pressures by half-spaces in NumPy; `ratio_of` gives them over those of Hertz."""
    values = []
    for (lead, pressure), force in zip(instances, forces, strict=True):
        height = _ADDENDUM * lead / 5
        ratio = ratio_of(_design(lead), side, (height, height), force, _MODULUS, cells)
        values.append(ratio * pressure)
    return {label: Reference(np.asarray(values))}


def _problem(side: str, instances, cells, reference_cells: int) -> Problem:
    forces = _forces(side, instances)
    methods = [
        _law(side, instances, forces, "prsm_jax, laminae", _LABEL),
        _law(side, instances, forces, "Hertz, whole ellipse", _LABEL),
        _half_spaces(side, instances, forces, cells),
    ]
    return _compared(
        side, f"Ellipses cut by the crests, {side} side", methods, "sharp", reference_cells,
        lambda: _reference(_LABEL, side, instances, forces, contact_pressure, reference_cells),
    )  # fmt: skip


def _edge_problem(side: str, instances, cells, reference_cells: int) -> Problem:
    forces = _forces(side, instances)

    def largest(design, side, addenda, force, modulus, cells):
        return pressures(design, side, addenda, force, modulus, cells, _EDGE_RADIUS)[1]

    methods = [
        _law(side, instances, forces, "prsm_jax, rounded edge", _AT_EDGE),
        # What the law of laminae leaves out.
        _law(side, instances, forces, "prsm_jax, laminae", _AT_EDGE),
        _half_spaces(side, instances, forces, cells, _AT_EDGE),
    ]
    title = f"Largest pressure at rounded crests, {side} side"
    return _compared(
        f"{side}_edge", title, methods, "rounded by 0.2 mm", reference_cells,
        lambda: _reference(_AT_EDGE, side, instances, forces, largest, reference_cells),
    )  # fmt: skip


def _compared(name: str, title: str, methods, crests: str, cells: int, reference) -> Problem:
    return Problem(
        name=name,
        title=title,
        instance="contact",
        methods=methods,
        reference=reference,
        reference_note="elastic half-spaces on the true flanks in NumPy, "
        f"{cells} × {cells} cells, crests {crests}",
        baseline=methods[-1].name,
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    instances = _INSTANCES[2:4] if quick else _INSTANCES
    cells = (24,) if quick else (32, 64, 128)
    problems = [_problem(side, instances, cells, 48 if quick else 192) for side in ("screw", "nut")]
    # Peaks at edges are narrower.
    cells = (96,) if quick else (64, 128, 256)
    problems += [
        _edge_problem(side, instances, cells, 128 if quick else 256) for side in ("screw", "nut")
    ]
    return Case(
        "truncated_contact",
        "Ellipses longer than the flank: laws of laminae and edges against elastic half-spaces",
        problems,
    )
