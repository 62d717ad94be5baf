"""The friction of one stage: each law is there only if the scene names it."""

from typing import TypeAlias

import equinox as eqx

from ._fields import Scalar, number, optional_number


class CoulombFriction(eqx.Module):
    """Coulomb friction between screw and roller threads: force μ F against the slip."""

    coefficient: Scalar = number("1", "friction coefficient, μ")


class ViscousFriction(eqx.Module):
    """Viscous friction between screw and roller threads: force c v per roller."""

    coefficient: Scalar = number("N·s/m", "viscous friction coefficient of one roller, μ'")


class RegularisedCoulombFriction(eqx.Module):
    """Coulomb friction smoothed over a small slip: force μ F v / √(v² + ε²).

    Differentiable through standstill and reversal. It lets a loaded contact creep where Coulomb
    friction would hold it, and misses about μ F ε of power while it does.
    """

    coefficient: Scalar = number("1", "friction coefficient, μ")
    width: Scalar = number("m/s", "slip speed over which the force changes its sign, ε")


class StribeckFriction(eqx.Module):
    """Friction that falls from a static to a sliding coefficient as a film of lubricant builds up.

    Force `(μ + (μ_s − μ) e^{−(v/v_S)²}) F + c v` against the slip.
    """

    static_coefficient: Scalar = number("1", "friction coefficient at the onset of slip, μ_s")
    coefficient: Scalar = number("1", "friction coefficient of fast slip, μ")
    stribeck_speed: Scalar = number("m/s", "slip speed of the transition, v_S")
    viscous_coefficient: Scalar | None = optional_number(
        "N·s/m", "viscous friction coefficient of one roller, c"
    )


ThreadFriction: TypeAlias = (
    CoulombFriction | ViscousFriction | RegularisedCoulombFriction | StribeckFriction
)


class SpinFriction(eqx.Module):
    """Spin of the contact ellipses about the common normal (screw and nut side)."""

    coefficient: Scalar = number("1", "friction coefficient in the spinning contact, μ")


class RollingHysteresis(eqx.Module):
    """Rolling resistance by elastic hysteresis in the contact ellipses (screw and nut side)."""

    loss_factor: Scalar = number("1", "share of the elastic energy lost per cycle, α_h")


class SplineFriction(eqx.Module):
    """Coulomb friction in the spline that turns an axially moving screw (not the first one)."""

    coefficient: Scalar = number("1", "friction coefficient, μ_SS")
    radius: Scalar = number("m", "effective radius of the spline, r_SS")


class ThrustBearingFriction(eqx.Module):
    """Friction of the thrust bearing that holds the screw, in the previous nut or the housing."""

    coefficient: Scalar = number("1", "friction coefficient, μ_NS")
    radius: Scalar = number("m", "effective radius of the bearing, r_NS")


class ConstantDrag(eqx.Module):
    """A drag torque on the screw that does not depend on the load (seals, lubricant, bearings)."""

    torque: Scalar = number("N·m", "drag torque")


class Friction(eqx.Module):
    """All losses of one stage; `None` is not modelled and leaves no trace."""

    thread: ThreadFriction | None = None
    spin: SpinFriction | None = None
    rolling_hysteresis: RollingHysteresis | None = None
    spline: SplineFriction | None = None
    thrust_bearing: ThrustBearingFriction | None = None
    drag: ConstantDrag | None = None
