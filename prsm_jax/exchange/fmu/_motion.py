"""A mechanism under a torque and a load, advanced from one time to the next."""

from typing import NamedTuple

from ..._errors import MissingDataError, PrsmError
from ...dynamics import Transient, has_smooth_threads, simulate, travel_per_radian
from ...mechanism import Mechanism
from ...scenario import TorqueScenario
from ._variables import STICKING

#: Length of the run whose first sample gives the outputs at the start [s].
_AT_START = 1e-6


class DrivenState(NamedTuple):
    """State of the mechanism: angle [rad] and speed [rad/s] of the screw, and the nut [m].

    Of an inverted roller screw the angle and speed of its nut, and the position of its screw.
    """

    screw_angle: float = 0.0
    screw_speed: float = 0.0
    nut_position: float = 0.0


def check_exchangeable(mechanism: Mechanism) -> None:
    """Check that screw and nut alone are the state of a mechanism.

    **Arguments:**

    - `mechanism`: the mechanism.

    **Raises:** `PrsmError` for thread friction with states of its own (LuGre), or that is
    regularised at standstill; `MissingDataError` without thread friction, which drives the rollers.
    """
    for number, stage in enumerate(mechanism.stages, start=1):
        if stage.thread_law is None:
            raise MissingDataError(
                f"stage {number}: only thread friction can drive the rollers; give "
                "[stage.friction.thread]"
            )
    if has_smooth_threads(mechanism):
        raise PrsmError(
            "an FMU has the state of screw and nut alone, and this thread friction brings states "
            "of its own; give [stage.friction.thread] the law coulomb, stribeck or viscous"
        )


def advance(
    mechanism: Mechanism, state: DrivenState, torque: float, load: float, duration: float
) -> tuple[DrivenState, dict[str, float]]:
    """Advance a mechanism under a constant torque and load.

    The method is that of `simulate(..., method="quasi_steady")`: the carriers are in balance at
    every instant, friction is exact, and events of sticking and slipping are located.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `state`: where it begins.
    - `torque`: at the first screw, or the nut of an inverted roller screw [N·m].
    - `load`: on the last nut, or that screw, against its motion at positive speed [N].
    - `duration`: [s].

    **Returns:** the state at the end, and the outputs there by name [SI].

    **Raises:** `PrsmError` if the motion has no solution; `ValueError` for NaN or infinite numbers,
    and for a duration that is not above 0.
    """
    run = _run(mechanism, state, torque, load, duration)
    values = _values(mechanism, state, run, -1, torque, load)
    return DrivenState(*(values[name] for name in DrivenState._fields)), values


def values_at_start(
    mechanism: Mechanism, state: DrivenState, torque: float, load: float
) -> dict[str, float]:
    """Outputs in a state under a torque and a load, before anything has moved.

    **Arguments:**

    - `mechanism`, `state`, `torque`, `load`: as for `advance`.

    **Raises:** as `advance`.
    """
    run = _run(mechanism, state, torque, load, _AT_START)
    return _values(mechanism, state, run, 0, torque, load)


def _run(
    mechanism: Mechanism, state: DrivenState, torque: float, load: float, duration: float
) -> Transient:
    scenario = TorqueScenario(torque, load, duration, initial_speed=state.screw_speed, samples=2)
    run = simulate(mechanism, scenario, method="quasi_steady", throw=False)
    if int(run.solver.code):
        raise PrsmError(
            f"no motion from {state.screw_speed:.6g} rad/s under {torque:.6g} N·m and "
            f"{load:.6g} N within {duration:.6g} s: {run.solver.result}"
        )
    return run


def _values(
    mechanism: Mechanism, state: DrivenState, run: Transient, at: int, torque: float, load: float
) -> dict[str, float]:
    """All outputs at a sample of a run, by the names of variables."""
    stages = mechanism.stages
    travel = float(travel_per_radian(stages, len(stages)))
    speed, moved = float(run.screw_speed[at]), 0.0
    if run.position is not None:
        moved = float(run.position[at])
    sticks = run.sticking is not None and bool(run.sticking[at])
    speeds = [float(one) for one in run.screw_speed]
    powers = [sum(float(power[k]) for power in run.losses.values()) for k in (0, -1)]
    # Where the screw sets out or reverses, the torque of friction is that of the other sample.
    turns = at if speed else -1 - at
    if sticks or speeds[turns] == 0:
        # Nothing is lost: friction holds what the load does not balance.
        friction = torque - load * travel
    else:
        friction = powers[turns] / speeds[turns]
    acceleration = 0.0 if run.screw_acceleration is None else run.screw_acceleration[at]
    values = {
        "screw_angle": state.screw_angle + moved / travel,
        "screw_speed": speed,
        "screw_acceleration": float(acceleration),
        "nut_position": state.nut_position + moved,
        "nut_speed": travel * speed,
        "friction_torque": friction,
        "loss_power": powers[at],
        STICKING: float(sticks),
    }
    for number, stage in enumerate(stages, start=1):
        carrier = float(run.carrier_speed[number - 1, at])
        values[f"carrier_speed[{number}]"] = carrier
        # Against the carrier a roller turns at −κ ω.
        values[f"roller_speed[{number}]"] = (1 - float(stage.thread.rolling_ratio)) * carrier
        values[f"contact_force[{number}]"] = float(run.contact_force[number - 1, at])
    return values
