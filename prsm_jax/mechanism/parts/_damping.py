"""The damping of vibration: one law for a stage, and none unless the scene names it."""

from typing import TypeAlias

import equinox as eqx

from ...fields import Scalar, number


class ModalDamping(eqx.Module):
    """Viscous damping with the same ratio in every mode."""

    ratio: Scalar = number("1", "damping ratio of every mode, ζ")


class RayleighDamping(eqx.Module):
    """Viscous damping in proportion to mass and stiffness, C = α M + β K."""

    mass_coefficient: Scalar = number("1/s", "coefficient of the mass matrix, α")
    stiffness_coefficient: Scalar = number("s", "coefficient of the stiffness matrix, β")


class StructuralDamping(eqx.Module):
    """Hysteretic damping of steady harmonic vibration, K (1 + iη)."""

    loss_factor: Scalar = number("1", "loss factor of every spring, η")


Damping: TypeAlias = ModalDamping | RayleighDamping | StructuralDamping
