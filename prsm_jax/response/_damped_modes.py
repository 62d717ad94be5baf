"""Damped modes of a network with a few dashpots: eigenvalues, exact and of first order.

In the modes of the undamped network the motion a of each mode follows

    (λ² + ω_j²) a_j + g_jᴴ f = 0,  f = λ diag(c) Σ g_j a_j,

with the elongations g_j of the dashpots and their forces f. With a_i = 1 the unknowns of a damped
mode that begins as mode i are its eigenvalue λ and the forces, so that Newton's iteration has as
many unknowns as dashpots, and one more. Dashpots of any strength are in proportion: forces are
those of a scale of damping, and a dashpot that is infinitely strong is a constraint.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Complex, Float

from ..fields import Scalar
from ..numerics import above_or_nan
from ..vibration import RIGID_SHARE, SpringModes, SpringNetwork, clusters

#: Damping grows in this many equal ratios from a weak one to its own, with this many iterations at
#: each.
_STEPS, _ITERATIONS = 48, 3
#: Damping ratio at which an eigenvalue of first order is the start.
_WEAK = 1e-3
#: Last iterations, which carry the derivatives up to the third.
_LAST = 2


class DampedModes(NamedTuple):
    """Damped modes in the order of the undamped ones."""

    #: Damping ratio −Re λ/|λ| [1]; 0 for a rigid motion. Of a repeated root the one of first order.
    ratios: Float[Array, " modes"]
    #: Damping ratio of first order, φᴴ C φ / 2ω; of a repeated root the mean.
    first_order: Float[Array, " modes"]
    #: λ [1/s]; 0 for a rigid motion.
    eigenvalues: Complex[Array, " modes"]
    #: Whether each mode still vibrates and was found; the others have the ratio of first order.
    found: Bool[Array, " modes"]


def _solved(matrix: Complex[Array, "n n"], right: Complex[Array, " n"]) -> Complex[Array, " n"]:
    """For two dashpots Cramer's rule: a library call takes seconds to compile."""
    if right.shape[0] != 3:
        return jnp.linalg.solve(matrix, right)
    first, second, third = matrix.T
    plane = jnp.cross(second, third)
    found = jnp.stack(
        [
            jnp.sum(right * plane),
            jnp.sum(first * jnp.cross(right, third)),
            jnp.sum(first * jnp.cross(second, right)),
        ]
    )
    return found / jnp.sum(first * plane)


class _Problem(NamedTuple):
    """Equations of the mode that is followed; time in units of 1/ω, damping of the scale σ."""

    #: All complex. ω of the mode, and elongations of the dashpots by it.
    omega: Complex[Array, ""]
    own: Complex[Array, " dashpots"]
    #: ω_j², 0 for the one that is followed; their elongations, 0 for the same.
    squares: Complex[Array, " modes"]
    others: Complex[Array, "dashpots modes"]
    #: c and σ.
    damping: Complex[Array, " dashpots"]
    scale: Complex[Array, ""]

    def residual(self, unknown: Complex[Array, " n"]) -> Complex[Array, " n"]:
        """Of the unknowns λ/ω and p = f/(ω σ)."""
        value, force = unknown[0], unknown[1:]
        omega, scale = self.omega, self.scale
        pushed = scale * omega * (self.others.conj().T @ force)
        moved = self.own - self.others @ (pushed / ((omega * value) ** 2 + self.squares))
        first = value**2 + 1 + scale / omega * jnp.sum(self.own.conj() * force)
        whole = scale + jnp.abs(self.damping).astype(scale.dtype)
        rest = self.damping / whole * value * moved - scale / whole * force
        return jnp.concatenate([first[None], rest])

    def improved(self, unknown: Complex[Array, " n"]) -> Complex[Array, " n"]:
        """After one iteration by Newton."""
        slope = jax.jacfwd(self.residual, holomorphic=True)(unknown)
        return unknown - _solved(slope, self.residual(unknown))


def _followed(of: _Problem, weakest: Scalar) -> tuple[Complex[Array, " n"], Bool[Array, ""]]:
    """λ/ω and forces of one mode, from weak damping to its own, and whether they were found."""
    fixed = jax.lax.stop_gradient(of)
    start = jnp.concatenate([jnp.full((1,), 1j, fixed.own.dtype), jnp.zeros_like(fixed.own)])
    shares = weakest ** jnp.linspace(1.0, 0.0, _STEPS, dtype=weakest.dtype)

    def stronger(unknown, share):
        damping = share.astype(fixed.damping.dtype) * fixed.damping
        return fixed._replace(damping=damping).improved(unknown), None

    unknown, _ = jax.lax.scan(stronger, start, jnp.repeat(shares, _ITERATIONS))
    before = jax.lax.stop_gradient(unknown)
    after = before
    for _ in range(_LAST):
        # The last iterations differentiate the equations, not the way to their solution.
        after = of.improved(after)
    change = jnp.abs(jax.lax.stop_gradient(after)[0] - before[0])
    accuracy = 1e-9 if weakest.dtype == jnp.float64 else 1e-3
    return after, (change <= accuracy * jnp.abs(before[0])) & (jnp.imag(before[0]) > 1e-3)


def damped_modes(modes: SpringModes, dashpots: SpringNetwork) -> DampedModes:
    """Eigenvalues of the modes of a network that has a few dashpots.

    First order, with mass-normalised shapes: `ζ_i = φ_iᴴ C φ_i / 2 ω_i = Σ c |g φ_i|² / 2 ω_i`
    (Lord Rayleigh, The Theory of Sound, section 102), at a repeated root the mean over its
    members: the trace of C on their subspace. Exact, the eigenvalue λ of `λ² M + λ C + K` that
    grows out of `i ω_i` as the damping does; ratio and frequency follow from it.

    **Arguments:**

    - `modes`: modes of a network.
    - `dashpots`: two or more, with a damping constant [N·s/m] for each row in place of a stiffness,
      of the same degrees of freedom.
    """
    omega, squares = modes.angular_frequencies, modes.eigenvalues
    elastic = ~(omega <= RIGID_SHARE * jnp.max(omega))
    moved = dashpots.rows @ modes.shapes
    damping = dashpots.stiffness
    sizes = jnp.real(moved) ** 2 + jnp.imag(moved) ** 2
    together = clusters(squares)
    members = together.astype(omega.dtype)
    number = jnp.sum(members, axis=1)
    safe = jnp.where(elastic, omega, 1.0)
    mean = members @ (damping @ sizes) / number
    first = jnp.where(elastic, mean / (2 * safe), 0.0)

    kind = jnp.complex128 if omega.dtype == jnp.float64 else jnp.complex64
    largest = jax.lax.stop_gradient(jnp.max(jnp.sum(sizes, axis=0)))
    couples = above_or_nan(largest)
    strength = jnp.max(jnp.abs(damping) @ sizes)

    def follow(at: Array, own_omega: Scalar):
        own = at == jnp.arange(len(omega))
        scale = own_omega / jnp.where(couples, largest, 1.0)
        parts = (
            own_omega,
            moved[:, at],
            # A rigid motion is one of frequency 0, without the rounding of it.
            jnp.where(elastic & ~own, squares, 0.0),
            jnp.where(own[None, :], jnp.zeros_like(moved), moved),
            damping,
            jax.lax.stop_gradient(scale),
        )
        problem = _Problem(*(part.astype(kind) for part in parts))
        weak = _WEAK * 2 * own_omega / jnp.where(above_or_nan(strength), strength, 1.0)
        weak = jnp.where(above_or_nan(strength), jnp.minimum(weak, 1.0), 1.0)
        unknown, found = _followed(problem, jax.lax.stop_gradient(weak))
        return unknown[0] * own_omega.astype(kind), found

    values, found = jax.vmap(follow)(jnp.arange(len(omega)), safe)
    finite = jnp.isfinite(jnp.abs(jax.lax.stop_gradient(values)))
    twice = jnp.abs(values[:, None] - values[None, :]) <= 1e-9 * jnp.abs(values)[:, None]
    pairs = twice & ~together & elastic[None, :]
    alone = (number == 1) & elastic
    found = found & finite & ~jnp.any(pairs, axis=1)
    light = jax.lax.complex(-first * safe, safe)
    values = jnp.where(alone & found, values, jnp.where(elastic, light, jnp.zeros_like(light)))
    size = jnp.abs(jnp.where(elastic, values, jnp.ones_like(values)))
    exact = jnp.where(alone & found, -jnp.real(values) / size, first)
    return DampedModes(exact, first, values, found | ~elastic | (number > 1))
