"""Modes and static stiffness of the axis around a mechanism, for the quantities of an analysis."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._errors import MissingDataError
from ..fields import Scalar
from ..geometry import axis_possible
from ..mechanism import Axis, Motor, Side, Stage
from ..numerics import above_or_nan, below_or_nan
from ..vibration import (
    RIGID_SHARE,
    Coordinate,
    SpatialSystem,
    SpringModes,
    SpringNetwork,
    axial_torsional_modes,
    spatial_harmonic_network,
    spatial_system,
    spring_modes,
    static_compliance,
)
from ._analysis import Analysis

#: Quantities of the axis, with their words in tables and their units.
AXIS_QUANTITIES = {
    "first_axial_frequency": ("first axial frequency", "Hz"),
    "first_torsional_frequency": ("first torsional frequency", "Hz"),
    "first_transverse_frequency": ("first transverse frequency", "Hz"),
    "antiresonance_frequency": ("anti-resonance, motor held", "Hz"),
    "position_loop_frequency": ("position loop", "Hz"),
    "servo_stiffness": ("servo stiffness at the load", "N/m"),
    "held_motor_stiffness": ("stiffness with the motor held", "N/m"),
}


class AxialModes(NamedTuple):
    """Frequencies of harmonic 0, and the axial share of each."""

    frequencies: Float[Array, " modes"]
    axial_share: Float[Array, " modes"]

    @property
    def elastic(self) -> Array:
        """Whether each is no rigid motion."""
        return above_or_nan(self.frequencies, RIGID_SHARE * jnp.max(self.frequencies))

    def first(self, *, axial: bool | None = None) -> Scalar:
        """The lowest elastic one: of the axial ones, of the others, or of all; else infinite."""
        chosen = self.elastic
        if axial is not None:
            side = above_or_nan if axial else below_or_nan
            chosen = chosen & side(self.axial_share, 0.5)
        return jnp.min(jnp.where(chosen, self.frequencies, jnp.inf))


def axis_of(analysis: Analysis) -> Axis:
    """The axis of the mechanism.

    **Raises:** `MissingDataError` if there is none.
    """
    if analysis.mechanism.axis is None:
        raise MissingDataError(
            "the mechanism has no axis around it; give [axis] with [axis.motor], [axis.shaft] or "
            "[axis.load]"
        )
    return analysis.mechanism.axis


def motor_of(analysis: Analysis) -> Motor:
    """The motor of the axis.

    **Raises:** `MissingDataError` if there is none.
    """
    motor = axis_of(analysis).motor
    if motor is None:
        raise MissingDataError("the axis has no motor; give [axis.motor]")
    return motor


def axis_spatial_system(analysis: Analysis, motor_held: bool = False) -> SpatialSystem:
    """Masses and springs of the stage and the axis, with the motor free or held.

    **Raises:** `MissingDataError` if there is no axis, or data are missing for it.
    """
    axis = axis_of(analysis)

    def make() -> SpatialSystem:
        stage = analysis.mechanism.stages[0]
        # Also for a search, which does not check dimensions again.
        analysis.require(axis_possible(axis, stage))
        try:
            return spatial_system(
                stage,
                analysis.tangent_threads[0],
                analysis.kinematics[0].meshing,
                axis=axis,
                motor_held=motor_held,
                tilt=axis.tilt,
            )
        except ValueError as error:
            # A quantity that a mechanism cannot have is left out, like one without data.
            raise MissingDataError(str(error)) from error

    return analysis.once(("axis_system", int(motor_held)), make)


def _spring_modes(analysis: Analysis, motor_held: bool) -> tuple[SpringNetwork, SpringModes]:
    """The network of harmonic 0 and its modes, which frequencies and stiffnesses share."""

    def make() -> tuple[SpringNetwork, SpringModes]:
        network = spatial_harmonic_network(axis_spatial_system(analysis, motor_held), 0)
        return network, spring_modes(network)

    return analysis.once(("axis_spring_modes", int(motor_held)), make)


def axial_modes(analysis: Analysis, motor_held: bool = False) -> AxialModes:
    """The axial–torsional modes of stage and axis."""

    def make() -> AxialModes:
        system = axis_spatial_system(analysis, motor_held)
        _, modes = _spring_modes(analysis, motor_held)
        group, share = axial_torsional_modes(system, modes)
        return AxialModes(group.frequencies, share)

    return analysis.once(("axial_modes", int(motor_held)), make)


def _is_held(stage: Stage, side: Side, direction: str) -> bool:
    """Whether screw or nut, with the ring gear that is fixed to the nut, has such a support."""
    bodies = (stage.screw,) if side == "screw" else (stage.nut, stage.ring_gear)
    supports = [None if body is None else body.support for body in bodies]
    return any(
        one is not None and getattr(one, f"{direction}_stiffness") is not None for one in supports
    )


def axis_stiffness(analysis: Analysis, motor_held: bool) -> Scalar:
    """Static force per displacement at the load [N/m].

    **Raises:** `MissingDataError` if nothing holds the body that turns along the axis (the screw;
    of an inverted roller screw the nut), or the other one against turning.
    """
    axis, stage = axis_of(analysis), analysis.mechanism.stages[0]
    family = stage.thread.family
    far = None if axis.shaft is None else axis.shaft.far_bearing
    if far is None and not _is_held(stage, family.turning, "axial"):
        raise MissingDataError(
            f"nothing holds the {family.turning} along the axis; give "
            f"stage.{family.turning}.support.axial_stiffness, that of its thrust bearing"
        )
    if not _is_held(stage, family.held, "torsional"):
        raise MissingDataError(
            f"nothing keeps the {family.held} from turning; give "
            f"stage.{family.held}.support.torsional_stiffness"
        )

    def make() -> Scalar:
        system = axis_spatial_system(analysis, motor_held)
        assert system.axis is not None
        network, modes = _spring_modes(analysis, motor_held)
        return 1 / static_compliance(network, Coordinate(system.axis.load, "z"), modes)

    return analysis.once(("axis_stiffness", int(motor_held)), make)


def reduced_inertia(analysis: Analysis) -> Scalar:
    """Moment of inertia at the motor of everything that it moves, with rigid springs [kg·m²].

    Rotor and screw turn; nut, rollers, carriers and load move by the lead for each turn. In an
    inverted roller screw rotor and nut turn, and screw, rollers, carriers and load move. The
    rollers' own rotation and their motion around the screw are left out.
    """
    system = axis_spatial_system(analysis)
    assert system.axis is not None
    stage = analysis.mechanism.stages[0]
    family = stage.thread.family
    on_screw = [body.name for body in system.axis.bodies if body.name.startswith("screw_")]
    parts: dict[Side, list[str]] = {"screw": ["screw", *on_screw], "nut": ["nut"]}
    travel = stage.thread.ideal_travel / (2 * jnp.pi)
    bodies = (*system.bodies, *system.axis.bodies)
    turn, move = (*parts[family.turning], "motor"), (*parts[family.held], "load")
    turning = [body.equivalent_mass for body in bodies if body.name in turn]
    moving = [body.axial_mass for body in bodies if body.name in move]
    moving.append(stage.present_roller_count * system.roller_mass)
    inertia = jnp.sum(jnp.stack([one for one in turning if one is not None]))
    mass = jnp.sum(jnp.stack([one for one in moving if one is not None]))
    return inertia * system.axis.radius**2 + mass * travel**2
