"""Rollers that lean and bend: a beam of finite elements, balances, closed forms and limits."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import numpy as np
import pytest
from error_scenes import ERRORS, FREE, stage_with
from numpy.polynomial.legendre import Legendre
from scenes import array
from sharing_scenes import sharing_stage

import prsm_jax as prsm
from benchmarks.references.roller_bending import balance, bent_rollers
from prsm_jax import file
from prsm_jax.cli.verbs._contact import _bent_results as bent_results, _lines_bent as lines_bent
from prsm_jax.load_sharing import stage_load_distribution
from prsm_jax.mechanism import RollerBending, material_of

LOAD = 7e3
#: Near what the roller's own bending resists [N·m/rad].
SUPPORT = 2e4


@eqx.filter_jit
def _shared(stage, load):
    return stage_load_distribution(stage, load)


def _stage(support=None, shapes=8, length=None, **more) -> Any:
    held = None if support is None else array(support)
    stage: Any = sharing_stage()
    sharing = dataclasses.replace(
        stage.load_sharing, roller_bending=RollerBending(held, shapes), **more
    )
    roller = stage.roller
    if length is not None:
        roller = dataclasses.replace(roller, length=array(length))
    return dataclasses.replace(stage, load_sharing=sharing, roller=roller)


def _found(stage, load=LOAD) -> Any:
    found = _shared(stage, array(load))
    assert bool(found.converged)
    return found


def _beam_of(stage, found):
    """Numbers of the rollers, read from the stage by the benchmark's finite elements."""
    return bent_rollers(stage, found.chains, None)


@pytest.mark.parametrize("support", [None, SUPPORT])
@pytest.mark.parametrize("length", [None, 60e-3])
def test_against_finite_elements(support, length):
    """Cubic elements are exact for forces at nodes; eight shapes leave 4e-4."""
    stage = _stage(support, length=length)
    found = _found(stage)
    own = balance(bent_rollers(stage, found.chains, support), LOAD)
    # Rounding: stiffnesses of short elements (1e10 N/m) times displacements of 1e-5 m.
    assert own.error < 1e-9
    for force, side in ((own.screw, found.screw), (own.nut, found.nut)):
        loads = np.asarray(side.forward[0])
        np.testing.assert_allclose(loads, force, atol=1e-3 * force.max())
        # The table changes far more than that.
        plain = _found(sharing_stage())
        assert np.max(np.abs(np.asarray(plain.screw.forward[0]) - own.screw)) > 5.0


def test_more_shapes_are_closer_to_the_beam():
    stage = _stage()
    own = balance(bent_rollers(stage, _found(stage).chains, None), LOAD)
    errors = []
    for shapes in (3, 5, 8, 12):
        loads = np.asarray(_found(_stage(shapes=shapes)).screw.forward[0])
        errors.append(np.abs(loads - own.screw).max() / own.screw.max())
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-3 < errors[0]


@pytest.mark.parametrize("shapes", [1, 8])
@pytest.mark.parametrize("backlash", [None, 3e-6])
def test_a_free_roller_carries_its_moment_by_shifted_loads(shapes, backlash):
    """2 r F = F tan α Δz: the forces of the nut act 2 r / tan α beyond those of the screw."""
    play: dict[str, Any] = {} if backlash is None else {"backlash": array(backlash)}
    stage = _stage(shapes=shapes, **play)
    found = _found(stage)
    z = _beam_of(stage, found).places
    centre = [np.sum(z * s.forward[0]) / np.sum(s.forward[0]) for s in (found.screw, found.nut)]
    distance = 2 * float(stage.thread.roller_radius) / np.tan(float(stage.thread.flank_angle))
    assert centre[1] - centre[0] == pytest.approx(distance, rel=1e-8)


def _unbalanced(stage: Any, found, support, z, at):
    """Slope of the energy over each shape of one class, by NumPy's polynomials [N]."""
    thread, bending = stage.thread, _beam_of(stage, found).bending
    half = float(thread.pitch) * z.shape[-1] / 2
    forces = []
    for side in (found.screw, found.nut):
        back = 0.0 if side.reverse is None else np.asarray(side.reverse[at])
        ahead = np.asarray(side.forward[at])
        forces.append((ahead - back, ahead + back))
    (screw, screw_sum), (nut, nut_sum) = forces
    shapes = stage.load_sharing.roller_bending.shapes
    basis: list[Any] = [
        Legendre.basis(m) - Legendre.basis(m % 2) * float(m > 1) for m in range(1, shapes + 1)
    ]
    start = 4 if stage.load_sharing.free_nut is not None else 0
    amplitudes = np.asarray(found.equilibrium.state.displacements)[start:].reshape(-1, shapes)[at]
    whole: Any = sum(a * one for a, one in zip(amplitudes, basis, strict=True))
    bow = whole.deriv(2)
    slope, radius = np.tan(float(thread.flank_angle)), float(thread.roller_radius)
    residual = []
    for one in basis:
        value, lean = one(z / half), one.deriv()(z / half) / half
        energy = (bow * one.deriv(2)).integ()
        held = bending / half**3 * (energy(1) - energy(-1))
        pressed = slope * value * (screw_sum - nut_sum) + radius * lean * (screw + nut)
        residual.append(held - pressed.sum())
    lean = amplitudes[0] / half
    assert float(found.roller_lean[at]) == pytest.approx(lean, rel=1e-12)
    bent: Any = sum(a * one for a, one in zip(amplitudes[1:], basis[1:], strict=True))
    np.testing.assert_allclose(found.roller_deflection[at], bent(z / half), rtol=1e-9, atol=1e-15)
    residual[0] += support * lean / half
    return np.array(residual)


def test_two_flanks_under_preload_balance_in_every_shape():
    """A split nut presses both flanks of the screw's threads."""
    split = prsm.mechanism.SplitNut(after_thread=10, preload=array(2e3))
    stage = _stage(SUPPORT, split_nut=split)
    found = _found(stage, 500.0)
    assert float(np.min(np.sum(found.screw.reverse, axis=1))) > 1.0
    residual = _unbalanced(stage, found, SUPPORT, _beam_of(stage, found).places, 0)
    assert np.abs(residual).max() < 1e-8 * float(np.sum(found.screw.forward))


def test_rollers_that_differ_balance_one_by_one():
    """All errors of parts, a free nut, and six rollers that lean and bend."""
    stage = stage_with(
        ERRORS, free_nut=FREE, roller_bending=RollerBending(array(SUPPORT), 4), backlash=array(5e-6)
    )
    found = _found(stage)
    places = np.asarray(found.contact_place)
    for at, z in enumerate(places):
        residual = _unbalanced(stage, found, SUPPORT, z, at)
        assert np.abs(residual).max() < 1e-8 * LOAD
    assert np.ptp(np.asarray(found.roller_lean)) > 1e-6


def test_a_stiff_support_and_a_rigid_roller_change_nothing():
    """Support 1e12 times as stiff as the contacts; one shape is a lean without bending."""
    plain, found = _found(sharing_stage()), _found(_stage(1e18, shapes=1))
    loads = np.asarray(plain.screw.forward)
    np.testing.assert_allclose(found.screw.forward, loads, rtol=1e-12)
    assert float(found.deflection) == pytest.approx(float(plain.deflection), rel=1e-12)


@pytest.mark.parametrize("support", [1e-9, SUPPORT, 1e18])
@pytest.mark.parametrize("modulus", [1e-3, 1.0, 1e9])
def test_extreme_stiffnesses(support, modulus):
    """A roller as soft as rubber or a billion times as stiff as steel still balances."""
    stage = _stage(support)
    material = material_of(stage, "roller")
    scaled = dataclasses.replace(material, youngs_modulus=modulus * material.youngs_modulus)
    # Only the beam: contacts and shafts stay those of steel.
    sharing = dataclasses.replace(stage.load_sharing, roller_segment_stiffness=array(1e9))
    roller = dataclasses.replace(stage.roller, material=scaled)
    found = _found(dataclasses.replace(stage, load_sharing=sharing, roller=roller))
    assert np.isfinite(np.asarray(found.screw.forward)).all()


@eqx.filter_jit
def _of_energy(stage, load) -> Any:
    def stored(f):
        return stage_load_distribution(stage, f).stored_energy

    return jax.grad(stored)(load), stage_load_distribution(stage, load)


@pytest.mark.parametrize("backlash", [None, 3e-6])
def test_the_energy_is_the_work_of_the_load(backlash):
    """dU/dF = F dx/dF: the energy of bending and of the support is counted once."""
    play: dict[str, Any] = {} if backlash is None else {"backlash": array(backlash)}
    stage = _stage(SUPPORT, **play)
    slope, found = _of_energy(stage, array(LOAD))
    assert float(slope) == pytest.approx(LOAD / float(found.tangent_stiffness), rel=1e-9)


def _numbers(values, stage) -> Any:
    """Loads of the first thread, lean and bending at a support, a radius, and a load."""
    support, radius, load = values
    one = eqx.tree_at(
        lambda s: (s.load_sharing.roller_bending.tilting_stiffness, s.thread.roller_radius),
        stage,
        (support, radius),
    )
    found = stage_load_distribution(one, load)
    bent = found.roller_deflection[0, 0] * 1e9
    return jax.numpy.stack([found.screw.forward[0, 0], found.roller_lean[0] * 1e6, bent])


@eqx.filter_jit
def _derivatives(values, stage):
    function = lambda v: _numbers(v, stage)  # noqa: E731
    return function(values), jax.jacfwd(function)(values), jax.jacrev(function)(values)


def test_gradients():
    """Forward and reverse against central differences; steps leave 1e-7 of rounding."""
    stage = _stage(SUPPORT)
    values = jax.numpy.stack([array(SUPPORT), stage.thread.roller_radius, array(LOAD)])
    _, forward, reverse = _derivatives(values, stage)
    np.testing.assert_allclose(forward, reverse, rtol=1e-9, atol=1e-9 * np.abs(forward).max())
    for at, value in enumerate(values):
        step = 1e-4 * float(value)
        up, down = (
            np.asarray(_derivatives(values.at[at].add(sign * step), stage)[0]) for sign in (1, -1)
        )
        np.testing.assert_allclose(forward[:, at], (up - down) / (2 * step), rtol=2e-6)


_TABLE = """
[stage.load_sharing.roller_bending]
tilting_stiffness = "20 kN m/rad"
shapes = 5
"""


def test_lean_and_bending_are_printed():
    """Of rollers that differ the largest of either sign; JSON has a row per class."""
    found = _found(_stage(SUPPORT))
    keys = {"roller_lean_rad": found.roller_lean, "roller_deflection_m": found.roller_deflection}
    results = bent_results(found)
    assert results.keys() == keys.keys()
    assert all(results[name] is value for name, value in keys.items())
    assert bent_results(_found(sharing_stage())) == {}
    rows = {"roller_lean_rad": [1e-4, -3e-4], "roller_deflection_m": [[1e-6, -2e-6], [0.0, 1e-6]]}
    assert [(value, unit) for _, value, unit in lines_bent(rows)] == [(3e-4, "rad"), (2e-6, "m")]


def test_a_file_and_its_way_back(tmp_path):
    text = file.example_text("actuator")
    end = text.index("\n\n", text.index("[stage.load_sharing]"))
    path = tmp_path / "bent.toml"
    path.write_text(text[: end + 1] + _TABLE + text[end + 1 :], encoding="utf-8")
    mechanism: Any = prsm.load(path)
    bending = mechanism.stages[0].load_sharing.roller_bending
    assert (float(bending.tilting_stiffness), bending.shapes) == (2e4, 5)
    again: Any = file.loads(file.dumps(mechanism)).stages[0].load_sharing
    assert again.roller_bending.shapes == 5
    with pytest.raises(ValueError, match="whole number from 1 to 16"):
        file.loads(path.read_text(encoding="utf-8").replace("shapes = 5", "shapes = 17"))


def test_no_trace_where_the_table_is_absent():
    def bends(stage) -> bool:
        return "roller_bending" in prsm.programs.traced_physics(
            lambda one: stage_load_distribution(one, array(LOAD)), stage
        )

    assert bends(_stage())
    assert not bends(sharing_stage())
