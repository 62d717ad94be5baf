"""Simultaneous sliding and spin on the screw side: friction, moment and normal force.

The ellipse slides over the roller at v and spins at ω_n, the part of the relative angular
velocity along the common normal. One dissipation potential gives both the friction force and the
moment (`contact.slip_and_spin`), so that no friction is counted twice. The local slip obeys
the law of thread friction; its coefficient is taken at the mean local slip speed Φ(v, ω_n).

Friction and moment depend on the ellipse, which grows with F^{1/3}, and F depends on the friction:
the axial balance is one equation for the share of the normal force that carries axially.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ...contact import EllipseShape, slip_and_spin
from ...fields import Scalar
from ...friction import Deflected, FrictionLaw
from ...mechanism import Stage
from ...numerics import cube_root_or_zero, dot_few, find_root, length_few
from ...programs import physics
from .._kinematics import StageKinematics
from ._bristles import bristle_friction, bristles_of
from ._law_inputs import Slip, asks_for_force, law_inputs_of
from ._thread_friction import friction_coefficient, slip_resistance, thread_friction

#: Points of the quadrature rule. For any position of the instantaneous centre its error is below
#: 1e-10 up to a/b = 5, and below 1e-7 up to a/b = 10.
_ORDER = 20
#: Least share of the normal force that carries axially; below it a thread counts as jammed.
_LEAST_SHARE = 1e-9


class RubbingEllipse(eqx.Module):
    """Contact ellipse of the screw side at 1 N normal force of one roller, with its orientation."""

    shape: EllipseShape
    #: Rolling direction and the tangent across it: radial, tangential, axial.
    rolling: Float[Array, "3"]
    across: Float[Array, "3"]
    #: Axial part of the common normal.
    normal_axial: Scalar


class Rubbing(eqx.Module):
    """Slip and spin of an ellipse, and the gradient of their mean local slip speed Φ."""

    #: ∂Φ/∂v: friction force per unit of μ F; spin makes it shorter than 1.
    direction: Float[Array, "3"]
    #: ∂Φ/∂ω_n |n_z|: resisting moment about the axis per unit of μ F [m].
    moment: Scalar
    #: Φ [m/s].
    mean_speed: Scalar
    #: Resisting moment about the axis per viscous coefficient, ω_n |n_z| (a² + b²)/5 [m²/s].
    viscous_moment: Scalar
    #: Inputs that the friction law asks for, by name.
    law_inputs: dict[str, Scalar] = eqx.field(default_factory=dict)


def rubbing_ellipse(shape: EllipseShape, normal: Float[Array, "3"]) -> RubbingEllipse:
    """An ellipse whose axes are the rolling direction and the tangent across it."""
    x, y, z = normal
    level = jnp.sqrt(x**2 + y**2)
    return RubbingEllipse(
        shape=shape,
        rolling=jnp.stack([-y / level, x / level, jnp.zeros_like(level)]),
        across=jnp.stack([-z * x / level, -z * y / level, level]),
        normal_axial=z,
    )


def spin_per_slip(kinematics: StageKinematics, direction: Float[Array, "3"]) -> Scalar:
    """Angular velocity of screw over roller, Ω + (n − 1) ω, per slip speed [rad/m].

    The direction of the slip determines it, because both speeds follow from the slip. This holds at
    standstill too, where only the direction of impending motion is known.
    """
    drive, slip = kinematics.drive, kinematics.slip_per_screw
    screw = direction[2] / slip[2]
    if kinematics.axial_drive is not None:
        # The axial slip determines the speed of screw over carrier.
        aside = slip[:2] - drive
        carrier = dot_few(direction[:2] - screw * slip[:2], aside) / dot_few(aside, aside)
        return screw + (1 + kinematics.relative_spin_ratio) * carrier
    carrier = dot_few(screw * slip[:2] - direction[:2], drive) / dot_few(drive, drive)
    return screw + kinematics.relative_spin_ratio * carrier


@physics("spin_friction")
def rubbing(
    ellipse: RubbingEllipse,
    kinematics: StageKinematics,
    slip: Slip,
    force: Scalar,
    law: FrictionLaw | None = None,
) -> Rubbing:
    """Slip and spin of an ellipse under a normal force, in the frame of the loaded flank.

    **Arguments:**

    - `ellipse`: contact ellipse of the screw side.
    - `kinematics`: of its stage.
    - `slip`: of the screw over the roller.
    - `force`: normal force of one roller [N].
    - `law`: the friction law, for the inputs that it asks for.
    """
    direction = slip.direction
    speed, friction_share = length_few(slip.velocity), length_few(slip.direction)
    growth, normal_axial = cube_root_or_zero(jnp.abs(force)), jnp.abs(ellipse.normal_axial)
    turning = spin_per_slip(kinematics, direction)
    # Doubling the ellipse has the effect of doubling the spin: the shape stays that at 1 N.
    spin = ellipse.normal_axial * turning * growth
    rolling, across = dot_few(direction, ellipse.rolling), dot_few(direction, ellipse.across)
    resultant = slip_and_spin(ellipse.shape, (rolling, across), spin, _ORDER)
    first, second = resultant.force
    size = ellipse.shape.first + ellipse.shape.second
    return Rubbing(
        direction=friction_share * (first * ellipse.rolling + second * ellipse.across),
        moment=growth * normal_axial * jnp.abs(resultant.moment),
        mean_speed=speed * (first * rolling + second * across + resultant.moment * spin),
        viscous_moment=size / 5 * jnp.abs(growth * normal_axial * spin) * speed,
        law_inputs={} if law is None else law_inputs_of(law, kinematics, slip, force),
    )


def deflected(
    slip: Float[Array, "3"], deflection: Float[Array, "3"], rub: Rubbing | None
) -> Deflected:
    """Slip and deflection of a contact, with its spin where that is modelled."""
    if rub is None:
        return Deflected(slip, deflection)
    return Deflected(slip, deflection, rub.direction, rub.mean_speed)


def friction_on_roller(
    stage: Stage,
    slip: Slip,
    deflection: Float[Array, "3"] | None,
    rub: Rubbing | None,
    law_inputs: dict[str, Scalar],
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """Friction of the threads on one roller: per unit of normal force, and independent of it [N].

    **Arguments:**

    - `stage`: the stage.
    - `slip`: of the screw over the roller.
    - `deflection`: of the bristles, if the law has that state [m].
    - `rub`: slip and spin of the ellipse, where that is modelled.
    - `law_inputs`: inputs that the law asks for, by name.
    """
    law, bristles = stage.thread_law, bristles_of(stage)
    if bristles is not None and deflection is not None:
        return bristle_friction(bristles, deflected(slip.velocity, deflection, rub))
    if law is None or rub is None:
        return thread_friction(law, slip.velocity, slip.direction, law_inputs)
    constant = slip_resistance(law, slip.velocity)
    if law.load_independent:
        return jnp.zeros_like(constant), constant
    return friction_coefficient(law, rub.mean_speed, law_inputs) * rub.direction, constant


@physics("spin_friction")
def rubbed_moment(law: FrictionLaw, rub: Rubbing, force: Scalar) -> Scalar:
    """Moment about the axis that resists the spin of the screw side of one roller [N·m]."""
    moment = friction_coefficient(law, rub.mean_speed, rub.law_inputs) * force * rub.moment
    resistance = law.viscous_resistance
    return moment if resistance is None else moment + resistance * rub.viscous_moment


class ScrewContact(NamedTuple):
    """Normal force of the screw on one roller, friction per force and independent of it, spin."""

    force: Scalar
    per_force: Float[Array, "3"]
    constant: Float[Array, "3"]
    #: `None` without spin, or without friction that spin could change.
    rubbing: Rubbing | None = None
    #: Residual of the axial balance at an assumed share of the normal force; of order one.
    residual: Scalar | None = None


def rubbing_of(stage: Stage, kinematics: StageKinematics) -> RubbingEllipse | None:
    """The ellipse that slides and spins; `None` without spin or thread friction."""
    friction = stage.friction
    if friction is None or friction.spin is None or friction.thread is None:
        return None
    # `StageKinematics` cannot import that class, which is defined in a higher layer.
    return getattr(kinematics.resistance, "ellipse", None)


def has_unknown_share(stage: Stage, kinematics: StageKinematics) -> bool:
    """Whether friction depends on the normal force other than in proportion to it."""
    return rubbing_of(stage, kinematics) is not None or asks_for_force(stage)


def unknown_shares(
    stages: tuple[Stage, ...], kinematics: tuple[StageKinematics, ...]
) -> dict[int, Scalar]:
    """Stages with an unknown share in their axial balance, and its guess without friction."""
    return {
        index: -geometry.sliding.normal[2]
        for index, (stage, geometry) in enumerate(zip(stages, kinematics, strict=True))
        if has_unknown_share(stage, geometry)
    }


class _Balance(NamedTuple):
    """The axial balance of a roller whose friction depends on its normal force."""

    stage: Stage
    ellipse: RubbingEllipse | None
    kinematics: StageKinematics
    slip: Slip
    deflection: Float[Array, "3"] | None
    #: Axial force left for the normal force [N]; share of the latter that carries without spin.
    remainder: Scalar
    bracket: Scalar

    def at(self, share: Scalar) -> ScrewContact:
        """The contact, if this share of the normal force carries axially."""
        carries = self.bracket > _LEAST_SHARE
        assumed = jnp.where(carries, jnp.maximum(share, _LEAST_SHARE), self.bracket)
        force = self.remainder / assumed
        law = self.stage.thread_law
        assert law is not None
        rub = None
        if self.ellipse is not None:
            rub = rubbing(self.ellipse, self.kinematics, self.slip, force, law)
        law_inputs = (
            law_inputs_of(law, self.kinematics, self.slip, force) if rub is None else rub.law_inputs
        )
        per_force, constant = friction_on_roller(
            self.stage, self.slip, self.deflection, rub, law_inputs
        )
        carried = -self.kinematics.sliding.normal[2] - per_force[2]
        residual = share - jnp.where(carries, carried, self.bracket)
        # Below the least share the force does not change. A balance there is not valid: the contact
        # would have to pull.
        pushes = (share > _LEAST_SHARE) | ~carries
        return ScrewContact(jnp.where(pushes, force, -force), per_force, constant, rub, residual)


def screw_contact(
    stage: Stage,
    kinematics: StageKinematics,
    slip: Slip,
    axial: Scalar,
    deflection: Float[Array, "3"] | None = None,
    share: Scalar | None = None,
) -> ScrewContact:
    """Normal force of one roller from its axial balance, F (|n_z| − f_z/F) = F_a + f_z.

    With spin, and with laws that ask for the normal force or the pressure, the bracket depends on
    the force and is found by Newton's iteration. A thread counts as jammed if it would jam without
    spin at the normal force without friction, because Hertz's theory gives no ellipse beyond that,
    and if no force balances.

    **Arguments:**

    - `stage`, `kinematics`: the stage, with the contact ellipses if spin is modelled.
    - `slip`: of the screw over the roller.
    - `axial`: axial force that one roller carries [N].
    - `deflection`: of the bristles, if friction has that state [m].
    - `share`: the bracket, if it is solved for with other unknowns (`residual` must then vanish).
    """
    law, ellipse = stage.thread_law, rubbing_of(stage, kinematics)
    normal_axial = -kinematics.sliding.normal[2]
    law_inputs = {} if law is None else law_inputs_of(law, kinematics, slip, axial / normal_axial)
    per_force, constant = friction_on_roller(stage, slip, deflection, None, law_inputs)
    bracket = normal_axial - per_force[2]
    remainder = axial + constant[2]
    if not has_unknown_share(stage, kinematics):
        return ScrewContact(remainder / bracket, per_force, constant)
    balance = _Balance(stage, ellipse, kinematics, slip, deflection, remainder, bracket)
    if share is None:
        start = jnp.where(bracket > _LEAST_SHARE, bracket, 1.0)
        accuracy = 1e-14 if start.dtype == jnp.float64 else 1e-6

        # A plain function: JAX hashes it, and a method would carry arrays.
        def axial_residual(unknown: Scalar) -> Scalar:
            residual = balance.at(unknown).residual
            assert residual is not None
            return residual

        share, _ = find_root(axial_residual, start, tolerance=accuracy, max_steps=20)
        contact = balance.at(share)
        # If friction grows faster than the force there may be no balance: the thread jams, and its
        # contact would have to pull.
        size = 1e-9 if start.dtype == jnp.float64 else 1e-3
        assert contact.residual is not None
        balanced = jnp.abs(contact.residual) <= size
        force = jnp.where(balanced, contact.force, -jnp.abs(contact.force))
        return contact._replace(force=force)
    return balance.at(share)
