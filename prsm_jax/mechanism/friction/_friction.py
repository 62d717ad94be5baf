"""The friction of one stage: each law is there only if the scene names it."""

from typing import ClassVar, TypeAlias

import equinox as eqx

from ..fields import Scalar, number, optional_number, part
from ._screw_friction import Drag, SplineLaw, ThrustBearingLaw


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


class LuGreFriction(eqx.Module):
    """Bristles between the threads that bend before they slip (Canudas de Wit et al. 1995).

    Deflection z and force of one roller, both vectors in the tangent plane of the contact:
    `ż = v − σ₀ |v| z / g(v)` with `g = μ + (μ_s − μ) e^{−(v/v_S)²}`, and `F (σ₀ z + σ₁ ż) + σ₂ v`.
    Steady slip is Stribeck's law; at rest the contact is a spring of stiffness F σ₀. It passes
    through standstill and reversal smoothly, holding the load.

    Stiffness and damping are those per unit of normal force. `σ₁ = 2 √(σ₀ m / F)` is critical
    damping for a mass m that a force F holds. Constant damping pulls hard where slip begins at
    once, and the contact may then give energy unless σ₂ ≥ σ₁ F (μ_s − μ)/μ (Barabanov and Ortega
    2000); with a damping speed v_d it fades with slip, `σ₁ e^{−(v/v_d)²}`.
    """

    law: ClassVar[str] = "lugre"
    static_coefficient: Scalar = number("1", "friction coefficient at the onset of slip, μ_s")
    coefficient: Scalar = number("1", "friction coefficient of fast slip, μ")
    stribeck_speed: Scalar = number("m/s", "slip speed of the transition, v_S")
    bristle_stiffness: Scalar = number("1/m", "stiffness of the bristles per normal force, σ₀")
    bristle_damping: Scalar = number("s/m", "damping of the bristles per normal force, σ₁")
    damping_speed: Scalar | None = optional_number(
        "m/s", "slip speed over which the bristles' damping fades, v_d; constant if not given"
    )
    viscous_coefficient: Scalar | None = optional_number(
        "N·s/m", "viscous friction coefficient of one roller, σ₂"
    )


ThreadFriction: TypeAlias = (
    CoulombFriction
    | ViscousFriction
    | RegularisedCoulombFriction
    | StribeckFriction
    | LuGreFriction
)


class SpinFriction(eqx.Module):
    """Spin of the contact ellipses about the common normal (screw and nut side).

    The coefficient is that of the nut side, which spins without sliding. The screw side slides and
    spins at once: the law of the threads rubs there.
    """

    coefficient: Scalar = number("1", "friction coefficient in the spinning contact, μ")


class RollingHysteresis(eqx.Module):
    """Rolling resistance by elastic hysteresis in the contact ellipses (screw and nut side)."""

    loss_factor: Scalar = number("1", "share of the elastic energy lost per cycle, α_h")


class Friction(eqx.Module):
    """All losses of one stage; `None` is not modelled and leaves no trace."""

    thread: ThreadFriction | None = part(
        "no sliding loss in the threads, and nothing that drives the carriers against losses"
    )
    spin: SpinFriction | None = part("no loss of contact ellipses that spin about their normal")
    rolling_hysteresis: RollingHysteresis | None = part(
        "no loss of rolling, so that carriers settle where geometry puts them"
    )
    spline: SplineLaw | None = part(
        "no axial force and no loss in the spline of a screw that moves axially"
    )
    thrust_bearing: ThrustBearingLaw | None = part(
        "no friction torque of the thrust bearing of the screw"
    )
    drag: Drag | None = part("no torque of seals and lubricant that does not depend on the load")
