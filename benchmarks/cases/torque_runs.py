"""Torque-driven runs: quasi-steady against integrated carriers, by tolerance, and SciPy."""

import functools
from math import pi, sin

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax import TorqueScenario, simulate
from prsm_jax.file import load
from prsm_jax.friction import CoulombFriction, Friction
from prsm_jax.mechanism import Mechanism, get_parameter, set_parameter
from prsm_jax.scenario import HingeLoad

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references.transients.torque_runs import Run, TorqueChain

_SPEED, _CARRIER = "screw speed", "carrier speed"
_SAMPLES, _DURATION, _LOAD = 101, 0.5, 7000.0
#: Torque, amplitude in N·m and frequency in Hz.
_MEAN, _AMPLITUDE, _FREQUENCY = 9.0, 8.0, 4.0
#: Speed that both speeds are measured by [rad/s]; about the fastest of the run.
_PEAK = 650.0


class _Swing(eqx.Module):
    mean: jax.Array
    amplitude: jax.Array
    frequency: jax.Array

    def __call__(self, time):
        return self.mean + self.amplitude * jnp.sin(2 * jnp.pi * self.frequency * time)


def _mechanism() -> Mechanism:
    """The first stage of Li et al. 2020 with heavy rollers, so that the carriers matter."""
    two = load("li2020_two_stage")
    stage = two.stages[0]
    assert stage.friction is not None
    friction = Friction(CoulombFriction(jnp.asarray(0.1)))
    one = eqx.tree_at(
        lambda m: m.stages,
        eqx.tree_at(lambda m: m.scenario, two, None, is_leaf=lambda x: x is None),
        (eqx.tree_at(lambda s: s.friction, stage, friction),),
    )
    heavy = 10 * float(get_parameter(one, "roller.inertia"))
    one = set_parameter(one, "roller.inertia", jnp.asarray(heavy))
    return set_parameter(one, "screw.inertia", jnp.asarray(1e-3))


def _named(out):
    return {_SPEED: np.asarray(out[0])[None], _CARRIER: np.asarray(out[1])[None]}


@functools.cache
def _jitted(method: str):
    mechanism = _mechanism()

    def solve(rtol):
        swing = _Swing(*(jnp.asarray(x) for x in (_MEAN, _AMPLITUDE, _FREQUENCY)))
        hinge = HingeLoad(jnp.asarray(_LOAD))
        scenario = TorqueScenario(
            swing, hinge, jnp.asarray(_DURATION), samples=_SAMPLES, most_phases=12
        )
        run = simulate(
            mechanism,
            scenario,
            method=method,  # pyright: ignore[reportArgumentType]
            gradient="forward",
            rtol=rtol,
            atol=rtol * 1e-2,
            throw=False,
        )
        failed = run.solver.code != 0
        speeds = (jnp.where(failed, jnp.nan, x) for x in (run.screw_speed, run.carrier_speed))
        error = run.solver.error_estimate
        error = jnp.zeros_like(rtol) if error is None else error
        return *speeds, run.solver.steps + run.solver.rejected, error

    return jax.jit(solve)


def _ours(method: str, name: str, tolerances) -> Method:
    jitted = _jitted(method)

    def note(out) -> str:
        steps = f"{int(out[2])} steps"
        error = float(out[3])
        return steps if error == 0 else f"{steps}, neglect estimated at {error:.1e}"

    def prepare(rtol):
        given = jnp.asarray(rtol)
        return Prepared(lambda: jitted(given), 1, _named, note)

    return Method(name, prepare, tolerances, "rtol")


def _torque(time: float) -> float:
    return _MEAN + _AMPLITUDE * sin(2 * pi * _FREQUENCY * time)


def _followed(rtol: float, method: str) -> Run:
    chain = TorqueChain(_mechanism(), _torque, lambda *_: _LOAD)
    return chain.run(_DURATION, _SAMPLES, peak=_PEAK, rtol=rtol, method=method)


def _rival(solver: str, tolerances) -> Method:
    def prepare(rtol):
        return Prepared(
            lambda: _followed(rtol, solver), 1, lambda run: _named((run.speed, run.carriers))
        )

    return Method(f"SciPy {solver}, Cartesian speeds", prepare, tolerances, "rtol", kind="rival")


def _problem(quick: bool) -> Problem:
    tolerances = (1e-3, 1e-6, 1e-8) if quick else (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)

    def reference():
        run = _followed(1e-9 if quick else 1e-11, "Radau")
        return {
            _SPEED: Reference(run.speed[None], scale=_PEAK),
            _CARRIER: Reference(run.carriers[None], scale=_PEAK),
        }

    return Problem(
        name="stick_slip",
        title="Torque that swings beyond the limits of sticking, 0.5 s, one stage",
        instance="trajectory",
        methods=[
            _ours("rosenbrock", "integrated carriers, RODASP", tolerances),
            _ours("quasi_steady", "quasi-steady carriers, Tsit5", tolerances),
            _rival("Radau", tolerances[:2] if quick else (1e-3, 1e-5, 1e-7)),
        ],
        reference=reference,
        reference_note=(
            "SciPy Radau at rtol 1e-11 (1e-9 if quick) in Cartesian speeds, with events of its "
            f"own and equations written apart; errors are over {_PEAK:g} rad/s"
        ),
        baseline="SciPy Radau, Cartesian speeds",
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    return Case(
        "torque_runs",
        "Runs under a prescribed torque: quasi-steady or integrated carriers, against SciPy",
        [_problem(quick)],
    )
