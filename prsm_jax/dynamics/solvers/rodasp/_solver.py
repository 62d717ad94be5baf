"""The solver RODASP for diffrax, order 4(3): for stiff transients of a few states.

Derivatives of states in a chain, as the carriers of a mechanism are, follow the variational
equation along the solution, not the arithmetic of the steps. These derivatives have the order of
the values, and take less than half the time: the derivative of a step's arithmetic needs six
derivatives of the rates, and second derivatives in every direction of the state.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import ClassVar

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Float, PyTree

from ....fields import Scalar
from ....numerics import merged
from .._dense_output import OneStep, StepInterpolation
from .._driven_rate import DrivenRate
from ._following import following_of
from ._jacobians import NODES, chain_jacobian, full_jacobian
from ._step import INSIDE_STAGE, SHARES, Motion, Taken, length_of, looped_step, step_of
from ._variational import Given, Slopes, of_start_and_length, step_slopes


def _cubic(share, y0, y1, first, second):
    inside = y0 + share * ((y1 - y0) + (1 - share) * (first + share * second))
    # A state at rest, and the end itself, are free of the rounding of weights.
    return jnp.where(share == 1, y1, inside)


def at_nodes(state, taken: Taken | Slopes) -> list[Float[Array, " states"]]:
    """States at the nodes of the variational equation, from the state at the start of a step."""
    return [state, _cubic(0.5, state, *taken[:3]), taken.end]


class RodasInterpolation(StepInterpolation):
    """Between two steps: `(1 − s) y₀ + s (y₁ + (1 − s)(p + s q))`, locally of order 3."""

    first: PyTree
    second: PyTree

    def at_share(self, share: Scalar) -> PyTree:
        return jax.tree.map(
            lambda *parts: _cubic(share, *parts), self.y0, self.y1, self.first, self.second
        )

    def _at_shares(self, shares: Float[Array, " times"]) -> PyTree:
        # Scalar by scalar, so that the axis of the times is contiguous.
        def at(*parts):
            numbers = zip(*(part.ravel() for part in parts), strict=True)
            return [_cubic(shares, *number) for number in numbers]

        return jax.tree.map(at, self.y0, self.y1, self.first, self.second)


def _driven_motion(
    field: DrivenRate, drives, change, t0, t1, flat, args, unflatten=lambda flat: flat
) -> Motion:
    """The equation of motion with its drive at the stages, and the change of the drive."""
    last, length = len(drives) - 1, length_of(t0, t1)

    def driven(drive, state):
        if field.chain is not None:
            return jnp.stack(field.chain(drive, list(state), args))
        return ravel_pytree(field.rate(drive, unflatten(state), args))[0]

    if field.chain is not None:
        jacobian = chain_jacobian(field.chain, drives[0], list(flat), args)
    else:
        jacobian = full_jacobian(lambda y: driven(drives[0], y), flat)
    slope = following = None
    if change is not None:
        slope = jax.jvp(lambda drive: driven(drive, flat), (drives[0],), (change,))[1]
    if field.leader is not None:
        leaders = [field.leader(drives[stage], args) for stage in (0, INSIDE_STAGE, -1)]
        following = following_of(flat, length, *leaders)
    return Motion(
        lambda index, state: driven(drives[min(index, last)], state), jacobian, slope, following
    )


def _chain_step(field, drives, change, t0, t1, flat, args) -> Taken:
    motion = _driven_motion(field, drives, change, t0, t1, flat, args)
    return step_of(motion, flat, t0, t1)


@eqx.filter_custom_jvp
def _differentiable_step(field, drives, change, t0, t1, flat, args) -> Taken:
    """A step of states in a chain; its derivatives are those of the solution."""
    return merged(_chain_step)(field, drives, change, t0, t1, flat, args)


@_differentiable_step.def_jvp
def _differentiable_step_jvp(primals, tangents):
    return merged(_step_and_slopes)(primals, tangents)


def _step_and_slopes(primals, tangents):
    """A step and its derivative in one direction, by the variational equation."""
    field, drives, _, t0, t1, flat, args = primals
    d_field, d_drives, _, d_t0, d_t1, d_flat, d_args = tangents
    taken = _differentiable_step(*primals)
    length = length_of(t0, t1)
    d_t0, d_length = of_start_and_length(t0, d_t0, d_t1)
    if field.constant:
        drives, d_drives = [drives[0]] * len(NODES), [d_drives[0]] * len(NODES)
    else:
        middle, d_drive = eqx.filter_jvp(
            lambda field, time, args: field.drive_at(time, args),
            (field, t0 + 0.5 * length, args),
            (d_field, None if d_t0 is None else d_t0 + 0.5 * d_length, d_args),
        )
        drives = [drives[0], middle, drives[-1]]
        d_drives = [d_drives[0], d_drive, d_drives[-1]]
    slopes = step_slopes(
        Given(field, drives, length, flat, args),
        Given(d_field, d_drives, d_length, d_flat, d_args),
        at_nodes(flat, taken),
    )
    none = jax.tree.map(lambda _: None, taken)
    return taken, none._replace(end=slopes.end, first=slopes.first, second=slopes.second)


def _driven_step(field: DrivenRate, t0, t1, flat, args, unflatten) -> Taken:
    """A step with its drive evaluated once for each stage."""
    # The last two stages are at the same time.
    times = t0 + jnp.asarray(SHARES[:-1], t0.dtype) * length_of(t0, t1)
    drives, change = field.drives_at(times, args)
    if field.chain is not None:
        return _differentiable_step(field, drives, change, t0, t1, flat, args)
    motion = _driven_motion(field, drives, change, t0, t1, flat, args, unflatten)
    return step_of(motion, flat, t0, t1)


def _direct_step(rate, flat, t0, t1, autonomous: bool) -> Taken:
    """A step with any function of time and state as the right-hand side."""
    length, slope = length_of(t0, t1), None
    if not autonomous:
        slope = jax.jvp(lambda t: rate(t, flat), (t0,), (jnp.ones_like(t0),))[1]
    motion = Motion(
        lambda index, state: rate(t0 + SHARES[index] * length, state),
        full_jacobian(lambda y: rate(t0, y), flat),
        slope,
    )
    return step_of(motion, flat, t0, t1)


class Rodasp(OneStep):
    """RODASP, order 4 with an embedded one of order 3, for stiff problems with few states.

    `autonomous` says that the right-hand side does not depend on time: its derivative by time is
    then not evaluated. A `DrivenRate` says so itself (`constant`). `compact` runs the stages in a
    loop: the right-hand side is then compiled twice instead of eight times, which suits right-hand
    sides that are long or contain loops. Derivatives of states in a chain (`DrivenRate.chain`)
    follow the variational equation.
    """

    autonomous: bool = False
    compact: bool = False

    interpolation_cls: ClassVar[Callable[..., RodasInterpolation]] = RodasInterpolation

    def order(self, terms) -> int:
        return 4

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        flat, unflatten = ravel_pytree(y0)
        # diffrax wraps the term, to integrate backwards too.
        field = getattr(terms, "term", terms).vector_field
        if isinstance(field, DrivenRate) and not self.compact:
            taken = _driven_step(field, t0, t1, flat, args, unflatten)
        else:

            def rate(time, state):
                return ravel_pytree(terms.vf(time, unflatten(state), args))[0]

            one = looped_step if self.compact else _direct_step
            taken = one(rate, flat, jnp.asarray(t0), jnp.asarray(t1), self.autonomous)
        end = unflatten(taken.end)
        dense = {
            "y0": y0,
            "y1": end,
            "first": unflatten(taken.first),
            "second": unflatten(taken.second),
        }
        return end, unflatten(taken.error), dense, None, diffrax.RESULTS.successful


__all__ = ["RodasInterpolation", "Rodasp"]
