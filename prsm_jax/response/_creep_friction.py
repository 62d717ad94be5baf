"""Creep friction: what the friction of a contact that slides steadily does to small vibration.

The friction of a roller on the screw (of an inverted roller screw, in the nut) is `f = −(F
μ(|v|)/|v| + c) v` of their slip v. A small vibration changes the slip `v₀ t` by w. To first order
the friction changes by `−C w`,

    C = c_∥ t tᵀ + c_⊥ b bᵀ,  c_∥ = F dμ/dv + c,  c_⊥ = F μ/v₀ + c,

with the direction t of the mean slip and b across it in the tangent plane: along the slip only the
slope of the law damps, across it friction turns with the slip. So each contact is a pair of
dashpots between the same points as its spring. Derived here; that friction which falls as the slip
rises feeds vibration: N. M. Kinkaid, O. M. O'Reilly, P. Papadopoulos, J. Sound Vib. 267 (2003)
105–166.
"""

import dataclasses
import itertools
from typing import Annotated

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..dynamics import SlidingContact, sliding_contact, turned_contact
from ..fields import In, Scalar
from ..friction import Sliding
from ..mechanism import Mechanism, Thread, of_one_design, stage_at
from ..numerics import above_or_nan, sum_few
from ..programs import one_program, physics
from ..results import Result
from ..vibration import (
    RollerSpring,
    SpatialSystem,
    SpringNetwork,
    contact_places,
    contact_springs,
    nominal_radius,
    spatial_harmonic_network,
    spatial_network,
    thread_spread,
    tilts,
)

#: Names of the dashpots of a contact, along the slip and across it.
CREEP_NAMES = ("creep_along", "creep_across")
#: Slip below which friction that is smooth at standstill is proportional to the slip [m/s].
_LEAST_SLIP = 1e-15


class CreepFriction(Result):
    """Damping of small vibration by the contacts of the rollers that slide steadily.

    It holds while the vibration slips slower than the contact (`|w|` well below `slip_speed`), and
    with a constant normal force: that friction follows a vibrating normal force is a force without
    symmetry, which this damping leaves out. So are a spin of the ellipse, and the bristles of a law
    with a state, of which the steady slip is used: its memory counts at frequencies above
    `slip_speed` over the length of the bristles.
    """

    #: v₀ over a roller of the body that turns [m/s].
    slip_speed: Annotated[Scalar, In("m/s")]
    #: F of one roller, all its threads together [N].
    contact_force: Annotated[Scalar, In("N")]
    #: μ at the mean slip.
    friction_coefficient: Annotated[Scalar, In("1")]
    #: c_∥ of one roller; negative where friction falls as the slip rises [N·s/m].
    damping_along_slip: Annotated[Scalar, In("N·s/m")]
    #: c_⊥ of one roller [N·s/m].
    damping_across_slip: Annotated[Scalar, In("N·s/m")]
    #: Power of the friction of one roller, f·v₀ [W].
    power: Annotated[Scalar, In("W")]
    #: Unit vectors t along the slip and b across it: radial, tangential, axial, in the frame of the
    #: flank that carries the load.
    along: Float[Array, "3"]
    across: Float[Array, "3"]
    #: Whether the contact slides: at standstill only friction that is smooth there damps, and both
    #: dampings of any other law are 0.
    slides: Bool[Array, ""]
    #: Whether the steady state is valid.
    valid: Bool[Array, ""]
    #: The pair of dashpots at each roller, and with `tilt` what the extent of each along the axis
    #: adds; their `stiffness` is a damping constant [N·s/m].
    dashpots: tuple[RollerSpring, ...]

    def network(self, system: SpatialSystem, harmonic: int | None = None) -> SpringNetwork:
        """Dashpots of all rollers, as a network with damping constants in place of stiffnesses.

        **Arguments:**

        - `system`: masses and springs of the same stage.
        - `harmonic`: reduced to a harmonic of the rollers (`spatial_harmonic_network`); default
          the whole stage.

        **Raises:** `ValueError` if bodies tilt in one of them only.
        """
        if (system.roller_tilt_mass is None) != (self.dashpots[0].roller_tilt is None):
            raise ValueError(
                "bodies tilt in the springs or in the dashpots only; give the same tilt to "
                "stage_spatial_system and creep_friction"
            )
        damped = dataclasses.replace(system, springs=self.dashpots)
        whole = (
            spatial_network(damped)
            if harmonic is None
            else spatial_harmonic_network(damped, harmonic)
        )
        rows = [at for at, spring in enumerate(whole.springs) if spring.name in CREEP_NAMES]
        places = jnp.asarray(rows)
        return SpringNetwork(
            whole.stiffness[places],
            whole.rows[places],
            whole.mass,
            whole.coordinates,
            tuple(whole.springs[at] for at in rows),
        )

    def viscous_matrix(self, system: SpatialSystem) -> Float[Array, "coordinates coordinates"]:
        """C [N·s/m] of the degrees of freedom of `spatial_network`; see `Dissipation`."""
        return self.network(system).stiffness_matrix()


def _dampings(sliding: SlidingContact) -> tuple[Scalar, Scalar, Scalar, Scalar, Bool[Array, ""]]:
    """Slip speed, μ, damping along and across the slip, and whether the contact slides."""
    law, inputs, force = sliding.law, sliding.law_inputs, sliding.force
    square = sum_few(sliding.velocity**2)
    moving = above_or_nan(square)
    speed = jnp.where(moving, jnp.sqrt(jnp.where(moving, square, 1.0)), 0.0)
    resistance = law.viscous_resistance
    constant = jnp.zeros_like(speed) if resistance is None else resistance * jnp.ones_like(speed)
    if law.load_independent:
        return speed, jnp.zeros_like(speed), constant, constant, jnp.ones_like(moving)

    def coefficient(at: Scalar) -> Scalar:
        return law.friction_coefficient(Sliding(at, inputs)) * jnp.ones_like(at)

    smooth = law.smooth_at_standstill and not law.has_state
    known = jnp.sqrt(square + _LEAST_SLIP**2) if smooth else jnp.where(moving, speed, 1.0)
    value, slope = jax.jvp(coefficient, (known,), (jnp.ones_like(known),))
    if smooth:
        per_speed = law.coefficient_per_speed(Sliding(known, inputs, square))
        slides = jnp.ones_like(moving)
        return speed, value, force * slope + constant, force * per_speed + constant, slides
    along = jnp.where(moving, force * slope + constant, 0.0)
    across = jnp.where(moving, force * value / known + constant, 0.0)
    return speed, jnp.where(moving, value, coefficient(speed)), along, across, moving


def creep_dashpots(
    thread: Thread,
    sliding: SlidingContact,
    along_slip: Scalar,
    across_slip: Scalar,
    spread: Scalar | None = None,
) -> tuple[RollerSpring, ...]:
    """The dashpots of a contact along its slip and across it, between a body and the roller.

    Those of a nut are given in the frame of the springs, in which the nut presses the rollers
    towards +z: half a turn about the line of centres from the frame of its sliding contact.
    """
    side = thread.family.turning
    contact, first = sliding.contact, sliding.direction
    if side == "nut":
        contact, first = turned_contact(contact), first * jnp.array([1, -1, -1], first.dtype)
    normal = contact.normal
    second = jnp.stack(
        [
            normal[1] * first[2] - normal[2] * first[1],
            normal[2] * first[0] - normal[0] * first[2],
            normal[0] * first[1] - normal[1] * first[0],
        ]
    )
    places = contact_places(contact, side, thread.family)
    radii = nominal_radius(thread, side), thread.roller_radius
    pairs = zip(CREEP_NAMES, (along_slip, across_slip), (first, second), strict=True)
    dashpots = [
        contact_springs(name, side, damping, (way[0], way[1], way[2]), places, radii, spread)
        for name, damping, way in pairs
    ]
    return tuple(itertools.chain(*dashpots))


@of_one_design
@one_program
@physics("creep_friction")
def creep_friction(
    mechanism: Mechanism,
    *,
    stage: int = 1,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    tilt: bool | None = None,
) -> CreepFriction:
    """Damping of small vibration by the sliding contacts of one stage at an operating point.

    Slip, normal force and friction law are those of `steady_state`: N times `power` is its loss
    `thread_sliding` (where spin is modelled, within its share of the sliding loss).

    **Arguments:**

    - `mechanism`: the mechanism; the stage needs a law of thread friction.
    - `stage`: which stage, counted from 1.
    - `speed`: screw speed [rad/s]; default that of the operating point.
    - `load`: axial load [N]; default that of the operating point.
    - `tilt`: whether bodies also tilt, as in `spatial_modal`; needs the number of engaged threads.

    **Raises:** `MissingDataError` if speed, load or the friction of the threads is not given, or
    for a recirculating roller screw, whose rollers slide on two bodies; `ValueError` for a stage
    that does not exist.
    """
    chosen = stage_at(mechanism, stage)
    sliding = sliding_contact(mechanism, stage, speed, load)
    slip, coefficient, along, across, slides = _dampings(sliding)
    tilting = tilts(mechanism, tilt)
    spread = thread_spread(chosen) if tilting else None
    dashpots = creep_dashpots(chosen.thread, sliding, along, across, spread)
    resistance = sliding.law.viscous_resistance
    friction = coefficient * sliding.force
    friction = friction if resistance is None else friction + resistance * slip
    return CreepFriction(
        slip_speed=slip,
        contact_force=sliding.force,
        friction_coefficient=coefficient,
        damping_along_slip=along,
        damping_across_slip=across,
        power=friction * slip,
        along=jnp.stack(dashpots[0].central[:3]),
        across=jnp.stack(dashpots[2 if tilting else 1].central[:3]),
        slides=slides,
        valid=sliding.valid,
        dashpots=dashpots,
    )
