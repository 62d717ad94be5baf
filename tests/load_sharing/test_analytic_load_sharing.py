"""Load sharing against closed forms, a minimisation of its own, and the work that loads do."""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from jax.flatten_util import ravel_pytree
from scenes import STEEL, array, example, mechanism
from sharing_scenes import (
    HERTZ,
    TOOTH,
    chains,
    equilibrium,
    force_deflection,
    load_distribution,
    loads_of,
    sharing_stage,
)

import prsm_jax as prsm
from prsm_jax.load_sharing import (
    State,
    elastic_deflection,
    flank_approach,
    flank_force,
    residual,
    roller_classes,
    tooth_compliance,
)
from prsm_jax.load_sharing._equilibrium import response
from prsm_jax.load_sharing._stage_chains import tooth_compliances
from prsm_jax.mechanism import (
    GivenStiffness,
    LoadSharing,
    SplitNut,
    UnequalRoller,
    material_of,
    nut_outer_radius,
)
from prsm_jax.stiffness import axial_stiffness, thread_stiffness
from prsm_jax.vibration import spring_network, vibration_system
from tests.present import present

#: The search stops at 1e-12 of the largest force; the artificial stiffness, 1e-12 of that of a
#: contact, adds as much.
_BALANCE = 1e-10


def _linear(**more):
    defaults = {"hertz": None, "tooth": 1.0, "segments": (0.01,) * 3, "load": 20.0}
    return chains(**(defaults | more))


def _shares(bare, load=20.0):
    found = equilibrium(bare, array(load))
    assert int(found.result) == 0
    return [side[0] for side in loads_of(bare, found)]


@pytest.mark.parametrize(
    ("same_end", "screw", "nut"),
    [
        (True, (1.977348, 0.552607), (1.977348, 0.552607)),
        (False, (1.759164, 0.770791), (0.770791, 1.759164)),
    ],
)
def test_linear_springs(same_end, screw, nut):
    """20 threads, contact compliance 1, segments 0.01: the known factors, to their six digits."""
    found = _shares(_linear(same_end=same_end))
    for loads, ends in zip(found, (screw, nut), strict=True):
        np.testing.assert_allclose(loads[[0, -1]], ends, atol=6e-7)
        assert loads.mean() == pytest.approx(1.0, abs=_BALANCE)


def test_rigid_roller_in_closed_form():
    """A rigid roller leaves two ladders: S_i = n sinh μ(n+1−i)/sinh μn, cosh μ = 1 + e/2k."""
    count, segment = 20, 0.03
    screw, nut = _shares(_linear(segments=(segment, 0.0, segment)))
    mu = np.arccosh(1 + segment / 2)
    passing = count * np.sinh(mu * (count - np.arange(count + 1))) / np.sinh(mu * count)
    np.testing.assert_allclose(screw, -np.diff(passing), rtol=1e-9)
    np.testing.assert_allclose(nut, -np.diff(passing), rtol=1e-9)


def test_limits():
    """Rigid shafts share equally; rigid contacts leave all load to the end threads."""
    np.testing.assert_allclose(_shares(_linear(segments=(0.0, 0.0, 0.0)))[0], 1.0, rtol=_BALANCE)
    screw, _ = _shares(_linear(tooth=1e-9))
    assert screw[0] == pytest.approx(20.0, rel=1e-3)
    assert np.all(screw[1:] < 1e-2)


def test_flank_law_is_the_inverse_of_its_approach():
    """To rounding over 24 decades of the ratio of its two parts; nothing where flanks are apart."""
    force = jnp.logspace(-12, 12, 49)
    hertz, tooth = array(1e-7), array(3e-9)
    found = flank_force(flank_approach(force, hertz, tooth), hertz, tooth)
    np.testing.assert_allclose(found, force, rtol=5e-15)
    assert float(flank_force(array(-1e-6), hertz, tooth)) == 0.0


def test_tooth_compliance_against_the_integrals_of_a_wedge_shaped_beam():
    """Bending, with the moment of the radial force, and shear; both bodies' radial parts."""
    angle, pitch, thickness, depth, radius = np.radians(40.0), 2e-3, 0.9e-3, 0.5e-3, 12e-3
    values = [array(x) for x in (angle, pitch, thickness, depth, radius)]
    solid = tooth_compliance(STEEL, *values)
    sleeve = tooth_compliance(STEEL, *values, array(18e-3))  # pyright: ignore[reportCallIssue]
    modulus, poisson = 210e9, 0.3
    nodes, weights = np.polynomial.legendre.leggauss(40)
    place, weights = depth * (nodes + 1) / 2, weights * depth / 2
    # From the root; a unit axial load presses at the depth's end, with tan α along the tooth.
    local = thickness + 2 * (depth - place) * np.tan(angle)
    lever = depth - place
    moment = lever - np.tan(angle) * thickness / 2
    bending = np.sum(weights * moment * lever * 12 * (1 - poisson**2) / (modulus * local**3))
    shear = np.sum(weights * 1.2 * 2 * (1 + poisson) / (modulus * local))
    assert float(solid.bending) == pytest.approx(bending, rel=1e-12)
    assert float(solid.shear) == pytest.approx(shear, rel=1e-12)
    ring = (18e-3**2 + radius**2) / (18e-3**2 - radius**2) + poisson
    widening = np.tan(angle) ** 2 * radius / (pitch * modulus)
    assert float(solid.radial) == pytest.approx((1 - poisson) * widening, rel=1e-12)
    assert float(sleeve.radial) == pytest.approx(ring * widening, rel=1e-12)
    assert float(sleeve.root_tilt) == float(solid.root_tilt)


# Two classes of rollers, two of the first and one of the second, on six threads with errors.
_GAPS = np.random.default_rng(5).normal(size=(2, 6)) * 2e-6


def _minimised(bare, load):
    """Forces at the minimum of the energy over all displacements, by SciPy."""
    from scipy.optimize import minimize

    weight, gaps, count = np.asarray(bare.weight), np.asarray(bare.screw.gap), 6
    springs = [
        1 / np.asarray(s) for s in (bare.screw_segment, bare.roller_segment, bare.nut_segment)
    ]
    length, force = 1e-6, 50.0  # to numbers of order 1

    def flanks(approach):
        closed = np.maximum(approach, 0) / HERTZ
        return closed**1.5, 1.5 * np.sqrt(closed) / HERTZ, 0.4 * HERTZ * closed**2.5

    def parts(unknown):
        nodes = unknown.reshape(4, count) * length
        screw, rollers = nodes[0], nodes[1:3]
        # The nut is held at the far end.
        nut = nodes[3] - nodes[3, -1]
        return screw, rollers, nut

    def energy(unknown):
        screw, rollers, nut = parts(unknown)
        total, slope = -load * screw[0], np.zeros((4, count))
        slope[0, 0] -= load
        chain = (np.ones(1), weight, np.ones(1))
        rows = (np.array([screw]), rollers, np.array([nut]))
        for at, (stiffness, many, row) in zip(
            (0, 1, 3), zip(springs, chain, rows, strict=True), strict=True
        ):
            for index in range(len(row)):
                stretch = row[index, :-1] - row[index, 1:]
                pull = many[index] * stiffness * stretch
                total += np.sum(pull * stretch) / 2
                slope[at + index, :-1] += pull
                slope[at + index, 1:] -= pull
        for index in range(2):
            for first, second, rows_ in (
                (screw, rollers[index], (0, 1 + index)),
                (rollers[index], nut, (1 + index, 3)),
            ):
                pressed, _, stored = flanks(first - second - gaps[index])
                total += weight[index] * np.sum(stored)
                slope[rows_[0]] += weight[index] * pressed
                slope[rows_[1]] -= weight[index] * pressed
        slope[3, -1] -= np.sum(slope[3])
        return total / (force * length), slope.ravel() / force

    start = np.repeat([40.0, 20.0, 20.0, 0.0], count)
    found = minimize(
        energy, start, jac=True, method="L-BFGS-B",
        options={"maxiter": 20_000, "maxfun": 40_000, "ftol": 0.0, "gtol": 1e-9, "maxcor": 40},
    )  # fmt: skip
    screw, rollers, nut = parts(found.x)
    return flanks(screw - rollers - gaps)[0], flanks(rollers - nut - gaps)[0]


def _two_classes(**more):
    defaults = {"gap": _GAPS, "tooth": None, "same_end": False, "load": 600.0}
    return chains(6, (2.0, 1.0), **(defaults | more))


def test_against_a_minimisation_of_the_energy():
    """Displacements of every node, found by another method; its gradient ends near 1e-7."""
    bare = _two_classes()
    found = equilibrium(bare, array(600.0))
    assert int(found.result) == 0
    for ours, theirs in zip(loads_of(bare, found), _minimised(bare, 600.0), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=600 * 1e-6)
    assert np.any(loads_of(bare, found)[0] == 0)


@settings(max_examples=10)
@given(st.floats(-3, 3), st.floats(-3, 3))
def test_scaling(force, length):
    """Loads in other units of force and lengths in other units of length are the same loads."""
    newton, metre = 10**force, 10**length
    plain = _two_classes()
    scaled = _two_classes(
        gap=_GAPS * metre,
        hertz=HERTZ * metre / newton ** (2 / 3),
        segments=tuple(s * metre / newton for s in (3e-11, 24e-11, 0.75e-11)),
        load=600.0 * newton,
    )
    expected = loads_of(plain, equilibrium(plain, array(600.0)))
    found = loads_of(scaled, equilibrium(scaled, array(600.0 * newton)))
    for one, other in zip(expected, found, strict=True):
        np.testing.assert_allclose(other / newton, one, atol=600 * _BALANCE)


def test_the_order_of_rollers_does_not_matter():
    plain = _two_classes()
    turned = chains(6, (1.0, 2.0), gap=_GAPS[::-1].copy(), tooth=None, same_end=False, load=600.0)
    expected = loads_of(plain, equilibrium(plain, array(600.0)))
    found = loads_of(turned, equilibrium(turned, array(600.0)))
    for one, other in zip(expected, found, strict=True):
        np.testing.assert_allclose(other[::-1], one, atol=600 * _BALANCE)


@pytest.mark.parametrize("weight", [(2.0, 1.0), (1.0, 2.0, 1.0, 1.0)])
def test_the_tangent_is_symmetric_and_the_elimination_solves_it(weight):
    """Written out for few classes and by arrays for many; with both flanks and wedges.

    A saddle point of a convex energy: as many positive eigenvalues as there are approaches and
    wedges, as many negative ones as forces and the unknown load.
    """
    count = len(weight)
    rng = np.random.default_rng(count)
    bare = chains(5, weight, gap=1e-6 * rng.normal(size=(count, 5)), backlash=-3e-6)
    state = State(
        *(1e-6 * jnp.asarray(rng.normal(size=s)) for s in ((count, 5), (5,))),
        *(10.0 * jnp.asarray(rng.normal(size=s)) for s in ((count, 4), (4,))),
        1e-7 * jnp.asarray(rng.normal(size=count)),  # pyright: ignore[reportCallIssue]
        array(300.0),  # pyright: ignore[reportCallIssue]
    )
    flat, shape = ravel_pytree(state)
    value = array(1e-5)

    @jax.jit
    def both(right):
        matrix = jax.jacobian(
            lambda x: ravel_pytree(residual(bare, shape(x), "deflection", value))[0]
        )(flat)
        solved = response(bare, state, "deflection", value, shape(right))
        return matrix, ravel_pytree(solved)[0]

    right = rng.normal(size=flat.size)
    # Approaches in metres and forces in newtons: to one scale.
    scale = np.concatenate([np.full(6 * count + 5, 1e-4), np.full(4 * count + 4, 1e3), [1e3]])
    order = np.concatenate(
        [np.arange(5 * count + 5), np.arange(9 * count + 9, 10 * count + 9),
         np.arange(5 * count + 5, 9 * count + 9), [10 * count + 9]]
    )  # fmt: skip
    matrix, solved = both(jnp.asarray(right))
    matrix = np.asarray(matrix)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-15 * np.abs(matrix).max())
    # Solved as well as the last digits of the terms allow, which are far larger than their sums.
    solved = np.asarray(solved)
    terms = np.abs(matrix) @ np.abs(solved)
    assert np.all(np.abs(matrix @ solved - right) <= 1e-14 * terms)
    balanced = matrix[np.ix_(order, order)] * np.outer(scale, scale)
    values = np.linalg.eigvalsh(balanced)
    assert np.sum(values > 0) == 6 * count + 5
    assert np.sum(values < 0) == 4 * count + 5


def test_work_is_stored_energy():
    """∫F dx = U and x = ∫dF/K, by quadrature in the cube root of the load: spectral."""
    one = mechanism(sharing_stage())
    nodes, weights = np.polynomial.legendre.leggauss(24)
    root, largest = (nodes + 1) / 2, 12e3
    curve = force_deflection(one, np.append(largest * root**3, largest))
    assert np.all(np.asarray(curve.converged))
    steps = weights / 2 * 3 * root**2 * largest
    deflection, stiffness = np.asarray(curve.deflection), np.asarray(curve.tangent_stiffness)
    complementary = np.sum(steps * deflection[:-1])
    work = largest * deflection[-1] - complementary
    assert float(curve.stored_energy[-1]) == pytest.approx(work, rel=1e-8)
    assert np.sum(steps / stiffness[:-1]) == pytest.approx(deflection[-1], rel=1e-8)
    assert np.all(np.diff(stiffness[:-1]) > 0)


def test_stiff_shafts_and_teeth_share_as_the_equal_share_does():
    """Then the stiffness that vibrations get is that of equal loads on all threads."""
    rigid = {f"{body}_segment_stiffness": 1e30 for body in ("screw", "roller", "nut")}
    one = mechanism(sharing_stage(tooth=None, **rigid))
    found = load_distribution(one, array(7e3))
    equal = prsm.thread_contacts(one, 7e3)[0]
    np.testing.assert_allclose(found.screw.forward, 35.0, rtol=1e-9)
    assert float(found.screw.thread_sharing_factor) == pytest.approx(1.0, rel=1e-9)
    assert float(found.max_pressure) == pytest.approx(float(equal.screw.hertz.max_pressure))
    for side in ("screw", "nut"):
        expected = float(getattr(equal, side).roller_stiffness)
        assert float(getattr(found, side).roller_stiffness) == pytest.approx(expected, rel=1e-9)
    stiffness = prsm.compute(one, ["thread_stiffness_screw"], load=7e3)
    assert float(stiffness["thread_stiffness_screw"][0]) == pytest.approx(
        float(equal.screw.roller_stiffness), rel=1e-9
    )


def test_backlash_and_both_signs_of_the_load():
    """The curve is the same on either side of the play; deflections give the loads back."""
    one = mechanism(sharing_stage(backlash=10e-6))
    loads = np.array([-12e3, -1e3, 1e3, 12e3])
    curve = force_deflection(one, loads)
    deflection = np.asarray(curve.deflection)
    np.testing.assert_allclose(deflection[::-1] + deflection, -10e-6, rtol=1e-9)
    back = force_deflection(one, deflections=deflection)
    np.testing.assert_allclose(back.load, loads, rtol=1e-7)
    assert np.all(np.asarray(curve.converged) & np.asarray(back.converged))


def test_split_nut():
    """Braced without load: the spacer's force on opposite flanks, and wedged on to the screw."""
    one = mechanism(sharing_stage(split_nut=SplitNut(10, preload=3e3)))
    found = load_distribution(one, array(0.0))
    assert bool(found.converged)
    nut, screw = found.nut, found.screw
    assert float(present(found.spacer_force)) == pytest.approx(3e3, rel=1e-6)
    np.testing.assert_allclose(nut.forward[:, :10].sum(), 300.0, rtol=1e-6)
    np.testing.assert_allclose(nut.reverse[:, 10:].sum(), 300.0, rtol=1e-6)
    assert np.all(np.asarray(nut.forward)[:, 10:] == 0)
    # Radially the screw bears what the nut presses; axially its flanks cancel.
    pressed = screw.forward + present(screw.reverse)
    np.testing.assert_allclose(pressed.sum(), 600.0, rtol=1e-5)
    np.testing.assert_allclose(screw.roller_load, 0.0, atol=1e-6)
    assert float(present(found.chains.offset)) > 0
    # Both halves take part in a small load: stiffer than one nut under the load of a half.
    assert float(present(found.tangent_stiffness)) > 8e8


def test_deflection_of_a_preloaded_nut_is_that_of_the_load_alone():
    """Not that of the spacer: without a load there is none, and small loads meet the tangent."""
    one = mechanism(sharing_stage(split_nut=SplitNut(10, preload=3e3)))
    resting = load_distribution(one, array(0.0))
    assert float(resting.deflection) > 5e-6
    assert float(resting.elastic.deflection) == pytest.approx(0.0, abs=1e-15)
    tangent = float(present(resting.tangent_stiffness))
    # The limit of the secant for a load that goes to 0.
    assert float(resting.secant_stiffness) == pytest.approx(tangent, rel=1e-12)
    names = ["nut_axial_stiffness_secant", "axial_deflection"]
    # Also under a load whose deflection is lost in the rounding of travels.
    for least in (0.0, 1e-13):
        of_nut = prsm.compute(one, names, speed=10.0, load=least)
        assert float(of_nut[names[0]]) == pytest.approx(tangent, rel=1e-9)
    for load in (100.0, -100.0):
        found = load_distribution(one, array(load))
        elastic = found.elastic
        assert bool(elastic.preloaded & elastic.converged)
        assert float(elastic.unloaded_position) == pytest.approx(
            float(resting.deflection), rel=1e-9
        )
        # The tangent itself changes by 2e-4 over these loads.
        assert float(found.secant_stiffness) == pytest.approx(tangent, rel=3e-4)
        assert float(elastic.deflection) == pytest.approx(load / tangent, rel=3e-4)


def test_deflection_with_play_starts_at_the_first_contact():
    """Rigid travel to it in closed form, on either side; as the load goes, nothing is left."""
    errors = np.random.default_rng(4).normal(size=(2, 6)) * 1e-6

    @eqx.filter_jit
    def at(load, backlash):
        bare = chains(6, (2.0, 1.0), gap=jnp.asarray(errors), backlash=None)
        # Play on the screw side only, errors on both.
        flanks = eqx.tree_at(
            lambda f: f.reverse_gap, bare.screw, backlash - bare.screw.gap,
            is_leaf=lambda x: x is None,
        )  # fmt: skip
        other = eqx.tree_at(
            lambda f: f.reverse_gap, bare.nut, -bare.nut.gap, is_leaf=lambda x: x is None
        )
        bare = dataclasses.replace(bare, screw=flanks, nut=other)
        return elastic_deflection(bare, load, jnp.zeros_like(load))

    rest = 2 * errors.min(axis=1)
    forward, backward = (at(array(load), array(2e-5)) for load in (1.0, -1.0))
    assert float(forward.unloaded_position) == pytest.approx(rest.min(), rel=1e-12)
    back = (2e-5 - errors.max(axis=1)) - errors.max(axis=1)
    assert float(backward.unloaded_position) == pytest.approx(-back.min(), rel=1e-12)
    assert not bool(forward.preloaded | backward.preloaded)
    nothing = at(array(0.0), array(2e-5))
    assert float(nothing.deflection) == 0
    # As the play closes into a fit without any, the balance without load goes on from there.
    least = -(rest.min() + back.min() - 2e-5)
    preloaded, loose = (at(array(1.0), array(least + 1e-12 * sign)) for sign in (-1, 1))
    assert bool(preloaded.preloaded & preloaded.converged)
    assert not bool(loose.preloaded)
    # The soft guidance of a roller that has to wedge by 1 µm bends contacts by some 10 pm.
    assert float(preloaded.unloaded_position) == pytest.approx(
        float(loose.unloaded_position), abs=1e-10
    )


def _threads_of(one):
    """The stiffnesses that vibrations get, without a load sharing of their own."""
    found = load_distribution(one, array(6e3))
    return found, thread_stiffness(one.stages[0], lambda: found)


@pytest.mark.parametrize(
    ("factors", "thinning"),
    [((2.0, 2.0, 2.0), (0.0, 0.0, 0.0)), ((1.0, 0.5, 1.0), (0.0, 0.0, 30e-6))],
)
def test_stiffness_of_unlike_rollers(factors, thinning):
    """Each with what it has under its load: with rigid shafts they add up to the nut's secant."""
    unequal = tuple(
        UnequalRoller(n, stiffness_factor=array(factor), tooth_thinning=array(thinner))
        for n, (factor, thinner) in enumerate(zip(factors, thinning, strict=True), start=1)
    )
    rigid = {f"{body}_segment_stiffness": 1e30 for body in ("screw", "roller", "nut")}
    stage = dataclasses.replace(sharing_stage(unequal, tooth=None, **rigid), roller_count=3)
    found, threads = _threads_of(mechanism(stage))
    each = np.asarray(threads.screw_each)
    alike = np.asarray(factors) * (np.asarray(thinning) == 0)
    np.testing.assert_allclose(each / each[0], alike / alike[0], rtol=1e-9)
    assert float(axial_stiffness(stage, threads)) == pytest.approx(
        float(found.secant_stiffness), rel=1e-9
    )
    network = spring_network(vibration_system(stage, threads))
    springs = [float(network.stiffness[network.springs.index(s)]) for s in network.springs
               if s.name == "screw_roller"]  # fmt: skip
    helix = float(jnp.cos(stage.thread.roller_helix_angle)) ** 2
    np.testing.assert_allclose(springs, each * helix, rtol=1e-12)
    # A given stiffness is a nominal one and takes the factors; thinner teeth do not enter it.
    given_ = dataclasses.replace(stage, stiffness=GivenStiffness(nut_roller=array(1e8)))
    np.testing.assert_allclose(
        present(thread_stiffness(given_, lambda: found).nut_each),
        1e8 * np.asarray(factors),
        rtol=1e-12,
    )


def test_unequal_and_missing_rollers():
    """A roller with thinner teeth carries less, a missing one nothing; sums stay."""
    unequal = (UnequalRoller(3, tooth_thinning=2e-6), UnequalRoller(5, missing=True))
    unequal = (*unequal, UnequalRoller(7, mass_factor=1.1))
    one = mechanism(sharing_stage(unequal))
    assert roller_classes(one.stages[0]) == ((1, 2, 4, 6, 7, 8, 9, 10), (3,))
    found = load_distribution(one, array(12e3))
    loads = np.asarray(found.nut.roller_load)
    assert loads[1] < loads[0]
    assert 8 * loads[0] + loads[1] == pytest.approx(12e3, rel=_BALANCE)
    assert float(found.nut.roller_sharing_factor) == pytest.approx(loads[0] / (12e3 / 9), rel=1e-9)
    numbers, rows = found.by_roller(found.nut.roller_load)
    assert numbers == (1, 2, 3, 4, 6, 7, 8, 9, 10)
    np.testing.assert_allclose(rows, np.where(np.array(numbers) == 3, loads[1], loads[0]))
    worst = found.worst_thread("screw")
    assert [int(x) for x in worst] == [0, 1]


def test_only_what_a_stage_mentions_is_traced():
    def physics(one):
        return prsm.programs.traced_physics(
            lambda m: prsm.compute(m, ["thread_stiffness_screw"]), one
        )

    shared = mechanism(sharing_stage())
    assert {"thread_chains", "flank_force", "tooth_compliance"} <= physics(shared)
    plain = eqx.tree_at(lambda m: m.stages[0].load_sharing, shared, None)
    assert not {"thread_chains", "flank_force", "tooth_compliance"} & physics(plain)
    assert "tooth_compliance" not in physics(mechanism(sharing_stage(tooth=None)))


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"thread_count": 0}, "a whole number from 1 to 1000"),
        ({"thread_count": 3, "mounting": "left"}, "mounting is 'left'"),
        (
            {"thread_count": 3, "screw_wear": [1e-6]},
            "1 number, but thread_count is 3; give as many",
        ),
    ],
)
def test_data_that_cannot_be(unchecked, given_, message):
    with pytest.raises(ValueError, match=message):
        LoadSharing(**given_)


def test_errors_name_what_is_missing():
    with pytest.raises(ValueError, match="either preload or offset"):
        SplitNut(3)
    with pytest.raises(ValueError, match="choose a smaller number"):
        LoadSharing(4, split_nut=SplitNut(4, offset=1e-6))
    with pytest.raises(prsm.MissingDataError, match="no load_sharing"):
        prsm.load_sharing.load_distribution(prsm.load("wu2022"))
    with pytest.raises(ValueError, match="stages 1 to 1"):
        prsm.load_sharing.load_distribution(mechanism(sharing_stage()), stage=2)
    with pytest.raises(ValueError, match="either loads or deflections"):
        prsm.load_sharing.force_deflection(mechanism(sharing_stage()))
    bare = eqx.tree_at(lambda m: m.stages[0].nut.wall_thickness, mechanism(sharing_stage()), None)
    with pytest.raises(prsm.MissingDataError, match="wall_thickness"):
        prsm.load_sharing.load_distribution(bare)
    assert TOOTH > 0


def test_steps_that_overshoot_are_cut():
    """Errors and play beside small approaches: whole Newton steps would go round in circles.

    One of 12,000 random chains, the only one that needs it.
    """
    rng = np.random.default_rng(1398)
    size, load = 10 ** rng.uniform(-8, -2.5), 10 ** rng.uniform(-3, 6)
    gap = size * rng.normal(size=(3, 20))
    backlash = rng.choice([-1, 1]) * 10 ** rng.uniform(-7, -3)
    segments = tuple(10 ** rng.uniform(-14, -7, 3))
    hertz, tooth = 10 ** rng.uniform(-9, -5), 10 ** rng.uniform(-11, -7)
    bare = chains(
        20, (1.0,) * 3, gap=gap, backlash=backlash, hertz=hertz, tooth=tooth,
        segments=segments, load=load,
    )  # fmt: skip
    found = equilibrium(bare, array(load))
    assert bool(found.converged)
    assert int(found.steps) < 40
    for side in loads_of(bare, found):
        np.testing.assert_allclose(np.sum(side), load, rtol=1e-9)


def test_compliances_of_a_stage_are_those_of_each_body():
    """All bodies in one call, each with its own section and material."""
    one = example("actuator").stages[0]
    bronze = dataclasses.replace(material_of(one, "nut"), youngs_modulus=array(1.1e11))
    one = eqx.tree_at(lambda s: s.nut.material, one, bronze, is_leaf=lambda x: x is None)
    found, geometry = present(tooth_compliances(one)), one.thread
    tooth = present(present(one.load_sharing).tooth)
    thickness = tooth.pitch_line_thickness
    thickness = geometry.pitch / 2 if thickness is None else thickness
    for body in ("screw", "roller", "nut"):
        expected = tooth_compliance(
            material_of(one, body),
            geometry.flank_angle,
            geometry.pitch,
            thickness,
            getattr(tooth, f"{body}_dedendum"),
            getattr(geometry, f"{body}_radius"),
            nut_outer_radius(one) if body == "nut" else None,
        )
        for name in ("bending", "shear", "root_tilt", "root_shear", "radial"):
            value, exact = float(getattr(found[body], name)), float(getattr(expected, name))
            assert value == pytest.approx(exact, rel=1e-14)
    assert len({float(one.total) for one in found.values()}) == 3
