"""A linearly implicit solver for stiff transients of a few states: RODASP, order 4(3).

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
from typing import ClassVar, NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float, PyTree

from ...fields import Scalar
from ...numerics import any_few, apart, merged
from ._dense_output import OneStep, StepInterpolation
from ._driven_rate import DrivenRate
from ._following import INSIDE, Following, following_of
from ._jacobians import (
    NODES,
    ChainJacobian,
    FullJacobian,
    chain_jacobian,
    full_jacobian,
    node_inverses,
    node_slopes,
)
from ._step_control import is_shortest

_GAMMA = 0.25
#: Largest exponent of growth that a step may have, `h ∂f_i/∂y_i`.
_LARGEST_GROWTH = 1.0
#: Replaces a zero length; times are of order one.
_NO_LENGTH = 1e-6
_C = (0.0, 0.75, 0.21, 0.63, 1.0, 1.0)
#: The stage whose time is nearest to the middle of the step.
_INSIDE = _C.index(INSIDE)
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


def _cubic(share, y0, y1, first, second):
    inside = y0 + share * ((y1 - y0) + (1 - share) * (first + share * second))
    # A state at rest, and the end itself, are free of the rounding of weights.
    return jnp.where(share == 1, y1, inside)


class RodasInterpolation(StepInterpolation):
    """Between two steps: `(1 − s) y₀ + s (y₁ + (1 − s)(p + s q))`, locally of order 3."""

    first: PyTree
    second: PyTree

    def _at(self, share: Scalar) -> PyTree:
        return jax.tree.map(
            lambda *parts: _cubic(share, *parts), self.y0, self.y1, self.first, self.second
        )

    def _at_shares(self, shares: Float[Array, " times"]) -> PyTree:
        # One number after the other: in arrays of several, times would not be innermost.
        def at(*parts):
            numbers = zip(*(part.ravel() for part in parts), strict=True)
            return [_cubic(shares, *number) for number in numbers]

        return jax.tree.map(at, self.y0, self.y1, self.first, self.second)


class _Motion(NamedTuple):
    """What a step needs of an equation of motion."""

    #: Rate at (stage, state).
    rate: Callable[[int, Float[Array, " states"]], Float[Array, " states"]]
    #: Derivatives of the rate at the start of the step: by state, and by time unless that is zero.
    jacobian: ChainJacobian | FullJacobian
    slope: Float[Array, " states"] | None
    following: Following | None = None


class _Taken(NamedTuple):
    """Result of a step: the state at its end, its interpolation and its error."""

    end: Float[Array, " states"]
    first: Float[Array, " states"]
    second: Float[Array, " states"]
    error: Float[Array, " states"]


def _length_of(start: Scalar, end: Scalar) -> Scalar:
    # In a batch, finished integrations take steps of zero length. Their results are dropped but
    # must be finite: derivatives of dropped results are multiplied by zero.
    return jnp.where(end == start, _NO_LENGTH, end - start)


def _taken(motion: _Motion, flat: Float[Array, " states"], t0: Scalar, t1: Scalar) -> _Taken:
    """A step with its stages one by one."""
    length = _length_of(t0, t1)
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
            index, point if following is None or index == 0 else point + following.moved(_C[index])
        )
        if index > 0:
            right = right + _combined(_E[index], stages) / length
        if following is not None:
            right = right - following.rate(_C[index])
        if slope is not None and _D[index] != 0:
            right = right + length * _D[index] * slope
        stages.append(solve(right))
    grows = _grows(motion.jacobian.diagonal, t0, t1)
    return apart(_finished)(point + stages[5], stages, grows, following)


def _finished(end, stages, grows, following=None) -> _Taken:
    first, second = _combined(_DENSE[0], stages[:4]), _combined(_DENSE[1], stages[:5])
    error = stages[5]
    if following is not None:
        end = end + following.moved(1.0)
        first, second = first + following.first, second + following.second
        # States that follow without lag are exact at both ends of a step of any length.
        error = jnp.abs(error) + jnp.abs(following.deviation)
    error = jnp.where(grows, 1 + jnp.abs(jax.lax.stop_gradient(end)), error)
    return _Taken(end, first, second, error)


def _grows(rates: list[Scalar], start: Scalar, end: Scalar) -> Bool[Array, ""]:
    """Whether a state grows by itself more within a step than the method can follow.

    **Arguments:**

    - `rates`: diagonal of the Jacobian; its eigenvalues where no stage acts back on those after it,
      as in a chain of screws.
    - `start`, `end`: of the step.
    """
    grow = any_few(jnp.stack(rates) * (end - start) > _LARGEST_GROWTH)
    return grow & ~is_shortest(start, end)


def _driven_motion(
    field: DrivenRate, drives, change, t0, t1, flat, args, unflatten
) -> _Motion:
    """The equation of motion with its drive at the stages, and the change of the drive."""
    last, length = len(drives) - 1, _length_of(t0, t1)

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
        leaders = [field.leader(drives[stage], args) for stage in (0, _INSIDE, -1)]
        following = following_of(flat, length, *leaders)
    return _Motion(
        lambda index, state: driven(drives[min(index, last)], state), jacobian, slope, following
    )


@eqx.filter_custom_jvp
def _chain_taken(field, drives, change, t0, t1, flat, args) -> _Taken:
    """A step of states in a chain; its derivatives are those of the solution."""
    return merged(_chain_taken_plain)(field, drives, change, t0, t1, flat, args)


def _chain_taken_plain(field, drives, change, t0, t1, flat, args) -> _Taken:
    motion = _driven_motion(field, drives, change, t0, t1, flat, args, lambda state: state)
    return _taken(motion, flat, t0, t1)


@_chain_taken.def_jvp
def _chain_taken_jvp(primals, tangents):
    """By the variational equation; derivatives of the drives are given.

    The derivative of the arithmetic of a step would need six derivatives of rates, and second
    derivatives in every direction of the state.
    """
    return merged(_chain_taken_jvp_plain)(primals, tangents)


def _chain_taken_jvp_plain(primals, tangents):
    field, drives, _, t0, t1, flat, args = primals
    d_field, d_drives, _, d_t0, d_t1, d_flat, d_args = tangents
    taken = _chain_taken(*primals)
    length = _length_of(t0, t1)
    moves = d_t0 is not None or d_t1 is not None
    d_length = None
    d_middle = None
    if moves:
        d_t0, d_t1 = (jnp.zeros_like(t0) if d is None else d for d in (d_t0, d_t1))
        d_length, d_middle = d_t1 - d_t0, 0.5 * (d_t0 + d_t1)
    at_nodes, d_at_nodes = [drives[0]] * len(NODES), [d_drives[0]] * len(NODES)
    if not field.constant:
        middle, d_drive = eqx.filter_jvp(
            lambda field, time, args: field.drive_at(time, args),
            (field, t0 + 0.5 * length, args),
            (d_field, d_middle, d_args),
        )
        at_nodes, d_at_nodes = (
            [drives[0], middle, drives[-1]],
            [d_drives[0], d_drive, d_drives[-1]],
        )
    between = RodasInterpolation(
        t0=t0, t1=t1, y0=flat, y1=taken.end, first=taken.first, second=taken.second
    )
    states = [flat, between._at(jnp.asarray(0.5, flat.dtype)), taken.end]
    jacobians, forcing = [], []
    for drive, d_drive, state in zip(at_nodes, d_at_nodes, states, strict=True):
        numbers = list(state)
        jacobians.append(chain_jacobian(field.chain, drive, numbers, args))
        rates, changes = eqx.filter_jvp(
            lambda field, drive, args, numbers=numbers: field.chain(drive, numbers, args),
            (field, drive, args),
            (d_field, d_drive, d_args),
        )
        changes = [0.0 * rate if d is None else d for rate, d in zip(rates, changes, strict=True)]
        forced = [length * change for change in changes]
        if d_length is not None:
            forced = [a + d_length * rate for a, rate in zip(forced, rates, strict=True)]
        forcing.append(forced)
    start = jnp.zeros_like(flat) if d_flat is None else d_flat
    inverses = apart(node_inverses)(jacobians, length)
    slopes = apart(node_slopes)(jacobians, inverses, forcing, length, list(start))
    first, middle, last = (jnp.stack([of_state[node] for of_state in slopes]) for node in range(3))
    # The cubic with these slopes at the nodes, which ends where the method ends.
    total = (first + 4 * middle + last) / 6
    return taken, _Taken(start + total, first - total, 2 * total - first - last, None)


class Rodasp(OneStep):
    """RODASP, order 4 with an embedded one of order 3, for stiff problems with few states.

    `autonomous` says that the right-hand side does not depend on time: its derivative by time is
    then not evaluated. `compact` runs the stages in a loop: the right-hand side is then compiled
    twice instead of eight times, which suits right-hand sides that are long or contain loops.
    `variational` says that derivatives of a `DrivenRate` with a chain follow the variational
    equation; all traced values of its functions must be their leaves (`DrivenRate.closed`).
    """

    autonomous: bool = False
    compact: bool = False
    variational: bool = False

    interpolation_cls: ClassVar[Callable[..., RodasInterpolation]] = RodasInterpolation

    def order(self, terms) -> int:
        return 4

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        flat, unflatten = ravel_pytree(y0)
        # diffrax wraps the term, to integrate backwards too.
        field = getattr(terms, "term", terms).vector_field
        if isinstance(field, DrivenRate) and not self.compact:
            times = t0 + jnp.asarray(_C[:-1], t0.dtype) * _length_of(t0, t1)
            # The last two stages are at the same time.
            drives, change = field.drives_at(times, args)
            if field.chain is not None and self.variational:
                taken = _chain_taken(field, drives, change, t0, t1, flat, args)
            else:
                motion = _driven_motion(field, drives, change, t0, t1, flat, args, unflatten)
                taken = _taken(motion, flat, t0, t1)
        else:

            def rate(time, state):
                return ravel_pytree(terms.vf(time, unflatten(state), args))[0]

            taken = self._looped(rate, t0, t1, flat) if self.compact else None
            if taken is None:
                taken = self._direct(rate, t0, t1, flat)
        end = unflatten(taken.end)
        dense = {
            "y0": y0,
            "y1": end,
            "first": unflatten(taken.first),
            "second": unflatten(taken.second),
        }
        return end, unflatten(taken.error), dense, None, diffrax.RESULTS.successful

    def _direct(self, rate, t0, t1, flat) -> _Taken:
        """A step with any function of time and state as the right-hand side."""
        length, slope = _length_of(t0, t1), None
        if not self.autonomous:
            slope = jax.jvp(lambda t: rate(t, flat), (t0,), (jnp.ones_like(t0),))[1]
        motion = _Motion(
            lambda index, state: rate(t0 + _C[index] * length, state),
            full_jacobian(lambda y: rate(t0, y), flat),
            slope,
        )
        return _taken(motion, flat, t0, t1)

    def _looped(self, rate, t0, t1, flat) -> _Taken:
        """A step with its stages in a loop."""
        length = _length_of(t0, t1)
        # Derivatives by the state and by time at once.
        directions = jnp.eye(flat.size + 1, dtype=flat.dtype)
        if self.autonomous:
            directions = directions[:-1]
        derivatives = jax.vmap(
            lambda d: jax.jvp(rate, (t0, flat), (d[-1], d[:-1]))[1], out_axes=-1
        )(directions)
        slope = jnp.zeros_like(flat) if self.autonomous else derivatives[:, -1]
        jacobian = FullJacobian(derivatives[:, : flat.size])
        solve = jacobian.shifted_solve(1 / (_GAMMA * length))
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
        grows = _grows(jacobian.diagonal, t0, t1)
        return _finished(points[5] + stages[5], list(stages), grows)


__all__ = ["RodasInterpolation", "Rodasp"]
