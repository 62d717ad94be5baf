"""Every quantity by every number of the examples, against differences that know their own error.

Differences of sixteen steps, halved from one to the next, extrapolated after Richardson; a row for
each of them, all in one program. Where no step agrees with its neighbours (rounding, a kink) the
estimate of the error is large and the comparison says nothing: few enough are allowed to.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from every_number import OF_AN_AXIS, extrapolated, quantities_of

import prsm_jax as prsm
from prsm_jax.contact import stress_peak, stress_peak_on_axis

_SHEAR = ("max_shear_depth_screw", "max_shear_depth_nut", "max_von_mises_screw")
_SHARED = ("largest_thread_load", "max_pressure_shared", "axial_deflection")
EXAMPLES = [
    ("lisowski2014", _SHEAR),
    *(
        (name, None)
        for name in (
            "lisowski2014",
            "wu2022",
            "ring_roller",
            "li2020_single_stage_viscous",
            "li2020_two_stage",
            "actuator_mission",
            "actuator_load_sharing",
        )
    ),
    ("actuator_axis", OF_AN_AXIS),
]
#: Relative; the differences know their own error, and what they are derivatives of is computed to
#: about 1e-12, so that their smallest steps leave this much.
_AGREE = 1e-6


@pytest.mark.parametrize(("name", "wanted"), EXAMPLES)
def test_every_quantity_by_every_number(name, wanted):
    program = quantities_of(name, wanted)
    found = program.derivatives()
    expected, error = program.differences()
    (base, *_), _ = program(program.values[None])
    # A derivative far below rounding of the quantity over a relative change of one is none.
    nothing = 1e-12 * np.abs(base)
    apart = np.abs(found - expected) > 5 * error + _AGREE * np.abs(expected) + nothing
    wrong = [
        f"{program.labels[j]} by {program.names[k]}: {found[k, j]:.9g}, differences "
        f"{expected[k, j]:.9g} ± {error[k, j]:.1g}"
        for k, j in zip(*np.nonzero(apart), strict=True)
    ]
    assert not wrong
    # The comparison says something: nearly everywhere the differences are good to a thousandth.
    matters = np.abs(found) > 1e-9 * np.abs(base)
    blind = matters & (error > 1e-3 * np.abs(expected))
    groups = [np.full(len(program.labels), True)]
    if name == "actuator_load_sharing":
        groups.append(np.array([label.partition("[")[0] in _SHARED for label in program.labels]))
        assert groups[-1].sum() >= len(_SHARED)
    for group in groups:
        assert matters[:, group].any()
        assert blind[:, group].sum() <= 0.02 * matters[:, group].sum()


def test_extrapolated_differences_know_their_error():
    """Of exp at 0, of a number in rounding, and of a kink."""
    steps = 2e-2 * 0.5 ** np.arange(16)
    rng = np.random.default_rng(5)
    smooth = (np.exp(steps) - np.exp(-steps)) / (2 * steps)
    noisy = smooth + 1e-3 * rng.standard_normal(16) * (steps[0] / steps)
    kinked = (np.abs(steps + 1e-3) - np.abs(-steps + 1e-3)) / (2 * steps)
    limit, error = extrapolated(np.stack([smooth, noisy, kinked], axis=1))
    assert error[0] < 1e-11
    assert abs(limit[0] - 1) < 5 * error[0] + 1e-14
    assert error[1] > 1e-5
    # Beyond the kink, where all steps agree again.
    assert limit[2] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("measure", ["von_mises", "max_shear"])
@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.9, 0.999])
def test_the_depth_of_the_largest_stress_moves_as_the_stress_says(measure, ratio):
    """Against the depth itself, which is exact: differences of it with their own error."""
    given = jnp.asarray([ratio, 0.3])

    def depth(given):
        one = jnp.ones_like(given[0])
        return stress_peak_on_axis(one, given[0], one, given[1], measure).depth

    steps = 2e-2 * 0.5 ** np.arange(12)
    moved = np.asarray(given) + np.concatenate([steps, -steps])[:, None, None] * np.diag(given)
    values = jax.jit(jax.vmap(jax.vmap(depth)))(jnp.asarray(moved)).reshape(2, len(steps), 2)
    values = np.asarray(values)
    expected, error = extrapolated((values[0] - values[1]) / (2 * steps[:, None]))
    for found in (jax.jacfwd(depth)(given), jax.jacrev(depth)(given)):
        relative = np.asarray(found) * np.asarray(given)
        # Stresses along a long ellipse are differences over κ²: 2e-10 at κ = 0.05.
        assert np.all(np.abs(relative - expected) < 5 * error + 1e-9 * np.abs(expected))
    assert np.all(error < 1e-6 * np.abs(expected))


@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.5, -0.2])
def test_a_maximum_on_the_surface_stays_there(poisson_ratio):
    """Where material that widens when pulled has it: on the surface, under a long ellipse."""
    found = stress_peak_on_axis(
        jnp.asarray(3.0), jnp.asarray(1.0), jnp.asarray(1.0), jnp.asarray(poisson_ratio)
    )
    depths = jnp.linspace(0.0, 2.0, 2001)
    stresses = jax.vmap(
        lambda z: prsm.contact.axis_stress(
            z, *(jnp.asarray(x) for x in (3.0, 1.0, 1.0, poisson_ratio))
        )
    )(depths)
    first, second, third = stresses
    square = ((first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2) / 2
    place = int(jnp.argmax(square))
    assert float(found.value) == pytest.approx(float(jnp.sqrt(square[place])), rel=1e-6)
    assert float(found.depth) == pytest.approx(float(depths[place]), abs=1e-3)


def test_the_place_of_the_largest_stress_under_friction_moves_as_differences_say():
    """In space: below a contact that slides, forward and reverse."""

    def place(friction):
        pulled = jnp.stack([friction, jnp.zeros_like(friction)])
        axes = jnp.asarray([1.5, 1.0])
        return stress_peak(axes, jnp.ones_like(friction), jnp.asarray(0.3), pulled).position

    at, step = jnp.asarray(0.1), 1e-3
    find = jax.jit(place)
    expected = np.asarray(8 * (find(at + step) - find(at - step)) - find(at + 2 * step))
    expected = (expected + np.asarray(find(at - 2 * step))) / (12 * step)
    for found in (jax.jit(jax.jacfwd(place))(at), jax.jit(jax.jacrev(place))(at)):
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("measure", ["von_mises", "max_shear"])
@pytest.mark.usefixtures("memory_for_large_programs")
def test_second_derivatives_of_the_largest_stress_on_the_axis(measure):
    """Of value and depth, below the surface and on it (ν −0.9).

    The maximum moves, which the first derivative of the value does not show.
    """

    def value(given):
        one = jnp.ones_like(given[0])
        found = stress_peak_on_axis(one, given[0], one, given[1], measure)
        return jnp.stack([found.value, found.depth])

    slope, step = jax.jit(jax.jacfwd(value)), 1e-3
    second = [jax.jit(jax.jacfwd(jax.jacfwd(value))), jax.jit(jax.hessian(value))]
    for given in (jnp.asarray([0.6, 0.3]), jnp.asarray([0.6, -0.9])):
        expected = [
            8 * (slope(given + s) - slope(given - s)) - slope(given + 2 * s) + slope(given - 2 * s)
            for s in step * np.eye(2)
        ]
        for one in second:
            found = np.moveaxis(np.asarray(one(given)), -1, 0)
            # Fourth order in the step.
            np.testing.assert_allclose(
                found, np.asarray(expected) / (12 * step), rtol=1e-8, atol=1e-9
            )


def test_second_derivatives_of_the_largest_stress_under_friction():
    """In space: below a contact that slides, and at its edge, where the point does not move."""

    def value(friction):
        pulled = jnp.stack([friction, jnp.zeros_like(friction)])
        axes = jnp.asarray([1.5, 1.0])
        return stress_peak(axes, jnp.ones_like(friction), jnp.asarray(0.3), pulled).value

    slope, step = jax.jit(jax.grad(value)), 1e-3
    second = jax.jit(jax.grad(jax.grad(value)))
    for at in (jnp.asarray(0.1), jnp.asarray(0.6)):
        expected = 8 * (slope(at + step) - slope(at - step))
        expected = (expected - slope(at + 2 * step) + slope(at - 2 * step)) / (12 * step)
        np.testing.assert_allclose(second(at), expected, rtol=1e-7)
