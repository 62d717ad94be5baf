"""The shipped examples, and their runs: one compiled program for many rows.

Compiling dominates the run time, so both two-stage papers share one structure, and variations
change only numbers.
"""

import dataclasses
import functools
from typing import Any, TypeVar

import equinox as eqx
import jax
import numpy as np

from ..dynamics import (
    StageKinematics,
    SteadyState,
    Transient,
    all_kinematics,
    settling_time,
    simulate,
    steady_state,
)
from ..fields import as_scalar
from ..file import load
from ..friction import CoulombFriction, ThrustBearingFriction
from ..mechanism import Mechanism, set_parameter
from ..scenario import Scenario

_SAMPLES = 2001
_T = TypeVar("_T")


def given(part: _T | None) -> _T:
    """A part or number that the shipped examples have."""
    assert part is not None
    return part


@functools.cache
def example(name: str) -> Mechanism:
    """A shipped example, loaded once."""
    return load(name)


@functools.cache
def two_stages(name: str) -> Mechanism:
    """`li2020_two_stage` or `li2021_two_stage`, in one structure.

    Li et al. 2021 neglect the friction of the thrust bearing, which is a coefficient of 0.
    """
    mechanism = dataclasses.replace(example(name), title="")
    first, second = mechanism.stages
    if second.friction is not None and second.friction.thrust_bearing is None:
        friction = dataclasses.replace(
            second.friction,
            thrust_bearing=ThrustBearingFriction(CoulombFriction(as_scalar(0.0)), as_scalar(1.0)),
        )
        second = dataclasses.replace(second, friction=friction)
    return dataclasses.replace(mechanism, stages=(first, second))


def _numpy(tree) -> Any:
    return jax.tree.map(lambda leaf: np.asarray(leaf) if eqx.is_array(leaf) else leaf, tree)


@eqx.filter_jit
def _simulate(mechanism: Mechanism) -> Transient:
    point = given(mechanism.operating_point)
    scenario = Scenario(point.speed, point.load, given(point.duration), samples=_SAMPLES)
    return simulate(mechanism, scenario, gradient="forward")


@eqx.filter_jit
def _steady(mechanism: Mechanism, speed, load) -> SteadyState:
    return steady_state(mechanism, speed, load)


def _varied(name: str, changes: tuple[tuple[str, float], ...]) -> Mechanism:
    mechanism = two_stages(name) if len(example(name).stages) > 1 else example(name)
    for path, value in changes:
        mechanism = set_parameter(mechanism, path, value)
    return mechanism


@functools.cache
def transient(name: str, *changes: tuple[str, float]) -> Transient:
    """Transient of an example from rollers at rest, with numbers changed by name."""
    run = _numpy(_simulate(_varied(name, changes)))
    if int(run.solver.code) != 0:
        raise RuntimeError(f"the transient of {name} did not finish: {run.solver.result}")
    return run


@functools.cache
def steady(name: str, *changes: tuple[str, float], sense: float = 1.0) -> SteadyState:
    """Steady state of an example; with `sense` −1 the load drives the screw back."""
    mechanism = _varied(name, changes)
    point = given(mechanism.operating_point)
    return _numpy(_steady(mechanism, sense * point.speed, point.load))


def scene(name: str) -> tuple[Mechanism, Transient]:
    """A mechanism of these papers, and its transient from rollers at rest."""
    return _varied(name, ()), transient(name)


_kinematics = eqx.filter_jit(all_kinematics)


@functools.cache
def kinematics(name: str) -> tuple[StageKinematics, ...]:
    """Kinematics of every stage of a shipped example."""
    return _kinematics(scene(name)[0])


def knees(time: np.ndarray, curve: np.ndarray) -> list[float]:
    """Times at which a rising curve bends over, its minima of the second derivative, in order [s].

    **Arguments:**

    - `time`: equally spaced [s].
    - `curve`: of the same length; bends below 5 % of the sharpest are not counted.
    """
    bend = np.gradient(np.gradient(curve, time), time)
    inner = bend[1:-1]
    lowest = (inner < bend[:-2]) & (inner <= bend[2:]) & (inner < 0.05 * bend.min())
    return [float(t) for t in np.asarray(time)[1:-1][lowest]]


def time_to_settle(run: Transient, stage: int, within: float) -> float:
    """Time after which a carrier stays within a relative distance of its last ratio [s].

    **Arguments:**

    - `run`: the transient.
    - `stage`: index of the stage, from 0.
    - `within`: relative distance.
    """
    return float(settling_time(run.time, run.carrier_ratio[stage], within)[0])
