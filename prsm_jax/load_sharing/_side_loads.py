"""Loads between rollers and screw, or rollers and nut, and what they do to the contacts."""

from typing import Literal

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..mechanism import Scalar
from ..numerics import above_or_nan
from ..programs import AbstractResult, mapped
from ._chains import Flanks, Loads
from ._stage_chains import StageChains

#: Share of a typical force, in double and single precision, below which there is none: well above
#: the film's.
_NOTHING = {True: 1e-9, False: 1e-3}


class SideLoads(AbstractResult):
    """Loads between rollers and screw, or rollers and nut; a row for each class of rollers."""

    #: Axial load on the flanks that a positive load presses [N].
    forward: Float[Array, "classes threads"]
    #: Axial load on the opposite flanks [N]; `None` where they are not modelled.
    reverse: Float[Array, "classes threads"] | None
    #: Largest Hertz pressure of each thread [Pa].
    max_pressure: Float[Array, "classes threads"]
    #: Axial secant stiffness of one roller of each class, its threads in parallel and its
    #: `stiffness_factor` in it [N/m]; 0 for a roller that carries nothing.
    stiffness: Float[Array, " classes"]
    #: How many rollers each class stands for.
    weight: Float[Array, " classes"]
    #: A typical force on one thread [N], which tells a load from rounding; `None` if not known.
    force_unit: Scalar | None = None
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

        The nominal ones; where all are unlike, the first roller. Those of the others are in
        `stiffness`.
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
        """Whether the threads bear more than rounding."""
        return above_or_nan(self._mean_thread_load, self._nothing)

    @property
    def _nothing(self) -> Scalar | float:
        """Up to here a force is rounding, or that of the film which keeps loose teeth [N]."""
        if self.force_unit is None:
            return 0.0
        return _NOTHING[self.weight.dtype == jnp.float64] * self.force_unit

    @property
    @mapped
    def roller_sharing_factor(self) -> Scalar:
        """Largest load of a roller over the mean of all; 1 without load."""
        load = self.roller_load
        mean = jnp.abs(jnp.sum(self.weight * load)) / jnp.sum(self.weight)
        return self._ratio(jnp.max(jnp.abs(load)), mean)

    def _ratio(self, part: Scalar, whole: Scalar) -> Scalar:
        loaded = above_or_nan(whole, self._nothing)
        return jnp.where(loaded, part / jnp.where(loaded, whole, 1.0), 1.0)


def _positive_root(value: Array) -> Array:
    """Cube root of loads; 0, with derivative 0, where there is none."""
    loaded = above_or_nan(value)
    return jnp.where(loaded, jnp.cbrt(jnp.where(loaded, value, 1.0)), 0.0)


def _stiffness(force: Array, flanks: Flanks, hertz_share: float = 1.0) -> Array:
    """Secant stiffness f/δ of each thread; with 2/3 of Hertz its tangent; 0 without load."""
    root = _positive_root(force)
    assert flanks.hertz is not None
    soft = hertz_share * flanks.hertz
    return root / (soft if flanks.tooth is None else soft + flanks.tooth * root)


def side_loads(whole: StageChains, side: Literal["screw", "nut"], loads: Loads) -> SideLoads:
    """Loads, pressures and stiffnesses of one side, from the forces on its flanks."""
    flanks: Flanks = getattr(whole.chains, side)
    forward, reverse = loads
    unit, normal = getattr(whole, f"{side}_unit_contact"), getattr(whole, f"{side}_normal")
    stiffness, tangent = _stiffness(forward, flanks), _stiffness(forward, flanks, 2 / 3)
    largest = forward
    if reverse is not None:
        stiffness = stiffness + _stiffness(reverse, flanks)
        tangent = tangent + _stiffness(reverse, flanks, 2 / 3)
        largest = jnp.maximum(forward, reverse)
    return SideLoads(
        forward=forward,
        reverse=reverse,
        max_pressure=unit.max_pressure * _positive_root(largest * normal),
        stiffness=jnp.sum(stiffness, axis=1),
        tangent=jnp.sum(tangent, axis=1),
        weight=whole.chains.weight,
        force_unit=whole.chains.force_unit,
    )
