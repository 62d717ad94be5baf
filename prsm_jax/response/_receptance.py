"""Receptances of a spring network: by direct solution, and as a sum over modes."""

from collections.abc import Callable
from functools import partial
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
from ._dissipation import AnyDamping, Dissipation, dissipation
from ._poles import ScaledModes, anywhere, modes_of, rounding

Solver: TypeAlias = Literal["direct", "modal"]
#: Frequencies solved at once; more are solved in chunks, so that memory stays bounded.
_CHUNK = 256
#: Modes are separated from undamped equations below this multiple of the rounding of a pivot. In
#: double precision the factors then lose at most 13 of 16 digits to a mode that is not separated.
_NEAR = 1e3
#: The same in single precision, whose rounding is large: else many frequencies would be near one.
_NEAR_SINGLE = 10.0


class Harmonic(eqx.Module):
    """Amplitudes of a steady harmonic vibration."""

    #: Complex displacement of every coordinate for every load, without the undamped modes that are
    #: driven at their natural frequency [m].
    limit: Complex[Array, "frequencies coordinates loads"]
    #: Residue Σ φ φᵀ f of these modes [N/kg]: the displacement is `limit + residue/(ω_k² − ω²)`. 0
    #: without such modes; NaN where no single mode is undamped, but several together are.
    residue: Complex[Array, "frequencies coordinates loads"]

    @property
    def infinite(self) -> Bool[Array, "*batch frequencies coordinates loads"]:
        """Whether a load drives undamped modes at their frequency, and they move the coordinate."""
        return self.residue != 0

    @property
    def displacement(self) -> Complex[Array, "*batch frequencies coordinates loads"]:
        """Complex displacement [m]; infinite where no amplitude exists."""
        return infinite(self.limit, self.infinite)

    @property
    def at_pole(self) -> Bool[Array, "*batch frequencies"]:
        """Whether any displacement is infinite."""
        return jnp.any(self.infinite, axis=(-2, -1))


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

    def losses(self, omega: Scalar) -> Float[Array, "n n"]:
        """`H + ωC`."""
        total = jnp.zeros_like(self.stiffness)
        total = total if self.viscous is None else total + omega * self.viscous
        return total if self.hysteretic is None else total + self.hysteretic


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
    for each load. Away from poles no modes are needed, so repeated roots need no special case, and
    derivatives use the same factors. Equations that are singular within rounding mark a possible
    pole: an undamped system driven near a natural frequency, or an unsupported one near 0 Hz. Only
    then are the modes found. Those within rounding of the equations are separated from them,
    `q = q₀ + Σ φ φᵀ f / (ω_k² − ω²)`, where q₀ solves the equations for all other modes. At the
    natural frequency an amplitude is infinite if the residue `Σ φ φᵀ f` is not zero; else it is
    q₀, its limit. The derivative of a limit is that for changes after which the mode still takes no
    part; for others, such as one that breaks the symmetry, none exists.

    **Arguments:**

    - `network`: the springs and masses.
    - `omega`: circular frequencies [rad/s].
    - `loads`: complex force amplitudes [N].
    - `damping`: a law, any viscous matrix, a `Dissipation`, or `None`.
    """
    scaled = _scale(network, dissipation(network, damping))
    near = _near(scaled.weight.dtype)
    # Damping moves energy between modes: they are separated only where the equations are singular.
    close = 1.0 if scaled.damped else near

    def at(w: Scalar, load: Complex[Array, "coordinates loads"]):
        factors, least, none = _factors(scaled, w)
        possible = _singular(factors, near * least) & ~none
        factors = _regular(factors, possible | none)
        moved = _solved(scaled, w, load, factors, lambda b: b, jnp.zeros_like)
        return _undefined(moved, none), possible

    displacement, possible = _each(at, omega, loads)

    def separated():
        modes = modes_of(network)
        found, residue = _each(partial(_separated, scaled, modes, close), omega, loads)
        # Elsewhere exactly the direct solution, whatever happens at other frequencies or designs.
        changed = possible[:, None, None]
        return jnp.where(changed, found, displacement), jnp.where(changed, residue, 0.0)

    def unchanged():
        return displacement, jnp.zeros_like(displacement)

    return Harmonic(*jax.lax.cond(anywhere(possible), separated, unchanged))


def _near(dtype: Any) -> float:
    return _NEAR if jnp.finfo(dtype).eps < 1e-12 else _NEAR_SINGLE


def _factors(
    scaled: _Scaled, omega: Scalar, shift: Float[Array, "n n"] | None = None
) -> tuple[Factors, Scalar, Bool[Array, ""]]:
    """Factors of the equations, the rounding of a pivot, and whether a number is not finite."""
    size = scaled.weight.shape[0]
    kind = _complex_dtype(scaled.weight.dtype) if scaled.damped else scaled.weight.dtype
    matrix = jax.lax.stop_gradient(scaled.apply(omega, jnp.eye(size, dtype=kind)))
    # The diagonal is a difference: even if small, it has the rounding error of ω² and of A.
    largest = jax.lax.stop_gradient(jnp.max(jnp.abs(scaled.stiffness)) + omega**2)
    factors = factorise(matrix if shift is None else matrix + (largest * shift).astype(kind))
    # Not a number: there is no amplitude, and no verdict of a pole.
    none = ~jnp.isfinite(factors.smallest_pivot + largest)
    return factors, rounding(scaled.weight) * largest, none


def _singular(factors: Factors, least: Scalar) -> Bool[Array, ""]:
    """Whether a pivot, or the smallest singular value, is not more than a bound.

    Pivots alone may miss it: with light rollers they are thousands of times the smallest singular
    value. The solution for a load that no symmetry makes orthogonal to a mode is not.
    """
    size = factors.matrix.shape[0]
    # Sines of integers: without symmetry, and the same in every run.
    load = jnp.sin(1.0 + jnp.arange(size, dtype=factors.matrix.real.dtype))
    found = substitute(factors, load.astype(factors.matrix.dtype)[:, None])
    regular = jnp.max(jnp.abs(found)) * least < 1.0
    # A pivot of zero gives infinity or NaN: neither is regular.
    return ~regular | (factors.smallest_pivot <= least)


def _regular(factors: Factors, replaced: Bool[Array, ""]) -> Factors:
    identity = jnp.eye(factors.matrix.shape[0], dtype=factors.matrix.dtype)
    return Factors(jnp.where(replaced, identity, factors.matrix), factors.order)


def _solved(
    scaled: _Scaled,
    omega: Scalar,
    load: Complex[Array, "coordinates loads"],
    factors: Factors,
    kept: Callable[[Array], Array],
    added: Callable[[Array], Array],
) -> Complex[Array, "coordinates loads"]:
    """Displacement: factors solve for the kept part of the load, and a part is added."""
    right = scaled.weight[:, None].astype(load.dtype) * load

    def solved(part: Array) -> Array:
        return jax.lax.custom_linear_solve(
            lambda x: scaled.apply(omega, x),
            part,
            lambda _, b: kept(substitute(factors, kept(b))) + added(b),
            lambda _, b: kept(substitute_transposed(factors, kept(b))) + added(b),
        )

    if scaled.damped:
        displacement = solved(right)
    else:
        # Real factors: half the work, and exactly in phase or antiphase with the load.
        parts = solved(jnp.concatenate([right.real, right.imag], axis=1))
        displacement = jax.lax.complex(*jnp.split(parts, 2, axis=1))
    return scaled.weight[:, None].astype(displacement.dtype) * displacement


def _separated(
    scaled: _Scaled,
    modes: ScaledModes,
    near: float,
    omega: Scalar,
    load: Complex[Array, "coordinates loads"],
) -> tuple[Complex[Array, "coordinates loads"], Complex[Array, "coordinates loads"]]:
    """Limit and residue of `Harmonic` near a pole, its modes apart from the equations."""
    vectors = modes.vectors
    largest = jax.lax.stop_gradient(jnp.max(jnp.abs(scaled.stiffness)) + omega**2)
    close = near * rounding(scaled.weight) * largest
    away = jax.lax.stop_gradient(modes.squares - omega**2)
    apart = jnp.abs(away) <= close
    lost, noise = jnp.zeros_like(away), 0.0
    if scaled.damped:
        losses = jax.lax.stop_gradient(scaled.losses(omega))
        lost = jnp.sum(vectors * (losses @ vectors), axis=0)
        noise = rounding(lost) * jnp.max(jnp.abs(losses))
        for matrix in (losses, losses.T):
            apart = apart & (jnp.sqrt(jnp.sum((matrix @ vectors) ** 2, axis=0)) <= close)
    met = apart & modes.met(omega, lost, noise)
    chosen = jnp.where(apart[None, :], vectors, 0.0)
    factors, least, none = _factors(scaled, omega, chosen @ chosen.T)
    # Singular all the same: no mode by itself is undamped, but several together are.
    singular = _singular(factors, least) & ~none
    factors = _regular(factors, singular | none)

    def kept(b: Array) -> Array:
        own = chosen.astype(b.dtype)
        return b - own @ (own.T @ b)

    def added(b: Array) -> Array:
        own = jnp.where(met[None, :], 0.0, chosen).astype(b.dtype)
        divisor = jax.lax.complex(away, lost) if scaled.damped else away
        divisor = jnp.where(apart & ~met, divisor, jnp.ones_like(divisor)).astype(b.dtype)
        return own @ ((own.T @ b) / divisor[:, None])

    moved = _undefined(_solved(scaled, omega, load, factors, kept, added), none)
    right = scaled.weight[:, None].astype(load.dtype) * load
    residue = scaled.weight[:, None].astype(load.dtype) * modes.residue(met, right)
    return moved, jnp.where(singular, jnp.nan, residue)


@physics("modal_sum")
def modal_response(
    network: SpringNetwork,
    omega: Float[Array, " frequencies"],
    loads: Complex[Array, "frequencies coordinates loads"],
    damping: AnyDamping | None = None,
) -> Harmonic:
    """As `direct_response`, by a sum over all modes, for damping that does not couple them.

    `q = Σ φ φᵀ f / (ω_k² − ω² + iL)` with the loss L of the law (`DampingLaw.modal_loss`). All
    modes are included, so no residual term is needed. At a pole the sum is over all other modes,
    and infinite where those of the pole have a residue. One eigenproblem serves all frequencies.
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
    modes = modes_of(network)
    roots = modes.roots

    def at(w: Scalar, load: Complex[Array, "coordinates loads"]):
        elastic = roots**2 - w**2
        lost = jnp.zeros_like(roots) if damping is None else damping.modal_loss(roots, w)
        none = ~jnp.all(jnp.isfinite(jnp.abs(elastic) + jnp.abs(lost)))
        met = modes.met(w, lost) & ~none
        unusable = met | none
        divisor = jax.lax.stop_gradient(
            jax.lax.complex(jnp.where(unusable, 1.0, elastic), jnp.where(unusable, 0.0, lost))
        )
        right = scaled.weight[:, None].astype(load.dtype) * load
        basis = jnp.where(met[None, :], 0.0, modes.vectors).astype(load.dtype)

        def solve(_, b):
            return basis @ ((basis.T @ b) / divisor[:, None])

        displacement = jax.lax.custom_linear_solve(
            lambda x: scaled.apply(w, x), right, solve, symmetric=True
        )
        moved = scaled.weight[:, None].astype(displacement.dtype) * displacement
        residue = scaled.weight[:, None].astype(load.dtype) * modes.residue(met, right)
        return _undefined(moved, none), residue

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

    **Returns:** the receptances, and whether any of them is infinite at each frequency.

    **Raises:** `ValueError` for a coordinate that does not exist.
    """
    rows = jnp.asarray([network.index(name) for name in responses])
    columns = jnp.asarray([network.index(name) for name in excitations])
    size, count = len(network.coordinates), len(excitations)
    kind = _complex_dtype(network.mass.dtype)
    unit = jnp.zeros((size, count), kind).at[columns, jnp.arange(count)].set(1.0)
    loads = jnp.broadcast_to(unit, (omega.shape[0], size, count))
    steady = harmonic_response(network, omega, loads, damping, method)
    return steady.displacement[:, rows, :], jnp.any(steady.infinite[:, rows, :], axis=(1, 2))
