"""Excitation of a turning roller screw: orders of the screw speed, and phases of the rollers.

Orders are counted in the frame that turns with the rollers, as in the vibration model. With the
carrier ratio κ = ω/Ω, the screw turns in it at (1 − κ)Ω and the nut at −κΩ; a roller rolls in the
nut without slip, timed by the ring gear, so it spins at n κ Ω. The rollers travel with the nut, by
one lead per turn of the screw. A plane that travels with them therefore cuts the screw's threads
in a section that is at rest in space: rotation and advance of the threads cancel. Relative to the
rollers this section turns at κ, although the screw itself turns at 1 − κ.
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
from ..mechanism import Mechanism, Stage, require_type, stage_at
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
    """Carrier speed over screw speed of one stage in its steady state.

    With losses in the contacts it is that of the steady operating point; without them, thread
    friction determines it from geometry alone. If data for the steady state are missing, ideal
    rolling is assumed, r_s / (2 a).

    **Raises:** `ValueError` for a stage that does not exist; `MissingDataError` if it is not a
    standard roller screw.
    """
    chosen = stage_at(mechanism, stage)
    require_type((chosen,), "the orders of excitation are")
    if not has_contact_losses(chosen.friction):
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
    | `carrier` | κ | runout of nut and ring gear as the rollers pass it |
    | `deviating_start` | κ | one start of screw or nut that deviates from the others |
    | `screw_rotation` | 1 − κ | runout of the screw as the rollers pass it |
    | `roller_passing_nut` | N κ | rollers that pass a flaw of the nut |
    | `roller_passing_screw` | N (1 − κ) | rollers that pass a flaw of the screw |
    | `thread_passing` | n κ | threads that pass along the rollers, and the rollers' own spin |
    | `ring_gear_mesh` | n z_R κ | teeth of the ring gear; only where their number is given |

    Thread passing is the same for screw, nut and roller: in the frame of the rollers all threads
    move along the axis by κ L per turn, which is n κ pitches. The n lobes that n starts cut into
    the cross-section of the screw pass at the same order, n κ, because the plane of the section
    travels with the rollers; a single start returns after n pitches, at order κ.

    **Arguments:**

    - `stage`: the stage.
    - `carrier_ratio`: κ; default that of ideal rolling, r_s / (2 a).

    **Raises:** `MissingDataError` if it is not a standard roller screw.
    """
    require_type((stage,), "the orders of excitation are")
    thread, count = stage.thread, plain(stage.roller_count)
    ratio = ideal_carrier_ratio(thread) if carrier_ratio is None else carrier_ratio
    ratio = jnp.asarray(ratio, thread.lead.dtype)
    one, starts = jnp.ones_like(ratio), thread.starts
    screw, ring, nut = ("screw_roller",), ("ring_roller",), ("nut_roller",)
    outer = nut if stage.ring_gear is None else ring + nut
    # Name, lobes, speed of the pattern relative to the rollers, contacts, description.
    patterns = [
        ("carrier", one, ratio, outer, "runout of nut and ring gear"),
        ("deviating_start", one, ratio, screw + nut, "one start of screw or nut deviates"),
        ("screw_rotation", one, 1 - ratio, screw, "runout of the screw"),
        ("roller_passing_nut", count * one, ratio, outer, "rollers pass a flaw of the nut"),
        ("roller_passing_screw", count * one, 1 - ratio, screw, "rollers pass a flaw of the screw"),
        ("thread_passing", starts, ratio, screw + nut, "threads pass along the rollers"),
    ]
    if stage.gear is not None and stage.gear.roller_teeth is not None and stage.ring_gear:
        teeth = starts * stage.gear.roller_teeth
        patterns.append(("ring_gear_mesh", teeth, ratio, ring, "teeth of ring gear and rollers"))
    return tuple(
        ExcitationOrder(lobes * turning, lobes, name, springs, words)
        for name, lobes, turning, springs, words in patterns
    )


#: Names of earlier releases: the starts of the screw pass with the threads, at n κ.
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
