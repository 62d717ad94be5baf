"""Sources and sinks of power or energy, with every loss by name."""

import dataclasses
from collections.abc import Mapping

import jax.numpy as jnp
import numpy as np

from ...dynamics import SteadyState, Transient, integral
from ...mechanism import Mechanism
from ._history_chart import nut_speed

#: Energy that remains in moving masses is ignored below this share of the total flow: the rule of
#: integration leaves as much where they start and end at rest.
_ROUNDING = 1e-4
#: Names of the terms that are not losses.
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


def _flow(terms: Mapping[str, tuple[float, float]], unit: str) -> PowerFlow:
    """Flow from pairs (into the mechanism, out of it) by name."""
    sources = {name: into for name, (into, _) in terms.items() if into > 0}
    sinks = {name: out for name, (_, out) in terms.items() if out > 0}
    return PowerFlow(sources, sinks, unit)


def steady_flow(state: SteadyState, load_drives: bool = False) -> PowerFlow:
    """Power flow of a steady state [W].

    **Arguments:**

    - `state`: the steady state.
    - `load_drives`: whether the load drives the screw back in this state.
    """
    lost = {name: (0.0, float(power)) for name, power in state.losses.items()}
    input_power, output_power = float(state.input_power), float(state.output_power)
    driving, driven = (LOAD, MOTOR) if load_drives else (MOTOR, LOAD)
    # A self-locking mechanism takes power from both ends.
    ends = {driving: (input_power, 0.0), driven: (max(-output_power, 0.0), max(output_power, 0.0))}
    return _flow({**ends, **lost}, "W")


@dataclasses.dataclass(frozen=True)
class PowerHistory:
    """Powers over time [W], positive into the mechanism; losses are positive as dissipated."""

    time: np.ndarray
    motor: np.ndarray
    load: np.ndarray
    losses: Mapping[str, np.ndarray]
    #: Power of the moving masses, positive where they return energy.
    kinetic: np.ndarray
    #: Power of the bristles between threads; zero without such a law.
    bristles: np.ndarray


def power_history(mechanism: Mechanism, run: Transient) -> PowerHistory:
    """Powers of a transient [W], at its samples.

    The rate of the kinetic energy is the remainder of the power balance, whose residual the
    transient reports.

    **Arguments:**

    - `mechanism`: the mechanism that was simulated.
    - `run`: its transient, not a batch.
    """
    motor = np.asarray(run.drive_torque) * np.asarray(run.screw_speed)
    load = -np.asarray(run.load) * nut_speed(mechanism, run)
    losses = {name: np.asarray(power) for name, power in run.losses.items()}
    bristles = np.zeros_like(motor)
    if run.bristle_power is not None:
        bristles = -np.asarray(run.bristle_power)
    kinetic = sum(losses.values(), np.zeros_like(motor)) - motor - load - bristles
    return PowerHistory(np.asarray(run.time), motor, load, losses, kinetic, bristles)


def energy_flow(mechanism: Mechanism, run: Transient) -> PowerFlow:
    """Energy flow of a whole transient [J].

    Energy that the motor supplies and energy that it takes back while it brakes are counted
    separately; likewise for the load. Moving masses count with their net gain or loss of energy at
    the end, unless that is less than a ten-thousandth of the total. Like `energy`, the integrals
    are those of Simpson's rule.

    **Arguments:**

    - `mechanism`: the mechanism that was simulated.
    - `run`: its transient, not a batch.
    """
    powers = power_history(mechanism, run)

    def energy(power: np.ndarray) -> float:
        return float(integral(run.time, jnp.asarray(power)))

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
