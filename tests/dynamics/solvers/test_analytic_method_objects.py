"""Methods of `simulate` as objects, and as words that stand for them."""

import diffrax
import equinox as eqx
import jax
import numpy as np
import optimistix
import pytest
from scenes import Swing, array, mechanism, simulate, stage

import prsm_jax as prsm
from prsm_jax.dynamics import Auto, Integrating, ReverseMode
from prsm_jax.dynamics.solvers import gradient_of, method_of
from prsm_jax.friction import Friction, RegularisedCoulombFriction

ONE = mechanism()
SWING = prsm.Scenario(Swing(array(100.0), array(30.0), array(400.0)), 7e3, 3e-3, samples=31)
STEP = prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=11)
TORQUE = prsm.TorqueScenario(Swing(array(15.0), array(5.0), array(300.0)), 7e3, 3e-3, samples=31)


@pytest.mark.parametrize(
    ("word", "method", "options"),
    [
        ("rosenbrock", prsm.Rodasp, {"rtol": 1e-6, "atol": 1e-8}),
        ("implicit", prsm.Implicit, {"rtol": 1e-6, "atol": 1e-8}),
        ("explicit", prsm.Explicit, {"rtol": 1e-6, "max_steps": 500}),
        ("auto", Auto, {"rtol": 1e-7}),
        ("quasi_steady", prsm.QuasiSteady, {"rtol": 1e-6}),
        ("closed_form", prsm.ClosedForm, {}),
    ],
)
def test_a_word_stands_for_an_object(word, method, options):
    """Nothing is run: `simulate` knows only the object, as the test below shows."""
    of_word, given = method_of(word, **options), method(**options)
    assert type(of_word) is method
    assert eqx.tree_equal(of_word, given)
    assert not options or not eqx.tree_equal(of_word, method())


@pytest.mark.parametrize(
    ("scene", "word", "method", "options"),
    [
        (SWING, "rosenbrock", prsm.Rodasp, {"rtol": 1e-6, "atol": 1e-8}),
        (STEP, "auto", Auto, {"rtol": 1e-7}),
        (TORQUE, "quasi_steady", prsm.QuasiSteady, {"rtol": 1e-6}),
    ],
)
def test_a_word_is_computed_as_its_object(scene, word, method, options):
    of_word = simulate(ONE, scene, method=word, **options)
    of_object = simulate(ONE, scene, method=method(**options))
    assert of_word.solver.name == of_object.solver.name
    assert int(of_word.solver.steps) == int(of_object.solver.steps)
    np.testing.assert_array_equal(of_word.carrier_ratio, of_object.carrier_ratio)


def test_options_reach_the_solver():
    """A looser tolerance takes fewer steps; steps that run out are told."""
    loose, tight = (simulate(ONE, SWING, method=prsm.Rodasp(rtol=r)) for r in (1e-4, 1e-9))
    assert int(loose.solver.steps) < 0.5 * int(tight.solver.steps)
    assert int(simulate(ONE, SWING, method=prsm.Rodasp(max_steps=4)).solver.code) == 1
    with pytest.raises(prsm.PrsmError, match="steps"):
        prsm.simulate(ONE, SWING, method=prsm.Rodasp(max_steps=4))


@pytest.mark.parametrize(
    "method",
    [
        prsm.Diffrax(
            diffrax.Kvaerno5(root_finder=optimistix.Newton(rtol=1e-8, atol=1e-8)), rtol=1e-8
        ),
        prsm.Diffrax(diffrax.Tsit5(), diffrax.PIDController(rtol=1e-8, atol=1e-10, pcoeff=0.3)),
        prsm.Diffrax(diffrax.Kvaerno3(), rtol=1e-7, atol=1e-9, max_steps=20_000),
    ],
    ids=["kvaerno", "controller", "chord"],
)
def test_any_solver_of_diffrax(method):
    exact = simulate(ONE, SWING, method=prsm.Rodasp(rtol=1e-11, atol=1e-13, max_steps=20_000))
    found = simulate(ONE, SWING, method=method)
    assert int(found.solver.code) == 0
    assert found.solver.name == type(method.solver).__name__
    error = np.max(np.abs(np.asarray(found.carrier_ratio - exact.carrier_ratio)))
    assert error < 2e-6


def test_any_solver_of_diffrax_under_a_prescribed_torque():
    exact = simulate(ONE, TORQUE, method=prsm.Rodasp(rtol=1e-9))
    found = simulate(ONE, TORQUE, method=prsm.Diffrax(diffrax.Tsit5(), rtol=1e-7))
    assert found.solver.name == "Tsit5 with events"
    np.testing.assert_allclose(
        found.screw_speed, exact.screw_speed, rtol=0, atol=1e-5 * np.max(exact.screw_speed)
    )
    smooth = mechanism(stage(friction=Friction(RegularisedCoulombFriction(0.05, 1e-2))))
    ends = [
        simulate(smooth, TORQUE, method=one).screw_speed[-1]
        for one in (prsm.Rodasp(), prsm.Diffrax(diffrax.Kvaerno5()))
    ]
    assert float(ends[0]) == pytest.approx(float(ends[1]), rel=1e-5)


@pytest.mark.parametrize(
    ("gradient", "solver"),
    [("forward", "Tsit5"), ("forward", "Kvaerno5"), ("both", "Tsit5"), ("reverse", "Kvaerno5")],
)
def test_derivatives_by_a_solver_of_diffrax(gradient, solver):
    method = prsm.Diffrax(getattr(diffrax, solver)(), rtol=1e-8, atol=1e-10)

    def last(load):
        scene = prsm.Scenario(SWING.speed, load, SWING.duration, samples=11)
        run = prsm.simulate(ONE, scene, method=method, gradient=gradient, throw=False)
        return run.carrier_ratio[0, -1]

    at = array(7e3)
    slope = jax.grad(last)(at) if gradient != "forward" else jax.jvp(last, (at,), (array(1.0),))[1]
    ends = [float(last(at + sign)) for sign in (-1.0, 1.0)]
    assert float(slope) == pytest.approx((ends[1] - ends[0]) / 2, rel=1e-4)


@pytest.mark.parametrize(
    ("scene", "method", "options", "message"),
    [
        (STEP, "closed_form", {"rtol": 1e-6}, "'closed_form' takes no options, but not rtol"),
        (SWING, "quasi_steady", {"max_steps": 9}, "no options at a prescribed speed, but not max"),
        (SWING, prsm.QuasiSteady(rtol=1e-6), {}, "no options at a prescribed speed, but not rtol"),
        (
            SWING,
            prsm.Rodasp(),
            {"rtol": 1e-6},
            r"is Rodasp\(…\).* write Rodasp\(…, rtol=…\)",
        ),
        (
            TORQUE,
            "closed_form",
            {},
            "under a prescribed torque choose auto, quasi_steady, rosenbrock",
        ),
        (
            TORQUE,
            prsm.ClosedForm(),
            {},
            "under a prescribed torque choose auto, quasi_steady, rosenbrock",
        ),
    ],
)
def test_what_a_method_does_not_take_is_refused(scene, method, options, message):
    with pytest.raises(ValueError, match=message):
        prsm.simulate(ONE, scene, method=method, **options)


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        *(("rtol", value, "above 0 and below 1") for value in (-1.0, 0.0, 1.0, np.nan, array(2.0))),
        *(("atol", value, "above 0 and finite") for value in (-1e-9, 0.0, np.inf)),
        ("atol", array(-1.0), "above 0 and finite"),
        ("max_steps", 0, "1 or more"),
    ],
)
def test_tolerances_and_steps_out_of_range_are_refused(option, value, words):
    for made in (
        lambda: prsm.Rodasp(**{option: value}),
        lambda: prsm.Diffrax(diffrax.Tsit5(), **{option: value}),
        lambda: prsm.simulate(ONE, STEP, method="implicit", **{option: value}),
    ):
        with pytest.raises(ValueError, match=rf": {option} is .*; give (a number )?{words}"):
            made()


def test_a_traced_tolerance_is_not_read():
    """So that tolerances can be swept by `vmap`, or differentiated by."""
    batch = jax.vmap(lambda r: prsm.Rodasp(rtol=r).rtol)(array([1e-4, 1e-6]))
    np.testing.assert_array_equal(batch, [1e-4, 1e-6])


class BogackiShampine(Integrating):
    """A method of a user's own, for one mode of differentiation."""

    gradients = ("forward",)

    def make_solver(self, rtol, atol, *, autonomous=False, compact=False):
        return diffrax.Bosh3()


@pytest.mark.parametrize("scene", [SWING, TORQUE], ids=["speed", "torque"])
def test_a_method_from_outside(scene):
    exact = simulate(ONE, scene, method=prsm.Rodasp(rtol=1e-9))
    own = simulate(ONE, scene, method=BogackiShampine(rtol=1e-7), gradient="forward")
    assert own.solver.name.split(" with ")[0] == "BogackiShampine"
    np.testing.assert_allclose(own.carrier_ratio, exact.carrier_ratio, rtol=0, atol=2e-6)
    with pytest.raises(ValueError, match="'both', but method BogackiShampine supports forward;"):
        prsm.simulate(ONE, scene, method=BogackiShampine())


def test_a_mode_of_differentiation_is_an_object_or_a_word():
    """A user's own mode reaches the integration: its adjoint is asked for once a program."""
    asked = []

    class Counted(ReverseMode):
        along_steps = False

        def adjoint(self):
            asked.append(self)
            return diffrax.RecursiveCheckpointAdjoint(checkpoints=40)

    def last(load, mode):
        scene = prsm.Scenario(SWING.speed, load, SWING.duration, samples=11)
        run = prsm.simulate(ONE, scene, method="rosenbrock", gradient=mode, throw=False)
        return run.carrier_ratio[0, -1]

    slopes = [jax.grad(last)(array(7e3), mode) for mode in ("reverse", ReverseMode(), Counted())]
    assert len(asked) == 1
    assert slopes[1] == slopes[0]
    # The repeated steps have other errors, of a few times the tolerance of 1e-8.
    np.testing.assert_allclose(slopes[2], slopes[0], rtol=1e-7)
    with pytest.raises(ValueError, match="gradient is 'sideways'; choose one of reverse, forward"):
        gradient_of("sideways")


def test_an_unknown_word_names_the_known_ones():
    with pytest.raises(ValueError, match="is 'runge'; choose one of auto, closed_form, quasi_st"):
        method_of("runge")


def test_the_closed_form_is_refused_with_smooth_friction_too():
    smooth = mechanism(stage(friction=Friction(RegularisedCoulombFriction(0.05, 1e-3))))
    with pytest.raises(ValueError, match="which needs a prescribed speed"):
        prsm.simulate(smooth, TORQUE, method="closed_form")


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: prsm.Diffrax("tsit5"), "solver is 'tsit5'; give a solver of diffrax"),  # pyright: ignore[reportArgumentType]
        (lambda: prsm.Diffrax(diffrax.KenCarp4()), "KenCarp4, which needs an equation"),
        (
            lambda: prsm.Diffrax(diffrax.Tsit5(), diffrax.ConstantStepSize()),  # pyright: ignore[reportArgumentType]
            "give one that adapts its steps",
        ),
    ],
)
def test_what_is_no_method_is_refused(made, message):
    with pytest.raises(ValueError, match=message):
        made()


def test_numbers_of_a_method_may_be_traced():
    """Tolerances in a batch; a controller that holds arrays, differentiated past."""
    found = jax.vmap(
        lambda rtol: prsm.simulate(
            ONE, STEP, method=prsm.Diffrax(diffrax.Tsit5(), rtol=rtol), throw=False
        ).carrier_ratio[0, -1]
    )(jax.numpy.asarray([1e-4, 1e-9]))
    exact = float(simulate(ONE, STEP, method="closed_form").carrier_ratio[0, -1])
    errors = np.abs(np.asarray(found) - exact)
    assert errors[1] < 1e-7
    assert errors[1] < 0.1 * errors[0]
