"""Steps that end at breaks, efficient for many breaks.

`diffrax.ClipStepSizeController` compares the start of every step with all breaks. Where the number
of steps grows with the number of breaks, as in repeated strokes, computing time grows with its
square. Here breaks are in order, and the state has the index of the next one.

Imports diffrax, so it is itself imported only where something is integrated.
"""

import dataclasses
from typing import Any

import diffrax
import equinox.internal as eqxi
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ...numerics import any_few


class ManyBreaks(diffrax.ClipStepSizeController[Any, Any]):
    """As the base class with `jump_ts` alone, but each step looks only at two adjacent breaks."""

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """The next step: starts past a break that was reached, ends at the next break at most."""
        keep, start, end, jumped, inner, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state.inner_state
        )
        jump_info: Any = controller_state.jump_info
        index, breaks = jump_info
        # The step began behind one break and could not pass the next.
        near = jnp.stack([_break(breaks, index - 1), _break(breaks, index)])
        after = eqxi.nextafter(start)
        before_one, at_one = any_few(jnp.equal(after, near)), any_few(jnp.equal(start, near))
        # Start past the break, from just before it or from on it, since its side is not known.
        start = jnp.where(before_one, eqxi.nextafter(after), start)
        start = jnp.where(at_one, after, start)
        end = jnp.maximum(eqxi.nextafter(start), end)
        index = _next_break(breaks, start, index)
        end = jnp.minimum(eqxi.prevbefore(_break(breaks, index)), end)
        state = dataclasses.replace(controller_state, jump_info=(index, breaks), inner_state=inner)
        return keep, start, end, jumped | before_one | at_one, state, result


def _break(breaks: Float[Array, " breaks"], index: Int[Array, ""]) -> Float[Array, ""]:
    """A break by its number; infinity beyond both ends."""
    inside = (index >= 0) & (index < breaks.size)
    return jnp.where(inside, breaks[jnp.clip(index, 0, breaks.size - 1)], jnp.inf)


def _next_break(breaks, time, index):
    """The first break after a time, searched upwards from a break close to it."""

    def on(i):
        return (i < breaks.size) & (_break(breaks, i) <= time)

    return jax.lax.while_loop(on, lambda i: i + 1, index)


__all__ = ["ManyBreaks"]
