"""Loads between rollers and screw, or rollers and nut, with their pressures and stiffnesses."""

from typing import Annotated, Literal

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..fields import In, Scalar
from ..numerics import above_or_nan, cube_root_or_zero, root_or_zero
from ..programs import mapped
from ..results import DesignResult
from ._flanks import Flanks, Loads
from ._stage_chains import StageChains

#: Share of a typical force, in double and single precision, below which a force counts as 0: well
#: above the forces of the regularising springs.
_ZERO_FORCE = {True: 1e-9, False: 1e-3}


class SideLoads(DesignResult):
    """Loads between rollers and screw, or rollers and nut; a row for each class of rollers."""

    #: Axial load on the flanks that a positive load presses [N].
    forward: Annotated[Float[Array, "classes threads"], In("N")]
    #: Axial load on the opposite flanks [N]; `None` where they are not modelled.
    reverse: Annotated[Float[Array, "classes threads"] | None, In("N")]
    #: Largest Hertz pressure of each thread [Pa].
    max_pressure: Annotated[Float[Array, "classes threads"], In("Pa")]
    #: Axial secant stiffness of one roller of each class, its threads in parallel and its
    #: `stiffness_factor` included [N/m]; 0 for a roller without load.
    stiffness: Annotated[Float[Array, " classes"], In("N/m")]
    #: How many rollers each class stands for.
    weight: Float[Array, " classes"]
    #: A typical force on one thread [N], to tell a load from rounding; `None` if not known.
    typical_force: Scalar | None = None
    #: As `stiffness`, but tangent [N/m]; `None` if not known.
    tangent: Float[Array, " classes"] | None = None

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch that these loads are of; empty for a single design."""
        return self.weight.shape[:-1]

    @property
    @mapped
    def thread_load(self) -> Float[Array, "classes threads"]:
        """Axial load on each thread, on whichever flank [N]."""
        return self.forward if self.reverse is None else self.forward + self.reverse

    @property
    @mapped
    def roller_load(self) -> Float[Array, " classes"]:
        """Axial load that one roller of each class carries [N]."""
        net = self.forward if self.reverse is None else self.forward - self.reverse
        return jnp.sum(net, axis=1)

    @property
    @mapped
    def roller_stiffness(self) -> Scalar:
        """Axial secant stiffness of one roller of the first class [N/m].

        That of the nominal rollers, or of the first roller if all differ. Those of the other
        classes are in `stiffness`.
        """
        return self.stiffness[0]

    @property
    @mapped
    def roller_tangent_stiffness(self) -> Scalar:
        """As `roller_stiffness`, but tangent [N/m]."""
        assert self.tangent is not None
        return self.tangent[0]

    @property
    @mapped
    def thread_sharing_factor(self) -> Scalar:
        """Largest load of a thread over the mean of all; 1 without load."""
        return self._ratio(jnp.max(self.thread_load), self._mean_thread_load)

    @property
    @mapped
    def _mean_thread_load(self) -> Scalar:
        load = self.thread_load
        return jnp.sum(self.weight[:, None] * load) / (jnp.sum(self.weight) * load.shape[1])

    @property
    @mapped
    def loaded(self) -> Bool[Array, ""]:
        """Whether the threads carry more than rounding."""
        return above_or_nan(self._mean_thread_load, self._zero_force)

    @property
    def _zero_force(self) -> Scalar | float:
        """Limit below which a force is rounding or a force of the regularising springs [N]."""
        if self.typical_force is None:
            return 0.0
        return _ZERO_FORCE[self.weight.dtype == jnp.float64] * self.typical_force

    @property
    @mapped
    def roller_sharing_factor(self) -> Scalar:
        """Largest load of a roller over the mean of all; 1 without load."""
        load = self.roller_load
        mean = jnp.abs(jnp.sum(self.weight * load)) / jnp.sum(self.weight)
        return self._ratio(jnp.max(jnp.abs(load)), mean)

    @property
    @mapped
    def roller_load_unbalance(self) -> Scalar:
        """Standard deviation of the loads of all rollers over their mean; 0 without load."""
        load, count = self.roller_load, jnp.sum(self.weight)
        mean = jnp.sum(self.weight * load) / count
        loaded = above_or_nan(jnp.abs(mean), self._zero_force)
        relative = jnp.where(loaded, load / jnp.where(loaded, mean, 1.0), 1.0)
        return root_or_zero(jnp.sum(self.weight * (relative - 1) ** 2) / count)

    def _ratio(self, largest: Scalar, mean: Scalar) -> Scalar:
        loaded = above_or_nan(mean, self._zero_force)
        return jnp.where(loaded, largest / jnp.where(loaded, mean, 1.0), 1.0)


def _stiffness(force: Array, flanks: Flanks, hertz_share: float = 1.0) -> Array:
    """Secant stiffness f/δ of each thread; with 2/3 of Hertz its tangent; 0 without load."""
    root = cube_root_or_zero(force)
    assert flanks.hertz is not None
    soft = hertz_share * flanks.hertz
    return root / (soft if flanks.tooth is None else soft + flanks.tooth * root)


def side_loads(
    chains_of_stage: StageChains, side: Literal["screw", "nut"], loads: Loads
) -> SideLoads:
    """Loads, pressures and stiffnesses of one side, from the forces on its flanks."""
    flanks: Flanks = getattr(chains_of_stage.chains, side)
    forward, reverse = loads
    unit = getattr(chains_of_stage, f"{side}_unit_contact")
    normal = getattr(chains_of_stage, f"{side}_normal")
    stiffness, tangent = _stiffness(forward, flanks), _stiffness(forward, flanks, 2 / 3)
    largest = forward
    if reverse is not None:
        stiffness = stiffness + _stiffness(reverse, flanks)
        tangent = tangent + _stiffness(reverse, flanks, 2 / 3)
        largest = jnp.maximum(forward, reverse)
    return SideLoads(
        forward=forward,
        reverse=reverse,
        max_pressure=unit.max_pressure * cube_root_or_zero(largest * normal),
        stiffness=jnp.sum(stiffness, axis=1),
        tangent=jnp.sum(tangent, axis=1),
        weight=chains_of_stage.chains.weight,
        typical_force=chains_of_stage.chains.typical_force,
    )
