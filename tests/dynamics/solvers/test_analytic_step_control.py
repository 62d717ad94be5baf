"""Steps and what is read between them: dense output of Kvaerno's method, tolerances, lengths."""

import dataclasses
from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from benchmarks.extremes import structures
from prsm_jax.dynamics import BothModes, Explicit
from prsm_jax.dynamics.histories._integration import Settings, integrated
from prsm_jax.dynamics.solvers._kvaerno import Kvaerno
from prsm_jax.dynamics.solvers._methods import controller_of
from prsm_jax.dynamics.solvers._step_control import root_mean_square
from prsm_jax.dynamics.speed_drive._choose_method import scene_problem


@eqx.filter_jit
def _between(rate, start, length, shares):
    """One step of a length from 0, and the states at shares of it."""
    term, solver = diffrax.ODETerm(rate), Kvaerno(1e-12, 1e-14)
    end = jnp.asarray(length)
    _, _, dense, _, _ = solver.step(term, jnp.zeros_like(end), end, start, None, None, False)
    path = solver.interpolation_cls(t0=jnp.zeros_like(end), t1=end, **dense)
    return jax.vmap(path.evaluate)(shares * end)


def test_errors_are_judged_by_their_root_mean_square():
    """As diffrax judges them by itself: of all numbers of a state; NaN is not a small error."""
    errors = {"carriers": jnp.array([3e-9, -4e-9]), "screw": jnp.array(12e-9)}
    assert float(root_mean_square(errors)) == pytest.approx(13e-9 / np.sqrt(3), rel=1e-14)
    assert float(root_mean_square(errors)) == pytest.approx(
        float(diffrax.PIDController(rtol=1, atol=1).norm(errors)), rel=1e-14
    )
    assert float(root_mean_square([jnp.zeros(2)])) == 0.0
    assert np.isnan(root_mean_square([jnp.array([0.0, jnp.nan])]))


def test_states_between_two_steps_are_of_order_four():
    """Halving a step divides the local error by 2⁵; a cubic through both ends would give 2⁴."""
    shares = jnp.linspace(0.0, 1.0, 9)

    def rate(t, y, _):
        return -y * jnp.cos(t) - y**2

    start = jnp.array([1.0])
    errors = []
    for length in (0.05, 0.025):
        exact = diffrax.diffeqsolve(
            diffrax.ODETerm(rate),
            diffrax.Dopri8(),
            t0=0.0,
            t1=length,
            dt0=None,
            y0=start,
            saveat=diffrax.SaveAt(ts=shares * length),
            stepsize_controller=diffrax.PIDController(rtol=1e-13, atol=1e-14, dtmax=length / 8),
        ).ys
        errors.append(float(jnp.max(jnp.abs(_between(rate, start, length, shares) - exact))))
    assert errors[0] < 1e-7
    assert errors[0] > 21 * errors[1]


@pytest.mark.parametrize("decay", [1e2, 1e5, 1e8])
def test_what_decays_within_a_step_does_not_grow_in_between(decay):
    """At most 6.7 times the start, where the cubic through both ends has an error of 4/27 `h λ`."""
    shares = jnp.linspace(0.0, 1.0, 21)
    path = _between(lambda t, y, _: -decay * y, jnp.array([1.0]), 1.0, shares)
    assert 4.5 < float(jnp.max(jnp.abs(path))) < 6.7
    # The cubic from the slope at the start alone: that at the end is finite.
    cubic = decay * shares * (1 - shares) ** 2
    assert float(jnp.max(cubic)) == pytest.approx(4 / 27 * decay, rel=1e-2)


def test_in_single_precision_reverse_takes_the_steps_that_forward_took():
    """At tolerances below rounding the two were 4 % apart on carriers, here 8e-4."""
    settings = Settings(Explicit(), BothModes(), 1e-8, 1e-10, 4096).within(jnp.float32)
    assert settings.rtol > 1e-6

    @jax.jit
    def run(rates):
        end = jnp.float32(3.0)

        def rate(t, y, slopes):
            lag = y - jnp.cos(t)
            return -slopes * lag / jnp.sqrt(lag**2 + 1e-2)

        start = jnp.zeros(2, jnp.float32)
        states, report = integrated(
            rate, start, end, jnp.zeros(0, jnp.float32), 21, settings, args=rates
        )
        return jnp.sum(states), report.code

    rates = jnp.array([3.0, 40.0], jnp.float32)
    (value, code), (forward, _) = jax.jvp(run, (rates,), (rates,))
    reverse = jax.grad(lambda r: run(r)[0])(rates) @ rates
    assert int(code) == 0
    assert np.isfinite(float(value))
    assert float(reverse) == pytest.approx(float(forward), rel=2e-5, abs=1e-5)


@pytest.mark.parametrize(
    "speed",
    [
        # Eight strokes in eight intervals: at the ends of all of them the screw stands still.
        prsm.scenario.SequenceProfile(
            (prsm.scenario.TrapezoidalProfile(*map(jnp.asarray, (200.0, 0.03, 0.24, 0.03, 0.06))),),
            repeats=8,
            reversing=True,
        ),
        # Four periods in eight intervals: sine of whole multiples of π.
        prsm.scenario.SineProfile(amplitude=200.0, frequency=4 / 2.88, mean=0.0),
    ],
    ids=["strokes", "sine"],
)
def test_scales_of_a_speed_that_is_zero_at_equal_intervals(speed):
    """They were 1 rad/s and the whole duration: 1.6 times as many steps, or 1e15 of a state."""
    two = structures._chain(2)
    scenario = prsm.Scenario(speed, jnp.asarray(7e3), jnp.asarray(2.88), samples=11)
    problem = scene_problem(two, scenario, None)
    assert 0.9 * 200.0 < float(problem.speed_scale) <= 200.0
    assert float(problem.time_scale) < 1e-3


def test_derivatives_take_the_steps_of_the_values():
    """A drive with bends: steps of the record are those taken, and both modes one derivative."""
    ramps = prsm.scenario.TableProfile(
        jnp.asarray([0.0, 2e-4, 3e-4]), jnp.asarray([0.0, 100.0, 50.0])
    )
    scenario = prsm.Scenario(ramps, jnp.asarray(7e3), jnp.asarray(3e-4), samples=7)
    base = structures._chain(1)
    part = base.stages[0]
    screw = dataclasses.replace(part.screw, mass=jnp.asarray(0.5))
    mechanism = dataclasses.replace(
        base, stages=(dataclasses.replace(part, screw=screw),), scenario=scenario
    )

    def last(factor, gradient):
        moved = prsm.set_parameter(mechanism, "scenario.load", 7e3 * factor)
        # Loops of fewer steps are smaller programs.
        run = prsm.simulate(
            moved, method="rosenbrock", gradient=gradient, max_steps=256, throw=False
        )
        return run.carrier_ratio[0, -1], run.solver.steps

    one = jnp.asarray(1.0)

    @jax.jit
    def of_all(one):
        slope, counted = jax.jacfwd(lambda f: last(f, "both"), has_aux=True)(one)
        reverse = jax.grad(lambda f: last(f, "both")[0])(one)
        directly, own = jax.jacfwd(lambda f: last(f, "forward"), has_aux=True)(one)
        return slope, counted, reverse, directly, own

    slope, counted, reverse, directly, own = of_all(one)
    # As many as by `gradient="forward"`, which takes its own.
    assert int(counted) == int(own) > 20
    assert float(reverse) == pytest.approx(float(slope), rel=1e-9)
    assert float(directly) == pytest.approx(float(slope), rel=1e-6)


def _of_lead(lead: float):
    mechanism = structures._chain(1)
    mechanism = prsm.set_parameter(mechanism, "lead", lead)
    return dataclasses.replace(
        mechanism,
        scenario=prsm.Scenario(jnp.asarray(100.0), jnp.asarray(7e3), jnp.asarray(2e-4), samples=41),
    )


@pytest.mark.parametrize("method", ["implicit", "rosenbrock"])
def test_derivatives_where_friction_turns_within_a_millionth_of_the_ratio(method):
    """At a lead of a micrometre those of the efficiency were 283 and 21 times what they are."""

    @jax.jit
    def slopes(mechanism):
        def along(method):
            def efficiency(factor):
                moved = prsm.set_parameter(
                    mechanism, "roller_radius", mechanism.stages[0].thread.roller_radius * factor
                )
                return prsm.simulate(moved, method=method, throw=False).efficiency

            return jax.jvp(efficiency, (jnp.asarray(1.0),), (jnp.asarray(1.0),))[1]

        return along(method), along("closed_form")

    # 4 to 5e-4 of them before, at the first.
    for lead, bound in ((1e-4, 5e-5), (1e-6, 0.1)):
        found, exact = slopes(_of_lead(lead))
        assert float(jnp.max(jnp.abs(found - exact))) < bound * float(jnp.max(jnp.abs(exact)))


@pytest.mark.parametrize("method", ["rosenbrock", "quasi_steady"])
def test_a_prescribed_torque_in_single_precision_can_be_traced(method):
    """Events compare with 0.0, which is of double precision unless it is told."""
    short = structures.single_precision(structures._torque())
    shape = eqx.filter_eval_shape(lambda m: prsm.simulate(m, method=method, throw=False), short)
    assert shape.screw_speed.dtype == jnp.float32


#: Just before this end the rate jumps, so that every step to it has an error above the tolerance.
_END = 1155.4139760224207


def _up_to_the_end(rounded_before, wraps):
    """Result and steps of an integration whose rate jumps some roundings before its end."""
    end = jnp.asarray(_END)
    start = end - 1.0
    jump = end - rounded_before * np.spacing(_END)

    def rate(t, y, _):
        return jnp.where(t > jump, 1e5, jnp.cos(t)) * jnp.ones_like(y)

    controller = controller_of(1e-9, 1e-12, jnp.zeros(0), end)
    if not wraps:
        controller = diffrax.PIDController(rtol=1e-9, atol=1e-12)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(rate),
        diffrax.Tsit5(),
        t0=start,
        t1=end,
        dt0=jnp.asarray(0.01),
        y0=jnp.zeros(1),
        stepsize_controller=controller,
        max_steps=2000,
        throw=False,
    )


@pytest.mark.parametrize("rounded_before", [40, 80])
def test_the_last_step_is_not_rejected_for_ever(rounded_before):
    """diffrax shortens a step next to the end to half of what is left, again and again."""
    found = _up_to_the_end(rounded_before, True)
    assert found.result == diffrax.RESULTS.successful
    assert int(found.stats["num_steps"]) < 500
    # ∫ cos, and the jump times what is left: 1e5 · 80 roundings of 2e-13.
    exact = np.sin(_END) - np.sin(_END - 1)
    assert float(found.ys[-1, 0]) == pytest.approx(exact, abs=1e-5)


def test_diffrax_by_itself_does_not_end():
    """Why the controller is wrapped; where this fails, diffrax has been mended."""
    found = _up_to_the_end(80, False)
    assert found.result == diffrax.RESULTS.max_steps_reached


@pytest.mark.parametrize("error", [1.0, np.nan])
def test_only_finite_errors_next_to_the_end_are_accepted(error):
    end = jnp.asarray(_END)
    controller: Any = controller_of(1e-9, 1e-12, jnp.zeros(0), end)
    for left, kept in ((100, error == 1.0), (1e6, False)):
        start = end - left * np.spacing(_END)
        state = jnp.zeros(1)
        _, memory = controller.init(None, start, end, state, end - start, None, None, 4.0)
        keep, *_ = controller.adapt_step_size(
            start, end, state, state, None, jnp.full(1, error), 4.0, memory
        )
        assert bool(keep) == kept
