"""Repeated steps of an integration, which reverse mode needs where steps are sensitive.

Reverse mode with checkpoints recomputes the states between them, in a program that is compiled
differently. Stiff right-hand sides, as near standstill, amplify the differences by rounding: error
estimates differ, with them the lengths of steps, and after the same number of steps the integration
ends at a different time; derivatives were up to 1 % off. So an integration that is not
differentiated chooses the steps, and one that is differentiated repeats exactly these.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import equinox as eqx
import equinox.internal as eqxi
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ...fields import Scalar

#: Largest distance behind a break at which a step past it begins, in roundings.
_NEXT = 4


class Steps(eqx.Module):
    """Accepted steps; infinity after the last one."""

    start: Float[Array, " most"]
    end: Float[Array, " most"]
    count: Int[Array, ""]


def steps_between(
    starts: Float[Array, " most"], count: Int[Array, ""], breaks: Float[Array, " breaks"]
) -> Steps:
    """Steps from the times at which the next ones start.

    A record in the state of the controller is rewritten at every step of a batch; results that
    diffrax saves at steps are not.

    **Arguments:**

    - `starts`: the start of each step but the first, which is 0, and the end of the last.
    - `count`: number of steps.
    - `breaks`: in order. A step that ends at one ends before it, and the next begins behind it.
    """
    ends = starts
    if breaks.size:
        before = jnp.searchsorted(breaks, starts, side="right") - 1
        last = breaks[jnp.maximum(before, 0)]
        near = (before >= 0) & (starts - last <= _NEXT * jnp.finfo(starts.dtype).eps * last)
        ends = jnp.where(near, eqxi.prevbefore(last), starts)
    taken = jnp.arange(starts.size) < count
    first = jnp.concatenate([jnp.zeros_like(starts[:1]), starts[:-1]])
    unused = jnp.inf
    return Steps(jnp.where(taken, first, unused), jnp.where(taken, ends, unused), count)


class Recording(diffrax.AbstractStepSizeController[Any, Any]):
    """Wraps a controller; a record of the accepted steps is the last entry of its state."""

    controller: Any
    #: Largest number of steps in the record.
    most: int = eqx.field(static=True)

    def wrap(self, direction):
        """As the controller that is wrapped."""
        return Recording(self.controller.wrap(direction), self.most)

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped."""
        end, inner = self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)
        empty = jnp.full(self.most, jnp.inf, jnp.result_type(t0))
        return end, (inner, Steps(empty, empty, jnp.zeros((), int)))

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped."""
        inner, steps = controller_state
        keep, start, end, jump, inner, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, inner
        )
        at = jnp.where(keep, steps.count, self.most)
        steps = Steps(
            steps.start.at[at].set(t0, mode="drop"),
            steps.end.at[at].set(t1, mode="drop"),
            steps.count + jnp.where(keep, 1, 0),
        )
        return keep, start, end, jump, (inner, steps), result


class Again(diffrax.AbstractStepSizeController[Any, Any]):
    """The steps of a record, all of them accepted; after the last one the integration ends."""

    steps: Steps
    #: Function of time to the same time, which in derivatives moves with a nearby reversal.
    moved: Callable[[Scalar], Scalar] | None = None

    def wrap(self, direction):
        """The only direction is that of the record."""
        del direction
        return self

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """The end of the first step; the number of steps taken, and the shift of the start."""
        del terms, t1, y0, dt0, args, func, error_order
        taken, shift = jnp.zeros((), int), jnp.asarray(t0 - jax.lax.stop_gradient(t0))
        return self._end(taken, shift), (taken, shift)

    def _recorded(self, times: Float[Array, " most"], number: Int[Array, ""]) -> Scalar:
        return jnp.where(number < times.size, times[number], jnp.inf)

    def _end(self, number: Int[Array, ""], shift: Scalar) -> Scalar:
        """End of a step, whose length does not change with the start of the phase.

        Only steps that end at a jump, or at the end of the integration, keep their end: the
        derivative of a step's error by its length is large where steps are short.
        """
        end = self._recorded(self.steps.end, number)
        following = self._recorded(self.steps.start, number + 1)
        moved = end + shift if self.moved is None else self.moved(end + shift)
        return jnp.where((number + 1 < self.steps.count) & (following != end), end, moved)

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """The next step; where a step ends before the start of the next one there is a jump."""
        del t0, y0, y1_candidate, args, y_error, error_order
        taken, shift = controller_state
        start = self._recorded(self.steps.start, taken + 1)
        jumps = start != self._recorded(self.steps.end, taken)
        # Starts where the last step ended, also in derivatives; after a jump the start is fixed.
        start, shift = jnp.where(jumps, start, t1), jnp.where(jumps, 0.0, shift)
        end, state = self._end(taken + 1, shift), (taken + 1, shift)
        return jnp.asarray(True), start, end, jumps, state, diffrax.RESULTS.successful


__all__ = ["Again", "Recording", "Steps"]
