"""The force of one pair of flanks: a thread tooth in series with a Hertz contact, unilateral."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..numerics import above_or_nan, root_above_one
from ..programs import physics

Numbers = Float[Array, "..."]


def _force(approach: Numbers, hertz: Numbers | None, tooth: Numbers | None) -> Numbers:
    """Force of flanks that touch: the root f of c f + b f^{2/3} = δ."""
    if hertz is None:
        assert tooth is not None
        return approach / tooth
    root = jnp.sqrt(approach / hertz)
    if tooth is not None:
        # With f^{1/3} = √(δ/b)/y the equation is y³ − y = c √δ / b^{3/2}.
        root = root / root_above_one(tooth * root / hertz)
    return root**3


def _slope(force: Numbers, hertz: Numbers | None, tooth: Numbers | None) -> Numbers:
    """df/dδ of flanks that touch."""
    if hertz is None:
        assert tooth is not None
        return 1 / tooth
    root = jnp.cbrt(force)
    return 3 * root / (2 * hertz if tooth is None else 3 * tooth * root + 2 * hertz)


def _where_touching(approach: Numbers) -> tuple[Array, Numbers]:
    touching = above_or_nan(approach)
    return touching, jnp.where(touching, approach, 1.0)


@physics("flank_force")
def flank_force_and_slope(
    approach: Numbers, hertz: Numbers | None, tooth: Numbers | None
) -> tuple[Numbers, Numbers]:
    """Force f [N] and slope df/dδ [N/m] of a pair of flanks; both 0 where they do not touch.

    The root of `δ = c f + b f^{2/3}`: both exact to rounding for any ratio of the two terms.

    **Arguments:**

    - `approach`: axial approach δ of the two teeth [m].
    - `hertz`: b [m/N^{2/3}], or `None` for flanks that are rigid at the contact.
    - `tooth`: c [m/N], or `None` for rigid teeth. Not both may be `None`.
    """
    touching, safe = _where_touching(approach)
    force = _force(safe, hertz, tooth)
    slope = _slope(force, hertz, tooth)
    return jnp.where(touching, force, 0.0), jnp.where(touching, slope, 0.0)


@jax.custom_jvp
def flank_force(approach: Numbers, hertz: Numbers | None, tooth: Numbers | None) -> Numbers:
    """As `flank_force_and_slope`, the force alone, with derivatives to all three [N]."""
    return flank_force_and_slope(approach, hertz, tooth)[0]


@flank_force.defjvp
def _flank_force_jvp(primals, tangents):
    approach, hertz, tooth = primals
    touching, safe = _where_touching(approach)
    force = _force(safe, hertz, tooth)
    change = tangents[0]
    if tooth is not None:
        change = change - force * tangents[2]
    if hertz is not None:
        change = change - jnp.cbrt(force) ** 2 * tangents[1]
    slope = jnp.where(touching, _slope(force, hertz, tooth), 0.0)
    return jnp.where(touching, force, 0.0), slope * change


def flank_energy(approach: Numbers, hertz: Numbers | None, tooth: Numbers | None) -> Numbers:
    """Energy stored in a pair of flanks, c f²/2 + 2/5 b f^{5/3} [J]."""
    touching, safe = _where_touching(approach)
    force = flank_force(safe, hertz, tooth)
    energy = jnp.zeros_like(force)
    if tooth is not None:
        energy = energy + tooth * force**2 / 2
    if hertz is not None:
        energy = energy + 0.4 * hertz * jnp.cbrt(force) ** 5
    return jnp.where(touching, energy, 0.0)


def flank_approach(force: Numbers, hertz: Numbers | None, tooth: Numbers | None) -> Numbers:
    """Approach of flanks under a force, c f + b f^{2/3} [m]."""
    approach = jnp.zeros_like(force)
    if tooth is not None:
        approach = approach + tooth * force
    if hertz is not None:
        approach = approach + hertz * jnp.cbrt(force) ** 2
    return approach
