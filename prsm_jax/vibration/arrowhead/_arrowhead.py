"""Modes of up to three bodies on springs around one roller coordinate, and their derivatives.

All numbers are scalars rather than small matrices: under `jax.vmap` each becomes one contiguous
array and the whole analysis a few fused loops over designs.
"""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp

from ...fields import Scalar
from ._poles import added, in_given_order, rounding, sorted_poles
from ._secular import pole_distances, root_values, secular_roots, support_distances

_BODIES = 3


class ArrowheadModes(NamedTuple):
    """Eigenvalues ascending, and for each of them its mass-normalised shape and mesh stretches.

    The shape lists the bodies and, last, the roller; a mesh spring stretches by
    `factor · body + roller`.
    """

    values: tuple[Scalar, ...]
    shapes: tuple[tuple[Scalar, ...], ...]
    stretches: tuple[tuple[Scalar, ...], ...]


def _padded(support, mesh, mass, factor):
    """Add missing bodies, without mesh and with eigenvalues above all others."""
    support, mesh, (*mass, roller) = list(support), list(mesh), list(mass)
    missing = _BODIES - len(mesh)
    if missing:
        on_support = [k / m for k, m in zip(support, mass, strict=True)]
        on_mesh = [k * (factor * factor / m + 1 / roller) for k, m in zip(mesh, mass, strict=True)]
        # The sum of all roots bounds the largest one.
        bound = sum(on_support) + sum(on_mesh)
        bound = jnp.where(bound > 0, bound, 1.0)
        support += [(2.0 + i) * bound * roller for i in range(missing)]
        mesh += [jnp.zeros_like(roller)] * missing
        mass += [roller] * missing
    return support, mesh, [*mass, roller]


@jax.custom_jvp
def arrowhead_modes(
    support: tuple[Scalar, ...],
    mesh: tuple[Scalar, ...],
    mass: tuple[Scalar, ...],
    factor: Scalar,
) -> ArrowheadModes:
    """Modes of one to three bodies, each on a support and on a mesh spring to a common roller.

    With elongations `e_j = F q_j + q_R` the eigenvalues are
    `λ_i = Σ K_j q_ji² + Σ k_j e_ji²`. Derivatives, of any order, are
    `dλ_i = φ_iᵀ (dK − λ_i dM) φ_i`, summed over springs, and
    `dφ_i = Σ_{a≠i} φ_a φ_aᵀ (dK − λ_i dM) φ_i / (λ_i − λ_a) − φ_i (φ_iᵀ dM φ_i)/2`, terms of
    equal eigenvalues omitted.

    **Arguments:**

    - `support`, `mesh`: stiffnesses K_j and k_j, one per body [N/m].
    - `mass`: of the bodies and, last, of the roller coordinate [kg].
    - `factor`: F; its square is the number of rollers that take part.

    **Returns:** the modes; eigenvalues are NaN if a stiffness is negative or a mass not positive.
    """
    return _modes(support, mesh, mass, factor)


# Traced once for all stages and mechanisms; the program is the same.
@functools.partial(jax.jit, inline=True)
def _modes(
    support: tuple[Scalar, ...],
    mesh: tuple[Scalar, ...],
    mass: tuple[Scalar, ...],
    factor: Scalar,
) -> ArrowheadModes:
    count = len(mesh)
    poles = sorted_poles(*_padded(support, mesh, mass, factor), factor)
    roots = secular_roots(poles)
    values = root_values(poles, roots)
    unit = 1 / jnp.where(poles.scale > 0, poles.scale, 1.0)
    distances = pole_distances(poles, roots)
    reduced = tuple(value * unit for value in values)
    supports = support_distances(poles, reduced, distances)
    couplings = [jnp.sqrt(weight) for weight in poles.weight]
    inverse = [1 / jnp.sqrt(m) for m in mass]
    # A body without a mesh spring: the elongation follows from the shape instead.
    ratios = [factor * k * w * inverse[-1] * unit for k, w in zip(mesh, inverse, strict=False)]
    unmeshed = [ratio * ratio < rounding(unit) ** 3 for ratio in ratios]
    shapes, stretches = [], []
    for i in range(count + 1):
        # Scaled by the distance of the nearest pole, so that no component overflows.
        nearest = jnp.abs(distances[i][0])
        for distance in distances[i][1:]:
            nearest = jnp.minimum(nearest, jnp.abs(distance))
        amplitude = [nearest / distance for distance in distances[i]]
        bodies = [-b * r for b, r in zip(couplings, amplitude, strict=True)]
        squares = nearest * nearest + sum(y * y for y in bodies)
        norm = 1 / jnp.sqrt(squares)
        ordered = in_given_order(poles, bodies)[:count]
        shape = [y * norm * w for y, w in zip(ordered, inverse, strict=False)]
        shapes.append((*shape, nearest * norm * inverse[-1]))
        stretch = in_given_order(
            poles, [r * n for r, n in zip(amplitude, supports[i], strict=True)]
        )
        stretches.append(
            tuple(
                jnp.where(
                    unmeshed[j],
                    factor * shapes[i][j] + shapes[i][-1],
                    stretch[j] * norm * inverse[-1],
                )
                for j in range(count)
            )
        )
    return ArrowheadModes(values[: count + 1], tuple(shapes), tuple(stretches))


@arrowhead_modes.defjvp
def _arrowhead_modes_jvp(primals, tangents):
    modes = arrowhead_modes(*primals)
    values, shapes, stretches = modes
    mesh, d_factor = primals[1], tangents[3]
    d_support, d_mesh, d_mass = tangents[:3]
    count, bodies = len(values), range(len(mesh))

    def moved(a: int, i: int) -> Scalar:
        """φ_aᵀ dK φ_i."""
        terms = []
        for j in bodies:
            terms.append(d_support[j] * (shapes[a][j] * shapes[i][j]))
            terms.append(d_mesh[j] * (stretches[a][j] * stretches[i][j]))
            crossed = shapes[a][j] * stretches[i][j] + stretches[a][j] * shapes[i][j]
            terms.append(d_factor * (mesh[j] * crossed))
        return added(terms)

    def weighed(a: int, i: int) -> Scalar:
        """φ_aᵀ dM φ_i."""
        return added(
            d * (left * right) for d, left, right in zip(d_mass, shapes[a], shapes[i], strict=True)
        )

    d_values, d_shapes, d_stretches = [], [], []
    for i in range(count):
        own_mass = weighed(i, i)
        d_values.append(moved(i, i) - values[i] * own_mass)
        mixing = []
        for a in range(count):
            if a == i:
                mixing.append(-own_mass / 2)
                continue
            gap = values[i] - values[a]
            distinct = jnp.abs(gap) > _same(values[i], values[a])
            projected = moved(a, i) - values[i] * weighed(a, i)
            share = projected / jnp.where(distinct, gap, 1.0)
            mixing.append(jnp.where(distinct, share, 0.0))
        d_shapes.append(
            tuple(
                added(mixing[a] * shapes[a][c] for a in range(count)) for c in range(len(shapes[i]))
            )
        )
        d_stretches.append(
            tuple(
                d_factor * shapes[i][j] + added(mixing[a] * stretches[a][j] for a in range(count))
                for j in bodies
            )
        )
    return modes, ArrowheadModes(tuple(d_values), tuple(d_shapes), tuple(d_stretches))


def _same(left: Scalar, right: Scalar) -> Scalar:
    """Largest difference of two eigenvalues that count as equal."""
    return 8 * rounding(left) * jnp.maximum(left, right)
