"""Where power or energy comes from and where it goes, every loss by name."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from ...dynamics import SteadyState, Transient, travel_per_turn
from ...mechanism import Mechanism
from ._history_chart import integrated

#: What stays in moving masses is no energy below this share of all that flowed: the trapezoidal
#: rule leaves so much where they start and end at rest.
_ROUNDING = 1e-4
#: Names of the terms that are no losses.
MOTOR, LOAD, KINETIC = "motor", "load", "moving masses"
BRISTLES = "bristles"


@dataclasses.dataclass(frozen=True)
class PowerFlow:
    """Sources and sinks by name, of equal sum; `unit` is "W" or "J"."""

    sources: Mapping[str, float]
    sinks: Mapping[str, float]
    unit: str

    @property
    def total(self) -> float:
        """Sum of the sources."""
        return sum(self.sources.values(), 0.0)


def _flow(given: Mapping[str, tuple[float, float]], unit: str) -> PowerFlow:
    """From (into the mechanism, out of it) by name."""
    sources = {name: into for name, (into, _) in given.items() if into > 0}
    sinks = {name: out for name, (_, out) in given.items() if out > 0}
    return PowerFlow(sources, sinks, unit)


def steady_flow(state: SteadyState, load_drives: bool = False) -> PowerFlow:
    """Power flow of a steady state [W].

    **Arguments:**

    - `state`: the steady state.
    - `load_drives`: whether it is one in which the load drives the screw back.
    """
    lost = {name: (0.0, float(power)) for name, power in state.losses.items()}
    given, useful = float(state.input_power), float(state.output_power)
    driving, driven = (LOAD, MOTOR) if load_drives else (MOTOR, LOAD)
    # A mechanism that locks itself takes power from both ends.
    ends = {driving: (given, 0.0), driven: (max(-useful, 0.0), max(useful, 0.0))}
    return _flow({**ends, **lost}, "W")


@dataclasses.dataclass(frozen=True)
class PowerHistory:
    """Powers in time [W], into the mechanism positive; losses are what they take."""

    time: np.ndarray
    motor: np.ndarray
    load: np.ndarray
    losses: Mapping[str, np.ndarray]
    #: Of the moving masses, positive where they give energy back.
    kinetic: np.ndarray
    #: Of the bristles between threads; zero without such a law.
    bristles: np.ndarray


def power_history(mechanism: Mechanism, run: Transient) -> PowerHistory:
    """Powers of a transient.

    The rate of the kinetic energy is what is left of the balance, whose residual the transient
    reports.
    """
    speed = np.asarray(run.screw_speed)
    travel = float(travel_per_turn(mechanism.stages, len(mechanism.stages)))
    motor = np.asarray(run.drive_torque) * speed
    load = -np.asarray(run.load) * travel * speed
    losses = {name: np.asarray(power) for name, power in run.losses.items()}
    bristles = np.zeros_like(motor)
    if run.bristle_power is not None:
        bristles = -np.asarray(run.bristle_power)
    kinetic = sum(losses.values(), np.zeros_like(motor)) - motor - load - bristles
    return PowerHistory(np.asarray(run.time), motor, load, losses, kinetic, bristles)


def energy_flow(mechanism: Mechanism, run: Transient) -> PowerFlow:
    """Energy flow of a whole transient [J].

    What the motor gives and what it takes back while it brakes are counted apart, and so for the
    load. Moving masses count with what is left in them, or taken out of them, in the end, unless
    that is less than a ten-thousandth of all.
    """
    powers = power_history(mechanism, run)

    def energy(power: np.ndarray) -> float:
        return float(integrated(run, power)[-1])

    def ends(power: np.ndarray) -> tuple[float, float]:
        return energy(np.maximum(power, 0.0)), energy(np.maximum(-power, 0.0))

    least = _ROUNDING * (energy(np.abs(powers.motor)) + energy(np.abs(powers.load)))

    def stored(power: np.ndarray) -> tuple[float, float]:
        net = energy(power)
        if abs(net) < least:
            return 0.0, 0.0
        return max(net, 0.0), max(-net, 0.0)

    lost = {name: (0.0, energy(power)) for name, power in powers.losses.items()}
    return _flow(
        {
            MOTOR: ends(powers.motor),
            LOAD: ends(powers.load),
            KINETIC: stored(powers.kinetic),
            BRISTLES: stored(powers.bristles),
            **lost,
        },
        "J",
    )
