"""Additions to the step-size control of diffrax: error weights, rounded lengths, reversals.

Friction in a thread turns from along the carrier's motion to across it within a range of carrier
ratios, `q/|d|`, that falls with the lead: 0.04 at an ordinary lead, 1e-5 at a lead of a micrometre.
There an error of 1e-8 in the ratio is an error of 1e-3 in the friction, and derivatives, which are
much larger before the turn than after it, lose more. So errors count relative to that range.

Reverse mode repeats steps, in a program that is compiled differently. If lengths follow from errors
to the last digit, these steps differ by rounding, which stiff states amplify, and the same number
of steps ends at a different time; derivatives were then wrong by any factor. Lengths with seven
binary digits are the same in both.

Where the screw reverses, Coulomb friction jumps. Steps that end before the reversal need not be
rejected, and ends of steps next to it move with it in derivatives.

Imports diffrax, so it is itself imported only where something is integrated.
"""

import functools
from collections.abc import Callable
from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PyTree

from ...fields import Scalar
from ...numerics import root_or_zero

#: Longest step as a share of the time to a standstill, and of the time since one.
_OF_THE_REST, _OF_THE_PAST = 0.32, 1.2
#: Shortest step, in roundings of the time.
_ROUNDINGS = 16.0
#: Time before the end of the integration in which steps are accepted, in roundings of the time:
#: diffrax repeats a rejected step for ever where less than 182 are left.
_LAST_ROUNDINGS = 256.0
#: Share of the largest speed below which ends of steps move with a reversal.
_NEXT_TO_IT = 1e-2

Weight = Callable[[Scalar, Float[Array, " states"]], Float[Array, " states"]]


def _controller(wrapper: "_Around") -> Any:
    return wrapper.controller


class _Around(diffrax.AbstractAdaptiveStepSizeController[Any, Any]):
    """Wraps a controller, which does everything that is not overridden."""

    controller: Any

    @property
    def rtol(self) -> Any:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Relative tolerance of the controller that is wrapped."""
        return self.controller.rtol

    @property
    def atol(self) -> Any:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Absolute tolerance of the controller that is wrapped."""
        return self.controller.atol

    @property
    def norm(self) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Norm of errors of the controller that is wrapped."""
        return self.controller.norm

    def wrap(self, direction):
        """As the controller that is wrapped."""
        return eqx.tree_at(_controller, self, self.controller.wrap(direction))

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped."""
        return self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)


def is_shortest(start: Any, end: Any) -> Bool[Array, ""]:
    """Whether a step is only a few roundings of the time long, so that it cannot be shortened."""
    return end - start <= _ROUNDINGS * jnp.finfo(jnp.result_type(end)).eps * jnp.abs(end)


def root_mean_square(tree: PyTree) -> Scalar:
    """Root mean square of a few states, as the norm of errors."""
    values = [x[k] for x in map(jnp.ravel, jax.tree.leaves(tree)) for k in range(x.size)]
    return root_or_zero(functools.reduce(jnp.add, [value**2 for value in values]) / len(values))


class UpToTheEnd(_Around):
    """Wraps a controller; next to the end of the integration, steps are accepted.

    A step that would end within a hundred roundings of the end is moved by diffrax: to the end or,
    after a rejected step, to the middle of what is left. If an error is too large there, which
    happens where the screw comes to a standstill, the same step is rejected again and again. What
    is left then, a few hundred roundings of the time, is too short for an error of the states.
    """

    #: End of the integration.
    last: Scalar

    def __init__(self, controller: Any, last: Scalar):
        self.controller, self.last = controller, jax.lax.stop_gradient(last)

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error: Any, error_order, controller_state
    ):
        """As the controller that is wrapped; next to the end errors count as 0, NaN as NaN."""
        rounding = jnp.finfo(self.last.dtype).eps * jnp.abs(self.last)
        share = jnp.where(self.last - t0 <= _LAST_ROUNDINGS * rounding, 0.0, 1.0)
        y_error = jax.tree.map(lambda error: share.astype(error.dtype) * error, y_error)
        return self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )


class Weighed(_Around):
    """Wraps a controller; errors are multiplied by a weight at the end of the step."""

    #: (time, state) to the weight of the error of each state.
    weight: Weight

    def __init__(self, controller: Any, weight: Weight):
        self.controller, self.weight = controller, weight

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error: Any, error_order, controller_state
    ):
        """As the controller that is wrapped."""
        weight = jax.lax.stop_gradient(self.weight(jnp.asarray(t1), y1_candidate))
        weight = jnp.where(is_shortest(t0, t1), 1.0, weight)
        return self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error * weight, error_order, controller_state
        )


class AroundStandstill(_Around):
    """Wraps a controller; steps are short next to a standstill of the screw.

    Coulomb friction jumps there, so a step across the standstill is rejected until it is very
    short; without a limit every step on the way there is first tried across it.

    The carriers' time constants are proportional to the speed. A step by RODASP uses those at its
    start. It multiplies a deviation of stiff carriers by 6 if the time constants halve within the
    step, and by 20 if they become ten times as long. The error estimate controls values, not
    derivatives, which grew by up to 1e37 over the steps of one reversal. With the two shares here a
    step multiplies a deviation of stiff carriers by 0.54 before a standstill and by 0.69 after it.
    """

    #: Function of time to the times until the next standstill and since the last one.
    standstills: Callable[[Scalar], tuple[Scalar, Scalar]]

    def __init__(self, controller: Any, standstills: Callable[[Scalar], tuple[Scalar, Scalar]]):
        self.controller, self.standstills = controller, standstills

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped, except for the length."""
        keep, start, end, jump, state, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )
        until, since = jax.lax.stop_gradient(self.standstills(start))
        longest = jnp.minimum(_OF_THE_REST * until, _OF_THE_PAST * since)
        return keep, start, jnp.minimum(end, start + longest), jump, state, result


class Moving(_Around):
    """Wraps a controller; in derivatives, ends of steps move with the reversal next to them.

    Friction jumps at the reversal. Steps with fixed ends keep the jump at a fixed time in every
    derivative; derivatives by a number that moves the reversal then lack a part.

    Steps after a reversal move with it, because the derivative of a step's error by its length is
    large. The variational equation has no such error, and then these steps stay: a part that moves
    with the step has the error of the rate between two samples.
    """

    #: Function of time to the same time, with the derivatives of the reversal next to it.
    moved: Callable[[Scalar], Scalar]
    #: Whether steps that are not next to a reversal stay.
    only_next: bool = eqx.field(static=True)

    def __init__(self, controller: Any, moved: Callable[[Scalar], Scalar], only_next: bool = False):
        self.controller, self.moved, self.only_next = controller, moved, only_next

    def _end(self, end: Any) -> Scalar:
        return self.moved(jax.lax.stop_gradient(end) if self.only_next else end)

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped, except for derivatives."""
        end, state = self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)
        return self._end(end), state

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped, except for derivatives."""
        keep, start, end, jump, state, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )
        # The step starts where the last one ended, and that end has moved already.
        return keep, start, self._end(end), jump, state, result


class WithReversals(eqx.Module):
    """Function of time to the same time, which in derivatives moves with the nearby reversal.

    With the speed v(t, p) of the leader, the reversal v(τ, p) = 0 moves by dτ = −dv/(∂v/∂t).
    """

    #: (scaled time, args) to speed and acceleration, in units of their scales.
    motion: Callable[[Scalar, Any], tuple[Scalar, Scalar]]
    args: Any

    def __call__(self, time: Scalar) -> Scalar:
        """The same time."""
        return _with_reversals(time, self.motion, self.args)


@eqx.filter_custom_jvp
def _with_reversals(time, motion, args):
    del motion, args
    return time


@_with_reversals.def_jvp
def _with_reversals_jvp(primals, tangents):
    time, motion, args = primals
    # Steps that were not taken start and end at infinity.
    at = jnp.where(jnp.isfinite(time), time, 0.0)
    speed, acceleration = motion(at, args)

    def speed_of(motion, args):
        return motion(at, args)[0]

    _, change = eqx.filter_jvp(speed_of, (motion, args), tuple(tangents[1:]))
    own = jnp.zeros_like(time) if tangents[0] is None else tangents[0]
    if change is None:
        # No differentiated number moves the reversal.
        return time, own
    near = (jnp.abs(speed) < _NEXT_TO_IT) & (acceleration != 0) & jnp.isfinite(time)
    shift = -change / jnp.where(near, acceleration, 1.0)
    return time, jnp.where(near, shift, own)


class Rounded(_Around):
    """Wraps a controller; lengths of steps are rounded to seven binary digits."""

    def __init__(self, controller: Any):
        self.controller = controller

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped, except for the length."""
        end, state = self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)
        return t0 + _rounded(end - t0), state

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped, except for the length."""
        keep, start, end, jump, state, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )
        return keep, start, start + _rounded(end - start), jump, state, result


def _rounded(length: Scalar) -> Scalar:
    length = jax.lax.stop_gradient(length)
    # Slightly more, because ten times a rounded length may lie just between two rounded lengths.
    return jax.lax.reduce_precision(length * 1.001, jnp.finfo(length.dtype).nexp, 6)


__all__ = [
    "AroundStandstill",
    "Moving",
    "Rounded",
    "UpToTheEnd",
    "Weighed",
    "Weight",
    "WithReversals",
    "is_shortest",
    "root_mean_square",
]
