"""Friction beside the threads: splines, thrust bearings, drag; each law is a class of its own.

The plain classes are Coulomb's law, which a file may leave unnamed.
"""

from typing import ClassVar, TypeAlias

import equinox as eqx

from ..fields import Scalar, number, optional_number


class SplineFriction(eqx.Module):
    """Coulomb friction in the spline that turns an axially moving screw (not the first one)."""

    law: ClassVar[str] = "coulomb"
    law_may_be_omitted: ClassVar[bool] = True
    coefficient: Scalar = number("1", "friction coefficient, μ_SS")
    radius: Scalar = number("m", "effective radius of the spline, r_SS")


class RegularisedSplineFriction(eqx.Module):
    """Coulomb friction in the spline, smoothed over a small sliding speed: μ v / √(v² + ε²)."""

    law: ClassVar[str] = "regularised_coulomb"
    coefficient: Scalar = number("1", "friction coefficient, μ_SS")
    radius: Scalar = number("m", "effective radius of the spline, r_SS")
    width: Scalar = number("m/s", "sliding speed over which the force changes its sign, ε")


class StribeckSplineFriction(eqx.Module):
    """Friction in the spline with a coefficient `μ + (μ_s − μ) e^{−(v/v_S)²}`, and a force c v."""

    law: ClassVar[str] = "stribeck"
    static_coefficient: Scalar = number("1", "friction coefficient at the onset of sliding, μ_s")
    coefficient: Scalar = number("1", "friction coefficient of fast sliding, μ_SS")
    stribeck_speed: Scalar = number("m/s", "sliding speed of the transition, v_S")
    radius: Scalar = number("m", "effective radius of the spline, r_SS")
    viscous_coefficient: Scalar | None = optional_number("N·s/m", "viscous friction coefficient, c")


class ViscousSplineFriction(eqx.Module):
    """Viscous friction in the spline: force c v, whatever the torque."""

    law: ClassVar[str] = "viscous"
    coefficient: Scalar = number("N·s/m", "viscous friction coefficient of the spline, c")


SplineLaw: TypeAlias = (
    SplineFriction | ViscousSplineFriction | RegularisedSplineFriction | StribeckSplineFriction
)


class ThrustBearingFriction(eqx.Module):
    """Coulomb friction of the thrust bearing of the screw, in the previous nut or the housing."""

    law: ClassVar[str] = "coulomb"
    law_may_be_omitted: ClassVar[bool] = True
    coefficient: Scalar = number("1", "friction coefficient, μ_NS")
    radius: Scalar = number("m", "effective radius of the bearing, r_NS")


class RegularisedThrustBearingFriction(eqx.Module):
    """Coulomb friction of the thrust bearing, smoothed over a small speed: μ v / √(v² + ε²)."""

    law: ClassVar[str] = "regularised_coulomb"
    coefficient: Scalar = number("1", "friction coefficient, μ_NS")
    radius: Scalar = number("m", "effective radius of the bearing, r_NS")
    width: Scalar = number("m/s", "speed at r_NS over which the torque changes its sign, ε")


class StribeckThrustBearingFriction(eqx.Module):
    """Friction of the thrust bearing with `μ + (μ_s − μ) e^{−(v/v_S)²}`, and a torque c Ω."""

    law: ClassVar[str] = "stribeck"
    static_coefficient: Scalar = number("1", "friction coefficient at the onset of sliding, μ_s")
    coefficient: Scalar = number("1", "friction coefficient of fast sliding, μ_NS")
    stribeck_speed: Scalar = number("m/s", "speed at r_NS of the transition, v_S")
    radius: Scalar = number("m", "effective radius of the bearing, r_NS")
    viscous_coefficient: Scalar | None = optional_number("N·m·s", "viscous friction torque, c")


class ViscousThrustBearingFriction(eqx.Module):
    """Viscous friction of the thrust bearing: torque c Ω, whatever the force."""

    law: ClassVar[str] = "viscous"
    coefficient: Scalar = number("N·m·s", "viscous friction coefficient of the bearing, c")


ThrustBearingLaw: TypeAlias = (
    ThrustBearingFriction
    | ViscousThrustBearingFriction
    | RegularisedThrustBearingFriction
    | StribeckThrustBearingFriction
)


class Drag(eqx.Module):
    """A drag torque on the screw whatever the load (seals, lubricant): constant, and c Ω."""

    torque: Scalar = number("N·m", "constant drag torque")
    viscous_coefficient: Scalar | None = optional_number("N·m·s", "viscous drag coefficient, c")
    width: Scalar | None = optional_number(
        "rad/s", "speed over which the constant torque changes its sign; at once if not given"
    )
