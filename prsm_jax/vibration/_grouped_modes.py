"""Natural frequencies in groups by symmetry: what all results of modal analyses share."""

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..programs import listed, mapped, one_program
from ..results import DesignResult
from ..text import Line
from ._spring_modes import RIGID_SHARE, clusters
from .model import Coordinate, SpringNetwork, kinetic_energies, shares, strain_energies

#: Frequencies of a group that are printed one by one.
_LISTED = 20
#: Family of a group whose modes are not separated by symmetry.
COUPLED = "coupled"


class ModeGroup(eqx.Module):
    """The modes of one family: distinct frequencies, how often each occurs, and its energy."""

    #: Distinct natural frequencies, ascending [Hz].
    frequencies: Float[Array, " modes"]
    #: Share of each mode's strain energy that is in the thread and gear contacts.
    mesh_energy_share: Float[Array, " modes"]
    multiplicity: int = eqx.field(static=True)
    family: str = eqx.field(static=True)
    #: Mass-normalised shapes [1/√kg], if requested.
    shapes: Float[Array, "coordinates modes multiplicity"] | None = None


def _repeated(groups: tuple[ModeGroup, ...]) -> Float[Array, " degrees"]:
    return jnp.concatenate([jnp.repeat(g.frequencies, g.multiplicity) for g in groups])


@one_program
def _ascending(groups: tuple[ModeGroup, ...]) -> Float[Array, " degrees"]:
    ascending = jnp.sort(_repeated(groups))
    return jnp.where(jnp.isnan(ascending[-1]), jnp.nan, ascending)


class GroupedModes(DesignResult):
    """Natural frequencies in groups, and on request the mode shapes.

    `frequencies` lists all degrees of freedom in ascending order, repeated roots repeated;
    `families`, `multiplicities` and the columns of `shapes` go with it. The order, and with it
    `families`, depends on values and is therefore only available outside of a trace; inside one
    use `groups`.
    """

    groups: eqx.AbstractVar[tuple[ModeGroup, ...]]
    #: The whole network of springs, if shapes were requested.
    network: eqx.AbstractVar[SpringNetwork | None]

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of a batch of modes; empty for a single design."""
        return self.groups[0].frequencies.shape[:-1]

    def lines(self) -> list[Line]:
        """What `print` shows: the distinct frequencies of each group; rigid motions have 0."""
        every = np.concatenate([np.ravel(group.frequencies) for group in self.groups])
        # NaN, of a design that cannot be computed, is no rigid motion.
        highest = np.fmax.reduce(every, initial=0.0)
        lines: list[Line] = []
        rigid = 0
        for group in self.groups:
            numbers = np.asarray(group.frequencies)
            label = group.family.replace("_", " ")
            if not self.batch_shape:
                moves = ~(numbers <= RIGID_SHARE * highest)
                rigid += group.multiplicity * int(np.sum(~moves))
                numbers = numbers[moves]
            if group.multiplicity > 1:
                label += f" (×{group.multiplicity})"
            lines.append(Line(label, numbers, "Hz", most=_LISTED))
        return [*lines, Line("rigid motions", rigid)] if rigid else lines

    def _repeated(self) -> Float[Array, " degrees"]:
        return _repeated(self.groups)

    @property
    @mapped
    def frequencies(self) -> Float[Array, "*batch degrees"]:
        """All natural frequencies, ascending, repeated roots repeated [Hz].

        If one of them is NaN, all are, because its place in the order is unknown.
        """
        return _ascending(self.groups)

    def _with_shapes(self) -> SpringNetwork:
        if self.network is None:
            raise ValueError("the mode shapes were not requested; ask for them with shapes=True")
        return self.network

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The degrees of freedom: the rows of `shapes`.

        **Raises:** `ValueError` if shapes were not requested.
        """
        return self._with_shapes().coordinates

    @property
    @mapped
    def shapes(self) -> Float[Array, "*batch coordinates degrees"]:
        """Mass-normalised mode shapes, one column for each entry of `frequencies` [1/√kg].

        Rotations are displacements u = r θ on the nominal circle. The shapes of a repeated root
        are one orthonormal choice among many, and a shape's sign is arbitrary.

        **Raises:** `ValueError` if shapes were not requested.
        """
        size = len(self.coordinates)
        columns = []
        for group in self.groups:
            assert group.shapes is not None
            columns.append(group.shapes.reshape(size, -1))
        order = jnp.argsort(self._repeated(), stable=True)
        return jnp.concatenate(columns, axis=1)[:, order]

    def _averaged(self, energies: Callable[[Array], dict[str, Array]]) -> dict[str, Array]:
        """Energy shares of every mode, summed over the members of a repeated root."""
        energy_shares: list[dict[str, Array]] = []
        for group in self.groups:
            assert group.shapes is not None
            size, modes, multiplicity = group.shapes.shape
            each = energies(group.shapes.reshape(size, -1))
            if group.family == COUPLED:
                members = clusters(group.frequencies**2).astype(group.frequencies.dtype)
                sums = {name: members @ row for name, row in each.items()}
            else:
                sums = {
                    name: jnp.sum(row.reshape(modes, multiplicity), axis=1)
                    for name, row in each.items()
                }
            energy_shares.append({k: jnp.repeat(v, multiplicity) for k, v in shares(sums).items()})
        order = jnp.argsort(self._repeated(), stable=True)
        return {
            name: jnp.concatenate([row[name] for row in energy_shares])[order]
            for name in energy_shares[0]
        }

    @mapped
    def kinetic_energy_shares(self, *, each_roller: bool = False) -> dict[str, Array]:
        """Share of the kinetic energy in each body, for each entry of `frequencies`.

        Summed over all members of a repeated root, so it does not depend on their choice and is
        differentiable.

        **Raises:** `ValueError` if shapes were not requested.
        """
        network = self._with_shapes()
        return self._averaged(
            lambda shapes: kinetic_energies(network, shapes, each_roller=each_roller)
        )

    @mapped
    def strain_energy_shares(self, *, each_spring: bool = False) -> dict[str, Array]:
        """Share of the strain energy in each kind of spring, for each entry of `frequencies`.

        These shares distinguish modes of the supports from modes of the contacts; they are 0 for a
        rigid motion. Summed over all members of a repeated root.

        **Raises:** `ValueError` if shapes were not requested.
        """
        network = self._with_shapes()
        energy_shares = self._averaged(
            lambda shapes: strain_energies(network, shapes, each_spring=each_spring)
        )
        # The strain energy of a rigid motion is only rounding.
        rigid = self.frequencies <= RIGID_SHARE * self.frequencies[-1]
        return {name: jnp.where(rigid, 0.0, row) for name, row in energy_shares.items()}

    def _labels(self) -> list[tuple[float, str, int]]:
        rows = []
        largest = max((float(g.frequencies.max()) for g in self.groups), default=0.0)
        for group in self.groups:
            names = self._family_names(group)
            for value, name in zip(group.frequencies.tolist(), names, strict=True):
                family = "rigid" if value <= RIGID_SHARE * largest else name
                rows += [(value, family, group.multiplicity)] * group.multiplicity
        return sorted(rows, key=lambda row: row[0])

    def _family_names(self, group: ModeGroup) -> list[str]:
        """The family of each mode of a group."""
        return [group.family] * len(group.frequencies)

    @property
    @listed
    def families(self) -> tuple[str, ...]:
        """Family of each entry of `frequencies`; `rigid` for a motion without strain."""
        return tuple(family for _, family, _ in self._labels())

    @property
    @listed
    def multiplicities(self) -> tuple[int, ...]:
        """Multiplicity by symmetry of each entry of `frequencies`; 1 without symmetry."""
        return tuple(multiplicity for _, _, multiplicity in self._labels())

    @property
    @listed
    def distinct(self) -> tuple[int, ...]:
        """First index in `frequencies` of each distinct root."""
        places, at, times = [], 0, self.multiplicities
        while at < len(times):
            places.append(at)
            at += times[at]
        return tuple(places)

    def group(self, family: str) -> ModeGroup | None:
        """The modes of one family by symmetry, or `None` if this stage has none."""
        return next((g for g in self.groups if g.family == family), None)


def of_elastic(
    share: Float[Array, " modes"], frequencies: Float[Array, " modes"]
) -> Float[Array, " modes"]:
    """Shares of strain energy; 0 for a rigid motion, whose strain energy is only rounding."""
    rigid = frequencies <= RIGID_SHARE * jnp.max(frequencies)
    return jnp.where(rigid, 0.0, share)


def frequency(eigenvalue: Float[Array, "*modes"]) -> Float[Array, "*modes"]:
    """√λ/2π [Hz]; value and derivative are 0 for a rigid motion."""
    free = eigenvalue <= 0
    # Not `eigenvalue > 0`, so that NaN stays NaN.
    return jnp.where(free, 0.0, jnp.sqrt(jnp.where(free, 1.0, eigenvalue))) / (2 * jnp.pi)
