r"""Rollers that lean and bend in the plane through the axes of screw and roller.

The screw presses a roller on one side of its axis and the nut on the other, so the load tilts it
about the tangent to the screw, with a moment of twice the roller's radius times its load. Its axis
moves outward by

$$v(z) = a_1 P_1(z/h) + \sum_{m>1} a_m \left(P_m(z/h) - c_m P_{(m \bmod 2)}(z/h)\right)$$

with Legendre polynomials over the half length h of its threads; beyond them it is straight. The
$c_m$ make all shapes but the first vanish at the ends of the roller: $a_1$ is the lean of the line
through its ends, the rest bends it away from there. Where the axis moves by v with the slope v',
the gaps open by

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
from ..mechanism import RollerBending, Stage, material_of
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


def bending_stiffness(stage: Stage) -> Scalar:
    """E I of a roller's section [N·m²]: from the bore to the root of its thread, if given.

    **Raises:** `MissingDataError` without its material.
    """
    sharing, bore = stage.load_sharing, stage.roller.bore_radius
    tooth = None if sharing is None else sharing.tooth
    outer = stage.thread.roller_radius - (0.0 if tooth is None else tooth.roller_dedendum)
    inner = jnp.zeros_like(outer) if bore is None else bore
    moment = jnp.pi / 4 * (outer**4 - inner**4)
    return material_of(stage, "roller").youngs_modulus * moment


def _along_roller(stage: Stage, places: Places | None, thread_count: int) -> Array:
    """Places of the threads from the middle of a roller [m], a row for all or for each class."""
    if places is not None:
        return places.axial
    count = jnp.arange(thread_count, dtype=stage.thread.lead.dtype) - (thread_count - 1) / 2
    return stage.thread.pitch * count[None, :]


@physics("roller_bending")
def roller_shapes(
    stage: Stage,
    bending: RollerBending,
    weight: Float[Array, " classes"],
    places: Places | None,
    thread_count: int,
    both: bool,
) -> Displacements:
    """The shapes of all classes of rollers, class by class.

    **Arguments:**

    - `stage`: the stage.
    - `bending`: what holds its rollers.
    - `weight`: number of rollers of each class.
    - `places`: of the contacts where rollers differ by their places.
    - `thread_count`: engaged threads of one roller.
    - `both`: whether reverse flanks are modelled.

    **Raises:** `MissingDataError` without the material of the rollers.
    """
    count, classes = bending.shapes, len(weight)
    half, end = _lengths(stage, thread_count)
    z = jnp.broadcast_to(_along_roller(stage, places, thread_count), (classes, thread_count))
    values, slopes = _shapes(count, z / half, end)
    radial = jnp.tan(stage.thread.flank_angle) * values
    axial = stage.thread.roller_radius * slopes / half
    own = jnp.eye(classes, dtype=z.dtype)[:, None, :, None]

    def of_all(one: Array) -> Array:
        return (own * one[None]).reshape(classes * count, classes, thread_count)

    def side(sign: float) -> SideCoupling:
        if both:
            return SideCoupling(of_all(axial), of_all(sign * radial))
        return SideCoupling(of_all(axial + sign * radial), None)

    beam = bending_stiffness(stage)
    stiffness = beam / half**3 * jnp.asarray(_bent(count), z.dtype)
    if bending.tilting_stiffness is not None:
        # Forces F = M/L at the ends, a beyond the threads, bend these cantilevers by F a³/3 E I.
        soft = half * (end - 1) ** 3 / (6 * beam * end**2)
        held = bending.tilting_stiffness / (1 + bending.tilting_stiffness * soft)
        stiffness = stiffness.at[0, 0].add(held / half**2)
    whole = jnp.kron(jnp.diag(weight), stiffness)
    load = jnp.zeros((classes * count,), z.dtype)
    return Displacements(side(-1.0), side(1.0), load, whole)


def deflected(
    stage: Stage,
    bending: RollerBending,
    shapes: Float[Array, " displacements"],
    places: Places | None,
    thread_count: int,
) -> tuple[Float[Array, " classes"], Float[Array, "classes threads"]]:
    """Lean of the line through the ends of each roller [rad], and distance of its axis from there
    at its threads [m]."""
    count, (half, end) = bending.shapes, _lengths(stage, thread_count)
    each = shapes.reshape(-1, count)
    z = jnp.broadcast_to(_along_roller(stage, places, thread_count), (each.shape[0], thread_count))
    values, _ = _shapes(count, z / half, end)
    bow = jnp.einsum("cm,mct->ct", each[:, 1:], values[1:])
    return each[:, 0] / half, bow
