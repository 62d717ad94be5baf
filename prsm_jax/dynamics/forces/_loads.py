"""Loads that depend on the nut's motion; under a prescribed speed they are functions of time."""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import Mechanism
from ...programs import physics
from ...scenario import Scenario, break_times_of, depends_on_motion
from .._kinematics import travel_per_radian

#: Gauss–Legendre on [−1, 1], five points: exact to the ninth order in every interval.
_NODES = (-0.906179845938664, -0.5384693101056831, 0.0, 0.5384693101056831, 0.906179845938664)
_WEIGHTS = (
    0.23692688505618908,
    0.47862867049936647,
    0.5688888888888889,
    0.47862867049936647,
    0.23692688505618908,
)
#: Intervals of the quadrature between two samples.
_PER_SAMPLE = 2


class AngleByQuadrature(eqx.Module):
    """Angle of rotation for a speed without a closed-form integral.

    Integrals between nodes, which include the samples and the breaks of the speed, are summed once;
    one more interval completes the angle from the last node.
    """

    speed: Callable[..., Any]
    nodes: Float[Array, " nodes"]
    angles: Float[Array, " nodes"]

    def __call__(self, time: Scalar) -> Scalar:
        index = jnp.searchsorted(self.nodes, time, side="right", method="scan_unrolled") - 1
        index = jnp.clip(index, 0, len(self.nodes) - 1)
        return self.angles[index] + _gauss(self.speed, self.nodes[index], time)


def _gauss(speed: Callable[..., Any], start: Scalar, end: Scalar) -> Scalar:
    half, middle = (end - start) / 2, (end + start) / 2
    total = jnp.zeros_like(half)
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        total = total + weight * speed(middle + half * node)
    return half * total


def angle_by_quadrature(scenario: Scenario) -> AngleByQuadrature:
    """Integrate the speed of a scenario from 0 to its end."""
    count = _PER_SAMPLE * (scenario.samples - 1)
    grid = jnp.linspace(0.0, 1.0, count + 1, dtype=scenario.duration.dtype) * scenario.duration
    nodes = jnp.sort(jnp.concatenate([grid, scenario.break_times]))
    parts = jax.vmap(lambda a, b: _gauss(scenario.speed_at, a, b))(nodes[:-1], nodes[1:])
    angles = jnp.concatenate([jnp.zeros_like(parts[:1]), jnp.cumsum(parts)])
    return AngleByQuadrature(scenario.speed_at, nodes, angles)


class BoundLoad(eqx.Module):
    """A load that depends on the nut's motion, with known motion: a function of time."""

    load: Callable[..., Any]
    scenario: Scenario
    #: Travel of the nut per radian [m].
    travel: Scalar
    angle: Callable[..., Any] | None

    def position(self, time: Scalar) -> Scalar:
        """Position of the nut [m]."""
        angle = self.angle
        turned = self.scenario.speed_at(time) * time if angle is None else angle(time)
        return self.scenario.initial_position + self.travel * turned

    @physics("load_of_motion")
    def __call__(self, time: Scalar) -> Scalar:
        speed, acceleration = self.scenario.motion_at(time)
        acceleration = jnp.zeros_like(speed) if acceleration is None else acceleration
        return self.load(time, self.position(time), self.travel * speed, self.travel * acceleration)

    @property
    def break_times(self) -> Float[Array, " breaks"]:
        """Break times of the load [s]."""
        return break_times_of(self.load, self.travel.dtype)


def bound_scenario(mechanism: Mechanism, scenario: Scenario) -> Scenario:
    """A scenario whose load is a number or a function of time, as the mechanism moves the nut.

    The position follows from the angle of the speed in closed form where the speed has one (a
    number, or a function with a method `angle`), else by quadrature. Other scenarios are unchanged.

    **Arguments:**

    - `mechanism`: its leads convert rotation into travel.
    - `scenario`: prescribed speed and load.

    **Raises:** `MissingDataError` for a load that depends on the motion of a nut whose travel
    depends on friction (differential roller screws).
    """
    if not (callable(scenario.load) and depends_on_motion(scenario.load)):
        return scenario
    for stage in mechanism.stages:
        if not stage.thread.family.lead_is_fixed:
            raise MissingDataError(
                "scenario.load depends on the motion of the nut, which in a roller screw of type "
                f"{stage.thread.type!r} is not determined by the turns of the screw: friction "
                "changes its travel; give the load as a number or a function of time"
            )
    travel = travel_per_radian(mechanism.stages, len(mechanism.stages))
    angle = None
    if callable(scenario.speed):
        angle = getattr(scenario.speed, "angle", None) or angle_by_quadrature(scenario)
    load = BoundLoad(scenario.load, scenario, travel, angle)
    return dataclasses.replace(scenario, load=load)
