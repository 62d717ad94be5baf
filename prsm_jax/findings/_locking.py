"""Findings on friction: can the screw move the load, and can the load turn the screw?"""

import math
from collections.abc import Callable, Iterator

import equinox as eqx
import jax.numpy as jnp

from ..contact import load_of
from ..dynamics import (
    STEADY_RESULTS,
    SteadyState,
    friction_needs_load,
    friction_sets_motion,
    jamming_coefficient,
    jamming_margin,
    locking_coefficient,
    self_locking_margin,
    steady_meaning,
    steady_state,
    travel_share,
)
from ..fields import Scalar
from ..geometry import Severity
from ..mechanism import Mechanism
from ..quantities import Analysis
from ._margin import Margin, Reading, margin_source

#: Friction coefficients scatter by this much with lubricant and wear.
_SCATTER = 0.3
#: Backward efficiency below which this scatter may decide whether the load turns the screw.
_NEARLY_HELD = 0.15
_NO_BALANCE = STEADY_RESULTS.index("no_balance")


def _without_friction(mechanism: Mechanism) -> bool:
    return all(stage.friction is None for stage in mechanism.stages)


@margin_source
def _jamming(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """The driving screw or nut jams, or is close to jamming."""
    if _without_friction(mechanism):
        return

    def value(analysis: Analysis) -> Scalar:
        stage = analysis.mechanism.stages[index]
        single = eqx.tree_at(lambda m: m.stages, analysis.mechanism, (stage,))
        geometry = analysis.kinematics[index]
        needs_load = friction_needs_load(single) or friction_sets_motion(single)
        load = analysis.load if needs_load else None
        return jamming_margin(single, (geometry,), jnp.abs(analysis.speed), load)[0]

    turning = mechanism.stages[index].thread.family.turning
    levels: tuple[tuple[Severity, float], ...] = (("error", 0.0), ("warning", _SCATTER))
    if friction_sets_motion(mechanism):

        def of_share(r: Reading) -> str:
            if r.severity == "error":
                found = f"the driving {turning} jams: thread friction cancels the axial force"
            else:
                found = (
                    f"friction of the threads leaves {r.value:.0%} of the axial part of their "
                    f"normal force to the load; at 0 the driving {turning} jams"
                )
            return f"{found}; lower the friction, or raise the contact angle"

        yield Margin("jamming", index + 1, value, levels, of_share, reserve=1e-2, strict=True)
        return

    def message(r: Reading) -> str:
        relation = "exceeds" if r.severity == "error" else "is close to"
        limit = r.details["limit"]
        return (
            f"the friction coefficient of the threads, {(1 - r.value) * limit:.3g}, {relation} "
            f"{limit:.3g}, where the driving {turning} jams: lower it, or raise the contact angle"
        )

    yield Margin(
        "jamming",
        index + 1,
        value,
        levels,
        message,
        details=lambda analysis: {"limit": jamming_coefficient(analysis.kinematics[index])},
        shown=lambda r: (
            (1 - r.value) * r.details["limit"],
            (1 - r.limit) * r.details["limit"],
        ),
        at_most=True,
        reserve=1e-2,
        strict=True,
    )


@margin_source
def _steady_motion(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Friction lets no steady motion exist, or the load moves the nut against the travel.

    Of roller screws in which friction sets the motion; the others have a closed form.
    """
    if _without_friction(mechanism) or index > 0 or not friction_sets_motion(mechanism):
        return

    def balance(analysis: Analysis) -> Scalar:
        return jnp.where(analysis.steady.code == _NO_BALANCE, -1.0, 1.0)

    def words_of(name: str) -> Callable[[Reading], str]:
        return lambda r: steady_meaning(name).partition(": ")[2]

    error: tuple[tuple[Severity, float], ...] = (("error", 0.0),)
    yield Margin("no_balance", 1, balance, error, words_of("no_balance"), smooth=False)
    if mechanism.stages[-1].thread.family.lead_is_fixed:
        return

    def travel(analysis: Analysis) -> Scalar:
        """Travel per turn over the lead while the screw drives; else nothing can sink."""
        state, load = (
            analysis.steady,
            jnp.asarray(load_of(analysis.mechanism, analysis.signed_load)),
        )
        share = travel_share(analysis.mechanism.stages[-1].thread, state.carrier_ratio[-1])
        assert share is not None
        # From standstill the screw drives.
        drives = state.screw_speed * load >= 0
        return jnp.where(drives & (state.code != _NO_BALANCE), share, 1.0)

    yield Margin("sinking_load", 1, travel, error, words_of("sinking_load"))


@margin_source
def _self_locking(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """The load alone causes no motion, or lubricant and wear decide whether it does."""
    if _without_friction(mechanism) or index > 0:
        return

    def driven(analysis: Analysis) -> SteadyState:
        speed = -jnp.abs(analysis.speed)
        load = jnp.abs(load_of(analysis.mechanism, analysis.signed_load))
        # At standstill the onset says that it is the load that is about to drive.
        return steady_state(
            analysis.mechanism, speed, load, analysis.kinematics, onset=-jnp.ones_like(speed)
        )

    def value(analysis: Analysis) -> Scalar:
        return driven(analysis).efficiency

    free = friction_sets_motion(mechanism)

    def limit_of(r: Reading) -> str:
        if free:
            factor = r.details["factor"]
            if not math.isfinite(factor):
                return "the limit is not known"
            return f"all friction multiplied by {factor:.3g} would just hold the load"
        coefficient = r.details["limit"]
        where = f"above a friction coefficient of {coefficient:.3g}"
        return f"thread friction alone is self-locking {where}"

    def message(r: Reading) -> str:
        turning = mechanism.stages[0].thread.family.turning
        if r.severity == "note":
            return (
                f"self-locking: friction holds the load without torque, and the {turning} needs "
                f"torque in either direction ({limit_of(r)})"
            )
        return (
            f"nearly self-locking: only {r.value:.0%} of the work of the load reaches the "
            f"{turning}, so lubricant and wear decide whether the load turns it ({limit_of(r)}); "
            "for the load to turn it, lower the friction or raise the lead; for the load to be "
            "held, add a brake"
        )

    def details(analysis: Analysis) -> dict[str, Scalar]:
        load = {"load": jnp.asarray(load_of(analysis.mechanism, analysis.signed_load))}
        if not free:
            return load | {"limit": locking_coefficient(analysis.kinematics[0])}
        margin, known = self_locking_margin(
            analysis.mechanism, analysis.kinematics, analysis.speed, analysis.load
        )
        moves = driven(analysis).code != _NO_BALANCE
        return load | {"factor": jnp.where(known, 1 / (1 - margin), jnp.nan), "moves": moves}

    yield Margin(
        "self_locking",
        1,
        value,
        (("note", 0.0), ("warning", _NEARLY_HELD)),
        message,
        details=details,
        # Without a load nothing is held, and there is no efficiency of its work; nor of a motion
        # that does not exist.
        applies=lambda numbers: numbers["load"] != 0 and numbers.get("moves", 1.0) != 0,
        shown=lambda r: (r.value, r.limit),
    )
