"""Largest stress below an elliptical Hertz contact, and its position."""

import functools
from collections.abc import Callable
from typing import Annotated, Literal, TypeAlias

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...fields import In, Scalar
from ...numerics import above_or_nan, find_root_of, solve
from ...programs import physics
from ...results import Result
from ._axis_stress import axis_stress
from ._edge_stress import (
    Integrals,
    PlaneStress,
    edge_integrals,
    edge_stress,
    plane_max_shear,
    plane_tension,
    plane_von_mises,
)
from ._stress_measures import (
    max_shear_of_principal,
    max_shear_stress,
    principal_stresses,
    von_mises_of_principal,
    von_mises_stress,
)
from ._subsurface import NODES, reduced_stress

StressMeasure: TypeAlias = Literal["von_mises", "max_shear", "tension"]
AxisMeasure: TypeAlias = Literal["von_mises", "max_shear"]
_MEASURES: dict[str, Callable[[Array], Array]] = {
    "von_mises": von_mises_stress,
    "max_shear": max_shear_stress,
    "tension": lambda stress: principal_stresses(stress)[..., 0],
}
#: The same from σ_x, σ_y and τ_xy at the edge of a contact.
_PLANE: dict[str, Callable[[PlaneStress], Scalar]] = {
    "von_mises": plane_von_mises,
    "max_shear": plane_max_shear,
    "tension": plane_tension,
}
#: The same from principal stresses; stresses on the axis are principal stresses.
_OF_PRINCIPAL: dict[str, Callable[[Array, Array, Array], Array]] = {
    "von_mises": von_mises_of_principal,
    "max_shear": max_shear_of_principal,
}
#: Number of depths in a grid on the axis, and number of successively finer grids; the first is 2 b
#: wide, and the next ones as wide as two intervals of the one before.
_DEPTHS, _GRIDS = 33, 2
_FINER = 2 / (_DEPTHS - 1)
#: Largest number of Newton steps from the finest grid; three are enough to reach rounding.
_STEPS = 8
#: Number of refinements of the grid in space.
_REFINEMENTS = 8
#: Number of angles in a grid along the edge, and number of successively finer grids.
_ANGLES, _ANGLE_GRIDS = 129, 3
#: Least curvature along the edge, over the stress, that is not rounding.
_LEAST_BEND = 1e-9
#: Distance from the edge, over the semi-axes, at which grids in space have found the edge itself,
#: and the difference of stress over p₀ that is then the error of the quadrature there.
_CLOSE, _SAME = 2e-3, 3e-4


class StressPeak(Result):
    """Largest value of a stress measure, and its position."""

    #: [Pa]
    value: Annotated[Scalar, In("Pa")]
    #: (x, y, z) in the coordinates of the contact, z into the body [m].
    position: Annotated[Float[Array, "3"], In("m")]

    @property
    def depth(self) -> Scalar:
        """Depth below the surface [m]."""
        return self.position[2]


def _measure(name: str, measures: dict[str, Callable[..., Array]]) -> Callable[..., Array]:
    if name not in measures:
        raise ValueError(f"stress measure is {name!r}; choose one of {', '.join(measures)}")
    return measures[name]


def _search(
    function: Callable[..., Scalar],
    first: Float[Array, "m d"],
    spacing: Float[Array, " d"],
    *parameters: Array,
) -> Float[Array, " d"]:
    """Point of the largest value: of `first`, then of ever smaller grids about it; z stays ≥ 0.

    Without derivatives: these come from the last step of Newton's method. `first` is as many points
    as several grids have, and is searched in such parts: one loop is one program to compile.
    """
    first, parameters = jax.lax.stop_gradient((first, parameters))
    several = jax.vmap(lambda point: function(point, *parameters))
    size = spacing.size
    steps = jnp.stack(
        jnp.meshgrid(*[jnp.linspace(-1.0, 1.0, 5, dtype=first.dtype)] * size), axis=-1
    ).reshape(-1, size)
    parts = first.reshape(-1, *steps.shape)
    count = len(parts)

    def refine(k, carry):
        centre, highest = carry
        width = spacing * 0.5 ** (k - count)
        grid = centre[None] + steps * width[None]
        grid = grid.at[:, -1].set(jnp.maximum(grid[:, -1], 0.0))
        grid = jnp.where(k < count, parts[jnp.minimum(k, count - 1)], grid)
        values = several(grid)
        best = jnp.argmax(values)
        better = values[best] >= highest
        return jnp.where(better, grid[best], centre), jnp.where(better, values[best], highest)

    start = first[0], jnp.full_like(first[0, 0], -jnp.inf)
    return jax.lax.fori_loop(0, count + _REFINEMENTS, refine, start)[0]


def _moving(
    function: Callable[..., Scalar],
    maximum: Float[Array, " d"],
    spacing: Float[Array, " d"],
    *parameters: Array,
) -> tuple[Float[Array, " d"], Scalar]:
    """Newton steps from an approximate maximum; the last one also carries its derivatives.

    A step that leaves the last grid belongs to a maximum at the surface or at the edge of the
    contact; there the point is not moved, in units of the semi-axes. On the surface the depth is
    fixed.

    **Returns:** the point, and the rise of the function in the last step: 0 up to rounding, but its
    second derivatives are what the motion of the maximum adds to those of the largest value.
    """
    constants = jax.lax.stop_gradient(parameters)
    last = jnp.arange(maximum.size) == maximum.size - 1
    fixed = last & ~(maximum[-1] > 0)
    unity = jnp.eye(maximum.size, dtype=maximum.dtype)
    middle = unity[-1] / 2

    def step(point, hessian, parameters, possible=True):
        # Where there is no step there need not be a derivative of the gradient either.
        place = jnp.where(possible, point, middle)
        gradient = jax.grad(function)(place, *parameters)
        gradient = jnp.where(possible & ~fixed, gradient, 0.0)
        return -solve(jnp.where(possible, hessian, -unity), gradient), gradient

    def is_small(change):
        limit = 2 * spacing * 0.5 ** (_REFINEMENTS - 1)
        return jnp.all(jnp.isfinite(change)) & jnp.all(jnp.abs(change) <= limit)

    def closer(_, carry):
        point, _, _ = carry
        hessian = jax.hessian(function)(point, *constants)
        hessian = jnp.where(fixed[:, None] | fixed[None, :], -unity, hessian)
        change, _ = step(point, hessian, constants)
        possible = is_small(change)
        return point + jnp.where(possible, change, 0.0), hessian, possible

    # The second Hessian is taken at the maximum: its inverse gives the derivative of the position.
    start = (maximum, -unity, jnp.asarray(False))
    point, hessian, possible = jax.lax.stop_gradient(jax.lax.fori_loop(0, 2, closer, start))
    change, gradient = step(point, hessian, parameters, possible)
    return point + change, gradient @ change / 2


def _edge_peak(
    measure: Callable[[PlaneStress], Scalar],
    start: Scalar,
    *parameters: Array,
) -> tuple[Scalar, Scalar]:
    """Angle of the largest value along the edge, with the derivatives of its motion, and the value.

    Among equal values it is the one at `start`.
    """

    def at(angle: Scalar, parameters: tuple[Array, ...], integrals: Integrals) -> Scalar:
        ratio, poisson_ratio, pulled = parameters
        return measure(edge_stress(angle, ratio, poisson_ratio, pulled, integrals))

    integrals = edge_integrals(parameters[0])
    given = parameters, integrals
    constants = jax.lax.stop_gradient(given)
    several = jax.vmap(lambda angle: at(angle, *constants))
    steps = jnp.linspace(-1.0, 1.0, _ANGLES, dtype=start.dtype)
    favour = 1 + jnp.where(steps == 0, 64 * jnp.finfo(start.dtype).eps, 0.0)

    def refine(_, carry):
        centre, width = carry
        grid = centre + width * steps
        return grid[jnp.argmax(several(grid) * favour)], width * (2 / (_ANGLES - 1))

    first = jax.lax.stop_gradient(start), jnp.full_like(start, jnp.pi)
    angle, width = jax.lax.fori_loop(0, _ANGLE_GRIDS, refine, first)

    def step(angle, given):
        def slope(
            angle: Scalar, given: tuple[tuple[Array, ...], Integrals]
        ) -> tuple[Scalar, Scalar]:
            value, rise = jax.jvp(lambda x: at(x, *given), (angle,), (jnp.ones_like(angle),))
            return rise, value

        rise, _ = slope(angle, given)
        _, bend, value = jax.jvp(
            lambda x: slope(x, constants), (angle,), (jnp.ones_like(angle),), has_aux=True
        )
        # A circle without friction has the same stress all around.
        bent = bend < -_LEAST_BEND * value
        change = -jnp.where(bent, rise, 0.0) / jnp.where(bent, bend, -1.0)
        return angle + jnp.where(jnp.abs(change) <= 4 * width, change, 0.0)

    angle = step(jax.lax.stop_gradient(step(angle, constants)), given)
    return angle, at(angle, *given)


def _on_axis(name: str, depth: Scalar, ratio: Scalar, poisson_ratio: Scalar) -> Scalar:
    """Stress over p₀ at a depth in units of b, for κ = b/a."""
    one = jnp.ones_like(ratio)
    return _OF_PRINCIPAL[name](*axis_stress(depth, 1 / ratio, one, one, poisson_ratio))


def _slope_on_axis(
    name: str, arguments: tuple[Scalar, Scalar, Bool[Array, ""], Scalar], depth: Scalar
) -> tuple[Scalar, Scalar]:
    """Its derivative by the depth, which is 0 at the maximum, and the curvature; on the surface the
    distance to it.
    """
    ratio, poisson_ratio, below, surface = arguments

    def slope(depth: Scalar) -> Scalar:
        at = functools.partial(_on_axis, name, ratio=ratio, poisson_ratio=poisson_ratio)
        return jax.jvp(at, (depth,), (jnp.ones_like(depth),))[1]

    rise, bend = jax.jvp(slope, (depth,), (jnp.ones_like(depth),))
    return jnp.where(below, rise, depth - surface), jnp.where(below, bend, 1.0)


# Functions of the module, as `find_root_of` needs them.
_SLOPES = {name: functools.partial(_slope_on_axis, name) for name in _OF_PRINCIPAL}


@physics("stress_peak_on_axis")
def stress_peak_on_axis(
    semi_major: Scalar,
    semi_minor: Scalar,
    max_pressure: Scalar,
    poisson_ratio: Scalar,
    measure: AxisMeasure = "von_mises",
) -> StressPeak:
    """Largest stress of a contact without friction; it lies on the axis.

    For a circle and ν = 0.3: shear 0.310 p₀ at 0.481 a, von Mises 0.620 p₀; for a line 0.300 p₀
    at 0.786 b. No quadrature: the closed form of `axis_stress`.

    **Arguments:**

    - `semi_major`, `semi_minor`: a ≥ b [m].
    - `max_pressure`: p₀ [Pa].
    - `poisson_ratio`: ν of the body.
    - `measure`: `"von_mises"` or `"max_shear"`.

    **Returns:** a `StressPeak`, differentiable twice.

    **Raises:** `ValueError` for an unknown measure.
    """
    _measure(measure, _OF_PRINCIPAL)
    # Without a load the axes are 0, and the position in units of b is meaningless.
    loaded = above_or_nan(semi_minor)
    ratio = jnp.where(loaded, semi_minor, 1.0) / jnp.where(loaded, semi_major, 1.0)
    one = jnp.ones_like(ratio)

    constants = jax.lax.stop_gradient((ratio, poisson_ratio))
    several = jax.vmap(lambda depth: _on_axis(measure, depth, *constants))
    steps = jnp.linspace(-1.0, 1.0, _DEPTHS, dtype=ratio.dtype)

    def refine(_, carry):
        centre, width = carry
        grid = jnp.maximum(centre + width * steps, 0.0)
        return grid[jnp.argmax(several(grid))], width * _FINER

    nearest, spacing = jax.lax.fori_loop(0, _GRIDS, refine, (one, one))
    # For Poisson's ratios below about 0 it lies on the surface, where the slope need not be 0.
    below = above_or_nan(nearest, 1.5 * spacing)
    arguments = ratio, poisson_ratio, below, nearest
    tolerance = 1e3 * float(jnp.finfo(ratio.dtype).eps)
    depth, _ = find_root_of(
        _SLOPES[measure], arguments, nearest, tolerance=tolerance, max_steps=_STEPS
    )
    value = _on_axis(measure, depth, ratio, poisson_ratio)
    zero = jnp.zeros_like(depth)
    return StressPeak(max_pressure * value, jnp.stack([zero, zero, depth * semi_minor]))


@physics("stress_peak")
def stress_peak(
    semi_axes: Float[Array, "2"],
    max_pressure: Scalar,
    poisson_ratio: Scalar,
    traction: Float[Array, "2"],
    measure: StressMeasure = "von_mises",
    *,
    nodes: int = NODES,
) -> StressPeak:
    """Largest stress anywhere in a half-space under a Hertz pressure and its friction.

    With increasing friction the maximum rises from below the middle of the contact; from about μ =
    0.3 on it lies on the surface. With `measure="tension"` it is the largest tensile stress, at the
    edge of the contact: of a circle, and for friction along an axis, at its trailing point; for
    oblique friction on an ellipse elsewhere. Stresses at the edge are a closed form without
    quadrature.

    **Arguments:**

    - `semi_axes`: of the contact ellipse along x and y [m].
    - `max_pressure`: Hertz pressure in the middle [Pa].
    - `poisson_ratio`: of the half-space.
    - `traction`: shear stress over pressure, along x and y.
    - `measure`: `"von_mises"`, `"max_shear"` or `"tension"` (the largest principal stress).
    - `nodes`: as for `subsurface_stress`, which names the source of the equations.

    **Returns:** a `StressPeak`; the value is differentiable twice, the position once. A maximum
    at the edge of the contact moves with the edge and along it.

    **Raises:** `ValueError` for an unknown measure.
    """
    stress_measure = _measure(measure, _MEASURES)
    turned = semi_axes[1] > semi_axes[0]
    major, minor = jnp.max(semi_axes), jnp.min(semi_axes)
    loaded = above_or_nan(minor)
    ratio = jnp.where(loaded, minor, 1.0) / jnp.where(loaded, major, 1.0)
    order = jnp.where(turned, jnp.asarray([1, 0]), jnp.asarray([0, 1]))
    pulled = traction[order]

    def at(point: Float[Array, "3"], ratio: Scalar, poisson_ratio: Scalar, pulled: Array):
        return stress_measure(reduced_stress(point, ratio, poisson_ratio, pulled, nodes))

    parameters = ratio, poisson_ratio, pulled

    # First the section along the friction; its maximum is close enough to start grids in space.
    length = jnp.hypot(pulled[0], pulled[1])
    sliding = above_or_nan(length)
    direction = jnp.where(sliding, pulled, jnp.asarray([1.0, 0.0], pulled.dtype))
    direction = direction / jnp.where(sliding, length, 1.0)
    along, depth = jnp.meshgrid(jnp.linspace(-1.25, 1.25, 25), jnp.linspace(0.0, 1.25, 10))
    along, depth = along.ravel().astype(ratio.dtype), depth.ravel().astype(ratio.dtype)
    first = jnp.stack([direction[0] * along, direction[1] * along, depth], axis=-1)
    spacing = jnp.full((3,), 0.125, ratio.dtype)
    maximum = _search(at, first, spacing, *parameters)
    moved, risen = _moving(at, maximum, spacing, *parameters)
    inside = at(jax.lax.stop_gradient(moved), *parameters) + risen

    # Then the edge, a ridge of infinite slope that grids do not follow; trailing point first.
    trailing = jnp.arctan2(-direction[1], -direction[0])
    angle, at_edge = _edge_peak(_PLANE[measure], trailing, *parameters)
    border = jnp.stack([jnp.cos(angle), jnp.sin(angle), jnp.zeros_like(angle)])
    # Grids that end within their spacing of the edge have found a point of it, with its rounding.
    close = jnp.abs(jnp.hypot(moved[0], moved[1]) - 1) + jnp.abs(moved[2]) < _CLOSE
    edge = at_edge + jnp.where(close, _SAME, 0.0) >= inside
    value, moved = jnp.where(edge, at_edge, inside), jnp.where(edge, border, moved)

    flat = jnp.stack([moved[0] * major, moved[1] * minor])[order]
    position = jnp.concatenate([flat, moved[2:] * minor])
    # If the values are NaN, the search still returns a position.
    position = jnp.where(jnp.isnan(value), jnp.nan, position)
    return StressPeak(max_pressure * value, position)
