"""Compliance of a thread tooth under a load across its flank, in Yamamoto's five parts."""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import equinox as eqx
import jax
import jax.numpy as jnp

from ..fields import Scalar
from ..mechanism import Material
from ..programs import physics


class ToothCompliance(eqx.Module):
    """Axial deflection of a tooth over the axial load per unit length of thread [m²/N].

    Divided by the length of thread that bears the load it is a compliance in m/N.
    """

    #: Each part in m²/N. The tooth bends and shears.
    bending: Scalar
    shear: Scalar
    #: The root turns in the body that carries the tooth.
    root_tilt: Scalar
    #: The root shears in that body.
    root_shear: Scalar
    #: The body shrinks (screw, roller) or widens (nut) and the flank slides along its slope.
    radial: Scalar

    @property
    def total(self) -> Scalar:
        """The sum of the five parts [m²/N]."""
        return self.bending + self.shear + self.root_tilt + self.root_shear + self.radial


def tooth_compliance(
    material: Material,
    flank_angle: Scalar,
    pitch: Scalar,
    pitch_line_thickness: Scalar,
    dedendum: Scalar,
    radius: Scalar,
    outer_radius: Scalar | None = None,
) -> ToothCompliance:
    """Yamamoto's compliance of a trapezoidal tooth that is loaded at its pitch line.

    With the thickness b at the pitch line, the root a distance c below it, the thickness there
    a = b + 2 c tan α, and an axial load w per unit length:

    - bending `(1 − ν²) ¾ {[1 − (2 − b/a)² + 2 ln(a/b)] cot³α − 4 (c/a)² tan α} w/E`
    - shear `(1 + ν) 6/5 cot α ln(a/b) w/E`
    - tilt of the root `(1 − ν²) 12 c (c − b/2 tan α)/(π a²) w/E`
    - shear of the root `(1 − ν²) 2/π {p/a ln[(p + a/2)/(p − a/2)] + ½ ln(4p²/a² − 1)} w/E`
    - radial: `k tan²α d/(2p) w/E`, k = 1 − ν for a solid body and
      (D² + d²)/(D² − d²) + ν for a sleeve of outer diameter D

    Source: Yamamoto, A., The Theory and Computation of Threads Connection (1980); the sums for
    bending and shear are those of a wedge-shaped beam. Flanks in axial sections are taken as
    straight.

    **Arguments:**

    - `material`: of the body.
    - `flank_angle`: α, from the transverse plane [rad].
    - `pitch`: p [m].
    - `pitch_line_thickness`: b [m].
    - `dedendum`: c [m].
    - `radius`: nominal radius d/2 [m].
    - `outer_radius`: D/2 of a sleeve [m]; `None` for a solid body.
    """
    body = ToothedBody(material, dedendum, radius, outer_radius)
    return _compliance(flank_angle, pitch, pitch_line_thickness, _numbers(body))


class ToothedBody(NamedTuple):
    """A body and its teeth, as in `tooth_compliance`."""

    material: Material
    dedendum: Scalar
    radius: Scalar
    outer_radius: Scalar | None = None


def compliances_of(
    bodies: Sequence[ToothedBody], flank_angle: Scalar, pitch: Scalar, pitch_line_thickness: Scalar
) -> list[ToothCompliance]:
    """`tooth_compliance` of several bodies of one thread, in the program size of one.

    **Arguments:** as in `tooth_compliance`.
    """
    each = map(_numbers, bodies)
    stacked: _Numbers = jax.tree.map(lambda *values: jnp.stack(values), *each)
    of_all = jax.vmap(_compliance, in_axes=(None, None, None, 0))(
        flank_angle, pitch, pitch_line_thickness, stacked
    )
    return [jax.tree.map(lambda values, k=k: values[k], of_all) for k in range(len(bodies))]


#: c and d/2 [m], E [Pa], ν, and k.
_Numbers: TypeAlias = tuple[Scalar, Scalar, Scalar, Scalar, Scalar]


def _numbers(body: ToothedBody) -> _Numbers:
    modulus, poisson = body.material.youngs_modulus, body.material.poisson_ratio
    if body.outer_radius is None:
        stretch = 1 - poisson
    else:
        outer, inner = body.outer_radius**2, body.radius**2
        stretch = (outer + inner) / (outer - inner) + poisson
    return body.dedendum, body.radius, modulus, poisson, stretch


@physics("tooth_compliance")
def _compliance(
    flank_angle: Scalar, pitch: Scalar, pitch_line_thickness: Scalar, body: _Numbers
) -> ToothCompliance:
    dedendum, radius, modulus, poisson, stretch = body
    tangent = jnp.tan(flank_angle)
    root = pitch_line_thickness + 2 * dedendum * tangent
    ratio, plane = pitch_line_thickness / root, 1 - poisson**2
    taper = -jnp.log(ratio)
    bending = (1 - (2 - ratio) ** 2 + 2 * taper) / tangent**3 - 4 * (dedendum / root) ** 2 * tangent
    lever = dedendum * (dedendum - pitch_line_thickness * tangent / 2)
    half = root / 2
    spread = pitch / root * jnp.log((pitch + half) / (pitch - half))
    spread = spread + jnp.log((pitch / half) ** 2 - 1) / 2
    return ToothCompliance(
        bending=plane * 0.75 * bending / modulus,
        shear=1.2 * (1 + poisson) * taper / (tangent * modulus),
        root_tilt=plane * 12 * lever / (jnp.pi * root**2 * modulus),
        root_shear=plane * 2 * spread / (jnp.pi * modulus),
        radial=stretch * tangent**2 * radius / (pitch * modulus),
    )
