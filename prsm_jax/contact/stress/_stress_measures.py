"""Measures of a stress tensor: principal stresses, von Mises, largest shear stress."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics import above_or_nan, root_or_zero
from ...programs import physics

Stress = Float[Array, "*batch 3 3"]
Measure = Float[Array, "*batch"]


def _second_invariant(stress: Stress) -> Measure:
    """J₂, half the square of the deviator, from differences, so that pressure cancels
    exactly.
    """
    xx, yy, zz = stress[..., 0, 0], stress[..., 1, 1], stress[..., 2, 2]
    xy, yz, zx = stress[..., 0, 1], stress[..., 1, 2], stress[..., 2, 0]
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return normal / 6 + xy**2 + yz**2 + zx**2


@physics("von_mises")
def von_mises_stress(stress: Stress) -> Measure:
    """Reduced stress √(3 J₂) after Huber, von Mises and Hencky, in the unit of the stress.

    Its derivative at a purely hydrostatic state is set to 0.

    **Arguments:**

    - `stress`: symmetric stress tensors.
    """
    return root_or_zero(3 * _second_invariant(stress))


def _lode_angle(stress: Stress, second: Measure) -> Measure:
    """Angle in [−π/6, π/6] from `sin 3θ = −(3√3/2) J₃/J₂^{3/2}`; 0 for a hydrostatic state."""
    third = jnp.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3
    xx, yy, zz = (stress[..., i, i] - third[..., 0, 0] for i in range(3))
    xy, yz, zx = stress[..., 0, 1], stress[..., 1, 2], stress[..., 2, 0]
    determinant = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx)
    deviatoric = above_or_nan(second)
    root = jnp.sqrt(jnp.where(deviatoric, second, 1.0))
    sine = -1.5 * jnp.sqrt(3.0) * jnp.where(deviatoric, determinant, 0.0) / root**3
    # At two equal principal stresses the sorted ones have a kink: the slope of arcsin, infinite
    # there, is replaced by 0, which is the mean of both sides.
    inside = jnp.abs(sine) < 1 - 8 * jnp.finfo(sine.dtype).eps
    return (
        jnp.where(inside, jnp.arcsin(jnp.where(inside, sine, 0.0)), jnp.sign(sine) * jnp.pi / 2) / 3
    )


@physics("principal_stresses")
def principal_stresses(stress: Stress) -> Float[Array, "*batch 3"]:
    """Principal stresses in descending order, in closed form by invariants.

    Accurate to about 1e-8 of the largest where two of them nearly coincide. Source: Nayak and
    Zienkiewicz 1972.

    **Arguments:**

    - `stress`: symmetric stress tensors.
    """
    second = _second_invariant(stress)
    mean = jnp.trace(stress, axis1=-2, axis2=-1) / 3
    angle, size = _lode_angle(stress, second), 2 * root_or_zero(second / 3)
    turn = 2 * jnp.pi / 3
    return jnp.stack([mean + size * jnp.sin(angle + k * turn) for k in (1, 0, -1)], axis=-1)


@physics("max_shear")
def max_shear_stress(stress: Stress) -> Measure:
    """Largest shear stress (σ₁ − σ₃)/2 after Tresca, in the unit of the stress.

    **Arguments:**

    - `stress`: symmetric stress tensors.
    """
    second = _second_invariant(stress)
    return root_or_zero(second) * jnp.cos(_lode_angle(stress, second))


@physics("von_mises")
def von_mises_of_principal(first: Measure, second: Measure, third: Measure) -> Measure:
    """`von_mises_stress` of principal stresses, in any order."""
    square = (first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2
    return root_or_zero(square / 2)


@physics("max_shear")
def max_shear_of_principal(first: Measure, second: Measure, third: Measure) -> Measure:
    """`max_shear_stress` of principal stresses, in any order."""
    largest = jnp.maximum(jnp.maximum(first, second), third)
    return (largest - jnp.minimum(jnp.minimum(first, second), third)) / 2
