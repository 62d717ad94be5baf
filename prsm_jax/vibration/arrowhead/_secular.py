"""Eigenvalues of a 4×4 arrowhead of springs, each to its last digits, from its secular equation.

Three bodies on supports are tied to one roller coordinate. Eliminating the bodies leaves

`f(λ) = Σ κ_j (a_j − λ)/(d_j − λ) − λ = 0`,  d_j = a_j + g_j,

with a_j = K_j/m_j (the body on its support), g_j = F²k_j/m_j (on its mesh) and κ_j = k_j/m_R. One
root lies below the lowest pole d_j, one between each two neighbours and one above the highest.
In this form, with springs in series, no terms cancel, so soft modes keep their digits beside stiff
ones. A root is stored by its distance to an adjacent pole, so that mode shapes (which divide by
such distances) keep their digits where a root almost coincides with a pole.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...fields import Scalar
from ._poles import Poles, added, rounding, shortest
from ._quartic import quartic_roots

#: Most systems need only the first step from the closed form; three poles close together need up
#: to five.
_MOST_STEPS = 10


class Roots(NamedTuple):
    """The roots, each as the distance from the nearer end of its interval.

    Positive from the lower end, negative from the upper one. The intervals are 0 to d₁, d₁ to d₂,
    d₂ to d₃, and above d₃.
    """

    lowest: Scalar
    low: Scalar
    high: Scalar
    highest: Scalar


def _closed_form(poles: Poles) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Roots of the characteristic polynomial, whose coefficients are sums of positive terms."""
    d, a, corner = poles.place, poles.support, poles.corner
    first = added(d) + added(corner)
    second = d[0] * d[1] + (d[0] + d[1]) * d[2]
    third = d[0] * d[1] * d[2]
    fourth = jnp.zeros_like(third)
    for j, (i, k) in enumerate(((1, 2), (0, 2), (0, 1))):
        total, product = d[i] + d[k], d[i] * d[k]
        second = second + corner[j] * (a[j] + total)
        third = third + corner[j] * (a[j] * total + product)
        fourth = fourth + corner[j] * a[j] * product
    return quartic_roots(first, second, third, fourth)


def _nearer(lower: Scalar, upper: Scalar) -> Scalar:
    """A root as the shorter of its distances to the ends."""
    return jnp.where(lower < upper, lower, -upper)


def _ends(root: Scalar, width: Scalar) -> tuple[Scalar, Scalar]:
    """Distances of a root to the lower and the upper end of its interval."""
    near_lower = root >= 0
    lower = jnp.where(near_lower, root, width + root)
    upper = jnp.where(near_lower, width - root, -root)
    return lower, jnp.maximum(upper, shortest(root))


def _pole_ends(root: Scalar, width: Scalar) -> tuple[Scalar, Scalar]:
    """As `_ends` for two poles; a root never coincides with either."""
    lower, upper = _ends(root, width)
    return jnp.maximum(lower, shortest(root)), upper


def _above(pole: Scalar, mesh: Scalar, value: Scalar, distance: Scalar) -> Scalar:
    """a − λ of a pole d = a + g above λ, in the more accurate form: a − λ or (d − λ) − g."""
    return jnp.where(value < distance, pole - value, distance - mesh)


def _inner_value(poles: Poles, index: int, root: Scalar) -> Scalar:
    """λ between poles `index` and `index + 1`."""
    lower, upper = poles.place[index], poles.place[index + 1]
    return jnp.where(root >= 0, lower, upper) + root


def _begin(poles: Poles) -> Roots:
    lowest, low, high, highest = _closed_form(poles)
    d, least = poles.place, shortest(lowest)
    value = jnp.clip(lowest, 0.0, d[0])

    def inner(root: Scalar, index: int) -> Scalar:
        width = poles.gaps[index]
        lower = jnp.clip(root - d[index], least, width)
        return _nearer(lower, jnp.maximum(width - lower, least))

    return Roots(
        lowest=_nearer(value, jnp.maximum(d[0] - value, least)),
        low=inner(low, 0),
        high=inner(high, 1),
        highest=jnp.maximum(highest - d[2], least),
    )


# Each step replaces f by a simpler function with the poles beside the root (or infinity) and with
# the same f, f' and f'' at the last iterate, and solves it (Borges and Gragg 1993; Gragg, Thornton
# and Warner 1992). Convergence is cubic from any point of the interval. The weights of the poles
# beside the root are exact, so the start may lie on a pole.


def _lowest_step(poles: Poles, root: Scalar) -> Scalar:
    """`f ≈ C − A η − B/(q − η)` with q = d₁ − λ."""
    value, q = _ends(root, poles.place[0])
    d, a, g, corner, weight, gaps, *_ = poles
    far = (gaps[0] + q, gaps[0] + gaps[1] + q)
    inverse = [1 / t for t in far]
    bend = [weight[j + 1] * inverse[j] * inverse[j] for j in (0, 1)]
    others = -value
    for j in (0, 1):
        others = others + corner[j + 1] * _above(a[j + 1], g[j + 1], value, far[j]) * inverse[j]
    residual = q * others + corner[0] * _above(a[0], g[0], value, q)
    cubic = bend[0] * inverse[0] + bend[1] * inverse[1]
    pole = weight[0] + q * q * q * cubic
    slope = 1 + bend[0] * (1 - q * inverse[0]) + bend[1] * (1 - q * inverse[1])
    constant = others + corner[0] + q * q * cubic
    middle = constant + slope * q
    tilt = constant - slope * q
    discriminant_root = jnp.sqrt(tilt * tilt + 4 * slope * pole)
    positive = middle >= 0
    change = jnp.where(positive, 2 * residual, middle - discriminant_root) / jnp.where(
        positive, middle + discriminant_root, 2 * slope
    )
    raised = jnp.clip(value + change, 0.0, d[0])
    return _nearer(raised, jnp.clip(q - change, shortest(q), d[0] + shortest(q)))


def _inner_step(poles: Poles, index: int, root: Scalar) -> Scalar:
    """`f ≈ C + A/(p + η) − B/(q − η)` with p = λ − d_left and q = d_right − λ."""
    p, q = _pole_ends(root, poles.gaps[index])
    _, a, g, corner, weight, gaps, *_ = poles
    left, right, other = index, index + 1, 2 - 2 * index
    width = gaps[index]
    share = 1 / width
    value = _inner_value(poles, index, root)
    if other > right:
        far = q + gaps[1]
        inverse = 1 / far
        others = corner[other] * _above(a[other], g[other], value, far) * inverse - value
        bend = weight[other] * inverse * inverse
        near_left, near_right = 1 - q * inverse, 1 + p * inverse
    else:
        far = p + gaps[0]
        inverse = 1 / far
        others = corner[other] * (far + g[other]) * inverse - value
        bend = weight[other] * inverse * inverse
        near_left, near_right = 1 + q * inverse, 1 - p * inverse
    from_left = corner[left] * p + weight[left]
    from_right = corner[right] * _above(a[right], g[right], value, q)
    both = p * q
    residual = both * others + from_left * q + from_right * p
    on_left = (1 + bend * near_left) * share
    on_right = (1 + bend * near_right) * share
    constant = others + corner[left] + corner[right] - p * p * on_left + q * q * on_right
    middle = from_left - from_right - q * corner[left] + p * corner[right] - (q - p) * others
    middle = middle + both * (on_left * p + on_right * q)
    discriminant_root = jnp.sqrt(jnp.maximum(middle * middle + 4 * constant * residual, 0.0))
    positive = middle >= 0
    divisor = jnp.where(positive, middle + discriminant_root, 2 * constant)
    change = jnp.where(positive, 2 * residual, discriminant_root - middle)
    change = change / jnp.where(divisor == 0, 1.0, divisor)
    least = shortest(p)
    return _nearer(jnp.clip(p + change, least, width), jnp.clip(q - change, least, width))


def _highest_step(poles: Poles, p: Scalar) -> Scalar:
    """`f ≈ C − A η + B/(p + η)` with p = λ − d₃."""
    d, _, g, corner, weight, gaps, *_ = poles
    value = d[2] + p
    far = (p + gaps[1] + gaps[0], p + gaps[1])
    inverse = [1 / t for t in far]
    bend = [weight[j] * inverse[j] * inverse[j] for j in (0, 1)]
    others = -value
    for j in (0, 1):
        others = others + corner[j] * (far[j] + g[j]) * inverse[j]
    residual = p * others + corner[2] * p + weight[2]
    cubic = bend[0] * inverse[0] + bend[1] * inverse[1]
    pole = weight[2] + p * p * p * cubic
    slope = 1 + bend[0] * (1 - p * inverse[0]) + bend[1] * (1 - p * inverse[1])
    constant = others + corner[2] - p * p * cubic
    middle = slope * p - constant
    total = slope * p + constant
    discriminant_root = jnp.sqrt(total * total + 4 * slope * pole)
    positive = middle >= 0
    change = jnp.where(positive, 2 * residual, discriminant_root - middle) / jnp.where(
        positive, middle + discriminant_root, 2 * slope
    )
    return jnp.maximum(p + change, shortest(p))


# Traced once for all of its calls, not once for each; the program is the same.
@functools.partial(jax.jit, inline=True)
def _step(poles: Poles, roots: Roots) -> Roots:
    return Roots(
        lowest=_lowest_step(poles, roots.lowest),
        low=_inner_step(poles, 0, roots.low),
        high=_inner_step(poles, 1, roots.high),
        highest=_highest_step(poles, roots.highest),
    )


@functools.partial(jax.jit, inline=True)
def _settled(poles: Poles, before: Roots, after: Roots) -> Bool[Array, ""]:
    """Whether the next step would be below rounding of the distances to the nearest poles."""
    first, second = poles.gaps
    lowest = _ends(after.lowest, poles.place[0])[1]
    low, high = _pole_ends(after.low, first), _pole_ends(after.high, second)

    def change(old: Scalar, new: Scalar, width: Scalar) -> Scalar:
        from_lower, from_upper = _ends(old, width)
        return jnp.where(new >= 0, new - from_lower, new + from_upper)

    changes = (
        change(before.lowest, after.lowest, poles.place[0]),
        change(before.low, after.low, first),
        change(before.high, after.high, second),
        after.highest - before.highest,
    )
    near = (lowest, jnp.minimum(*low), jnp.minimum(*high), after.highest)
    wide = (
        lowest + first,
        jnp.minimum(first, low[1] + second),
        jnp.minimum(second, high[0] + first),
        after.highest + second,
    )
    settled = jnp.ones_like(first, bool)
    for moved, close, far in zip(changes, near, wide, strict=True):
        step = jnp.abs(moved)
        settled &= step * step * step <= rounding(step) * close * close * far
    return settled


def secular_roots(poles: Poles) -> Roots:
    """The four roots: closed form, one step, and more steps until no root changes."""
    start = _begin(poles)
    first = _step(poles, start)

    def moving(carry):
        _, settled, steps = carry
        return ~settled & (steps < _MOST_STEPS)

    def again(carry):
        roots, _, steps = carry
        moved = _step(poles, roots)
        return moved, _settled(poles, roots, moved), steps + 1

    return jax.lax.while_loop(moving, again, (first, _settled(poles, start, first), 1))[0]


def root_values(poles: Poles, roots: Roots) -> tuple[Scalar, ...]:
    """λ [1/s²], ascending; exactly zero for a rigid motion."""
    values = (
        _ends(roots.lowest, poles.place[0])[0],
        _inner_value(poles, 0, roots.low),
        _inner_value(poles, 1, roots.high),
        poles.place[2] + roots.highest,
    )
    rigid = rounding(poles.scale) ** 3
    return tuple(jnp.where(value <= rigid, 0.0, value) * poles.scale for value in values)


def pole_distances(poles: Poles, roots: Roots) -> tuple[tuple[Scalar, ...], ...]:
    """d_j − λ_i for each root i and sorted pole j, with a small relative error."""
    first, second = poles.gaps
    _, q = _ends(roots.lowest, poles.place[0])
    low_left, low_right = _pole_ends(roots.low, first)
    high_left, high_right = _pole_ends(roots.high, second)
    p = roots.highest
    return (
        (q, q + first, q + first + second),
        (-low_left, low_right, low_right + second),
        (-(high_left + first), -high_left, high_right),
        (-(p + second + first), -(p + second), -p),
    )


def support_distances(
    poles: Poles, values: tuple[Scalar, ...], distances: tuple[tuple[Scalar, ...], ...]
) -> tuple[tuple[Scalar, ...], ...]:
    """a_j − λ_i, for each root i (divided by the scale) and sorted body j, as in the equation."""
    return tuple(
        tuple(
            jnp.where(distance > 0, _above(a, g, value, distance), distance - g)
            for a, g, distance in zip(poles.support, poles.mesh, row, strict=True)
        )
        for value, row in zip(values, distances, strict=True)
    )
