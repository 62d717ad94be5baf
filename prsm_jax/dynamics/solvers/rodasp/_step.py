"""One step of RODASP, from the rates of the states and their derivatives.

Six stages share one matrix `I/(γh) − J`, so a step costs six right-hand sides, one Jacobian and no
iteration that could fail. L-stable and stiffly accurate, with dense output. Of the family of RODAS
methods (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, second edition, 1996,
section IV.7) it is the one that keeps its order where a stiff state follows a moving one, as
carriers follow a screw whose speed changes: G. Steinebach, Order-reduction of ROW-methods for DAEs
and method of lines applications, preprint 1741, TH Darmstadt (1995). There the first RODAS takes
ten to seventy times as many steps.

An L-stable method also damps fast growth, and its error estimate does not show it: with `h λ` of
800 a step leaves the state where it is, while the solution moves away. Friction has such states:
outside the narrow range of carrier speeds in which it turns, deviations grow, and carriers that had
left the range at a reversal never returned. A step with `h ∂f_i/∂y_i > 1` is therefore rejected.

Imports diffrax, so it is itself imported only where something is integrated.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ....fields import Scalar
from ....numerics import any_few, apart
from .._step_control import is_shortest
from ._following import INSIDE, Following
from ._jacobians import ChainJacobian, FullJacobian

_GAMMA = 0.25
#: Largest exponent of growth that a step may have, `h ∂f_i/∂y_i`.
_LARGEST_GROWTH = 1.0
#: Replaces a zero length; times are of order one.
_NO_LENGTH = 1e-6
#: Shares of the step at which the stages are; the last two are at the same time.
SHARES = (0.0, 0.75, 0.21, 0.63, 1.0, 1.0)
#: The stage whose time is nearest to the middle of the step.
INSIDE_STAGE = SHARES.index(INSIDE)
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


class Motion(NamedTuple):
    """What a step needs of an equation of motion."""

    #: Rate at (stage, state).
    rate: Callable[[int, Float[Array, " states"]], Float[Array, " states"]]
    #: Derivatives of the rate at the start of the step: by state, and by time unless that is zero.
    jacobian: ChainJacobian | FullJacobian
    slope: Float[Array, " states"] | None
    following: Following | None = None


class Taken(NamedTuple):
    """Result of a step: the state at its end, its interpolation and its error."""

    end: Float[Array, " states"]
    first: Float[Array, " states"]
    second: Float[Array, " states"]
    error: Float[Array, " states"]


def length_of(start: Scalar, end: Scalar) -> Scalar:
    """Length of a step; small where it is zero."""
    # In a batch, finished integrations take steps of zero length. Their results are dropped but
    # must be finite: derivatives of dropped results are multiplied by zero.
    return jnp.where(end == start, _NO_LENGTH, end - start)


def step_of(motion: Motion, flat: Float[Array, " states"], t0: Scalar, t1: Scalar) -> Taken:
    """A step with its stages one by one."""
    length = length_of(t0, t1)
    solve = motion.jacobian.shifted_solve(1 / (_GAMMA * length))
    slope, following = motion.slope, motion.following
    if following is not None:
        assert slope is not None
        slope = slope + motion.jacobian.times(following.rate(0.0))
        slope = slope - following.second_rate_at_start()

    stages: list[Array] = []
    point = flat
    for index in range(6):
        if index > 0:
            point = flat + _combined(_A[index], stages) if index < 5 else point + stages[4]
        right = motion.rate(
            index,
            point if following is None or index == 0 else point + following.moved(SHARES[index]),
        )
        if index > 0:
            right = right + _combined(_E[index], stages) / length
        if following is not None:
            right = right - following.rate(SHARES[index])
        if slope is not None and _D[index] != 0:
            right = right + length * _D[index] * slope
        stages.append(solve(right))
    grows = _grows(motion.jacobian.diagonal, t0, t1)
    return apart(_finished)(point + stages[5], stages, grows, following)


def _finished(end, stages, grows, following=None) -> Taken:
    first, second = _combined(_DENSE[0], stages[:4]), _combined(_DENSE[1], stages[:5])
    error = stages[5]
    if following is not None:
        end = end + following.moved(1.0)
        first, second = first + following.first, second + following.second
        # States that follow without lag are exact at both ends of a step of any length.
        error = jnp.abs(error) + jnp.abs(following.deviation)
    error = jnp.where(grows, 1 + jnp.abs(jax.lax.stop_gradient(end)), error)
    return Taken(end, first, second, error)


def _grows(rates: list[Scalar], start: Scalar, end: Scalar) -> Bool[Array, ""]:
    """Whether a state grows by itself more within a step than the method can follow.

    **Arguments:**

    - `rates`: diagonal of the Jacobian; its eigenvalues where no stage acts back on those after it,
      as in a chain of screws.
    - `start`, `end`: of the step.
    """
    grow = any_few(jnp.stack(rates) * (end - start) > _LARGEST_GROWTH)
    return grow & ~is_shortest(start, end)


def looped_step(
    rate: Callable[[Scalar, Float[Array, " states"]], Float[Array, " states"]],
    flat: Float[Array, " states"],
    t0: Scalar,
    t1: Scalar,
    autonomous: bool,
) -> Taken:
    """A step with its stages in a loop.

    **Arguments:**

    - `rate`: function of time and state.
    - `flat`: state at the start of the step.
    - `t0`, `t1`: start and end of the step.
    - `autonomous`: whether the rate is independent of time.
    """
    length = length_of(t0, t1)
    # Derivatives by the state and by time at once.
    directions = jnp.eye(flat.size + 1, dtype=flat.dtype)
    if autonomous:
        directions = directions[:-1]
    derivatives = jax.vmap(lambda d: jax.jvp(rate, (t0, flat), (d[-1], d[:-1]))[1], out_axes=-1)(
        directions
    )
    slope = jnp.zeros_like(flat) if autonomous else derivatives[:, -1]
    jacobian = FullJacobian(derivatives[:, : flat.size])
    solve = jacobian.shifted_solve(1 / (_GAMMA * length))
    rows = tuple(jnp.asarray(table, flat.dtype) for table in (_AS_TABLE, _ES_TABLE, SHARES, _D))

    def stage(carry, row):
        stages, index = carry
        weights, history, share, slopes = row
        point = flat + weights @ stages
        right = rate(t0 + share * length, point) + history @ stages / length
        increment = solve(right + length * slopes * slope)
        return (stages.at[index].set(increment), index + 1), point

    empty = jnp.zeros((6, flat.size), flat.dtype)
    (stages, _), points = jax.lax.scan(stage, (empty, 0), rows)
    grows = _grows(jacobian.diagonal, t0, t1)
    return _finished(points[5] + stages[5], list(stages), grows)


__all__ = ["INSIDE_STAGE", "SHARES", "Motion", "Taken", "length_of", "looped_step", "step_of"]
