"""NaN in, NaN out, and flagged: no quantity makes a number of it; infinity, zero and less flagged.

Every number of a mechanism is set to NaN, one at a time. A quantity that changes when the number
is nudged has to be NaN then; one that does not change is the same, or NaN.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from every_number import OF_AN_AXIS, quantities_of
from scenes import example

import prsm_jax as prsm
from prsm_jax.quantities import REASONS, compute_coded

#: One of each room: contact, stress, strength, life, stiffness, steady state, vibration.
_SOME = (
    "max_pressure",
    "max_shear_depth_nut",
    "static_safety",
    "rating_life_time",
    "buckling_safety",
    "critical_speed",
    "axis_axial_stiffness_secant",
    "lost_motion",
)
EXAMPLES = [
    (name, None)
    for name in (
        "lisowski2014",
        "actuator",
        "actuator_load_sharing",
        "li2020_two_stage",
        "li2020_single_stage_viscous",
        "ring_roller",
        "wu2022",
    )
] + [("actuator_axis", OF_AN_AXIS)]


def _with_each(values, changed):
    """A row for each number, with that number changed."""
    rows = np.repeat(values[None], len(values), axis=0)
    np.fill_diagonal(rows, changed)
    return rows


@pytest.fixture(scope="module", params=EXAMPLES, ids=[name for name, _ in EXAMPLES])
def program(request):
    """One example after the other: both tests of it share a program that takes long to trace."""
    return quantities_of(*request.param)


def test_nan_is_never_a_number(program):
    x = program.values
    (base, *_), (code, *_) = program(x[None])
    assert code == 0
    assert np.isfinite(base).all()
    nudged, _ = program(_with_each(x, np.where(x == 0, 1e-7, x * (1 + 1e-4))))
    depends = np.abs(nudged - base) > 1e-12 * np.abs(base)
    found, codes = program(_with_each(x, np.nan))
    # Most numbers matter to something, and most quantities to some number.
    assert depends.any(axis=1).mean() > 0.5
    assert depends.any(axis=0).mean() > 0.8
    numbers = [
        f"{program.labels[j]} is {found[k, j]} where {program.names[k]} is NaN"
        for k, j in zip(*np.nonzero(depends & ~np.isnan(found)), strict=True)
    ]
    same = np.isnan(found) | np.isclose(found, base, rtol=1e-9, atol=1e-9 * np.abs(base))
    invented = [
        f"{program.labels[j]} moves from {base[j]} to {found[k, j]} where {program.names[k]} is NaN"
        for k, j in zip(*np.nonzero(~depends & ~same), strict=True)
    ]
    unflagged = [
        program.names[k] for k in np.flatnonzero(np.isnan(found).any(axis=1) & (codes == 0))
    ]
    assert not numbers
    assert not invented
    assert not unflagged


def test_whatever_a_number_is_the_result_is_finite_or_flagged(program):
    x = program.values
    kinds = {"infinite": np.inf, "minus infinity": -np.inf, "zero": 0.0}
    kinds |= {"negative": -x, "huge": 1e12 * x, "tiny": 1e-12 * x}
    silent = []
    for kind, changed in kinds.items():
        found, codes = program(_with_each(x, changed))
        silent += [
            f"{program.labels[j]} is {found[k, j]} where {program.names[k]} is {kind}"
            for k, j in zip(*np.nonzero(~np.isfinite(found)), strict=True)
            if codes[k] == 0
        ]
    assert not silent


@eqx.filter_jit
def _coded(mechanism, names, load):
    return compute_coded(mechanism, names, load=load)


def test_strength_and_stiffness_of_a_load_that_is_nan():
    """Given as an argument, not in the mechanism; its own program."""
    found, code = _coded(scenes.equal_shares("actuator"), _SOME[:4], jnp.asarray(jnp.nan))
    assert int(code) != 0
    assert all(np.isnan(value).all() for value in found.values())


def test_a_load_that_is_nan_has_no_pressure_and_fails_a_sweep():
    mechanism = scenes.equal_shares("actuator")
    assert np.isnan(prsm.compute(mechanism, ["max_pressure"], load=jnp.nan)["max_pressure"])
    data = prsm.sweep(
        mechanism,
        {"contact_angle": np.radians([44.0, 45.0])},
        quantities=["max_pressure"],
        load=float("nan"),
    )
    assert bool(data["failed"].all())
    assert {REASONS[int(code)] for code in np.ravel(data["code"].values)} == {"not_finite"}


@eqx.filter_jit
def _pressures(mechanism, loads):
    def one(load):
        return jax.value_and_grad(
            lambda force: prsm.compute(mechanism, ["max_pressure"], load=force)["max_pressure"]
        )(load)

    return jax.vmap(one)(loads)


def test_a_good_design_beside_bad_ones_keeps_its_number_and_its_derivative():
    mechanism = scenes.equal_shares("actuator")
    bad = [jnp.nan, jnp.inf, 0.0]
    values, slopes = _pressures(mechanism, jnp.asarray([*bad, 3e3]))
    alone, slope = _pressures(mechanism, jnp.full(4, 3e3))
    assert float(values[-1]) == pytest.approx(float(alone[0]), rel=1e-14)
    assert float(slopes[-1]) == pytest.approx(float(slope[0]), rel=1e-14)
    # A cube root: a third of the secant.
    assert float(slope[0]) == pytest.approx(float(alone[0]) / 9e3, rel=1e-12)
    assert np.isnan(float(values[0]))
    assert np.isnan(float(slopes[0]))
    assert (float(values[2]), float(slopes[2])) == (0.0, 0.0)


def test_steady_states_of_numbers_that_are_not_finite_say_so():
    names = ("speed", "load")
    good = {"speed": jnp.asarray(100.0), "load": jnp.asarray(7e3)}
    for name in names:
        for value in (jnp.nan, jnp.inf):
            found = scenes.steady_state(example("wu2022"), **(good | {name: jnp.asarray(value)}))
            assert found.result_name == "not_finite"
            assert not bool(found.valid)
    assert scenes.steady_state(example("wu2022"), **good).result_name == "successful"
