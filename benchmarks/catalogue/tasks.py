"""What is searched: one task for each size and number of starts, and their common evaluation."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.mechanism import Mechanism

from .problem import (
    FEWEST_ROLLERS,
    LOWER,
    SIGNS,
    UPPER,
    Size,
    dimensioned,
    limits_of,
    measured,
    varied,
)

#: Gains of a design whose threads do not mesh.
FAILED = -10.0


@dataclasses.dataclass(frozen=True)
class Task:
    """One search: a size, one number of starts, and what is allowed."""

    size: Size
    starts: int
    mechanism: Mechanism
    lower: np.ndarray
    upper: np.ndarray
    limits: np.ndarray
    #: Contact angle and ratios of radii and lengths where the search begins; the size's own.
    begin: tuple[float, float, float] = (np.pi / 4, 1.0, 1.0)

    @property
    def first(self) -> np.ndarray:
        """Values of the variables where the search begins, with as many rollers as fit."""
        return np.array([*self.begin, self.upper[3]])

    def unit(self, variables: np.ndarray) -> np.ndarray:
        """Position in the unit box."""
        width = np.where(self.upper > self.lower, self.upper - self.lower, 1.0)
        return (variables - self.lower) / width

    def physical(self, position: np.ndarray) -> np.ndarray:
        """Values of the variables at a position in the unit box."""
        return self.lower + (self.upper - self.lower) * position

    def with_rollers(self, count: float, near: np.ndarray) -> "Task":
        """The same with a fixed number of rollers, begun at values of the variables."""
        lower, upper = (np.append(end[:3], count) for end in (self.lower, self.upper))
        angle, profile_ratio, length_ratio, _ = (float(one) for one in near)
        begin = (angle, profile_ratio, length_ratio)
        return dataclasses.replace(self, lower=lower, upper=upper, begin=begin)


def stacked(mechanisms: Sequence[Mechanism]) -> Mechanism:
    """Mechanisms of one structure as a batch, with their numbers of rollers as numbers."""
    counted = [
        eqx.tree_at(lambda m: m.stages[0].roller_count, one, float(one.stages[0].roller_count))
        for one in mechanisms
    ]
    return jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(leaf) for leaf in leaves]), *counted)


@eqx.filter_jit
def _values_and_slopes(mechanisms: Mechanism, lower: Any, width: Any, positions: Any):
    """Logarithms of measures, their derivatives by position, and which designs are usable."""

    def one(mechanism, lower, width, position):
        def logarithms(place):
            values, good = measured(varied(mechanism, lower + width * place))
            return jnp.log(values), good

        values, push, good = jax.linearize(logarithms, position, has_aux=True)
        slopes = jax.vmap(push, out_axes=-1)(jnp.eye(position.shape[0], dtype=position.dtype))
        return values, slopes, good & jnp.isfinite(values).all() & jnp.isfinite(slopes).all()

    return jax.vmap(one)(mechanisms, lower, width, positions)


@eqx.filter_jit
def measured_together(mechanisms: Mechanism, index: Any, variables: Any):
    """Measures of many designs, and which are usable.

    **Arguments:**

    - `mechanisms`: a batch of whole length.
    - `index`: which of them each design has.
    - `variables`: designs × `VARIABLES`.
    """

    def one(index, variables):
        mechanism = jax.tree.map(lambda leaf: leaf[index], mechanisms)
        return measured(varied(mechanism, variables))

    return jax.vmap(one)(index, variables)


def tasks_of(
    sizes: Sequence[Size], loss: float, flattest: float = UPPER[1]
) -> tuple[list[Task], np.ndarray]:
    """A search for each size and number of starts, and the measures of the sizes' own designs."""
    made = [(size, n, dimensioned(size, n)) for size in sizes for n in size.choices]
    own = {size.name: m for size, n, m in made if n == size.starts}
    counts = {name: float(m.stages[0].roller_count) for name, m in own.items()}
    variables = jnp.asarray([[np.pi / 4, 1.0, 1.0, counts[size.name]] for size in sizes])
    batch = stacked([own[size.name] for size in sizes])
    starts = np.asarray(measured_together(batch, jnp.arange(len(sizes)), variables)[0])
    limits = {
        size.name: limits_of(start, _load(own[size.name]), loss)
        for size, start in zip(sizes, starts, strict=True)
    }
    tasks = [
        Task(
            size,
            n,
            mechanism,
            np.array([*LOWER, FEWEST_ROLLERS]),
            np.array([UPPER[0], flattest, UPPER[2], float(mechanism.stages[0].roller_count)]),
            limits[size.name],
        )
        for size, n, mechanism in made
    ]
    return tasks, starts


def _load(mechanism: Mechanism) -> float:
    assert mechanism.operating_point is not None
    return float(mechanism.operating_point.load)


def evaluation_of(tasks: Sequence[Task]) -> Callable[[np.ndarray], tuple[np.ndarray, ...]]:
    """Gains over the limits, and their slopes by position, of one design for each task."""
    mechanisms = stacked([task.mechanism for task in tasks])
    lower = np.stack([task.lower for task in tasks])
    width = np.stack([task.upper for task in tasks]) - lower
    limits = np.log(np.stack([task.limits for task in tasks]))

    def answer(positions: np.ndarray) -> tuple[np.ndarray, ...]:
        values, slopes, good = map(
            np.asarray, _values_and_slopes(mechanisms, lower, width, jnp.asarray(positions))
        )
        bad = ~good
        gain = np.where(bad[:, None], FAILED, SIGNS * (values - limits))
        slope = np.where(bad[:, None, None], 0.0, SIGNS[:, None] * slopes)
        return gain, slope

    return answer
