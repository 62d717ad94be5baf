"""Modes of any stage, symmetric or not, from all its degrees of freedom at once."""

import dataclasses
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..numerics import above_or_nan
from ..programs import physics
from ._families import FAMILIES, family_shares
from ._grouped_modes import COUPLED, ModeGroup, frequency, of_elastic
from ._modes import Modes
from ._spring_modes import directional_slopes, spring_modes
from ._symmetric import carrier_mode, meshed_share, symmetric_modes
from .model import VibrationSystem, spring_network


@physics("dense_modes")
def dense_modes(system: VibrationSystem) -> Modes:
    """All natural frequencies, shapes and families, without use of symmetry.

    For rollers that differ in stiffness, mass or position, for missing or fewer than 3 rollers,
    and for supports that differ in x and y. A symmetric stage has the modes of `symmetric_modes`.
    Derivatives at repeated roots: see `spring_modes`.

    **Arguments:**

    - `system`: masses and springs from `vibration_system`.
    """
    network = spring_network(system)
    # An uncoupled carrier would mix with any other mode of equal frequency.
    carrier_group = carrier_mode(system, shapes=True)
    rest = (
        network
        if carrier_group is None
        else spring_network(dataclasses.replace(system, carrier=None))
    )
    modes = spring_modes(rest)
    frequencies = modes.angular_frequencies / (2 * jnp.pi)
    share = of_elastic(meshed_share(rest, modes.shapes), frequencies)
    shapes = modes.shapes
    groups: tuple[ModeGroup, ...] = ()
    if carrier_group is not None:
        shapes = jnp.concatenate([shapes, jnp.zeros_like(shapes[:1])])
        groups = (carrier_group,)
    coupled = ModeGroup(frequencies, share, 1, COUPLED, shapes[..., None])
    return Modes((*groups, coupled), system=system, network=network)


def family_modes(modes: Modes, family: str) -> ModeGroup | None:
    """The modes of one family, identified by symmetry or, without it, by their motion.

    **Arguments:**

    - `modes`: of any stage, symmetric or not.
    - `family`: one of `FAMILIES`.

    **Returns:** the group, or `None` if the stage has no such modes by its structure. Without
    symmetry it has an entry for every mode; modes of other families have infinite frequencies and
    come last.
    """
    group = modes.group(family)
    coupled = modes.group(COUPLED)
    if group is not None or coupled is None:
        return group
    assert modes.system is not None
    assert modes.network is not None
    assert coupled.shapes is not None
    shares = family_shares(modes.system, modes.network, coupled.shapes[..., 0])
    belongs = jnp.argmax(shares, axis=0) == FAMILIES.index(family)
    frequencies = jnp.where(belongs, coupled.frequencies, jnp.inf)
    order = jnp.argsort(frequencies)
    return ModeGroup(frequencies[order], coupled.mesh_energy_share[order], 1, family)


class FrequencySlopes(eqx.Module):
    """Natural frequencies at a point of a path, and their one-sided derivatives."""

    #: Ascending, repeated roots repeated [Hz].
    frequencies: Float[Array, " degrees"]
    #: One-sided derivative of each entry as the path's parameter grows [Hz per its unit].
    forward: Float[Array, " degrees"]
    #: One-sided derivative of each entry as it comes from below [Hz per its unit].
    backward: Float[Array, " degrees"]


@physics("directional_derivatives")
def directional_derivatives(
    system_at: Callable[[Scalar], VibrationSystem], at: float | Scalar = 0.0
) -> FrequencySlopes:
    """One-sided derivatives of every natural frequency along a path of systems.

    A repeated root that the path splits has no derivative, but each of its members has one in each
    direction: from the eigenvalues of `Φᵀ (K′ − λ M′) Φ` in the subspace of the root. It depends
    on the direction, so `jax.grad` cannot give it. The mean of a cluster has a derivative that is
    valid in every direction: that of `spring_modes` and `dense_modes`.

    **Arguments:**

    - `system_at`: gives the system for a value of the path's parameter; differentiable.
    - `at`: value of the path's parameter.
    """
    place = jnp.asarray(at, jnp.result_type(float))
    network, change = jax.jvp(
        lambda t: spring_network(system_at(t)), (place,), (jnp.ones_like(place),)
    )
    values, forward, backward = directional_slopes(network, change)
    frequencies = frequency(values)
    elastic = above_or_nan(frequencies)
    # f = √λ/2π; for a rigid motion f has a slope at zero only if λ grows with t².
    rate = jnp.where(elastic, 1 / (8 * jnp.pi**2 * jnp.where(elastic, frequencies, 1.0)), 0.0)
    return FrequencySlopes(frequencies, rate * forward, rate * backward)


def stage_modes(system: VibrationSystem, *, shapes: bool = False) -> Modes:
    """Modes of a stage: by symmetry if its structure is symmetric, else from all coordinates."""
    return symmetric_modes(system, shapes=shapes) if system.symmetric else dense_modes(system)


__all__ = [
    "FrequencySlopes",
    "dense_modes",
    "directional_derivatives",
    "family_modes",
    "stage_modes",
]
