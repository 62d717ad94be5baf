"""Resisting moments inside the contact ellipses: spin and rolling hysteresis.

The relative angular velocity of screw (or nut) and roller is parallel to the axis; its part along
the common normal spins the ellipse, its part in the tangent plane rolls it. Both moments oppose
it, so each contact adds one resisting moment about the axis, Σ M |∂ω_i/∂ω_z|.

The nut side rolls without sliding, so only spin rubs there. The screw side slides as well: its
spin moment and its friction force come from one potential (`_rubbing`).

A Hertz ellipse keeps its shape and grows with F^{1/3}, so the moments of hysteresis, and of spin on
the nut side, are coefficients times F^{4/3}: the ellipses are computed once for a mechanism, not at
every instant.
"""

import dataclasses
from typing import cast

import equinox as eqx
import jax
import jax.numpy as jnp

from ..._errors import MissingDataError
from ...contact import (
    ContactFrame,
    HertzContact,
    contact_frames,
    ellipse_shape,
    engaged_threads,
    side_contact,
)
from ...fields import Scalar
from ...friction import Friction, RollingHysteresis, SpinFriction
from ...geometry import RelativeCurvature
from ...mechanism import Stage
from ...numerics import above_or_nan, apart, cube_root_or_zero
from ...programs import physics
from .._kinematics import StageKinematics
from ._law_inputs import asks_for_pressure
from ._rubbing import Rubbing, RubbingEllipse, rubbed_moment, rubbing_ellipse


class ResistingMoment(eqx.Module):
    """Moments about the axis of one roller that resist its rotation on one side, by cause [N·m].

    `None` where the loss is not modelled.
    """

    spin: Scalar | None
    rolling_hysteresis: Scalar | None

    @property
    def total(self) -> Scalar | float:
        """Sum of the modelled moments [N·m]."""
        return sum(part for part in (self.spin, self.rolling_hysteresis) if part is not None)


class ContactResistance(eqx.Module):
    """Contact ellipses and resisting moments of one roller at a normal force of 1 N."""

    #: Screw and nut side; the spin of the screw side is not included.
    screw: ResistingMoment
    nut: ResistingMoment
    #: Ellipse of the screw side, where spin is modelled.
    ellipse: RubbingEllipse | None
    #: Largest Hertz pressure of the screw side, where the friction law asks for it [Pa].
    pressure: Scalar | None = None


def has_contact_losses(friction: Friction | None) -> bool:
    """Whether any loss inside the contact ellipses is modelled."""
    return friction is not None and not (
        friction.spin is None and friction.rolling_hysteresis is None
    )


@physics("spin_friction")
def spin_moment(law: SpinFriction, hertz: HertzContact, force: Scalar) -> Scalar:
    """Moment that resists the spin of a Hertz ellipse that does not slide, 3/8 μ F a E(m) [N·m].

    Coulomb friction over the ellipse with full spin (Johnson 1985; Harris and Kotzalas 2006).
    """
    ellipse = hertz.semi_major * hertz.second_elliptic_integral
    return 3 / 8 * law.coefficient * force * ellipse


@physics("rolling_hysteresis")
def rolling_moment(
    law: RollingHysteresis, hertz: HertzContact, curvature: RelativeCurvature, force: Scalar
) -> Scalar:
    """Moment that resists rolling of a Hertz ellipse by hysteresis, 3/16 α F l [N·m].

    `l` is the half-length of the ellipse in the rolling direction, from
    1/l² = cos²ψ/a² + sin²ψ/b² with the angle ψ between rolling direction and major axis
    (Johnson 1985, equation 9.2).
    """
    difference_squared = curvature.difference_squared
    elongated = above_or_nan(difference_squared)
    difference = jnp.sqrt(jnp.where(elongated, difference_squared, 1.0))
    # The gap coefficient in the rolling direction is A cos²ψ + B sin²ψ.
    sine_squared = jnp.where(
        elongated, (curvature.rolling - curvature.total / 2) / difference + 0.5, 0.5
    )
    loaded = above_or_nan(hertz.semi_minor)
    major = jnp.where(loaded, hertz.semi_major, 1.0)
    minor = jnp.where(loaded, hertz.semi_minor, 1.0)
    length = 1 / jnp.sqrt((1 - sine_squared) / major**2 + sine_squared / minor**2)
    return 3 / 16 * law.loss_factor * force * jnp.where(loaded, length, 0.0)


def contact_resistance(stage: Stage, kinematics: StageKinematics) -> ContactResistance:
    """Ellipses and resisting moments of one roller at a normal force of 1 N.

    **Raises:** `MissingDataError` if the contact ellipses cannot be computed.
    """
    friction = stage.friction
    assert friction is not None
    force = jnp.ones_like(kinematics.slip_per_screw[2])
    frames = contact_frames(stage.thread, kinematics.meshing, stage.curvature)
    family = stage.thread.family
    sides = (kinematics.sliding, kinematics.rolling)
    names = (family.turning, family.held)
    if family.turning == "nut":
        frames = _turned_frames(frames)
    moments, ellipse, pressure = [], None, None
    for name, frame, side in zip(names, frames, sides, strict=True):
        try:
            threads = engaged_threads(stage)
            hertz = side_contact(stage, name, frame, force / threads).hertz
        except MissingDataError as error:
            needs = "spin, rolling losses, and friction by pressure need the ellipses"
            raise MissingDataError(f"{needs}: {error}") from error
        along_normal = jnp.abs(side.normal[2])
        in_plane = jnp.hypot(side.normal[0], side.normal[1])
        spin, rolling = friction.spin, friction.rolling_hysteresis
        slides = name == family.turning
        if slides and asks_for_pressure(stage):
            pressure = hertz.max_pressure
        if slides and spin is not None:
            ellipse = rubbing_ellipse(ellipse_shape(hertz, frame.curvature), side.normal)
        moments.append(
            ResistingMoment(
                spin=None
                if spin is None or slides
                else spin_moment(spin, hertz, force) * along_normal,
                rolling_hysteresis=None
                if rolling is None
                else rolling_moment(rolling, hertz, frame.curvature, force) * in_plane,
            )
        )
    return ContactResistance(moments[0], moments[1], ellipse, pressure)


def _turned_frames(frames: tuple[ContactFrame, ContactFrame]) -> tuple[ContactFrame, ContactFrame]:
    """Frames of the nut, on which rollers slide, and of the screw.

    The directions of a curvature are given about the screw's normal: about that of the nut, which
    points the other way, its twist has the other sign.
    """
    screw, nut = frames
    curvature = dataclasses.replace(nut.curvature, twist=-nut.curvature.twist)
    return dataclasses.replace(nut, curvature=curvature), screw


def _at_force(coefficient: ResistingMoment, force: Scalar) -> ResistingMoment:
    growth = force * cube_root_or_zero(force)
    return jax.tree.map(lambda at_unit_force: at_unit_force * growth, coefficient)


def resisting_moments(
    stage: Stage,
    kinematics: StageKinematics,
    screw_force: Scalar,
    nut_force: Scalar,
    rub: Rubbing | None,
) -> tuple[ResistingMoment, ResistingMoment]:
    """Resisting moments about the axis on the screw and the nut side of one roller.

    **Arguments:**

    - `stage`: the stage; needs materials and engaged threads for the contact ellipses.
    - `kinematics`: its kinematics, with the contact losses (`with_resistance`).
    - `screw_force`, `nut_force`: normal force of one roller, all its threads together [N].
    - `rub`: slip and spin of the screw side, where spin is modelled.

    **Raises:** `MissingDataError` if the contact ellipses cannot be computed.
    """
    # `StageKinematics` cannot import this class, which is defined in a higher layer.
    unit = cast(ContactResistance, kinematics.resistance)
    screw, nut = _at_force(unit.screw, screw_force), _at_force(unit.nut, nut_force)
    law = stage.thread_law
    if rub is not None and law is not None:
        screw = dataclasses.replace(screw, spin=rubbed_moment(law, rub, screw_force))
    return screw, nut


def with_resistance(
    stages: tuple[Stage, ...], kinematics: tuple[StageKinematics, ...]
) -> tuple[StageKinematics, ...]:
    """Kinematics with the coefficients of the contact losses, where these are modelled."""
    return tuple(
        dataclasses.replace(geometry, resistance=apart(contact_resistance)(stage, geometry))
        if geometry.resistance is None
        and (has_contact_losses(stage.friction) or asks_for_pressure(stage))
        else geometry
        for stage, geometry in zip(stages, kinematics, strict=True)
    )
