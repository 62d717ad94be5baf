"""Steps of one integration taken again, which reverse mode needs where steps are sensitive.

Reverse mode with checkpoints computes states between them again, in a program that is compiled
differently. What differs by rounding is then amplified by stiff right-hand sides, as near
standstill: error estimates differ, with them the lengths of steps, and after the same number of
steps the integration ends elsewhere; derivatives were up to 1 % off. So the steps are chosen in an
integration that is not differentiated, and taken again as they are in one that is.

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

from ...mechanism import Scalar

#: A step past a break begins so many roundings behind it at most.
_NEXT = 4


class Steps(eqx.Module):
    """Accepted steps, infinity behind the last one."""

    start: Float[Array, " most"]
    end: Float[Array, " most"]
    count: Int[Array, ""]


def steps_between(
    starts: Float[Array, " most"], count: Int[Array, ""], breaks: Float[Array, " breaks"]
) -> Steps:
    """Steps by the times from which they went on.

    A record in the state of the controller is written anew by every step of a batch; what diffrax
    saves at steps is not.

    **Arguments:**

    - `starts`: the start of each step but the first, which is 0, and the end of the last.
    - `count`: how many there are.
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
    none = jnp.inf
    return Steps(jnp.where(taken, first, none), jnp.where(taken, ends, none), count)


class Recording(diffrax.AbstractStepSizeController):
    """Another controller, with a record of the steps that it accepted as the last of its state."""

    controller: Any
    #: Steps there is room for.
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


class Again(diffrax.AbstractStepSizeController):
    """The steps of a record, all of them accepted; behind the last one the integration ends."""

    steps: Steps
    #: Time to the same time, which moves with a reversal next to it in derivatives.
    moved: Callable[[Scalar], Scalar] | None = None

    def wrap(self, direction):
        """There is one direction, that of the record."""
        del direction
        return self

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """The end of the first step; the number of those taken, and how the start moves."""
        del terms, t1, y0, dt0, args, func, error_order
        taken, shift = jnp.zeros((), int), jnp.asarray(t0 - jax.lax.stop_gradient(t0))
        return self._end(taken, shift), (taken, shift)

    def _recorded(self, times: Float[Array, " most"], number: Int[Array, ""]) -> Scalar:
        return jnp.where(number < times.size, times[number], jnp.inf)

    def _end(self, number: Int[Array, ""], shift: Scalar) -> Scalar:
        """End of a step, whose length does not change with the start of the phase.

        Only those that end at a jump, or at the end of all, keep their end: the derivative of a
        step's error by its length is large where steps are short.
        """
        end = self._recorded(self.steps.end, number)
        following = self._recorded(self.steps.start, number + 1)
        moved = end + shift if self.moved is None else self.moved(end + shift)
        return jnp.where((number + 1 < self.steps.count) & (following != end), end, moved)

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """The next step; the end of a step that lies before the next start is a jump."""
        del t0, y0, y1_candidate, args, y_error, error_order
        taken, shift = controller_state
        start = self._recorded(self.steps.start, taken + 1)
        jumps = start != self._recorded(self.steps.end, taken)
        # Where the last one ended, also in derivatives; what follows a jump stays where it is.
        start, shift = jnp.where(jumps, start, t1), jnp.where(jumps, 0.0, shift)
        end, state = self._end(taken + 1, shift), (taken + 1, shift)
        return jnp.asarray(True), start, end, jumps, state, diffrax.RESULTS.successful


__all__ = ["Again", "Recording", "Steps"]
