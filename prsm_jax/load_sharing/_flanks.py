"""Flanks between rollers and screw, or rollers and nut: gaps, compliances, forces."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ._flank_law import flank_energy, flank_force


class Teeth(NamedTuple):
    """Forces of the teeth on one side, a row per class; the last two only with both flanks."""

    #: Net axial force, and its slope over the approach [N, N/m].
    force: Float[Array, "classes threads"]
    slope: Float[Array, "classes threads"]
    #: Force on both flanks together, and the difference of their slopes [N, N/m].
    force_sum: Float[Array, "classes threads"] | None = None
    slope_difference: Float[Array, "classes threads"] | None = None


#: Force and slope of one kind of flanks; forces on forward and reverse flanks of one side.
Law: TypeAlias = tuple[Array, Array]
Loads: TypeAlias = tuple[Array, Array | None]
#: Gap that radial shifts have opened on one side [m]; 0 without them.
Opening: TypeAlias = Float[Array, "classes #threads"] | float


class FlankApproach(NamedTuple):
    """Flanks at an approach, with their compliances."""

    approach: Float[Array, "classes threads"]
    hertz: Float[Array, "classes #threads"] | None
    tooth: Float[Array, "classes #threads"] | None


def evaluate_alike(law: Callable[..., Any], flanks: list[FlankApproach]) -> list[Any]:
    """A law of several flanks, compiled once where they have the same compliances."""
    kinds = {(one.hertz is None, one.tooth is None) for one in flanks}
    if len(kinds) > 1:
        return [law(*one) for one in flanks]
    shape = flanks[0].approach.shape

    def stacked(values):
        if values[0] is None:
            return None
        return jnp.stack([jnp.broadcast_to(value, shape) for value in values])

    values_of_all = law(*map(stacked, zip(*flanks, strict=True)))
    return [jax.tree.map(lambda x, k=k: x[k], values_of_all) for k in range(len(flanks))]


def shift_opening(radial_shift: Float[Array, " classes"] | None) -> Opening:
    return 0.0 if radial_shift is None else radial_shift[:, None]


def by_flank(forces: list[Array]) -> Loads:
    return forces[0], forces[1] if len(forces) > 1 else None


class Flanks(eqx.Module):
    """The flanks between rollers and screw, or rollers and nut."""

    #: Gap of the flanks that a positive load presses [m].
    gap: Float[Array, "classes threads"]
    #: Gap of the opposite flanks [m]; `None` where they are not modelled.
    reverse_gap: Float[Array, "classes threads"] | None
    #: b of δ = b f^{2/3} + c f [m/N^{2/3}]; `None` without Hertz compliance.
    hertz: Float[Array, "classes #threads"] | None
    #: c [m/N]; `None` for rigid teeth.
    tooth: Float[Array, "classes #threads"] | None

    @property
    def centre(self) -> Float[Array, "classes threads"]:
        """Approach at which a tooth stands midway between its flanks (or just touches) [m]."""
        if self.reverse_gap is None:
            return self.gap
        return (self.gap - self.reverse_gap) / 2

    def approaches(
        self, approach: Float[Array, "classes threads"], opening: Opening
    ) -> list[FlankApproach]:
        """The flanks that are modelled: forward, then reverse.

        **Arguments:**

        - `approach`: of the two teeth [m].
        - `opening`: gap that the roller's radial shift has opened on this side [m].
        """
        each = [approach - self.gap - opening]
        if self.reverse_gap is not None:
            each.append(-approach - self.reverse_gap - opening)
        return [FlankApproach(one, self.hertz, self.tooth) for one in each]

    def loads(self, approach: Float[Array, "classes threads"], opening: Opening) -> Loads:
        """Force on forward and reverse flanks, with derivatives to everything [N].

        **Arguments:** those of `approaches`.
        """
        return by_flank([flank_force(*one) for one in self.approaches(approach, opening)])

    def teeth(
        self, approach: Float[Array, "classes threads"], regularisation: Scalar, laws: list[Law]
    ) -> Teeth:
        """Forces and slopes, for the search, from those of the flanks in `approaches`."""
        spring = regularisation * (approach - self.centre)
        force, slope = laws[0]
        if len(laws) == 1:
            return Teeth(force + spring, slope + regularisation)
        back, back_slope = laws[1]
        return Teeth(
            force - back + spring,
            slope + back_slope + regularisation,
            force + back,
            slope - back_slope,
        )

    def force(
        self, approach: Float[Array, "classes threads"], regularisation: Scalar, loads: Loads
    ) -> Teeth:
        """Forces with derivatives to everything, from those of `flank_loads`; without slopes."""
        forward, reverse = loads
        spring = regularisation * (approach - self.centre)
        if reverse is None:
            return Teeth(forward + spring, forward)
        return Teeth(forward - reverse + spring, forward, forward + reverse)

    def energy(
        self, approach: Float[Array, "classes threads"], opening: Opening
    ) -> Float[Array, "classes threads"]:
        """Energy stored in the flanks and teeth [J]."""
        energies = [flank_energy(*one) for one in self.approaches(approach, opening)]
        return sum(energies[1:], energies[0])
