"""Modes of a symmetric stage, family by family; at a cost independent of the number of rollers."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..programs import physics
from ._grouped_modes import ModeGroup, frequency, of_elastic
from ._modes import Modes
from ._spring_modes import spring_modes
from .arrowhead import SpringBlock, block_modes, mesh_energy_share
from .model import (
    Coordinate,
    SpringNetwork,
    VibrationSystem,
    carrier_shape,
    harmonic_network,
    harmonic_shapes,
    is_mesh,
    roller_corner,
    shares,
    spring_network,
    strain_energies,
    torsional_springs,
    transverse_springs,
)

_ROLLER = Coordinate("roller", "u")


def meshed_share(network: SpringNetwork, shapes) -> Float[Array, " modes"]:
    """Share of each mode's strain energy in the contacts; 0 for a rigid motion."""
    energy_shares = shares(strain_energies(network, shapes))
    return jnp.sum(jnp.stack([row for name, row in energy_shares.items() if is_mesh(name)]), axis=0)


def _group(
    system: VibrationSystem,
    block: SpringBlock,
    modes: tuple[Array, Array],
    family: str,
    harmonic: int,
    shapes: bool,
) -> ModeGroup:
    values, small = modes
    stage_shapes = None
    if shapes:
        direction = "uw"[harmonic]
        amplitudes = {
            Coordinate(body.name, direction): row
            for body, row in zip(system.bodies, small[:-1], strict=True)
        }
        stage_shapes = harmonic_shapes(system, harmonic, amplitudes | {_ROLLER: small[-1]})
    frequencies = frequency(values)
    share = of_elastic(mesh_energy_share(block, small), frequencies)
    return ModeGroup(frequencies, share, harmonic + 1, family, stage_shapes)


def _of_harmonic(system: VibrationSystem, family: str, harmonic: int, shapes: bool) -> ModeGroup:
    network = harmonic_network(system, harmonic)
    modes = spring_modes(network)
    stage_shapes = None
    if shapes:
        amplitudes = dict(zip(network.coordinates, modes.shapes, strict=True))
        stage_shapes = harmonic_shapes(system, harmonic, amplitudes)
    multiplicity = system.roller_count - 3 if harmonic == 2 else harmonic + 1
    frequencies = modes.angular_frequencies / (2 * jnp.pi)
    share = of_elastic(meshed_share(network, modes.shapes), frequencies)
    return ModeGroup(frequencies, share, multiplicity, family, stage_shapes)


@physics("torsional_modes")
def torsional_modes(system: VibrationSystem, *, shapes: bool = False) -> ModeGroup:
    """Modes in which all rollers turn equally (harmonic 0), each simple."""
    if system.translation is not None:
        return _of_harmonic(system, "torsional", 0, shapes)
    block = torsional_springs(system)
    return _group(system, block, block_modes(block), "torsional", 0, shapes)


@physics("transverse_modes")
def transverse_modes(system: VibrationSystem, *, shapes: bool = False) -> ModeGroup:
    """Modes in which screw, ring gear and nut move sideways (harmonic ±1), each double."""
    if system.translation is not None:
        return _of_harmonic(system, "transverse", 1, shapes)
    block = transverse_springs(system)
    return _group(system, block, block_modes(block), "transverse", 1, shapes)


def _torsional_and_transverse_modes(
    system: VibrationSystem, *, shapes: bool = False
) -> tuple[ModeGroup, ModeGroup]:
    """Both families in one batch: one program instead of two equal ones."""
    if system.translation is not None:
        return torsional_modes(system, shapes=shapes), transverse_modes(system, shapes=shapes)
    blocks = torsional_springs(system), transverse_springs(system)
    values, small = _modes_of_both(*blocks)
    torsional, transverse = (
        _group(system, block, (values[i], small[i]), family, i, shapes)
        for i, (block, family) in enumerate(zip(blocks, ("torsional", "transverse"), strict=True))
    )
    return torsional, transverse


@physics("torsional_modes")
@physics("transverse_modes")
def _modes_of_both(*blocks: SpringBlock) -> tuple[Array, Array]:
    return jax.vmap(block_modes)(jax.tree.map(lambda *values: jnp.stack(values), *blocks))


@physics("roller_modes")
def roller_modes(system: VibrationSystem, *, shapes: bool = False) -> ModeGroup | None:
    """Modes in which only rollers move, each with multiplicity N − 3.

    If rollers only rotate there is one, ω² = (k_s + k_r + k_n) r_R²/J_R.
    """
    if system.roller_count == 3:
        return None
    if system.translation is not None:
        return _of_harmonic(system, "roller", 2, shapes)
    value = jnp.atleast_1d(roller_corner(system) / system.roller_equivalent_mass)
    stage_shapes = None
    if shapes:
        amplitude = jnp.atleast_1d(system.roller_equivalent_mass**-0.5)
        stage_shapes = harmonic_shapes(system, 2, {_ROLLER: amplitude})
    frequencies = frequency(value)
    share = jnp.ones_like(frequencies)
    return ModeGroup(frequencies, share, system.roller_count - 3, "roller", stage_shapes)


@physics("carrier_mode")
def carrier_mode(system: VibrationSystem, *, shapes: bool = False) -> ModeGroup | None:
    """The carrier on its support: ω² = K_cu / (J_c/r_c² + N m_R).

    `None` without a carrier, and where rollers move in translation: it then moves with them.
    """
    if system.carrier is None or system.translation is not None:
        return None
    value = system.carrier.torsional_support / system.carrier.equivalent_mass
    frequencies = frequency(jnp.atleast_1d(value))
    stage_shapes = carrier_shape(system) if shapes else None
    return ModeGroup(frequencies, jnp.zeros_like(frequencies), 1, "carrier", stage_shapes)


def symmetric_modes(system: VibrationSystem, *, shapes: bool = False) -> Modes:
    """All natural frequencies of a stage with equal, evenly spaced rollers.

    The discrete Fourier transform over the rollers splits the N + 10 degrees of freedom exactly
    into one small matrix for harmonic 0 (torsional), one for harmonics ±1 (transverse, double),
    one for all higher harmonics (roller, N − 3 times) and the carrier, so the cost does not depend
    on N and repeated roots never occur in one matrix.

    **Arguments:**

    - `system`: masses and springs from `vibration_system`.
    - `shapes`: also give the mode shapes.

    **Raises:** `ValueError` if the system is not symmetric by its structure.
    """
    if not system.symmetric:
        raise ValueError(
            "the system is not symmetric (unequal or fewer than 3 rollers, or supports that differ "
            "in x and y); use dense_modes"
        )
    groups = (
        carrier_mode(system, shapes=shapes),
        *_torsional_and_transverse_modes(system, shapes=shapes),
        roller_modes(system, shapes=shapes),
    )
    present = tuple(group for group in groups if group is not None)
    if not shapes:
        return Modes(present)
    return Modes(present, system=system, network=spring_network(system))


__all__ = [
    "carrier_mode",
    "meshed_share",
    "roller_modes",
    "symmetric_modes",
    "torsional_modes",
    "transverse_modes",
]
