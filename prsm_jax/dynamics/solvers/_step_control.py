"""What is added to diffrax's choice of steps: weights of errors, lengths of few digits, reversals.

Friction in a thread turns from along the carrier's motion to across it within a range of carrier
ratios, `q/|d|`, that falls with the lead: 0.04 at an ordinary one, 1e-5 at a lead of a micrometre.
An error of 1e-8 of the ratio is then one of 1e-3 of the friction, and derivatives, which are much
larger before the turn than behind it, lose more. There an error counts by its share of that range.

Reverse mode takes steps again, in a program that is compiled differently. Where lengths follow from
errors to the last digit, its steps differ by rounding, which stiff states amplify, and after the
same number of them it ends elsewhere; derivatives were then wrong by any factor. Lengths of seven
binary digits are the same in both.

Where the screw reverses, Coulomb friction jumps. Steps that end before it need not be rejected.

Imports diffrax, so it is itself imported only where something is integrated.
"""

import functools
from collections.abc import Callable
from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PyTree

from ...mechanism import Scalar
from ...numerics import root_or_zero

#: Share of the time to a standstill that a step may take.
_OF_THE_REST = 0.35

Weight = Callable[[Scalar, Float[Array, " states"]], Float[Array, " states"]]


def _controller(wrapper: "_Around") -> Any:
    return wrapper.controller


class _Around(diffrax.AbstractAdaptiveStepSizeController):
    """Another controller, which does what is not said to be otherwise."""

    controller: Any

    @property
    def rtol(self):
        """Relative tolerance of the controller that is wrapped."""
        return self.controller.rtol

    @property
    def atol(self):
        """Absolute tolerance of the controller that is wrapped."""
        return self.controller.atol

    @property
    def norm(self):
        """Norm of errors of the controller that is wrapped."""
        return self.controller.norm

    def wrap(self, direction):
        """As the controller that is wrapped."""
        return eqx.tree_at(_controller, self, self.controller.wrap(direction))

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped."""
        return self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)


def root_mean_square(tree: PyTree) -> Scalar:
    """The size by which errors of a few states are judged."""
    values = [x[k] for x in map(jnp.ravel, jax.tree.leaves(tree)) for k in range(x.size)]
    return root_or_zero(functools.reduce(jnp.add, [value**2 for value in values]) / len(values))


class Weighed(_Around):
    """Another controller, told errors that are multiplied by a weight at the end of the step."""

    #: (time, state) to the weight of the error of each state.
    weight: Weight

    def __init__(self, controller: Any, weight: Weight):
        self.controller, self.weight = controller, weight

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error: Any, error_order, controller_state
    ):
        """As the controller that is wrapped."""
        weight = jax.lax.stop_gradient(self.weight(jnp.asarray(t1), y1_candidate))
        return self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error * weight, error_order, controller_state
        )


class Approaching(_Around):
    """Another controller, whose steps end before a standstill that the screw comes to.

    Friction turns round there within no time, so a step across it is rejected until it is next to
    nothing; each step on the way there was tried across first.
    """

    #: Time to the time that is left to the next standstill.
    remaining: Callable[[Scalar], Scalar]

    def __init__(self, controller: Any, remaining: Callable[[Scalar], Scalar]):
        self.controller, self.remaining = controller, remaining

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped, but for the length."""
        keep, start, end, jump, state, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )
        longest = _OF_THE_REST * jax.lax.stop_gradient(self.remaining(start))
        return keep, start, jnp.minimum(end, start + longest), jump, state, result


class Rounded(_Around):
    """Another controller, with lengths of steps rounded to seven binary digits."""

    def __init__(self, controller: Any):
        self.controller = controller

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        """As the controller that is wrapped, but for the length."""
        end, state = self.controller.init(terms, t0, t1, y0, dt0, args, func, error_order)
        return t0 + _rounded(end - t0), state

    def adapt_step_size(
        self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
    ):
        """As the controller that is wrapped, but for the length."""
        keep, start, end, jump, state, result = self.controller.adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )
        return keep, start, start + _rounded(end - start), jump, state, result


def _rounded(length: Scalar) -> Scalar:
    length = jax.lax.stop_gradient(length)
    # A bit more, for ten times a rounded length may lie just between two of them.
    return jax.lax.reduce_precision(length * 1.001, jnp.finfo(length.dtype).nexp, 6)


__all__ = ["Approaching", "Rounded", "Weighed", "Weight", "root_mean_square"]
