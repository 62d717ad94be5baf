"""Public functions run as one compiled program, and other numbers compile nothing.

Counted are compilations, by JAX's own events, not seconds.
"""

import contextlib
import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.monitoring
import jax.numpy as jnp
import numpy as np
import pytest
from jax.core import Tracer

import prsm_jax as prsm
from prsm_jax.programs import _one_verb, bind_program, one_program_where_possible
from prsm_jax.programs._one_program import one_program
from tests.scenes import array, mechanism, stage

_COMPILED = "/jax/core/compile/backend_compile_duration"
_TRACED = "/jax/core/compile/jaxpr_trace_duration"
_counted: list[str] = []
_traced: list[str] = []


def _heard(event, duration, **about):
    if event == _COMPILED:
        _counted.append(str(about.get("fun_name")))
    if event == _TRACED:
        _traced.append(str(about.get("fun_name")))


jax.monitoring.register_event_duration_secs_listener(_heard)  # pyright: ignore[reportArgumentType]


@contextlib.contextmanager
def compilations():
    """The names of the programs that are compiled inside, in a list that fills."""
    names: list[str] = []
    before = len(_counted)
    yield names
    names += _counted[before:]


ONE, OTHER = (mechanism(stage(roller_count=n), speed=speed) for n, speed in ((7, 90.0), (7, 80.0)))
ANOTHER = mechanism(stage(roller_count=8))
SINE = prsm.scenario.SineProfile


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
    # The first trace in a process also compiles single operations of diffrax, whatever the scene.
    jax.eval_shape(
        lambda number: prsm.simulate(ANOTHER, scene(number), method=method, throw=False).time,
        jnp.asarray(first),
    )
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
            prsm.dynamics.energy(run, "loss"),
            prsm.dynamics.mean_efficiency(run),
            prsm.dynamics.peak(run.drive_torque),
            prsm.dynamics.settling_time(run.time, run.carrier_ratio[0], 0.02),
            prsm.dynamics.body_forces(one, run),
        )

    with compilations() as made:
        numbers(ONE, runs[0])
    assert len(made) <= 8
    with compilations() as made:
        numbers(OTHER, runs[1])
    assert made == []


def test_users_functions_are_told_apart_by_what_they_are():
    def turned(speed):
        run = prsm.simulate(ONE, _step(speed), method="quasi_steady")
        return np.asarray(run.screw_speed)

    def plain(time):
        return 90.0 + 5e4 * time

    np.testing.assert_allclose(turned(plain), [90.0, 115.0, 140.0], rtol=1e-12)
    np.testing.assert_allclose(turned(Ramp(5e4)), turned(plain), rtol=1e-12)
    # Ramp asks its slope, a Python number, for its sign; another is another program.
    assert np.ptp(turned(Ramp(-1.0))) == 0
    with compilations() as made:
        turned(plain)
    assert made == []


def test_what_cannot_be_told_apart_runs_without_a_program():
    @dataclasses.dataclass
    class Unhashable:
        slope: float

        def __call__(self, time):
            return self.slope * time

    sides = []

    @one_program
    def applied(function, time):
        sides.append(isinstance(time, Tracer))
        return function(time)

    assert float(applied(Unhashable(2.0), 3.0)) == 6.0
    assert float(applied(jnp.sqrt, 9.0)) == 3.0
    assert sides == [False, True]


def test_gradient_by_a_number_that_no_argument_shows():
    """A user's function has it from around it; differences are of the same number in a profile."""

    def profile(slope):
        return prsm.scenario.TableProfile(
            [0.0, 1e-3], jnp.stack([array(90.0), 90.0 + slope * 1e-3])
        )

    def work(slope, speed):
        run = prsm.simulate(ONE, _step(speed(slope)), method="quasi_steady", throw=False)
        return run.carrier_speed[0, 1]

    slope, change = array(5e4), 10.0
    exact = jax.grad(lambda slope: work(slope, lambda s: lambda time: 90.0 + s * time))(slope)
    sides = [work(slope + way * change, profile) for way in (1, -1)]
    # Carriers follow the speed nearly linearly: what is left is rounding over the change.
    np.testing.assert_allclose(exact, (sides[0] - sides[1]) / (2 * change), rtol=1e-7)
    assert exact != 0


def _efficiency(one):
    return prsm.steady_state(one).efficiency


def _highest(one):
    return prsm.modal(one).frequencies[-1]


def _pressure(one):
    return prsm.compute(one, ["max_pressure"])["max_pressure"]


@pytest.mark.parametrize("function", [_efficiency, _highest, _pressure])
def test_a_second_call_traces_and_compiles_nothing(function):
    """As a user writes them, each time with a new function to differentiate."""
    vibrating = prsm.load("wu2022")

    def both(one):
        return function(one), jax.grad(lambda other: function(other))(one)

    value, slope = jax.block_until_ready(both(vibrating))
    before = len(_traced)
    with compilations() as made:
        other, again = jax.block_until_ready(both(vibrating))
    assert made == []
    assert _traced[before:] == []
    assert float(other) == float(value)
    assert jax.tree.all(jax.tree.map(np.array_equal, slope, again))
    # The same derivative where it is part of the program of a user.
    whole = jax.jit(jax.grad(function))(vibrating)
    scale = [float(jnp.abs(leaf).max()) for leaf in jax.tree.leaves(whole)]
    for exact, found, size in zip(*map(jax.tree.leaves, (whole, slope)), scale, strict=True):
        np.testing.assert_allclose(found, exact, rtol=1e-11, atol=1e-14 * size)


@pytest.mark.parametrize(
    "function",
    [
        lambda m, number: prsm.frequency_response(m, "screw u", "nut u", [293.0, number]).value,
        lambda m, number: prsm.response.mesh_response(m, [50.0, number]).displacement,
        lambda m, number: prsm.campbell(m, load=number, orders=["carrier"]).modes.frequencies,
    ],
    ids=["frequency_response", "mesh_response", "campbell"],
)
def test_a_second_response_traces_and_compiles_nothing(function):
    vibrating = prsm.load("wu2022")
    with compilations() as made:
        jax.block_until_ready(function(vibrating, 300.0))
    # Its own, and single operations that prepare the numbers.
    assert len(made) <= 8
    before = len(_traced)
    with compilations() as made:
        jax.block_until_ready(function(vibrating, 310.0))
    assert made == []
    assert _traced[before:] == []


def test_responses_take_plain_numbers_in_a_mechanism():
    """As `eqx.tree_at` puts them there."""
    one = prsm.load("wu2022")
    lead = float(prsm.get_parameter(one, "lead"))
    plain = eqx.tree_at(lambda m: m.stages[0].thread.lead, one, lead)
    for function in (
        lambda m: prsm.frequency_response(m, "screw u", "nut u", 293.0).value,
        lambda m: prsm.response.mesh_response(m, 50.0).displacement,
    ):
        np.testing.assert_array_equal(function(plain), function(one))


def test_reverse_mode_outside_of_a_program_keeps_its_arguments_only():
    numbers = len(jax.tree.leaves(ONE))
    _, pull = jax.vjp(lambda one: prsm.steady_state(one).efficiency, ONE)
    assert len(jax.tree.leaves(pull)) <= numbers
    # In the program of a user nothing is calculated twice.
    whole = str(jax.make_jaxpr(jax.grad(_efficiency))(ONE))
    assert "checkpoint" not in whole
    assert "remat" not in whole


def test_every_way_to_differentiate_outside_of_a_program():
    lead = prsm.get_parameter(ONE, "stage.1.lead")

    def travel(lead):
        found = prsm.mesh(prsm.set_parameter(ONE, "stage.1.lead", lead).stages[0].thread)
        return jnp.sin(found.screw.contact_radius * 1e3)

    change = 1e-4 * lead
    first = (travel(lead + change) - travel(lead - change)) / (2 * change)
    ways = {
        "forward": jax.jvp(travel, (lead,), (jnp.ones_like(lead),))[1],
        "linear": jax.linearize(travel, lead)[1](jnp.ones_like(lead)),
        "reverse": jax.grad(travel)(lead),
        "mapped": jax.vmap(jax.grad(travel))(jnp.stack([lead, 2 * lead]))[0],
    }
    for name, found in ways.items():
        np.testing.assert_allclose(found, first, rtol=1e-6, err_msg=name)
        np.testing.assert_allclose(found, ways["forward"], rtol=1e-12, err_msg=name)
    second = (jax.grad(travel)(lead + change) - jax.grad(travel)(lead - change)) / (2 * change)
    for twice in (jax.hessian(travel), jax.grad(jax.grad(travel))):
        np.testing.assert_allclose(twice(lead), second, rtol=1e-5)
    assert abs(float(second)) > 0


_traces: list[int] = []


def _scaled(given, place):
    """A tree of numbers and words in the first place, an array in the last."""
    _traces.append(given["power"])
    return given["factor"] * place ** given["power"], -place


_compiled_scaled = one_program_where_possible(_scaled)


@pytest.mark.parametrize("of_one_verb", [False, True])
def test_a_bound_program_is_that_of_the_function(of_one_verb, monkeypatch):
    """Compiled once for all numbers, also in another binding; again for other words."""
    monkeypatch.setattr(_one_verb, "_one_verb", of_one_verb)
    _traces.clear()
    place = jnp.arange(3.0)
    for factor in (2.0, 5.0):
        given = {"factor": jnp.asarray(factor), "power": 3}
        bound = bind_program(_compiled_scaled, given)
        for shift in (0.0, 1.0, 2.0):
            values, negative = bound(place + shift)
            np.testing.assert_allclose(values, factor * (np.arange(3.0) + shift) ** 3, rtol=1e-15)
            np.testing.assert_array_equal(negative, -(np.arange(3.0) + shift))
    assert _traces == [3]
    other = bind_program(_compiled_scaled, {"factor": jnp.asarray(2.0), "power": 2})
    np.testing.assert_allclose(other(place)[0], 2 * np.arange(3.0) ** 2, rtol=1e-15)
    assert _traces == [3, 2]


def test_true_and_one_are_not_the_same_to_a_bound_program():
    kind = one_program_where_possible(_number_of_kind)
    place = jnp.zeros(())
    assert [float(bind_program(kind, one)(place)) for one in (1, True, 1)] == [0.0, 1.0, 0.0]


def _number_of_kind(given, place):
    return place + float(isinstance(given, bool))


def test_what_cannot_be_hashed_is_bound_without_a_program():
    bound = bind_program(one_program_where_possible(_first_and_last), {"words": _Unhashable()})
    assert float(bound(jnp.asarray(2.0))) == 4.0


class _Unhashable:
    __hash__ = None  # type: ignore[assignment]


def _first_and_last(given, place):
    assert isinstance(given["words"], _Unhashable)
    return 2 * place


_SAME_NUMBER: tuple[Any, ...] = (
    100,
    np.int64(100),
    np.float32(100.0),
    np.float64(100.0),
    np.asarray(100.0),
)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(
    "verb",
    [
        lambda speed: prsm.steady_state(ONE, speed=speed).drive_torque,
        lambda speed: prsm.steady_state(ONE, speed).drive_torque,
        lambda load: prsm.modal(ONE, load=load).frequencies,
        lambda speed: prsm.compute(ONE, ["loss_power"], speed=speed)["loss_power"],
    ],
    ids=["steady_state", "by place", "modal", "compute"],
)
def test_a_number_of_another_type_compiles_nothing(verb):
    expected = verb(100.0)
    for number in (*_SAME_NUMBER, jnp.float32(100.0), jnp.asarray(100)):
        with compilations() as made:
            found = verb(number)
        assert made == [], type(number)
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected)


def test_a_number_of_another_type_in_float32():
    """The result is in the precision of the mechanism, as with a Python float."""
    single = prsm.programs.to_precision(ONE, jnp.float32)
    expected = prsm.steady_state(single, speed=100.0).drive_torque
    assert expected.dtype == jnp.float32
    for number in (*_SAME_NUMBER, jnp.float32(100.0)):
        with compilations() as made:
            found = prsm.steady_state(single, speed=number).drive_torque
        assert made == [], type(number)
        assert found.dtype == jnp.float32
        assert float(found) == float(expected)
