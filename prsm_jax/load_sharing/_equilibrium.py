r"""Equilibrium of the chains: Newton on a convex energy, with implicit derivatives.

The unknowns satisfy the linear equations (closing of the meshes) after the first step and then for
good; along a step $(\Delta q, \Delta Q)$ the energy has the slope $r_q(t)\cdot\Delta q$, which
never falls, so a step that overshoots is cut where that slope is small. Regularising springs, far
softer than any contact, hold unloaded teeth in place and make the energy strictly convex.
"""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Int

from ..fields import Scalar
from ._block_tridiagonal import solve_linear
from ._chains import (
    Chains,
    Control,
    State,
    balance,
    forces_and_slopes,
    residual,
    tooth_approaches,
)
from ._flank_law import flank_approach
from ._flanks import Teeth

#: A step is cut while more than this share of the energy's slope along it remains.
_SLOPE_LEFT = 0.5
_MOST_CUTS = 60
#: Share of the typical force above which the regularising springs change the result code.
_REGULARISATION_SHARE = 1e-4


class Equilibrium(eqx.Module):
    """Unknowns in equilibrium, and how they were found."""

    state: State
    #: Largest unbalanced force over the largest force [1].
    error: Scalar
    steps: Int[Array, ""]
    #: Result code: 0 in balance, 1 steps used up, 2 not finite, 3 in balance only with the
    #: regularising springs (loads too small against play and errors to be resolved).
    result: Int[Array, ""]

    @property
    def converged(self) -> Bool[Array, ""]:
        """Whether the residual reached its tolerance."""
        return self.result == 0


class _Point(NamedTuple):
    """A state with the forces and slopes of its teeth and the residual of the balance."""

    state: State
    screw: Teeth
    nut: Teeth
    residual: State


def default_tolerance(dtype) -> float:
    """Tolerance on the residual that a precision can reach with some room."""
    return 1e-12 if dtype == jnp.float64 else 1e-5


def _point(chains: Chains, state: State, control: Control, value: Scalar) -> _Point:
    screw, nut = forces_and_slopes(chains, state)
    return _Point(state, screw, nut, balance(chains, state, control, value, screw, nut))


def _moved(state: State, step: State, share: Scalar) -> State:
    return jax.tree.map(lambda a, b: a + share * b, state, step)


def _energy_slope(residual: State, step: State) -> Scalar:
    slope = jnp.sum(residual.screw_approach * step.screw_approach)
    slope = slope + jnp.sum(residual.approach * step.approach)
    if residual.displacements is not None and step.displacements is not None:
        slope = slope + jnp.sum(residual.displacements * step.displacements)
    if residual.radial_shift is None or step.radial_shift is None:
        return slope
    return slope + jnp.sum(residual.radial_shift * step.radial_shift)


def _start(chains: Chains, control: Control, value: Scalar) -> _Point:
    """No travel, with linear springs that hold both ways in place of the teeth.

    The first step from here leads to their balance.
    """
    zero = jnp.zeros_like(value)
    count = chains.screw.gap.shape[1]
    classes = chains.weight.shape[0]
    unloaded = State(
        jnp.zeros((classes, count), zero.dtype),
        jnp.zeros((count,), zero.dtype),
        jnp.zeros((classes, count - 1), zero.dtype),
        jnp.zeros((count - 1,), zero.dtype),
        None if chains.screw.reverse_gap is None else jnp.zeros((classes,), zero.dtype),
        None if control == "load" else zero,
        None if chains.displacements is None else jnp.zeros_like(chains.displacements.load),
    )
    direction = jnp.sign(value) if control == "load" and chains.split is None else zero

    def spring(flanks):
        force = jnp.broadcast_to(chains.typical_force, flanks.gap.shape)
        stiffness = force / flank_approach(force, flanks.hertz, flanks.tooth)
        centre = flanks.centre
        if flanks.reverse_gap is not None:
            centre = centre + direction * (flanks.gap + flanks.reverse_gap) / 2
        zeros = None if flanks.reverse_gap is None else jnp.zeros_like(force)
        return Teeth(-stiffness * centre, stiffness, zeros, zeros)

    screw, nut = spring(chains.screw), spring(chains.nut)
    return _Point(unloaded, screw, nut, balance(chains, unloaded, control, value, screw, nut))


def _error(chains: Chains, point: _Point) -> Scalar:
    """Largest unbalanced force and largest mesh error, over the largest force and length."""
    tiny = jnp.finfo(point.state.approach.dtype)
    state, residual = point.state, point.residual
    weight = chains.weight[:, None]
    forces = [
        weight * point.screw.force,
        weight * point.nut.force,
        state.roller_force,
        state.nut_force,
    ]
    largest = jnp.maximum(_largest(forces), 1e-3 * chains.typical_force)
    # Rounding of an approach limits the accuracy of a stiff tooth's force.
    on_screw, on_nut = tooth_approaches(chains, state)
    round_screw = weight * point.screw.slope * _magnitude(chains.screw, on_screw)
    round_nut = (
        weight * point.nut.slope * (_magnitude(chains.nut, on_nut) + jnp.abs(state.screw_approach))
    )
    allowed = 4 * tiny.eps
    excess = [
        jnp.abs(residual.screw_approach) - allowed * (round_screw + round_nut),
        jnp.abs(residual.approach) - allowed * jnp.sum(round_nut, axis=0),
    ]
    if residual.radial_shift is not None:
        excess.append(
            jnp.abs(residual.radial_shift) - allowed * jnp.sum(round_screw + round_nut, axis=1)
        )
    if residual.displacements is not None:
        # A displacement moves flanks by about as much, or more by the lever of their places.
        rounded = jnp.sum(round_nut)
        if chains.displacements is not None and chains.displacements.screw is not None:
            rounded = rounded + jnp.sum(round_screw)
        excess.append(jnp.abs(residual.displacements) - allowed * rounded)
    unbalanced = _largest([jnp.maximum(x, 0.0) for x in excess]) / largest
    lengths = [
        state.screw_approach,
        state.approach,
        chains.screw_segment * largest,
        chains.nut_segment * largest,
        chains.roller_segment * largest,
    ]
    longest = jnp.maximum(_largest(lengths), tiny.tiny)
    mesh_error = _largest([residual.roller_force, residual.nut_force]) / longest
    return jnp.maximum(unbalanced, mesh_error)


def _carried_by_regularisation(chains: Chains, state: State) -> Bool[Array, ""]:
    """Whether a regularising spring carries a noticeable share of the typical force."""
    on_screw, on_nut = tooth_approaches(chains, state)
    offsets = [on_screw - chains.screw.centre, on_nut - chains.nut.centre]
    return chains.regularisation * _largest(offsets) > _REGULARISATION_SHARE * chains.typical_force


def _magnitude(flanks, approach):
    return jnp.abs(approach) + jnp.abs(flanks.gap)


def _largest(arrays) -> Scalar:
    return jnp.max(jnp.abs(jnp.concatenate([jnp.ravel(array) for array in arrays])), initial=0.0)


class _Bracket(NamedTuple):
    """Shares of a step between which the energy's slope along it changes sign, with the slopes."""

    share: Scalar
    low: Scalar
    low_slope: Scalar
    high: Scalar
    high_slope: Scalar
    cuts: Int[Array, ""]


class _Search(NamedTuple):
    """State of the search: the last accepted point, the step from it, the next share."""

    point: _Point
    error: Scalar
    steps: Int[Array, ""]
    #: Step from the point, and whether the next step has to be computed.
    step: State
    arrived: Bool[Array, ""]
    bracket: _Bracket


def _full_step(slope: Scalar) -> _Bracket:
    one, none = jnp.ones_like(slope), jnp.zeros_like(slope)
    return _Bracket(one, none, slope, one, slope, jnp.zeros_like(slope, dtype=int))


def _next_share(bracket: _Bracket, slope: Scalar) -> _Bracket:
    """The next share of a step that overshot, by false position and bisection in turn."""
    share, low, low_slope, high, high_slope, cuts = bracket
    overshot = slope > 0
    low, low_slope = jnp.where(overshot, low, share), jnp.where(overshot, low_slope, slope)
    high, high_slope = jnp.where(overshot, share, high), jnp.where(overshot, slope, high_slope)
    secant = low + (high - low) * low_slope / (low_slope - high_slope)
    # A tooth that has just closed is stiffer than its regularising spring by orders of magnitude:
    # search by decades too.
    half = jnp.where(low > 0, (low + high) / 2, high / 10)
    share = jnp.where(cuts % 2 == 0, secant, half)
    return _Bracket(share, low, low_slope, high, high_slope, cuts + 1)


def _select(condition: Bool[Array, ""], first, second):
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), first, second)


def _search(
    chains: Chains, control: Control, value: Scalar, tolerance: float, max_steps: int
) -> tuple[State, Scalar, Scalar]:
    """Newton steps and their cuts in one loop, so that each part is compiled once."""
    # Near rounding a cut follows noise, and in a batch all designs would wait for it.
    worth_cutting = max(tolerance, 1e3 * default_tolerance(value.dtype))

    def goes_on(search: _Search):
        # The first step leads from springs to teeth.
        return (search.error > tolerance) & (search.steps <= max_steps)

    def body(search: _Search) -> _Search:
        start = search.point
        right = jax.tree.map(jnp.negative, start.residual)
        newton_step = solve_linear(chains, (start.screw, start.nut), control, right)
        step = _select(search.arrived, newton_step, search.step)
        first = _energy_slope(start.residual, step)
        bracket = _select(search.arrived, _full_step(first), search.bracket)
        point = _point(chains, _moved(start.state, step, bracket.share), control, value)
        slope = _energy_slope(point.residual, step)
        limit = _SLOPE_LEFT * jnp.abs(first)
        outside = (slope > limit) | ((slope < -limit) & (bracket.cuts > 0))
        worthwhile = (search.error > worth_cutting) & (search.steps > 0) & (first < 0)
        cuts_left = (bracket.cuts < _MOST_CUTS) & (bracket.high > bracket.low)
        accepted = ~(worthwhile & outside & cuts_left)
        return _Search(
            _select(accepted, point, start),
            jnp.where(accepted, _error(chains, point), search.error),
            jnp.where(accepted, search.steps + 1, search.steps),
            step,
            accepted,
            _next_share(bracket, slope),
        )

    start = _start(chains, control, value)
    search = _Search(
        start,
        jnp.full_like(value, jnp.inf),
        jnp.zeros_like(value, dtype=int),
        start.state,
        jnp.ones_like(value, dtype=bool),
        _full_step(jnp.zeros_like(value)),
    )
    search = jax.lax.while_loop(goes_on, body, search)
    return search.point.state, search.error, (search.steps - 1).astype(value.dtype)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2))
def _find(control, tolerance, max_steps, chains, value):
    return _search(chains, control, value, tolerance, max_steps)


@_find.defjvp
def _find_jvp(control, tolerance, max_steps, primals, tangents):
    chains, value = primals
    state, error, count = _find(control, tolerance, max_steps, chains, value)
    _, moved = jax.jvp(lambda c, v: residual(c, state, control, v), primals, tangents)
    change = response(chains, state, control, value, jax.tree.map(jnp.negative, moved))
    zero = jnp.zeros_like(error)
    return (state, error, count), (change, zero, zero)


def response(chains: Chains, state: State, control: Control, value: Scalar, right: State) -> State:
    """Change of the unknowns for a right-hand side of the linearised balance, differentiable.

    The system is symmetric, so reverse mode solves it with the same elimination.
    """

    # One vector: reverse mode needs every part of the right-hand side to be linear in the
    # differentiated numbers, and some parts do not depend on them.
    flat, unravel = ravel_pytree(right)

    def linear(vector):
        product = jax.jvp(
            lambda s: residual(chains, s, control, value), (state,), (unravel(vector),)
        )
        return ravel_pytree(product[1])[0]

    def solve(_, vector):
        teeth = forces_and_slopes(chains, state)
        return ravel_pytree(solve_linear(chains, teeth, control, unravel(vector)))[0]

    return unravel(jax.lax.custom_linear_solve(linear, flat, solve, symmetric=True))


@jax.custom_jvp
def linear_response(chains: Chains, state: State, right: State) -> State:
    """Change of the unknowns at a prescribed load for a right-hand side A x = y.

    Differentiable in everything: A dx = dy − dA x. Derivatives of A are traced only where they are
    needed.
    """
    return solve_linear(chains, forces_and_slopes(chains, state), "load", right)


@linear_response.defjvp
def _linear_response_jvp(primals, tangents):
    chains, state, right = primals
    solution = linear_response(chains, state, right)
    # A does not depend on the load itself.
    load = jnp.zeros_like(chains.regularisation)

    def product(chains, state):
        return jax.jvp(lambda s: residual(chains, s, "load", load), (state,), (solution,))[1]

    _, matrix_change = jax.jvp(product, (chains, state), tangents[:2])
    right_change = jax.tree.map(lambda a, b: a - b, tangents[2], matrix_change)
    return solution, response(chains, state, "load", load, right_change)


def equilibrium(
    chains: Chains,
    value: Scalar,
    control: Control = "load",
    *,
    tolerance: float | None = None,
    max_steps: int = 60,
) -> Equilibrium:
    """Find the state in which all threads balance.

    **Arguments:**

    - `chains`: the chains.
    - `value`: prescribed axial load [N], deflection [m], or force in the spacer [N].
    - `control`: which of the three is prescribed.
    - `tolerance`: on the unbalanced force over the largest force; default 1e-12 (1e-5 in single
      precision). Rounding of approaches is allowed on top.
    - `max_steps`: Newton steps allowed.

    **Returns:** an `Equilibrium`, differentiable in `chains` and `value` in either mode; in a
    trace its `result` tells whether it is valid.
    """
    if tolerance is None:
        tolerance = default_tolerance(value.dtype)
    state, error, count = _find(control, tolerance, max_steps, chains, value)
    finite = jnp.isfinite(error)
    result = jnp.where(_carried_by_regularisation(chains, state), 3, 0)
    result = jnp.where(finite, jnp.where(error <= tolerance, result, 1), 2)
    return Equilibrium(state, error, count.astype(jnp.int32), result.astype(jnp.int32))
