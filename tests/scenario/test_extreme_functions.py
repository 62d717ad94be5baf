"""Functions in a scenario that take other arguments, or return more than one number."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.scenario import SineProfile, SumLoad, check_scenario

_MECHANISM = prsm.load("wu2022")


def _scenario(**given: Any) -> prsm.Scenario:
    return prsm.Scenario(**{"speed": 10.0, "load": 1e3, "duration": 0.01, "samples": 3} | given)


@pytest.mark.parametrize(
    ("load", "arguments"),
    [
        (lambda t, x: 1e3, "t, x"),
        (lambda t, x, v: 1e3, "t, x, v"),
        (lambda t, x, v, a, force: 1e3, "t, x, v, a, force"),
        (lambda: 1e3, "none"),
    ],
)
def test_a_load_with_other_arguments(load, arguments):
    expected = (
        rf"^Scenario: load is a function with the arguments \({arguments}\); it must take 1 "
        r"\(time\), or 4 \(time, position, speed and acceleration of the nut\)$"
    )
    for one in (load, SumLoad((1e3, load))):
        with pytest.raises(ValueError, match=expected):
            prsm.simulate(_MECHANISM, _scenario(load=one))


def test_a_drive_with_other_arguments():
    torque: Any = lambda t, x: 10.0  # noqa: E731
    for name, scenario in (
        ("Scenario: speed", _scenario(speed=lambda t, x: 10.0)),
        ("TorqueScenario: torque", prsm.TorqueScenario(torque, 1e3, 0.01)),
    ):
        expected = rf"^{name} is a function with the arguments \(t, x\); it must take 1 \(time\)$"
        with pytest.raises(ValueError, match=expected):
            prsm.simulate(_MECHANISM, scenario)


def test_functions_with_the_right_arguments_pass():
    class Own:
        def __call__(self, time):
            return 1e3 * time

    parts: Any = (1e3, lambda t: 1e3, lambda t, x, v, a: v)
    for load in (
        1e3,
        lambda t: 1e3,
        lambda t, scale=2.0: scale * t,
        lambda *given: 1e3,
        lambda t, x, v, a: 1e3,
        lambda t, x, v, a, scale=1.0: 1e3,
        SineProfile(10.0, 5.0),
        SumLoad(parts),
        Own(),
        np.cos,
    ):
        check_scenario(_scenario(load=load))


@pytest.mark.parametrize(
    ("what", "given"),
    [
        ("load", {"load": lambda t: jnp.ones(2)}),
        ("load", {"load": lambda t, x, v, a: jnp.ones(2)}),
        ("speed or torque", {"speed": lambda t: jnp.ones(2)}),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_a_function_that_returns_two_numbers(what, given):
    expected = (
        rf"^the function for the {what} returns an array of shape \(2,\); it must return one "
        r"number at each time"
    )
    with pytest.raises(ValueError, match=expected):
        prsm.simulate(_MECHANISM, _scenario(**given))
