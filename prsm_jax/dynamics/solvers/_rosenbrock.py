"""A linearly implicit solver for stiff transients of a few states: RODASP, order 4(3).

Six stages share one matrix `I/(γh) − J`, so a step costs six right-hand sides, one Jacobian and no
iteration that could fail. L-stable and stiffly accurate, with dense output. Of the family of RODAS
methods (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, second edition, 1996,
section IV.7) it is the one that keeps its order where a stiff state follows a moving one, as
carriers follow a screw whose speed changes: G. Steinebach, Order-reduction of ROW-methods for DAEs
and method of lines applications, preprint 1741, TH Darmstadt (1995). There the first RODAS takes
ten to seventy times as many steps.

Carriers turn nearly in proportion to the screw, and are stiff: the motion of the screw limits the
steps, although carriers hardly deviate from it. So a step integrates the remainder of a state after
subtraction of a part in proportion to its leader, `u = y − c P(t)`, with c their ratio at the start
of the step and P the cubic through the leader. The equation of motion is the same for any c and P.
An oscillating screw takes 1.6 times fewer steps at a tolerance of 1e-5, and 3 times fewer at 1e-7.

An L-stable method also damps fast growth, and its error estimate does not show it: with `h λ` of
800 a step leaves the state where it is, while the solution moves away. Friction has such states:
outside the narrow range of carrier speeds in which it turns, deviations grow, and carriers that had
left the range at a reversal never returned. A step with `h ∂f_i/∂y_i > 1` is therefore rejected.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, PyTree

from ...fields import Scalar
from ...numerics import any_few, dot_few, solve_small
from ._dense_output import OneStep, StepInterpolation
from ._driven_rate import DrivenRate
from ._step_control import is_shortest

_GAMMA = 0.25
#: Largest exponent of growth that a step may have, `h ∂f_i/∂y_i`.
_LARGEST_GROWTH = 1.0
#: Replaces a zero length; times are of order one.
_NO_LENGTH = 1e-6
#: A leader below this share of its scale is ignored.
_NO_LEADER = 1e-6
_C = (0.0, 0.75, 0.21, 0.63, 1.0, 1.0)
#: The stage whose time is nearest to the middle of the step.
_INSIDE = 3
_D = (0.25, -0.5, -0.023504, -0.0362, 0.0, 0.0)
_A = (
    (),
    (3.0,),
    (1.831036793486759, 0.4955183967433795),
    (2.304376582692669, -0.05249275245743001, -1.176798761832782),
    (-7.170454962423024, -4.741636671481785, -16.31002631330971, -1.062004044111401),
)
_E = (
    (),
    (-12.0,),
    (-8.791795173947035, -2.207865586973518),
    (10.81793056857153, 6.780270611428266, 19.5348594464241),
    (34.19095006749676, 15.49671153725963, 54.7476087596413, 14.16005392148534),
    (
        34.62605830930532,
        15.30084976114473,
        56.99955578662667,
        18.40807009793095,
        -5.714285714285717,
    ),
)
_DENSE = (
    (25.09876703708589, 11.62013104361867, 28.49148307714626, -5.664021568594133),
    (
        1.638054557396973,
        -0.7373619806678748,
        8.47791821923899,
        15.9925314877952,
        -1.882352941176471,
    ),
)


def _padded(rows: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
    return tuple(row + (0.0,) * (6 - len(row)) for row in rows)


#: The same as full rows; the last point is the previous point plus its stage.
_AS_TABLE = _padded((*_A, (*_A[4], 1.0)))
_ES_TABLE = _padded(_E)


def _combined(weights: tuple[float, ...], stages: list[Array]) -> Array:
    total = weights[0] * stages[0]
    for weight, stage in zip(weights[1:], stages[1:], strict=True):
        total = total + weight * stage
    return total


class RodasInterpolation(StepInterpolation):
    """Between two steps: `(1 − s) y₀ + s (y₁ + (1 − s)(p + s q))`, locally of order 3."""

    first: PyTree
    second: PyTree

    def _at(self, share: Scalar) -> PyTree:
        rest = 1 - share

        def at(y0, y1, first, second):
            inside = y0 + share * ((y1 - y0) + rest * (first + share * second))
            # A state at rest, and the end itself, are free of the rounding of weights.
            return jnp.where(share == 1, y1, inside)

        return jax.tree.map(at, self.y0, self.y1, self.first, self.second)


class _Following(NamedTuple):
    """Motion of states in a step if they follow a leader in proportion: `c P(s)`, s from 0 to 1.

    P is the cubic with the values and rates of the leader at both ends of the step, in the form in
    which the method interpolates.
    """

    length: Scalar
    #: c (P(1) − P(0)), and the two other coefficients.
    change: Float[Array, "*states"]
    first: Float[Array, "*states"]
    second: Float[Array, "*states"]
    #: Largest difference between leader and P inside the step, times c.
    deviation: Float[Array, "*states"]

    def moved(self, share: float) -> Float[Array, "*states"]:
        """`c (P(s) − P(0))`."""
        return share * (self.change + (1 - share) * (self.first + share * self.second))

    def rate(self, share: float) -> Float[Array, "*states"]:
        """Its derivative by time."""
        bent = (1 - 2 * share) * (self.first + share * self.second)
        return (self.change + bent + share * (1 - share) * self.second) / self.length

    def second_rate_at_start(self) -> Float[Array, "*states"]:
        """Its second derivative by time at the start of the step."""
        return 2 * (self.second - self.first) / self.length**2


def _following(state, length, start, inside, end) -> _Following:
    """Motion of a state in a step if it keeps its proportion to a leader.

    **Arguments:**

    - `state`, `length`: state at the start of the step, and length of the step.
    - `start`, `inside`, `end`: the leader and its rate at the start, at the share `_INSIDE` of the
      step and at its end.
    """
    moves = jnp.abs(start[0]) > _NO_LEADER
    share = jnp.where(moves, jnp.clip(state / jnp.where(moves, start[0], 1.0), -1.0, 1.0), 0.0)
    change = end[0] - start[0]
    first = length * start[1] - change
    second = 2 * change - length * (start[1] + end[1])
    cubic = _Following(length, change, first, second, change)
    difference = inside[0] - start[0] - cubic.moved(_C[_INSIDE])
    # It grows as s² (1 − s)² from both ends.
    difference = difference / (4 * _C[_INSIDE] * (1 - _C[_INSIDE])) ** 2
    return _Following(length, share * change, share * first, share * second, share * difference)


def _grows(jacobian: Float[Array, "states states"], start: Any, end: Any) -> Bool[Array, ""]:
    """Whether a state grows by itself more within a step than the method can follow.

    The diagonal holds the eigenvalues where no stage acts back on those after it, as in a chain of
    screws.
    """
    rates = jnp.stack([jacobian[k, k] for k in range(jacobian.shape[0])])
    return any_few(rates * (end - start) > _LARGEST_GROWTH) & ~is_shortest(start, end)


class Rodasp(OneStep):
    """RODASP, order 4 with an embedded one of order 3, for stiff problems with few states.

    `autonomous` says that the right-hand side does not depend on time: its derivative by time is
    then not evaluated. `compact` runs the stages in a loop: the right-hand side is then compiled
    twice instead of eight times, which suits right-hand sides that are long or contain loops.
    """

    autonomous: bool = False
    compact: bool = False

    interpolation_cls: ClassVar[Callable[..., RodasInterpolation]] = RodasInterpolation

    def order(self, terms) -> int:
        return 4

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        flat, unflatten = ravel_pytree(y0)
        # In a batch, finished integrations take steps of zero length. Their results are dropped but
        # must be finite: derivatives of dropped results are multiplied by zero.
        length = jnp.where(t1 == t0, _NO_LENGTH, t1 - t0)

        def rate(time, state):
            return ravel_pytree(terms.vf(time, unflatten(state), args))[0]

        if self.compact:
            end, stages, grows = self._looped(rate, t0, t1, length, flat)
            return self._step(y0, unflatten, end, stages, grows)
        at_stage, slope, following = self._rates(terms, rate, t0, length, flat, unflatten, args)
        identity = jnp.eye(flat.size, dtype=flat.dtype)
        here = at_stage(0, flat)
        jacobian = jax.vmap(
            lambda direction: jax.jvp(lambda y: at_stage(0, y), (flat,), (direction,))[1],
            out_axes=-1,
        )(identity)
        matrix = identity / (_GAMMA * length) - jacobian
        solve = solve_small(matrix)
        if following is not None:
            assert slope is not None
            slope = slope + dot_few(jacobian, following.rate(0.0))
            slope = slope - following.second_rate_at_start()

        stages: list[Array] = []
        point = flat
        for index in range(6):
            if index == 0:
                right = here
            else:
                point = flat + _combined(_A[index], stages) if index < 5 else point + stages[4]
                right = at_stage(
                    index, point if following is None else point + following.moved(_C[index])
                )
                right = right + _combined(_E[index], stages) / length
            if following is not None:
                right = right - following.rate(_C[index])
            if slope is not None and _D[index] != 0:
                right = right + length * _D[index] * slope
            stages.append(solve(right))
        grows = _grows(jacobian, t0, t1)
        return self._step(y0, unflatten, point + stages[5], stages, grows, following)

    def _rates(self, terms, rate, t0, length, flat, unflatten, args):
        """Function of (stage, state) to the rate, its time derivative, and the leading motion."""
        # diffrax wraps the term, to integrate backwards too.
        field = getattr(terms, "term", terms).vector_field
        if not isinstance(field, DrivenRate):
            slope = None
            if not self.autonomous:
                slope = jax.jvp(lambda t: rate(t, flat), (t0,), (jnp.ones_like(t0),))[1]
            return lambda index, state: rate(t0 + _C[index] * length, state), slope, None
        # The last two stages are at the same time.
        drives, change = field.drives_at(t0 + jnp.asarray(_C[:-1], t0.dtype) * length, args)

        def driven(drive, state):
            return ravel_pytree(field.rate(drive, unflatten(state), args))[0]

        slope = jax.jvp(lambda drive: driven(drive, flat), (drives[0],), (change,))[1]
        following = None
        if field.leader is not None:
            leaders = [field.leader(drives[stage], args) for stage in (0, _INSIDE, -1)]
            following = _following(flat, length, *leaders)
        last = len(drives) - 1
        return lambda index, state: driven(drives[min(index, last)], state), slope, following

    def _looped(self, rate, t0, t1, length, flat):
        """End of the step and its stages, by a loop over these, and whether states grow too far."""
        # Derivatives by the state and by time at once.
        directions = jnp.eye(flat.size + 1, dtype=flat.dtype)
        if self.autonomous:
            directions = directions[:-1]
        derivatives = jax.vmap(
            lambda d: jax.jvp(rate, (t0, flat), (d[-1], d[:-1]))[1], out_axes=-1
        )(directions)
        slope = jnp.zeros_like(flat) if self.autonomous else derivatives[:, -1]
        jacobian = derivatives[:, : flat.size]
        solve = solve_small(jnp.eye(flat.size, dtype=flat.dtype) / (_GAMMA * length) - jacobian)
        rows = tuple(jnp.asarray(table, flat.dtype) for table in (_AS_TABLE, _ES_TABLE, _C, _D))

        def stage(carry, row):
            stages, index = carry
            weights, history, share, slopes = row
            point = flat + weights @ stages
            right = rate(t0 + share * length, point) + history @ stages / length
            increment = solve(right + length * slopes * slope)
            return (stages.at[index].set(increment), index + 1), point

        empty = jnp.zeros((6, flat.size), flat.dtype)
        (stages, _), points = jax.lax.scan(stage, (empty, 0), rows)
        return points[5] + stages[5], list(stages), _grows(jacobian, t0, t1)

    @staticmethod
    def _step(y0, unflatten, end, stages, grows, following=None):
        first, second = _combined(_DENSE[0], stages[:4]), _combined(_DENSE[1], stages[:5])
        if following is not None:
            end, first, second = (
                end + following.moved(1.0),
                first + following.first,
                second + following.second,
            )
        dense = {
            "y0": y0,
            "y1": unflatten(end),
            "first": unflatten(first),
            "second": unflatten(second),
        }
        error = stages[5]
        if following is not None:
            # States that follow without lag are exact at both ends of a step of any length.
            error = jnp.abs(error) + jnp.abs(following.deviation)
        error = jnp.where(grows, 1 + jnp.abs(jax.lax.stop_gradient(end)), error)
        return unflatten(end), unflatten(error), dense, None, diffrax.RESULTS.successful


__all__ = ["RodasInterpolation", "Rodasp"]
