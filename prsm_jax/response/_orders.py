"""Excitation of a turning roller screw: orders of the screw speed, and phases of the rollers.

Orders are counted in the frame that turns with the rollers, as in the vibration model. In a
standard roller screw, with the carrier ratio ζ = ω/Ω, the screw turns in it at (1 − ζ)Ω and the nut
at −ζΩ; a roller rolls in the nut without slip, timed by the ring gear, so it spins at n ζ Ω. The
rollers travel with the nut, by one lead per turn of the screw. A plane that travels with them
therefore cuts the screw's threads in a section that is at rest in space: rotation and advance of
the threads cancel. Relative to the rollers this section turns at ζ, although the screw itself turns
at 1 − ζ.
"""

from typing import Annotated, Literal, TypeAlias

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..dynamics import (
    all_kinematics,
    free_carrier_ratio,
    has_contact_losses,
    ideal_carrier_ratio,
    steady_state,
)
from ..fields import In, Scalar, plain
from ..mechanism import Mechanism, Side, Stage, stage_at
from ..programs import physics
from ..results import Result, lines_of
from ..text import Line

Phasing: TypeAlias = Literal["torsional", "transverse", "roller"]


class ExcitationOrder(Result):
    """A periodic excitation of the contacts, with its fundamental frequency and phases.

    Its h-th harmonic has `h · order` times the rotational frequency of the screw. At the roller at
    angle φ its phase is `h · lobes · φ`.
    """

    #: Periods per turn of the screw.
    order: Annotated[Scalar, In("1")]
    #: Periods of the pattern around the screw; they give the phases of the rollers.
    lobes: Annotated[Scalar, In("1")]
    name: str = eqx.field(static=True)
    #: Contacts on which it acts.
    springs: tuple[str, ...] = eqx.field(static=True)
    description: str = eqx.field(static=True)

    def lines(self) -> list[Line]:
        """What `print` shows."""
        return [Line("name", self.name), *lines_of(self), Line("what", self.description)]


@physics("carrier_ratio")
def working_carrier_ratio(mechanism: Mechanism, stage: int = 1) -> Scalar:
    """Carrier speed over that of the body that turns, of one stage in its steady state.

    With losses in the contacts, and where it depends on friction (rollers without lead), it is that
    of the steady operating point; without them, thread friction determines it from geometry alone.
    If data for the steady state are missing, ideal rolling is assumed, r_s / (2 a), of an inverted
    roller screw r_n / (2 a).

    **Raises:** `ValueError` for a stage that does not exist.
    """
    chosen = stage_at(mechanism, stage)
    family = chosen.thread.family
    of_geometry = family.carrying is not None and family.lead_is_fixed
    if of_geometry and not has_contact_losses(chosen.friction):
        return free_carrier_ratio(all_kinematics(mechanism)[stage - 1])
    try:
        return steady_state(mechanism).carrier_ratio[stage - 1]
    except MissingDataError:
        return ideal_carrier_ratio(chosen.thread)


def excitation_orders(
    stage: Stage, carrier_ratio: float | Scalar | None = None
) -> tuple[ExcitationOrder, ...]:
    """The excitations of one stage, from its kinematics.

    | name | order | what it is |
    |---|---|---|
    | `carrier` | ζ | runout of nut and ring gear as the rollers pass it |
    | `deviating_start` | ζ | one start of screw or nut that deviates from the others |
    | `screw_rotation` | 1 − ζ | runout of the screw as the rollers pass it |
    | `roller_passing_nut` | N ζ | rollers that pass a flaw of the nut |
    | `roller_passing_screw` | N (1 − ζ) | rollers that pass a flaw of the screw |
    | `thread_passing` | n ζ | threads that pass along the rollers, and the rollers' own spin |
    | `ring_gear_mesh` | z_r ζ | teeth of the ring gear, z_r = n z_R if not given; only with z_R |

    Thread passing is the same for screw, nut and roller: in the frame of the rollers all threads
    move along the axis by ζ L per turn, which is n ζ pitches. The n lobes that n starts cut into
    the cross-section of the screw pass at the same order, n ζ, because the plane of the section
    travels with the rollers; a single start returns after n pitches, at order ζ.

    In an inverted roller screw the nut turns: the orders of screw and nut are exchanged,
    `nut_rotation` takes the place of `screw_rotation`, and the teeth are on the screw
    (`screw_gear_mesh`). Rollers without lead (recirculating and differential roller screws) keep
    their place on all threads, so that no thread passes, and a start that deviates does not either.

    **Arguments:**

    - `stage`: the stage.
    - `carrier_ratio`: ζ, carrier speed over that of the body that turns; default that of ideal
      rolling.
    """
    thread, count = stage.thread, plain(stage.roller_count)
    family = thread.family
    ratio = ideal_carrier_ratio(thread) if carrier_ratio is None else carrier_ratio
    ratio = jnp.asarray(ratio, thread.lead.dtype)
    one, starts = jnp.ones_like(ratio), thread.starts
    sides: tuple[Side, ...] = ("screw", "nut")
    both = tuple(f"{side}_roller" for side in sides)
    held, turning = family.held, family.turning
    springs: dict[Side, tuple[str, ...]] = {side: (f"{side}_roller",) for side in sides}
    # Teeth on the screw are part of its contact in the bending–torsional model.
    teeth_at = springs["screw"] if family.gear_body == "screw" else ("ring_roller",)
    words = {"screw": "the screw", "nut": "the nut"}
    runout = words[held]
    if stage.ring_gear is not None:
        springs["nut"] = teeth_at + springs["nut"]
        runout = "nut and ring gear"
    # Speeds of the bodies against the rollers.
    speed = {held: ratio, turning: 1 - ratio}
    # Name, lobes, speed of the pattern relative to the rollers, contacts, description.
    patterns: list[tuple[str, Scalar, Scalar, tuple[str, ...], str]] = [
        ("carrier", one, ratio, springs[held], f"runout of {runout}")
    ]
    if family.roller_hand:
        patterns.append(("deviating_start", one, ratio, both, "one start of screw or nut deviates"))
    turned = f"{turning}_rotation"
    patterns.append((turned, one, 1 - ratio, springs[turning], f"runout of {words[turning]}"))
    for side in ("nut", "screw"):
        name, description = f"roller_passing_{side}", f"rollers pass a flaw of {words[side]}"
        patterns.append((name, count * one, speed[side], springs[side], description))
    if family.roller_hand:
        description = "threads pass along the rollers"
        patterns.append(("thread_passing", starts, ratio, both, description))
    if has_gear_teeth(stage):
        assert stage.gear is not None
        assert stage.gear.roller_teeth is not None
        given = stage.gear.ring_teeth
        teeth = starts * stage.gear.roller_teeth if given is None else given
        on_screw = family.gear_body == "screw"
        name = "screw_gear_mesh" if on_screw else "ring_gear_mesh"
        description = f"teeth of {'screw' if on_screw else 'ring gear'} and rollers"
        patterns.append((name, teeth, ratio, teeth_at, description))
    return tuple(
        ExcitationOrder(lobes * passing, lobes, name, contacts, description)
        for name, lobes, passing, contacts, description in patterns
    )


def has_gear_teeth(stage: Stage) -> bool:
    """Whether the rollers of a stage have teeth of known number, and what they mesh with."""
    if stage.gear is None or stage.gear.roller_teeth is None:
        return False
    return stage.ring_gear is not None or stage.thread.family.gear_body == "screw"


def gear_mesh_order(orders: tuple[ExcitationOrder, ...]) -> ExcitationOrder:
    """The excitation by teeth, on a ring gear or on the screw.

    **Raises:** `ValueError` if there are none.
    """
    on_screw = any(order.name == "screw_gear_mesh" for order in orders)
    return find_order(orders, "screw_gear_mesh" if on_screw else "ring_gear_mesh")


#: Names of earlier releases: the starts of the screw pass with the threads, at n ζ.
_FORMER_NAMES = {"screw_starts": "thread_passing"}


def find_order(orders: tuple[ExcitationOrder, ...], name: str) -> ExcitationOrder:
    """An excitation by its name; `screw_starts`, a former name, is `thread_passing`.

    **Raises:** `ValueError` for an unknown name, with the names that exist.
    """
    name = _FORMER_NAMES.get(name, name)
    for order in orders:
        if order.name == name:
            return order
    names = ", ".join(order.name for order in orders)
    needs = "; the stage has no ring gear with teeth" if name == "ring_gear_mesh" else ""
    raise ValueError(f"order is {name!r}; choose one of {names}{needs}")


def phasing(lobes: float | int, roller_count: int) -> Phasing:
    """The family of modes that a pattern excites through equal, evenly spaced rollers.

    The phases `lobes · 2πi/N` are a single harmonic of the rollers. If `lobes` is divisible by N,
    the rollers are in phase and turn the bodies on the axis. With remainder 1 or N − 1 they push
    these bodies sideways. Otherwise their forces cancel on all bodies except the rollers. A number
    of lobes within 1e-6 of a whole number counts as whole.

    **Arguments:**

    - `lobes`: periods around the screw, times the harmonic.
    - `roller_count`: N, at least 3.

    **Raises:** `ValueError` for a number of lobes that is not whole.
    """
    number = round(float(lobes))
    if abs(float(lobes) - number) > 1e-6:
        raise ValueError(f"lobes is {float(lobes):.6g}; a closed pattern needs a whole number")
    remainder = number % roller_count
    if remainder == 0:
        return "torsional"
    return "transverse" if remainder in (1, roller_count - 1) else "roller"


def roller_phases(
    order: ExcitationOrder, harmonic: int, positions: Float[Array, " rollers"]
) -> Float[Array, " rollers"]:
    """Phase of the excitation at each roller [rad]."""
    return harmonic * order.lobes * positions
