"""Damping of vibration: one law per stage, and none unless the input defines it."""

from typing import TypeAlias

from ...fields import DAMPING_RATIO, NOT_NEGATIVE, SHARE, Limited, Number, number


class ModalDamping(Limited):
    """Viscous damping with the same ratio in every mode."""

    ratio: Number = number("1", "damping ratio of every mode, ζ", limit=DAMPING_RATIO)


class RayleighDamping(Limited):
    """Viscous damping proportional to mass and stiffness, C = α M + β K."""

    mass_coefficient: Number = number(
        "1/s", "coefficient of the mass matrix, α", limit=NOT_NEGATIVE
    )
    stiffness_coefficient: Number = number(
        "s", "coefficient of the stiffness matrix, β", limit=NOT_NEGATIVE
    )


class StructuralDamping(Limited):
    """Hysteretic damping of steady harmonic vibration, K (1 + iη)."""

    loss_factor: Number = number("1", "loss factor of every spring, η", limit=SHARE)


Damping: TypeAlias = ModalDamping | RayleighDamping | StructuralDamping
