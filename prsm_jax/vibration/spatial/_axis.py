"""The axis around a stage: points that move along it or turn, and springs in series between them.

Rotations are `u = r θ` with the nominal radius r of the body that turns (the screw; of an inverted
roller screw the nut), so that a torsional stiffness is `k/r²` and a moment of inertia `J/r²`. Those
of an elastic screw have its own radius.
"""

import dataclasses
import functools
import operator

import equinox as eqx
import jax.numpy as jnp

from ..._errors import MissingDataError
from ...fields import Scalar
from ...mechanism import (
    Axis,
    AxisLoad,
    AxisShaft,
    Motor,
    Side,
    Stage,
    body_inertia,
    body_mass,
    material_of,
    screw_section,
)
from ...numerics import above_or_nan
from ...programs import physics
from ..model import Coordinate
from ._bodies import SpatialBody, has_support, moving_with, nominal_radius, supports


class AxisBody(eqx.Module):
    """A part of the axis that moves along it or turns about it; `None` where it does not."""

    name: str = eqx.field(static=True)
    #: [kg].
    axial_mass: Scalar | None = None
    #: J/r² [kg].
    equivalent_mass: Scalar | None = None


class AxisSpring(eqx.Module):
    """Springs in series from one part of the axis to another, or to the housing."""

    #: Of each spring [N/m].
    stiffness: tuple[Scalar, ...]
    #: Of each spring.
    names: tuple[str, ...] = eqx.field(static=True)
    #: `z` or `u`.
    direction: str = eqx.field(static=True)
    #: One part, held by the housing, or two.
    bodies: tuple[str, ...] = eqx.field(static=True)

    @property
    def shares(self) -> tuple[Scalar, ...]:
        """Springs in parallel with the strain energies of those in series, `k²/k_i` [N/m].

        With `1/k = Σ 1/k_i` their sum is k, and spring i of the series has the energy F²/2k_i.
        """
        if len(self.stiffness) == 1:
            return self.stiffness
        # A mounting may have the stiffness 0, and then the series has.
        every = [above_or_nan(one) for one in self.stiffness]
        given = functools.reduce(operator.and_, every)
        safe = [jnp.where(given, one, 1.0) for one in self.stiffness]
        whole = 1 / sum((1 / one for one in safe), jnp.zeros_like(safe[0]))
        return tuple(jnp.where(given, whole * (whole / one), 0.0) for one in safe)


class AxisSystem(eqx.Module):
    """Masses and springs of an axis."""

    bodies: tuple[AxisBody, ...]
    springs: tuple[AxisSpring, ...]
    #: Nominal radius of the body that the motor turns, r of the rotor's u = r θ [m].
    radius: Scalar
    #: The part that turns with the motor's rotor; `None` without a motor.
    motor: str | None = eqx.field(static=True)
    #: The part that moves with the load, or would: the nut, or the end of an inverted screw.
    load: str = eqx.field(static=True)
    #: Whether the rotor is held.
    motor_held: bool = eqx.field(static=True, default=False)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Degrees of freedom beside those of the stage."""
        degrees = [
            Coordinate(body.name, direction)
            for body in self.bodies
            for direction, mass in (("z", body.axial_mass), ("u", body.equivalent_mass))
            if mass is not None
        ]
        return tuple(one for one in degrees if one != self.held_coordinate)

    @property
    def held_coordinate(self) -> Coordinate | None:
        """The degree of freedom that does not move, if the rotor is held."""
        if self.motor is None or not self.motor_held:
            return None
        return Coordinate(self.motor, "u")

    def mass(self, coordinate: Coordinate) -> Scalar | None:
        """Mass of a degree of freedom of the axis [kg]; `None` for one of the stage."""
        for body in self.bodies:
            if body.name == coordinate.body:
                return body.axial_mass if coordinate.direction == "z" else body.equivalent_mass
        return None


#: The end of an elastic screw at its thrust bearing (of an inverted one, at the load), and the one
#: at the far bearing.
SCREW_END, FAR_END = "screw_end", "screw_far_end"


def _shaft(
    stage: Stage, shaft: AxisShaft, screw: SpatialBody
) -> tuple[SpatialBody, list[AxisBody], list[AxisSpring]]:
    """The screw as bars and shafts between thrust bearing (or load), nut and far bearing.

    Each section between two of them has half of its mass at either end; what is beyond the last one
    moves with it. Mass and support of what is fixed to the screw (carriers) stay at the nut.
    """
    if stage.screw.length is None:
        raise MissingDataError(
            "the elastic screw of the axis needs its length; give stage.screw.length"
        )
    assert screw.axial_mass is not None
    assert screw.axial_support is not None
    material, section = material_of(stage, "screw"), screw_section(stage)
    shear_modulus = material.youngs_modulus / (2 * (1 + material.poisson_ratio))
    distance, length = shaft.nut_distance, stage.screw.length
    at_end = distance / (2 * length)
    radius = stage.thread.screw_radius
    bar = material.youngs_modulus * section.area
    twist = shear_modulus * section.polar_moment / distance / radius**2
    mass, inertia = body_mass(stage, "screw"), body_inertia(stage, "screw") / radius**2
    zero = jnp.zeros_like(screw.axial_support)
    axial, torsional = (supports(stage, ("screw",), way, zero) for way in ("axial", "torsional"))
    ends = [AxisBody(SCREW_END, mass * at_end, inertia * at_end)]
    springs = [
        AxisSpring((axial,), ("screw_support_axial",), "z", (SCREW_END,)),
        AxisSpring((torsional,), ("screw_support_torsional",), "u", (SCREW_END,)),
        AxisSpring((bar / distance,), ("screw_shaft_axial",), "z", (SCREW_END, "screw")),
        AxisSpring((twist,), ("screw_shaft_torsional",), "u", (SCREW_END, "screw")),
    ]
    at_ends = at_end
    if shaft.far_bearing is not None:
        beyond = shaft.far_bearing.distance - distance
        at_far_end = beyond / (2 * length) + (length - shaft.far_bearing.distance) / length
        at_ends = at_ends + at_far_end
        ends.append(AxisBody(FAR_END, mass * at_far_end))
        held = (shaft.far_bearing.axial_stiffness,)
        springs += [
            AxisSpring(held, ("far_bearing",), "z", (FAR_END,)),
            AxisSpring((bar / beyond,), ("screw_shaft_beyond_nut",), "z", (FAR_END, "screw")),
        ]
    at_nut = dataclasses.replace(
        screw,
        axial_mass=screw.axial_mass - mass * at_ends,
        # The far end turns with the screw at the nut.
        equivalent_mass=screw.equivalent_mass - inertia * at_end,
        axial_support=screw.axial_support - axial,
        torsional_support=zero,
    )
    return at_nut, ends, springs


def _heavier(
    bodies: dict[str, SpatialBody | AxisBody], name: str, field: str, mass: Scalar
) -> None:
    """Fix a mass to a body that exists, in one direction."""
    body = bodies[name]
    bodies[name] = dataclasses.replace(body, **{field: getattr(body, field) + mass})


def _motor(
    motor: Motor, driven: str, radius: Scalar, bodies: dict[str, SpatialBody | AxisBody]
) -> tuple[str, list[AxisSpring]]:
    """The body that turns with the rotor, and the springs at it."""
    inertia = motor.inertia / radius**2
    train = {"motor_shaft": motor.shaft_stiffness, "coupling": motor.coupling_stiffness}
    given = {name: value / radius**2 for name, value in train.items() if value is not None}
    springs: list[AxisSpring] = []
    rotor = driven
    if given:
        rotor = "motor"
        bodies[rotor] = AxisBody(rotor, None, inertia)
        parts = tuple(given.values()), tuple(given)
        springs.append(AxisSpring(*parts, "u", (rotor, driven)))
    else:
        _heavier(bodies, driven, "equivalent_mass", inertia)
    if motor.controller is not None:
        gain = motor.controller.proportional_gain / radius**2
        springs.append(AxisSpring((gain,), ("position_gain",), "u", (rotor,)))
    return rotor, springs


def _to_load(load: AxisLoad, stage: Stage, like: Scalar) -> dict[str, Scalar]:
    """Springs in series from the body that moves along the axis to the load, by name [N/m].

    Its mounting, with the axial supports of what moves with it, and the thrust tube.
    """
    held = stage.thread.family.held
    names = moving_with(stage, held)
    found: dict[str, Scalar] = {}
    if has_support(stage, names, "axial"):
        found[f"{held}_support_axial"] = supports(stage, names, "axial", like)
    if load.tube_stiffness is not None:
        found["thrust_tube"] = load.tube_stiffness
    return found


@physics("axis_system")
def axis_system(
    axis: Axis, stage: Stage, stage_bodies: tuple[SpatialBody, ...], motor_held: bool = False
) -> tuple[tuple[SpatialBody, ...], AxisSystem]:
    """The masses and springs of the axis around a stage, and the stage's bodies with it.

    The motor's rotor turns on the springs of its shaft and of the coupling in series. The load
    moves on the thrust tube and the mounting of the nut (its `support.axial_stiffness`) in series:
    a nut that moves a load is mounted to it, and without a load to the housing. Where such a spring
    is not given, the mass is fixed to the next body. The screw is rigid, or has bars E A/l and
    shafts G I_p/l between thrust bearing, nut and far bearing, with the section of its root. The
    proportional gain of the position controller is a torsional spring from the rotor to the
    housing. In an inverted roller screw the motor turns the nut, and the load moves with the end of
    the screw, from which the distance of the nut counts.

    **Arguments:**

    - `axis`: the axis.
    - `stage`: its stage.
    - `stage_bodies`: screw, nut, and further bodies on the axis.
    - `motor_held`: whether the rotor does not turn.

    **Returns:** the bodies of the stage with what is fixed to them, and the rest.

    **Raises:** `MissingDataError` if the screw's length, root or material is missing for its
    stiffness; `ValueError` for a motor that is held and does not exist.
    """
    if motor_held and axis.motor is None:
        raise ValueError("motor_held is True, but the axis has no motor; give [axis.motor]")
    bodies: dict[str, SpatialBody | AxisBody] = {body.name: body for body in stage_bodies}
    springs: list[AxisSpring] = []
    family = stage.thread.family
    # The places on the screw and on the nut where motor and load are.
    at: dict[Side, str] = {"screw": "screw", "nut": "nut"}
    rotor = None
    if axis.shaft is not None:
        at["screw"], screw = SCREW_END, bodies["screw"]
        assert isinstance(screw, SpatialBody)
        bodies["screw"], ends, springs = _shaft(stage, axis.shaft, screw)
        bodies |= {end.name: end for end in ends}
    driven, load = at[family.turning], at[family.held]
    radius = nominal_radius(stage.thread, family.turning)
    if axis.motor is not None:
        rotor, at_motor = _motor(axis.motor, driven, radius, bodies)
        springs += at_motor
    if axis.load is not None:
        between = _to_load(axis.load, stage, radius)
        if f"{family.held}_support_axial" in between:
            springs = [one for one in springs if one.names != (f"{family.held}_support_axial",)]
            body = bodies[family.held]
            bodies[family.held] = dataclasses.replace(body, axial_support=jnp.zeros_like(radius))
        if between:
            moved, load = load, "load"
            bodies[load] = AxisBody(load, axis.load.mass)
            pair = tuple(between.values()), tuple(between)
            springs.append(AxisSpring(*pair, "z", (load, moved)))
        else:
            _heavier(bodies, load, "axial_mass", axis.load.mass)
    changed = tuple(b for b in bodies.values() if isinstance(b, SpatialBody))
    added = tuple(b for b in bodies.values() if isinstance(b, AxisBody))
    return changed, AxisSystem(added, tuple(springs), radius, rotor, load, motor_held)
