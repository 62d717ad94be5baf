r"""Rollers that lean and bend in the plane through the axes of screw and roller.

The screw presses a roller on one side of its axis and the nut on the other, so the load tilts it
about the tangent to the screw, with a moment of twice the roller's radius times its load. Its axis
moves outward by

$$v(z) = a_1 P_1(z/h) + \sum_{m>1} a_m \left(P_m(z/h) - c_m P_{(m \bmod 2)}(z/h)\right)$$

with Legendre polynomials over the half length h of its threads; beyond them it is straight. The
$c_m$ make all shapes but the first vanish at the ends of the roller: $a_1/h$ is the lean of the
line through these ends, and the rest bends the roller away from it. Where the axis moves by v with
the slope v', the gaps open by

$$v\tan\alpha + r_R v' \quad\text{(screw)}, \qquad -v\tan\alpha + r_R v' \quad\text{(nut)},$$

as those of a roller that leans as a whole. The energy of Euler and Bernoulli's beam is
$\tfrac12 E I \int v''^2 dz$. A support against the lean $\psi = a_1/h$ adds
$\tfrac12 k_\tau \psi^2$, with both ends of the roller, as cantilevers, in series. A radial shift
of the whole roller is an unknown of the chains where threads have two flanks; with one flank it
changes nothing.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..fields import Scalar
from ..mechanism import LoadSharing, Stage, material_of
from ..programs import physics
from .part_errors import Displacements, Places, SideCoupling


def _shapes(count: int, at: Array, end: Scalar) -> tuple[Array, Array]:
    """The shapes and their derivatives, by Bonnet's recursion.

    **Arguments:**

    - `count`: number of shapes.
    - `at`: places z/h.
    - `end`: end of the roller over h, at least 1.
    """
    values, slopes = [jnp.ones_like(at), at], [jnp.zeros_like(at), jnp.ones_like(at)]
    for m in range(1, count):
        values.append(((2 * m + 1) * at * values[m] - m * values[m - 1]) / (m + 1))
        slopes.append(slopes[m - 1] + (2 * m + 1) * values[m])

    def from_ends(rows: list[Array]) -> Array:
        bent = []
        for m in range(2, count + 1):
            # P_m'(1) = m (m + 1)/2; straight from the last thread to the end.
            there = 1 + m * (m + 1) / 2 * (end - 1)
            bent.append(rows[m] - there * (rows[1] / end if m % 2 else rows[0]))
        return jnp.stack([rows[1], *bent])

    return from_ends(values), from_ends(slopes)


def _bent(count: int) -> np.ndarray:
    """∫ P_m'' P_n'' over −1 … 1, exact for polynomials of this degree."""
    points, weights = np.polynomial.legendre.leggauss(count)
    basis = [np.polynomial.legendre.Legendre.basis(m).deriv(2) for m in range(1, count + 1)]
    rows = np.array([np.broadcast_to(one(points), points.shape) for one in basis])
    return (rows * weights) @ rows.T


def _lengths(stage: Stage, thread_count: int) -> tuple[Scalar, Scalar]:
    """Half the length of the engaged threads [m], and that of the roller over it, 1 or more."""
    threads, length = thread_count * stage.thread.pitch, stage.roller.length
    end = jnp.ones_like(threads) if length is None else jnp.maximum(length / threads, 1.0)
    return threads / 2, end


def _shapes_of(
    stage: Stage, sharing: LoadSharing, classes: int, places: Places | None
) -> tuple[Array, Array]:
    """The shapes and their slopes [1/m] at all threads, [shapes, classes, threads]."""
    assert sharing.roller_bending is not None
    threads, pitch = sharing.thread_count, stage.thread.pitch
    if places is None:
        z = pitch * (jnp.arange(threads, dtype=pitch.dtype) - (threads - 1) / 2)
    else:
        z = places.axial
    half, end = _lengths(stage, threads)
    at = jnp.broadcast_to(z / half, (classes, threads))
    values, slopes = _shapes(sharing.roller_bending.shapes, at, end)
    return values, slopes / half


@physics("roller_bending")
def roller_shapes(
    stage: Stage,
    sharing: LoadSharing,
    section: tuple[Scalar, Scalar],
    weight: Float[Array, " classes"],
    places: Places | None,
) -> Displacements:
    """The shapes of all classes of rollers, class by class.

    **Arguments:**

    - `stage`: the stage.
    - `sharing`: its load sharing, with `roller_bending`.
    - `section`: inner and outer radius of a roller's section [m].
    - `weight`: number of rollers of each class.
    - `places`: of the contacts where rollers differ by their places.

    **Raises:** `MissingDataError` without the material of the rollers.
    """
    bending, classes = sharing.roller_bending, len(weight)
    assert bending is not None
    values, slopes = _shapes_of(stage, sharing, classes, places)
    radial = jnp.tan(stage.thread.flank_angle) * values
    axial = stage.thread.roller_radius * slopes
    own = jnp.eye(classes, dtype=values.dtype)[:, None, :, None]

    def of_all(one: Array) -> Array:
        return (own * one[None]).reshape(classes * bending.shapes, *one.shape[1:])

    def side(sign: float) -> SideCoupling:
        if sharing.has_reverse_flanks:
            return SideCoupling(of_all(axial), of_all(sign * radial))
        return SideCoupling(of_all(axial + sign * radial), None)

    inner, outer = section
    beam = material_of(stage, "roller").youngs_modulus * jnp.pi / 4 * (outer**4 - inner**4)
    half, end = _lengths(stage, sharing.thread_count)
    stiffness = beam / half**3 * jnp.asarray(_bent(bending.shapes), values.dtype)
    if bending.tilting_stiffness is not None:
        # Forces F = M/L at the ends, a beyond the threads, bend these cantilevers by F a³/3 E I.
        soft = half * (end - 1) ** 3 / (6 * beam * end**2)
        held = bending.tilting_stiffness / (1 + bending.tilting_stiffness * soft)
        stiffness = stiffness.at[0, 0].add(held / half**2)
    whole = jnp.kron(jnp.diag(weight), stiffness)
    return Displacements(side(-1.0), side(1.0), jnp.zeros_like(whole[0]), whole)


def deflected(
    stage: Stage,
    sharing: LoadSharing,
    amplitudes: Float[Array, " displacements"],
    places: Places | None,
) -> tuple[Float[Array, " classes"], Float[Array, "classes threads"]]:
    """Lean of each roller [rad], and how far it is bent from there at its threads [m].

    **Arguments:**

    - `stage`, `sharing`, `places`: as in `roller_shapes`.
    - `amplitudes`: of its displacements [m].
    """
    assert sharing.roller_bending is not None
    each = amplitudes.reshape(-1, sharing.roller_bending.shapes)
    values, _ = _shapes_of(stage, sharing, len(each), places)
    half, _ = _lengths(stage, sharing.thread_count)
    return each[:, 0] / half, jnp.einsum("cm,mct->ct", each[:, 1:], values[1:])
