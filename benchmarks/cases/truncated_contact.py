"""Ellipses longer than the flank: the law of laminae and half-spaces on the true flanks."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import pressure_ratio, stage_contact
from prsm_jax.geometry import mesh
from prsm_jax.halfspace import flank_contact
from prsm_jax.mechanism import Material, Stage, Thread, as_scalar
from prsm_jax.strength import side_onsets

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references.meshing import Design
from ..references.truncated import contact_pressure, hertz_pressure

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


def _named(values) -> dict:
    return {_LABEL: np.asarray(values)}


def _law(side: str, instances, forces, name: str, cut: bool) -> Method:
    stages, loads = _stacked(instances, forces)

    def one(stage, load):
        meshing = mesh(stage.thread)
        pressure = getattr(stage_contact(stage, load, meshing), side).hertz.max_pressure
        if not cut:
            return pressure
        sides = side_onsets(stage, meshing)
        assert sides is not None
        onset = sides[("screw", "nut").index(side)]
        assert onset is not None
        return pressure * pressure_ratio(pressure, onset.onsets)

    def prepare(_):
        solver = eqx.filter_jit(eqx.filter_vmap(one))
        return Prepared(lambda: solver(stages, loads), len(instances), _named)

    return Method(name, prepare, kind="approximation")


def _half_spaces(side: str, instances, forces, cells) -> Method:
    stages, loads = _stacked(instances, forces)

    def prepare(count):
        def one(given):
            stage, load = given
            found = flank_contact(stage, side, load, (count, count), extent=1.45, tolerance=1e-6)
            near = slice(count // 2 - 1, count // 2 + 1)
            return jnp.sqrt(jnp.mean(found.surface.pressure[near, near] ** 2))

        solver = eqx.filter_jit(lambda s, f: jax.lax.map(one, (s, f)))
        return Prepared(lambda: solver(stages, loads), len(instances), _named)

    return Method("prsm_jax, half-spaces on the flanks", prepare, cells, "cells along a side")


def _problem(side: str, instances, cells, reference_cells: int) -> Problem:
    forces = _forces(side, instances)

    def reference():
        values = []
        for (lead, pressure), force in zip(instances, forces, strict=True):
            height = _ADDENDUM * lead / 5
            ratio = contact_pressure(
                _design(lead), side, (height, height), force, _MODULUS, reference_cells
            )
            values.append(ratio * pressure)
        return {_LABEL: Reference(np.asarray(values))}

    methods = [
        _law(side, instances, forces, "prsm_jax, laminae", True),
        _law(side, instances, forces, "Hertz, whole ellipse", False),
        _half_spaces(side, instances, forces, cells),
    ]
    return Problem(
        name=side,
        title=f"Ellipses cut by the crests, {side} side",
        instance="contact",
        methods=methods,
        reference=reference,
        reference_note="elastic half-spaces on the true flanks in NumPy, "
        f"{reference_cells} × {reference_cells} cells, crests sharp",
        baseline=methods[-1].name,
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    instances = _INSTANCES[2:4] if quick else _INSTANCES
    cells = (24,) if quick else (32, 64, 128)
    return Case(
        "truncated_contact",
        "Ellipses longer than the flank: a law of laminae against elastic half-spaces",
        [_problem(side, instances, cells, 48 if quick else 192) for side in ("screw", "nut")],
    )
