"""The bending–torsional system of one stage: bodies, rollers and their springs."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._errors import MissingDataError
from ...fields import CountOrTraced, Scalar, as_count, at_least, plain
from ...mechanism import Stage, Support, body_inertia, body_mass
from ...stiffness import ThreadStiffness, ring_roller_stiffness


class CentralBody(eqx.Module):
    """A body on the axis (screw, ring gear or nut) with its springs to housing and rollers."""

    #: [kg].
    mass: Scalar
    #: J/r² [kg].
    equivalent_mass: Scalar
    #: Stiffness of the spring to one roller, along the tangent [N/m].
    mesh_stiffness: Scalar
    #: Stiffness of the springs to the housing, the torsional one over r² [N/m].
    radial_support: Scalar
    torsional_support: Scalar
    #: +1 if the roller's rotation stretches the spring in the same sense (screw), −1 otherwise.
    roller_sign: int = eqx.field(static=True)
    name: str = eqx.field(static=True)
    #: Support in y, if it differs from that in x [N/m].
    radial_support_y: Scalar | None = None
    #: Angle between the contact's line of action and the tangent [rad]; it only turns the modes
    #: unless rollers move in translation.
    contact_angle: Scalar | None = None
    #: Stiffness of the spring to each roller, if known individually; it replaces
    #: `mesh_stiffness` and the stiffness factors [N/m].
    each_mesh_stiffness: Float[Array, " rollers"] | None = None


class CarrierBody(eqx.Module):
    """The carrier. If rollers only rotate, it has their masses and vibrates on its own."""

    #: J/r² [kg], and torsional stiffness over r² [N/m].
    equivalent_mass: Scalar
    torsional_support: Scalar
    #: Mass [kg] and stiffness [N/m], only where rollers and with them the carrier move in
    #: translation.
    mass: Scalar | None = None
    radial_support: Scalar | None = None


class RollerTranslation(eqx.Module):
    """Rollers that also translate in the transverse plane, on pins of the carrier."""

    #: Of one roller [kg].
    mass: Scalar
    #: Equal in the radial and the tangential direction [N/m].
    pin_stiffness: Scalar


class RollerScatter(eqx.Module):
    """Differences of the rollers that are present; an entry `None` is equal for all."""

    #: Angle of each roller around the screw [rad].
    position: Float[Array, " rollers"]
    #: Factors on stiffness and mass of each roller [1].
    stiffness_factor: Float[Array, " rollers"] | None = None
    mass_factor: Float[Array, " rollers"] | None = None
    #: The number of each roller's position, for names.
    numbers: tuple[int, ...] = eqx.field(static=True, kw_only=True)


class VibrationSystem(eqx.Module):
    """Masses and springs of one stage.

    `roller_count` is the number of rollers present. A part that is `None` is not modelled.
    """

    bodies: tuple[CentralBody, ...]
    roller_equivalent_mass: Scalar
    carrier: CarrierBody | None
    roller_count: CountOrTraced = eqx.field(converter=as_count)
    translation: RollerTranslation | None = None
    scatter: RollerScatter | None = None

    @property
    def symmetric(self) -> bool:
        """Whether, by its structure, a turn by one roller pitch leaves the system unchanged.

        True for equal, evenly spaced rollers (at least 3, so that x and y are equivalent) and
        supports that are equal in x and y.
        """
        isotropic = all(body.radial_support_y is None for body in self.bodies)
        return self.scatter is None and isotropic and at_least(self.roller_count, 3)

    @property
    def roller_numbers(self) -> tuple[int, ...]:
        """The number of each roller's position, from 1."""
        if self.scatter is not None:
            return self.scatter.numbers
        return tuple(range(1, self.roller_count + 1))

    @property
    def roller_positions(self) -> Float[Array, " rollers"]:
        """Angle of each roller around the screw, φ_i = 2π(i − 1)/N unless they are scattered."""
        if self.scatter is not None:
            return self.scatter.position
        count = plain(self.roller_count)
        return 2 * jnp.pi * jnp.arange(count, dtype=self.roller_equivalent_mass.dtype) / count


def _support(support: Support | None, name: str, like: Scalar) -> Scalar:
    value = None if support is None else getattr(support, name)
    return jnp.zeros_like(like) if value is None else value


def _contact_angle(stage: Stage, body: str) -> Scalar:
    if body == "ring_gear":
        return jnp.zeros(()) if stage.gear is None else stage.gear.pressure_angle
    return stage.thread.contact_angle


def _scatter(stage: Stage) -> RollerScatter | None:
    unequal = {roller.number: roller for roller in stage.unequal_roller}
    if not unequal and not stage.rollers_carry_otherwise:
        return None
    places = plain(stage.roller_count)
    numbers = tuple(
        number
        for number in range(1, places + 1)
        if number not in unequal or not unequal[number].missing
    )
    dtype = stage.thread.lead.dtype

    def gather(name: str, default: float) -> Float[Array, " rollers"] | None:
        values = [getattr(unequal.get(number), name, None) for number in numbers]
        if all(value is None for value in values):
            return None
        like = jnp.full((), default, dtype)
        return jnp.stack([like if value is None else value.astype(dtype) for value in values])

    even = 2 * jnp.pi * (jnp.asarray(numbers, dtype) - 1) / places
    offset = gather("position_offset", 0.0)
    return RollerScatter(
        position=even if offset is None else even + offset,
        stiffness_factor=gather("stiffness_factor", 1.0),
        mass_factor=gather("mass_factor", 1.0),
        numbers=numbers,
    )


def _carrier(
    stage: Stage, translation: RollerTranslation | None, scatter: RollerScatter | None
) -> CarrierBody | None:
    if stage.carrier is None:
        return None
    pieces, support = stage.carrier.count, stage.carrier.support
    equivalent = pieces * body_inertia(stage, "carrier") / stage.thread.centre_distance**2
    torsional = _support(support, "torsional_stiffness", equivalent)
    if translation is not None:
        mass = pieces * body_mass(stage, "carrier")
        radial = _support(support, "radial_stiffness", equivalent)
        return CarrierBody(equivalent, torsional, mass, radial)
    rollers: Scalar | int = stage.present_roller_count
    if scatter is not None and scatter.mass_factor is not None:
        rollers = jnp.sum(scatter.mass_factor)
    return CarrierBody(equivalent + rollers * body_mass(stage, "roller"), torsional)


def vibration_system(stage: Stage, threads: ThreadStiffness) -> VibrationSystem:
    """Collect the masses and springs of one stage.

    The thread springs act in the transverse plane: their stiffness on tangential displacements u =
    r θ is k cos²β_R (Wu et al. 2022, equations 7 to 13). Without a ring gear, or without a carrier,
    those degrees of freedom do not exist. The teeth of an inverted roller screw are on its screw,
    where their springs act beside those of the threads. Rollers move in translation only if
    `stage.roller.support` is given; the carrier then does so too.

    **Arguments:**

    - `stage`: the stage; needs masses and inertias (given or from dimensions).
    - `threads`: thread contact stiffness of one roller, or of each.

    **Raises:** `MissingDataError` if masses are missing.
    """
    thread = stage.thread
    projection = jnp.cos(thread.roller_helix_angle) ** 2
    ring_stiffness = None if stage.ring_gear is None else ring_roller_stiffness(stage)
    roller_support = stage.roller.support
    pins = None if roller_support is None else roller_support.radial_stiffness

    def central(
        name: str,
        radius: Scalar,
        stiffness: Scalar,
        sign: int,
        each: Float[Array, " rollers"] | None = None,
    ) -> CentralBody:
        mass = body_mass(stage, name)
        support: Support | None = getattr(stage, name).support
        return CentralBody(
            mass=mass,
            equivalent_mass=body_inertia(stage, name) / radius**2,
            mesh_stiffness=stiffness,
            radial_support=_support(support, "radial_stiffness", mass),
            torsional_support=_support(support, "torsional_stiffness", mass),
            roller_sign=sign,
            name=name,
            radial_support_y=None if support is None else support.radial_stiffness_y,
            contact_angle=None if pins is None else _contact_angle(stage, name),
            each_mesh_stiffness=each,
        )

    screw, nut = threads.screw_roller * projection, threads.nut_roller * projection
    screw_each, nut_each = (
        None if each is None else each * projection
        for each in (threads.screw_each, threads.nut_each)
    )
    if thread.family.gear_body == "screw":
        teeth = ring_roller_stiffness(stage)
        if teeth is not None and pins is not None:
            raise MissingDataError(
                f"vibration of an {stage.type} roller screw with a gear and with pins "
                "(stage.roller.support) is not known, because threads and teeth on the screw push "
                "rollers in different directions; remove one of them"
            )
        if teeth is not None:
            screw = screw + teeth
            screw_each = None if screw_each is None else screw_each + teeth
    bodies = [central("screw", thread.screw_radius, screw, 1, screw_each)]
    if ring_stiffness is not None:
        # The pitch circle of the ring gear is the nominal circle of the nut's thread.
        bodies.append(central("ring_gear", thread.nut_radius, ring_stiffness, -1))
    bodies.append(central("nut", thread.nut_radius, nut, -1, nut_each))

    scatter = _scatter(stage)
    present = stage.roller_count if scatter is None else len(scatter.numbers)
    translation = None if pins is None else RollerTranslation(body_mass(stage, "roller"), pins)
    return VibrationSystem(
        bodies=tuple(bodies),
        roller_equivalent_mass=body_inertia(stage, "roller") / thread.roller_radius**2,
        carrier=_carrier(stage, translation, scatter),
        roller_count=present,
        translation=translation,
        scatter=scatter,
    )
