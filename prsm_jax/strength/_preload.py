r"""Two nuts preloaded against each other: their loads, the load that opens one, their stiffness.

Both are Hertz point contacts, $F = k\,\delta^{3/2}$. Under the preload $F_p$ the approach of each
is $\delta_0$; a load $F$ moves the screw by $x = s\,\delta_0$ and changes their loads to
$F_p (1 \pm s)^{3/2}$, so that $f = F/F_p = (1+s)^{3/2} - (1-s)^{3/2}$ as long as both touch.
"""

import math

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..fields import Scalar
from ..programs import physics
from ._powers import positive_power

#: Load over preload at which one nut is free: s = 1, so 2^{3/2}.
OPENING_RATIO = 2**1.5


def preload_opening_load(preload: Scalar) -> Scalar:
    r"""Load at which one of two preloaded nuts comes free, $2^{3/2} F_p \approx 2.83 F_p$ [N].

    Source: derived here from Hertz point contacts; the same number is in ISO 3408-5 and catalogues
    of ball screws.
    """
    return OPENING_RATIO * preload


def _slope(displacement):
    """ds/df, from the derivative of f(s); one nut alone above the opening load."""
    size = jnp.abs(displacement)
    other = positive_power(1 - size, 0.5)
    return 2 / (3 * (jnp.sqrt(1 + size) + other))


@jax.custom_jvp
def relative_displacement(load_ratio: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    r"""Displacement s = x/δ₀ of the screw between two preloaded nuts, in closed form.

    With $q = \sqrt{1 - s^2}$ the square of the balance is the cubic $q^3 + 3 q^2 + f^2/2 - 4 = 0$,
    whose root by Viète is $q = 2\cos\theta - 1$ with $\sin(3\theta/2) = f/\sqrt 8$; then
    $s = 2 \sin(\theta/2)\sqrt{2\cos\theta}$. Above $f = \sqrt 8$ one nut carries the load alone,
    $s = f^{2/3} - 1$: value and slope are continuous.

    **Arguments:**

    - `load_ratio`: f = F/F_p, of either sign.
    """
    size = jnp.abs(load_ratio)
    closed = size < OPENING_RATIO
    angle = 2 / 3 * jnp.arcsin(jnp.where(closed, size, 0.0) / math.sqrt(8.0))
    inside = 2 * jnp.sin(angle / 2) * jnp.sqrt(2 * jnp.cos(angle))
    outside = jnp.where(closed, 1.0, size) ** (2 / 3) - 1
    return jnp.sign(load_ratio) * jnp.where(closed, inside, outside)


@relative_displacement.defjvp
def _relative_displacement_jvp(primals, tangents):
    (load_ratio,), (tangent,) = primals, tangents
    displacement = relative_displacement(load_ratio)
    return displacement, _slope(displacement) * tangent


@physics("preload")
def preloaded_pair_loads(
    load: Float[Array, "*batch"], preload: Scalar
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Loads on the two nuts of a preloaded pair under an axial load [N].

    Exact for two equal nuts with Hertz point contacts. The approximation F_p (1 + F/(2.83
    F_p))^{3/2} of ISO 3408-5 takes s as linear in F and is up to 2.5 % higher.

    **Arguments:**

    - `load`: axial load; a positive one presses on the first nut [N].
    - `preload`: F_p, above 0 [N].

    **Returns:** the load on the first nut and on the second, neither negative.
    """
    displacement = relative_displacement(load / preload)
    first, second = (positive_power(1 + s, 1.5) * preload for s in (displacement, -displacement))
    return first, second


def flank_loads(
    load: Float[Array, "*batch"], preload: Scalar | None
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Loads on the flanks of both directions [N]: of a preloaded pair, or of one nut with play.

    **Arguments:**

    - `load`: axial load, of either sign [N].
    - `preload`: preload [N], or `None` for a nut that is not preloaded.
    """
    if preload is None:
        return jnp.maximum(load, 0.0), jnp.maximum(-load, 0.0)
    return preloaded_pair_loads(load, preload)


def preloaded_pair_stiffness(load: Scalar, preload: Scalar, preload_approach: Scalar) -> Scalar:
    r"""Tangent stiffness of a preloaded pair, $\tfrac32 (F_p/\delta_0)(\sqrt{1+s} + \sqrt{1-s})$.

    In N/m; without load it is twice the tangent stiffness of one nut under its preload.

    **Arguments:**

    - `load`: axial load [N].
    - `preload`: F_p, above 0 [N].
    - `preload_approach`: axial approach δ₀ of one nut under the preload [m].
    """
    return preload / (preload_approach * _slope(relative_displacement(load / preload)))


def preload_torque(preload: Scalar, lead: Scalar, forward: Scalar, backward: Scalar) -> Scalar:
    r"""Drag torque of a preload, $F_p L (1/\eta_f - \eta_b)/2\pi$ [N·m].

    The screw drives one nut against the preload and is driven back by the other.

    **Arguments:**

    - `preload`: F_p [N].
    - `lead`: L [m].
    - `forward`, `backward`: efficiencies of the threads when the screw drives and is driven.
    """
    return preload * lead / (2 * jnp.pi) * (1 / forward - backward)
