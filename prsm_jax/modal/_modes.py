"""Natural frequencies and families of one stage, by cyclic symmetry."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._physics import physics
from ._assembly import roller_corner, torsional_springs, transverse_springs
from ._block import SpringBlock, block_modes, mesh_energy_share
from ._system import VibrationSystem

#: A frequency below this share of the largest one is a rigid-body motion: rounding leaves it at
#: about 1e-16, and no spring is that soft.
_RIGID_SHARE = 1e-13


class ModeGroup(eqx.Module):
    """The modes of one family: distinct frequencies, how often each occurs, and its energy."""

    #: Distinct natural frequencies, ascending [Hz].
    frequencies: Float[Array, " modes"]
    #: Share of each mode's strain energy that is in the thread and gear contacts.
    mesh_energy_share: Float[Array, " modes"]
    multiplicity: int = eqx.field(static=True)
    family: str = eqx.field(static=True)


class Modes(eqx.Module):
    """Natural frequencies of one stage.

    `frequencies` lists all degrees of freedom in ascending order, repeated roots repeated;
    `families` and `multiplicities` go with it. The order, and with it `families`, depends on
    values and is therefore only available outside of a trace; inside one use `groups`.
    """

    groups: tuple[ModeGroup, ...]

    @property
    def frequencies(self) -> Float[Array, " degrees"]:
        """All natural frequencies, ascending, repeated roots repeated [Hz]."""
        return jnp.sort(
            jnp.concatenate([jnp.repeat(g.frequencies, g.multiplicity) for g in self.groups])
        )

    def _labels(self) -> list[tuple[float, str, int]]:
        rows = []
        largest = max((float(g.frequencies.max()) for g in self.groups), default=0.0)
        for group in self.groups:
            for value in group.frequencies.tolist():
                rigid = value <= _RIGID_SHARE * largest
                family = "rigid" if rigid else group.family
                rows += [(value, family, group.multiplicity)] * group.multiplicity
        return sorted(rows, key=lambda row: row[0])

    @property
    def families(self) -> tuple[str, ...]:
        """Family of each entry of `frequencies`: rigid, carrier, torsional, transverse, roller."""
        return tuple(family for _, family, _ in self._labels())

    @property
    def multiplicities(self) -> tuple[int, ...]:
        """Multiplicity by symmetry of each entry of `frequencies`."""
        return tuple(multiplicity for _, _, multiplicity in self._labels())

    def group(self, family: str) -> ModeGroup | None:
        """The modes of one family by symmetry, or `None` if this stage has none."""
        return next((g for g in self.groups if g.family == family), None)


def _frequency(eigenvalue: Float[Array, " modes"]) -> Float[Array, " modes"]:
    """√λ/2π; value and derivative 0 where nothing holds the body."""
    elastic = eigenvalue > 0
    root = jnp.sqrt(jnp.where(elastic, eigenvalue, 1.0))
    return jnp.where(elastic, root, 0.0) / (2 * jnp.pi)


def _group(block: SpringBlock, multiplicity: int, family: str) -> ModeGroup:
    values, shapes = block_modes(block)
    return ModeGroup(_frequency(values), mesh_energy_share(block, shapes), multiplicity, family)


@physics("torsional_modes")
def torsional_modes(system: VibrationSystem) -> ModeGroup:
    """Modes in which all rollers turn alike (harmonic 0), each simple."""
    return _group(torsional_springs(system), 1, "torsional")


@physics("transverse_modes")
def transverse_modes(system: VibrationSystem) -> ModeGroup:
    """Modes in which screw, ring gear and nut move sideways (harmonic ±1), each double."""
    return _group(transverse_springs(system), 2, "transverse")


@physics("roller_modes")
def roller_modes(system: VibrationSystem) -> ModeGroup | None:
    """Modes in which only rollers turn: ω² = (k_s + k_r + k_n) r_R²/J_R, N − 3 times."""
    if system.roller_count == 3:
        return None
    value = roller_corner(system) / system.roller_equivalent_mass
    frequencies = _frequency(jnp.atleast_1d(value))
    return ModeGroup(frequencies, jnp.ones_like(frequencies), system.roller_count - 3, "roller")


@physics("carrier_mode")
def carrier_mode(system: VibrationSystem) -> ModeGroup | None:
    """The carrier on its support: ω² = K_cu / (J_c/r_c² + N m_R)."""
    if system.carrier is None:
        return None
    value = system.carrier.torsional_support / system.carrier.equivalent_mass
    frequencies = _frequency(jnp.atleast_1d(value))
    return ModeGroup(frequencies, jnp.zeros_like(frequencies), 1, "carrier")


def symmetric_modes(system: VibrationSystem) -> Modes:
    """All natural frequencies of a stage with equal, evenly spaced rollers.

    The discrete Fourier transform over the rollers splits the N + 10 degrees of freedom exactly
    into one small matrix for harmonic 0 (torsional), one for harmonics ±1 (transverse, double),
    a closed form for all higher harmonics (roller, N − 3 times) and the carrier, so the cost does
    not depend on N and repeated roots never meet in one matrix.

    **Arguments:**

    - `system`: masses and springs from `vibration_system`.
    """
    groups = (
        carrier_mode(system),
        torsional_modes(system),
        transverse_modes(system),
        roller_modes(system),
    )
    return Modes(tuple(group for group in groups if group is not None))
