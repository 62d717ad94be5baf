"""States at sample times, which every step computes for all samples at once.

diffrax saves one sample after the other, in a loop within the step. In a batch this loop runs as
often as the design with the most samples in the step needs, and each time it writes one number of
each design to a different place, one design after the other. Here each step computes the states at
all samples and keeps those inside the step: 1000 designs that settle take 0.75 to 0.95 of the time
with 21 samples, and two thirds of it with 201.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from typing import Any, ClassVar

import diffrax
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, PyTree

from ._dense_output import OneStep, StepInterpolation

#: Largest number of samples, with few steps (a constant drive) and with many. The time of a step
#: grows with the number of samples, and a loop takes less time where most steps have no sample.
_MOST_WITH_FEW_STEPS, _MOST_WITH_MANY_STEPS = 256, 64


class Sampled(diffrax.AbstractAdaptiveSolver[Any]):
    """Wraps a solver without memory, and stores the states at the samples."""

    term_structure: ClassVar = diffrax.AbstractTerm

    solver: OneStep
    #: In order; the first is the start of the integration.
    times: Float[Array, " samples"]

    @property
    def interpolation_cls(self) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """That of the solver that is wrapped."""
        return self.solver.interpolation_cls

    def order(self, terms) -> int | None:
        """That of the solver that is wrapped."""
        return self.solver.order(terms)

    def func(self, terms, t0, y0, args) -> PyTree:
        """That of the solver that is wrapped."""
        return self.solver.func(terms, t0, y0, args)

    def init(self, terms, t0, t1, y0, args) -> Any:
        """The end of the last step, and the states at the samples: infinite after that time."""
        del terms, t1, args
        past = self.times <= t0
        return t0, [jnp.where(past, y, jnp.inf) for y in _numbers(y0)]

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        """A step of the solver that is wrapped, and the samples up to its end."""
        until, values = solver_state
        y1, error, dense, _, result = self.solver.step(terms, t0, t1, y0, args, None, made_jump)
        between: StepInterpolation = self.interpolation_cls(t0=t0, t1=t1, **dense)
        states = between.at_all(self.times)
        # A step after a break begins behind it, and a sample on the break belongs to that step.
        inside = (self.times > until) & (self.times <= t1)
        values = [
            jnp.where(inside, new, old)
            for new, old in zip(jax.tree.leaves(states), values, strict=True)
        ]
        return y1, error, dense, (t1, values), result


def _numbers(state: PyTree) -> list[Array]:
    return [number for leaf in jax.tree.leaves(state) for number in leaf.ravel()]


def sampled(solver: Any, times: Float[Array, " samples"], few_steps: bool) -> Sampled | None:
    """A solver that computes states at samples, or `None` where diffrax saves them faster.

    **Arguments:**

    - `solver`: any solver of diffrax.
    - `times`: samples, in order; the first is the start of the integration.
    - `few_steps`: whether there are few steps for each sample, as with a constant drive.
    """
    most = _MOST_WITH_FEW_STEPS if few_steps else _MOST_WITH_MANY_STEPS
    return Sampled(solver, times) if isinstance(solver, OneStep) and times.size <= most else None


#: What diffrax saves of an integration by `Sampled`.
LAST_STATE = diffrax.SaveAt(t1=True, solver_state=True)


def states_at_samples(solution: diffrax.Solution) -> PyTree:
    """States at the samples of an integration by `Sampled`, with samples along the first axis."""
    state: Any = solution.solver_state
    _, values = state
    end: Any = solution.ys
    states = jnp.stack(values, axis=-1)
    _, unflatten = ravel_pytree(jax.tree.map(lambda y: y[0], end))
    return jax.vmap(unflatten)(states)


__all__ = ["LAST_STATE", "Sampled", "sampled", "states_at_samples"]
