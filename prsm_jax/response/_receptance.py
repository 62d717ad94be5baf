"""Receptances of a spring network: by direct solution, and as a sum over modes."""

from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Complex, Float

from ..fields import Scalar
from ..mechanism import DampingLaw
from ..numerics import Factors, factorise, substitute, substitute_transposed
from ..programs import physics
from ..vibration import SpringNetwork
from ._dissipation import AnyDamping, Dissipation, dissipation, scaled_modes

Solver: TypeAlias = Literal["direct", "modal"]
#: Frequencies solved at once; more are solved in chunks, so that memory stays bounded.
_CHUNK = 256


class Harmonic(eqx.Module):
    """Amplitudes of a steady harmonic vibration."""

    #: Complex displacement of every coordinate for every load [m].
    displacement: Complex[Array, "frequencies coordinates loads"]
    #: Whether the system is driven at a pole, so that no amplitude exists; it is then infinite.
    at_pole: Bool[Array, " frequencies"]


class _Scaled(eqx.Module):
    """A network in coordinates `√m q`, where the mass matrix is the identity."""

    stiffness: Float[Array, "n n"]
    viscous: Float[Array, "n n"] | None
    hysteretic: Float[Array, "n n"] | None
    weight: Float[Array, " n"]

    @property
    def damped(self) -> bool:
        return self.viscous is not None or self.hysteretic is not None

    def apply(self, omega: Scalar, x: Array) -> Array:
        """`(A + iH + iωC − ω²) x`."""
        dtype = x.dtype
        product = self.stiffness.astype(dtype) @ x - (omega**2).astype(dtype) * x
        if self.damped:
            losses = jnp.zeros_like(x)
            if self.viscous is not None:
                losses = losses + (omega * self.viscous).astype(dtype) @ x
            if self.hysteretic is not None:
                losses = losses + self.hysteretic.astype(dtype) @ x
            product = product + jnp.asarray(1j, dtype) * losses
        return product


def _scale(network: SpringNetwork, losses: Dissipation) -> _Scaled:
    weight = 1 / jnp.sqrt(network.mass)
    scale = weight[:, None] * weight[None, :]

    def scaled(matrix: Array | None) -> Array | None:
        return None if matrix is None else matrix.astype(scale.dtype) * scale

    return _Scaled(
        network.stiffness_matrix() * scale,
        scaled(losses.viscous),
        scaled(losses.hysteretic),
        weight,
    )


def _each(function: Callable[..., Any], *arrays: Array):
    """`function` at every frequency: all at once, or in chunks of bounded size."""
    if arrays[0].shape[0] <= _CHUNK:
        return jax.vmap(function)(*arrays)
    return jax.lax.map(lambda values: function(*values), arrays, batch_size=_CHUNK)


def _complex_dtype(dtype):
    return jnp.complex64 if dtype == jnp.float32 else jnp.complex128


def infinite(amplitude: Array, at_pole: Array) -> Array:
    """Infinity, real and positive, where no steady amplitude exists."""
    marked = jax.lax.complex(jnp.full_like(amplitude.real, jnp.inf), jnp.zeros_like(amplitude.real))
    return jnp.where(at_pole, marked, amplitude)


def _undefined(amplitude: Array, none: Array) -> Array:
    """NaN where a number of the equations is not finite."""
    return jnp.where(none, jnp.full_like(amplitude, jnp.nan), amplitude)


def magnitude(amplitude: Array) -> Array:
    """Absolute value; its derivative is 0 where the amplitude is 0."""
    moves = amplitude != 0
    size = jnp.abs(jnp.where(moves, amplitude, jnp.ones_like(amplitude)))
    return jnp.where(moves, size, 0.0)


@physics("direct_response")
def direct_response(
    network: SpringNetwork,
    omega: Float[Array, " frequencies"],
    loads: Complex[Array, "frequencies coordinates loads"],
    damping: AnyDamping | None = None,
) -> Harmonic:
    """Solve `(K + iH + iωC − ω²M) q = f` at every frequency, for any damping.

    NaN where a frequency or a number of the network is not finite; this is no pole.

    One factorisation for each frequency, in coordinates scaled by √m, and one back substitution
    for each load. No modes are needed, so repeated roots need no special case, and derivatives use
    the same factors. A pivot within rounding of zero marks a pole: an undamped system driven at a
    natural frequency, or an unsupported one at 0 Hz. All coordinates are marked, even those that
    the mode of the pole does not move.

    **Arguments:**

    - `network`: the springs and masses.
    - `omega`: circular frequencies [rad/s].
    - `loads`: complex force amplitudes [N].
    - `damping`: a law, any viscous matrix, a `Dissipation`, or `None`.
    """
    scaled = _scale(network, dissipation(network, damping))
    size = len(network.coordinates)
    real = network.mass.dtype
    kind = _complex_dtype(real) if scaled.damped else real
    rounding = size * float(jnp.finfo(real).eps)

    def at(w: Scalar, load: Complex[Array, "coordinates loads"]):
        matrix = jax.lax.stop_gradient(scaled.apply(w, jnp.eye(size, dtype=kind)))
        factors = factorise(matrix)
        # The diagonal is a difference: even if small, it has the rounding error of ω² and of A.
        largest = jnp.max(jnp.abs(scaled.stiffness)) + w**2
        # Not a number: there is no amplitude, and no verdict of a pole.
        none = ~jnp.isfinite(factors.smallest_pivot + largest)
        at_pole = (factors.smallest_pivot <= rounding * largest) & ~none
        regular = jnp.where(at_pole | none, jnp.eye(size, dtype=kind), factors.matrix)
        factors = Factors(regular, factors.order)
        right = scaled.weight[:, None].astype(load.dtype) * load

        def solved(part: Array) -> Array:
            return jax.lax.custom_linear_solve(
                lambda x: scaled.apply(w, x),
                part,
                lambda _, b: substitute(factors, b),
                lambda _, b: substitute_transposed(factors, b),
            )

        if scaled.damped:
            displacement = solved(right)
        else:
            # Real factors: half the work, and exactly in phase or antiphase with the load.
            parts = solved(jnp.concatenate([right.real, right.imag], axis=1))
            displacement = jax.lax.complex(*jnp.split(parts, 2, axis=1))
        moved = scaled.weight[:, None].astype(displacement.dtype) * displacement
        return infinite(_undefined(moved, none), at_pole), at_pole

    return Harmonic(*_each(at, omega, loads))


@physics("modal_sum")
def modal_response(
    network: SpringNetwork,
    omega: Float[Array, " frequencies"],
    loads: Complex[Array, "frequencies coordinates loads"],
    damping: AnyDamping | None = None,
) -> Harmonic:
    """As `direct_response`, by a sum over all modes, for damping that does not couple them.

    `q = Σ φ φᵀ f / (ω_k² − ω² + iL)` with the loss L of the law (`DampingLaw.modal_loss`). All
    modes are included, so no residual term is needed. One eigenproblem serves all frequencies.
    Derivatives are those of the system of equations that the sum solves: they are correct at
    repeated roots, where derivatives of single modes do not exist.

    **Arguments:** as `direct_response`; `damping` is a law or `None`.

    **Raises:** `ValueError` for a damping matrix, which in general couples the modes.
    """
    if damping is not None and not isinstance(damping, DampingLaw):
        raise ValueError(
            "a damping matrix couples the modes in general, so the sum over modes is not valid; "
            'choose method "direct", or a law of damping'
        )
    scaled = _scale(network, dissipation(network, damping))
    vectors, roots = scaled_modes(network)
    rounding = len(network.coordinates) * float(jnp.finfo(roots.dtype).eps)

    def at(w: Scalar, load: Complex[Array, "coordinates loads"]):
        elastic = roots**2 - w**2
        lost = jnp.zeros_like(roots) if damping is None else damping.modal_loss(roots, w)
        size = jnp.abs(elastic) + jnp.abs(lost)
        # Rounding errors of ω² and ω_k² are relative; for rigid motions relative to the largest.
        close = size <= rounding * (roots**2 + w**2) + rounding**2 * jnp.max(roots) ** 2
        none = ~jnp.all(jnp.isfinite(size))
        at_pole = jnp.any(close) & ~none
        unusable = at_pole | none
        divisor = jax.lax.stop_gradient(
            jax.lax.complex(jnp.where(unusable, 1.0, elastic), jnp.where(unusable, 0.0, lost))
        )
        right = scaled.weight[:, None].astype(load.dtype) * load
        basis = vectors.astype(load.dtype)

        def solve(_, b):
            return basis @ ((basis.T @ b) / divisor[:, None])

        displacement = jax.lax.custom_linear_solve(
            lambda x: scaled.apply(w, x), right, solve, symmetric=True
        )
        moved = scaled.weight[:, None].astype(displacement.dtype) * displacement
        return infinite(_undefined(moved, none), at_pole), at_pole

    return Harmonic(*_each(at, omega, loads))


def harmonic_response(
    network: SpringNetwork,
    omega: Float[Array, " frequencies"],
    loads: Complex[Array, "frequencies coordinates loads"],
    damping: AnyDamping | None = None,
    method: Solver = "direct",
) -> Harmonic:
    """Steady vibration under harmonic loads, by one of the two methods.

    **Raises:** `ValueError` for an unknown method, or damping that it does not accept.
    """
    if method == "direct":
        return direct_response(network, omega, loads, damping)
    if method == "modal":
        return modal_response(network, omega, loads, damping)
    raise ValueError(f'method is {method!r}; choose "direct" or "modal"')


def receptance_matrix(
    network: SpringNetwork,
    omega: Float[Array, " frequencies"],
    responses: tuple[str, ...],
    excitations: tuple[str, ...],
    damping: AnyDamping | None = None,
    method: Solver = "direct",
) -> tuple[Complex[Array, "frequencies responses excitations"], Bool[Array, " frequencies"]]:
    """Displacement at some coordinates per unit force at others [m/N].

    **Arguments:**

    - `network`: the springs and masses.
    - `omega`: circular frequencies [rad/s].
    - `responses`, `excitations`: coordinates by name, such as `"screw u"` and `"roller 3 u"`.
    - `damping`, `method`: as `harmonic_response`.

    **Returns:** the receptances, and whether each frequency is a pole.

    **Raises:** `ValueError` for a coordinate that does not exist.
    """
    rows = jnp.asarray([network.index(name) for name in responses])
    columns = jnp.asarray([network.index(name) for name in excitations])
    size, count = len(network.coordinates), len(excitations)
    kind = _complex_dtype(network.mass.dtype)
    unit = jnp.zeros((size, count), kind).at[columns, jnp.arange(count)].set(1.0)
    loads = jnp.broadcast_to(unit, (omega.shape[0], size, count))
    steady = harmonic_response(network, omega, loads, damping, method)
    return steady.displacement[:, rows, :], steady.at_pole
