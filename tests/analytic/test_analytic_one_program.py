"""Public functions run as one compiled program, and other numbers compile nothing.

Counted are compilations, by JAX's own events, not seconds.
"""

import contextlib
import dataclasses

import equinox as eqx
import jax
import jax.monitoring
import pytest

import prsm_jax as prsm
from tests.scenes import mechanism, stage

_COMPILED = "/jax/core/compile/backend_compile_duration"
_counted: list[str] = []


def _heard(event, duration, **about):
    if event == _COMPILED:
        _counted.append(str(about.get("fun_name")))


jax.monitoring.register_event_duration_secs_listener(_heard)


@contextlib.contextmanager
def compilations():
    """The names of the programs that are compiled inside, in a list that fills."""
    names: list[str] = []
    before = len(_counted)
    yield names
    names += _counted[before:]


ONE, OTHER = (mechanism(stage(roller_count=n), speed=speed) for n, speed in ((7, 90.0), (7, 80.0)))
SINE = prsm.SineProfile


class Ramp(eqx.Module):
    """A user's function with a number that stays one: he may ask it which way it goes."""

    slope: float

    def __call__(self, time):
        return 90.0 + (self.slope * time if self.slope > 0 else 0.0 * time)


def _step(speed):
    return prsm.Scenario(speed, 7000.0, 1e-3, samples=3)


def _swing(speed):
    return prsm.Scenario(SINE(speed, 0.5, 2 * speed), 7000.0, 1.0, samples=3)


def _driven(torque):
    return prsm.TorqueScenario(torque, 7000.0, 1e-3, samples=3, most_phases=2)


@pytest.mark.parametrize(
    ("scene", "method", "first", "second", "solver"),
    [
        (_step, "auto", 90.0, 80.0, "closed form"),
        (_step, "rosenbrock", 90.0, 80.0, "RODASP"),
        (_swing, "auto", 50.0, 40.0, "quasi-steady balance"),
        (_driven, "quasi_steady", 12.0, 13.0, "quasi-steady carriers, Tsit5 with events"),
    ],
    ids=["closed form", "integrated", "quasi-steady", "torque"],
)
def test_a_transient_with_other_numbers_compiles_nothing(scene, method, first, second, solver):
    with compilations() as made:
        run = prsm.simulate(ONE, scene(first), method=method, throw=False)
    assert run.solver.name == solver
    # What chooses the method is another program, where the speed varies.
    own = [name for name in made if name in ("jit(_transient)", "jit(_quasi_steady)")]
    assert own.count("jit(_transient)") == 1
    assert len(own) == 1 + (scene is _swing)
    assert len(made) <= len(own) + 3
    with compilations() as made:
        again = prsm.simulate(OTHER, scene(second), method=method, throw=False)
        again = jax.block_until_ready(again)
    assert made == []
    assert float(again.drive_torque[-1]) != float(run.drive_torque[-1])


def test_what_follows_from_a_transient_is_one_program_too():
    runs = [prsm.simulate(ONE, _step(speed), method="rosenbrock") for speed in (90.0, 80.0)]

    def numbers(one, run):
        return (
            prsm.energy(run, "loss"),
            prsm.mean_efficiency(run),
            prsm.peak(run.drive_torque),
            prsm.settling_time(run.time, run.carrier_ratio[0], 0.02),
            prsm.body_forces(one, run),
        )

    with compilations() as made:
        numbers(ONE, runs[0])
    assert len(made) <= 8
    with compilations() as made:
        numbers(OTHER, runs[1])
    assert made == []


def test_users_functions_are_told_apart_by_what_they_are():
    @dataclasses.dataclass
    class Unhashable:
        slope: float

        def __call__(self, time):
            return 90.0 + self.slope * time

    def torque(speed):
        run = prsm.simulate(ONE, _step(speed), method="quasi_steady")
        return np.asarray(run.drive_torque), np.asarray(run.screw_speed)

    def plain(time):
        return 90.0 + 5e4 * time

    expected = torque(plain)
    for function in (Unhashable(5e4), Ramp(5e4)):
        for found, right in zip(torque(function), expected, strict=True):
            np.testing.assert_allclose(found, right, rtol=1e-12)
    # Ramp asks its slope, a Python number, for its sign; another is another program.
    assert np.ptp(torque(Ramp(-1.0))[1]) == 0
    with compilations() as made:
        torque(plain)
    assert made == []


@pytest.mark.parametrize("transform", [jax.grad, jax.jacfwd, lambda f: jax.jit(jax.grad(f))])
def test_gradients_with_and_without_a_program_agree(transform):
    """Also by a number that a user's function has from around it, and that no argument shows."""

    def work(slope):
        scene = _step(lambda time: 90.0 + slope * time)
        run = prsm.simulate(ONE, scene, method="rosenbrock", rtol=1e-6, atol=1e-8, throw=False)
        return run.carrier_speed[0, -1]

    around = transform(work)(array(5e4))
    inside = transform(
        lambda slope: prsm.simulate(
            ONE,
            _step(prsm.TableProfile([0.0, 1e-3], jnp.stack([array(90.0), 90.0 + slope * 1e-3]))),
            method="rosenbrock",
            rtol=1e-6,
            atol=1e-8,
            throw=False,
        ).carrier_speed[0, -1]
    )(array(5e4))
    np.testing.assert_allclose(around, inside, rtol=1e-4)
    assert around != 0
