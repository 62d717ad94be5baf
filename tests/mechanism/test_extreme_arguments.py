"""Arguments of another kind, and arrays in place of one design or one number, are refused."""

import re
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.fields import Scalar
from prsm_jax.scenario import SineProfile

_MECHANISM = prsm.load("wu2022")
_BATCH = jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), _MECHANISM)
_LOADS = np.array([1e3, 2e3, 4e3])

_VERBS = {
    "steady_state": lambda **given: prsm.steady_state(_MECHANISM, **given),
    "compute": lambda **given: prsm.compute(_MECHANISM, ["efficiency"], **given),
    "modal": lambda **given: prsm.modal(_MECHANISM, **given),
    "spatial_modal": lambda **given: prsm.spatial_modal(_MECHANISM, **given),
    "thread_contacts": lambda **given: prsm.thread_contacts(_MECHANISM, **given),
    "load_distribution": lambda **given: prsm.load_sharing.load_distribution(_MECHANISM, **given),
    "sensitivity": lambda **given: prsm.sensitivity(_MECHANISM, ["efficiency"], **given),
    "sweep": lambda **given: prsm.sweep(_MECHANISM, {"lead": [1e-2]}, ["efficiency"], **given),
    "tolerance": lambda **given: prsm.tolerance(_MECHANISM, ["efficiency"], **given),
    "optimise": lambda **given: prsm.optimise(_MECHANISM, **given),
}


@pytest.mark.parametrize("verb", list(_VERBS))
@pytest.mark.parametrize(
    ("load", "shape"),
    [
        (_LOADS, "(3,)"),
        (_LOADS[:1], "(1,)"),
        (jnp.ones((2, 1)), "(2, 1)"),
        ([1e3, 2e3], "(2,)"),
    ],
    ids=["numpy", "one", "jax", "list"],
)
def test_several_loads_are_refused(verb, load, shape):
    expected = rf"{verb}: load has the shape {re.escape(shape)}, and {verb} takes one load; "
    with pytest.raises(ValueError, match=expected):
        _VERBS[verb](load=load)


@pytest.mark.parametrize("verb", list(_VERBS))
@pytest.mark.parametrize("load", [100 + 0j, np.complex128(1e3 + 2j), jnp.array(1e3 + 1j)])
def test_a_complex_load_is_refused(verb, load):
    expected = f"{verb}: load is complex: {complex(load)}; give real numbers"
    with pytest.raises(ValueError, match=re.escape(expected)):
        _VERBS[verb](load=load)


@pytest.mark.usefixtures("unchecked")
def test_a_complex_number_in_a_trace_is_refused():
    with pytest.raises(ValueError, match="load is complex; give real numbers"):
        jax.jit(lambda load: prsm.steady_state(_MECHANISM, load=load))(1e3 + 1j)
    # Without a door in front.
    number: Any = 1e-3 + 1j
    with pytest.raises(ValueError, match=r"a number is complex: .*; give real numbers"):
        prsm.programs.one_program(_halved)(number)
    axes: Any = {"lead": [1e-2 + 1j]}
    with pytest.raises(ValueError, match=r"axis 'lead' is complex: .*; give real numbers"):
        prsm.sweep(_MECHANISM, axes, ["efficiency"])


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize("number", [5e3 + 1j, np.complex128(5e3), jnp.asarray(5e3 + 1j)])
def test_a_complex_number_in_a_field_is_refused(number):
    """A scenario with 5000 + 9e9 i gave the results of 5000."""
    makers: tuple[Any, ...] = (
        lambda: prsm.Scenario(speed=100.0, load=number, duration=1e-3),
        lambda: prsm.Scenario(speed=number, load=5e3, duration=1e-3),
        lambda: prsm.scenario.HingeLoad(number),
        lambda: prsm.scenario.SineProfile(number, 5.0),
        lambda: prsm.mechanism.DutyCycle([1.0], [2.0], [number]),
    )
    for make in makers:
        with pytest.raises(ValueError, match=r"a number is complex: .*5000.*; give real numbers"):
            make()
    for name in ("load", "stage.thread.lead"):
        with pytest.raises(ValueError, match=rf"{name} is complex: .*; give real numbers"):
            prsm.set_parameter(_MECHANISM, name, number)
        with pytest.raises(ValueError, match=rf"{name} is complex: .*; give real numbers"):
            prsm.mechanism.set_parameters(_MECHANISM, {name: number})


def _halved(number: float | Scalar):
    return number / 2


def test_several_speeds_and_onsets_are_refused():
    steady_state: Any = prsm.steady_state
    for name in ("speed", "onset"):
        remedy = (
            f"map it over the batch: jax.vmap(lambda {name}: prsm.steady_state(mechanism, "
            f"{name}={name}))({name}s)"
        )
        with pytest.raises(ValueError, match=re.escape(remedy)):
            steady_state(_MECHANISM, **{name: _LOADS})


@pytest.mark.usefixtures("unchecked")
def test_several_loads_in_a_trace_are_refused():
    with pytest.raises(ValueError, match=r"load has the shape \(3,\)"):
        jax.jit(lambda load: prsm.steady_state(_MECHANISM, load=load))(_LOADS)
    # Without a verb in front.
    analysis = prsm.quantities.Analysis(_MECHANISM, load=jnp.asarray(_LOADS))
    with pytest.raises(ValueError, match=r"load has the shape \(3,\), and an operating point"):
        _ = analysis.load


def test_loads_are_mapped_as_the_message_says():
    """The contact pressure grows with the cube root of the load."""
    found = jax.vmap(lambda load: prsm.compute(_MECHANISM, ["max_pressure"], load=load))(_LOADS)
    pressure = np.asarray(found["max_pressure"])
    np.testing.assert_allclose(pressure / pressure[0], np.cbrt(_LOADS / _LOADS[0]), rtol=1e-12)


_SCENARIOS = {
    "speed": lambda two: prsm.Scenario(speed=two, load=1e3, duration=0.01),
    "load": lambda two: prsm.Scenario(speed=10.0, load=two, duration=0.01),
    "speed.amplitude": lambda two: prsm.Scenario(SineProfile(two, 5.0), 1e3, 0.01),
    "torque": lambda two: prsm.TorqueScenario(torque=two, load=1e3, duration=0.01),
}


@pytest.mark.parametrize("path", list(_SCENARIOS))
def test_a_batch_of_scenarios_is_refused(path):
    scenario = _SCENARIOS[path](np.array([1.0, 2.0]))
    for verb in (prsm.simulate, prsm.dynamics.choose_method):
        expected = (
            rf"{verb.__name__}: scenario.{path} has the shape \(2,\), so this is a batch of "
            rf"scenarios, and {verb.__name__} takes one scenario; map it over the batch: "
            r"jax\.vmap\(lambda scenario: prsm\."
        )
        with pytest.raises(ValueError, match=expected):
            verb(_MECHANISM, scenario)


def test_a_batch_of_scenarios_is_mapped():
    """Each design keeps its own speed."""
    speeds = np.array([50.0, 100.0])

    def speed_at_end(scenario):
        return prsm.simulate(_MECHANISM, scenario, throw=False).screw_speed[-1]

    fixed = jax.vmap(lambda speed: prsm.Scenario(speed, 1e3, 0.01))(jnp.asarray(speeds))
    found = jax.vmap(speed_at_end)(fixed)
    np.testing.assert_allclose(found, speeds, rtol=1e-15)


def _refused(call, *words: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(''.join(words))}$"):
        call()


def test_the_remedy_for_a_batch_can_be_called():
    place = "stages[0].thread.lead has the shape (2,), so this is a batch of designs, and "
    _refused(
        lambda: prsm.compute(_BATCH, ["mass"]),
        f"compute: {place}compute takes one mechanism; map it over the batch: ",
        "jax.vmap(lambda mechanism: prsm.compute(mechanism, quantities))(mechanisms)",
    )
    _refused(
        lambda: prsm.load_sharing.load_distribution(_BATCH),
        f"load_distribution: {place}load_distribution takes one mechanism; map it over the batch: ",
        "jax.vmap(prsm.load_sharing.load_distribution)(mechanism)",
    )
    for verb in (prsm.explain, prsm.dumps):
        name = verb.__name__
        _refused(
            lambda verb=verb: verb(_BATCH),
            f"{name}: {place}{name} takes one mechanism; call it with each design, one after the ",
            "other",
        )


@pytest.mark.parametrize(
    "verb",
    [
        prsm.steady_state,
        prsm.modal,
        prsm.spatial_modal,
        prsm.check,
        prsm.simulate,
        prsm.optimise,
        prsm.explain,
        prsm.dumps,
        prsm.strength_checks,
        lambda given: prsm.compute(given, ["mass"]),
        lambda given: prsm.dump(given, "never.toml"),
        lambda given: prsm.get_parameter(given, "lead"),
        lambda given: prsm.set_parameter(given, "lead", 12e-3),
        lambda given: prsm.assumptions(given),
    ],
)
def test_a_name_in_place_of_a_mechanism(verb):
    words = r"takes a mechanism, not the text 'wu2022'; load it: prsm\.load\('wu2022'\)$"
    with pytest.raises(ValueError, match=words):
        verb("wu2022")
    with pytest.raises(ValueError, match=r"takes a mechanism, not 5$"):
        verb(5)


def test_other_arguments_of_another_kind():
    simulate: Any = prsm.simulate
    _refused(
        lambda: simulate(_MECHANISM, 5),
        "simulate: scenario must be a Scenario or a TorqueScenario, not 5",
    )
    mesh: Any = prsm.mesh
    _refused(lambda: mesh(_MECHANISM), f"mesh takes a thread, not {_MECHANISM!r}")
    steady_state: Any = prsm.steady_state
    _refused(
        lambda: steady_state(_MECHANISM, load="7 kN"),
        "steady_state: load is the text '7 kN', and must be a number in SI units",
    )


@pytest.mark.parametrize("value", ["12 mm", None])
def test_a_word_in_place_of_a_number_of_a_mechanism(value):
    wrong = eqx.tree_at(lambda m: m.stages[0].thread.lead, _MECHANISM, value)
    _refused(
        lambda: prsm.steady_state(wrong),
        f"steady_state: stages[0].thread.lead is {value!r}, and must be a number in SI units, ",
        "such as 12e-3 for 12 mm",
    )


@pytest.mark.parametrize(
    ("name", "text", "unit"), [("lead", "10 mm", "m"), ("roller_count", "10", "1")]
)
def test_a_text_in_place_of_a_parameter(name, text, unit):
    expected = f"{name} is the text {text!r}; give a number in SI, here in {unit}"
    _refused(lambda: prsm.set_parameter(_MECHANISM, name, text), expected)
