"""Springs of one roller to the bodies around it, along directions in space."""

from typing import TypeAlias

import equinox as eqx
import jax.numpy as jnp

from ...contact import contact_modulus
from ...fields import Scalar
from ...geometry import ThreadContact
from ...mechanism import Family, Material, Side
from ...programs import physics

#: Components along the line of centres (radial, outwards), around the screw (tangential), and
#: along the axis.
Vector: TypeAlias = tuple[Scalar, Scalar, Scalar]
#: A place in the transverse plane, from the axis of a body: radial, tangential [m].
Place: TypeAlias = tuple[Scalar, Scalar]
#: Elongation per unit of radial, tangential and axial displacement, and of u = r θ.
Elongation: TypeAlias = tuple[Scalar, Scalar, Scalar, Scalar]
#: Elongation per unit of r ψ, with the angle ψ of a tilt about the radial and tangential direction.
Tilt: TypeAlias = tuple[Scalar, Scalar]


class RollerSpring(eqx.Module):
    """The springs of one kind, one at each roller: they stretch by `central·q_c + roller·q_R`.

    All components are in the frame of the roller's own position around the screw, in which the
    springs of all rollers are equal.
    """

    #: Of the spring at one roller [N/m].
    stiffness: Scalar
    roller: Elongation
    #: Of the body on the axis; zero if the spring leads to the housing.
    central: Elongation
    name: str = eqx.field(static=True)
    #: The body on the axis; `None` for the housing.
    body: str | None = eqx.field(static=True)
    #: `None` where bodies do not tilt, or a tilt does not stretch the spring.
    roller_tilt: Tilt | None = None
    central_tilt: Tilt | None = None


def _with_lever(direction: Vector, place: Place, radius: Scalar) -> Elongation:
    """Components of a direction, and its moment about z per radius: a turn u moves by u/r z × p."""
    along, around, axial = direction
    outward, aside = place
    return along, around, axial, (outward * around - aside * along) / radius


def _tilting(direction: Vector, place: Place, radius: Scalar) -> Tilt:
    """Moments of a direction about the radial and tangential direction, p × d, per radius."""
    outward, aside = place
    return aside * direction[2] / radius, -outward * direction[2] / radius


def _reversed(tilt: Tilt) -> Tilt:
    return -tilt[0], -tilt[1]


def contact_spring(
    name: str,
    body: str,
    stiffness: Scalar,
    direction: Vector,
    places: tuple[Place, Place],
    radii: tuple[Scalar, Scalar],
    *,
    tilt: bool = False,
) -> RollerSpring:
    """A spring between the touching points of a body on the axis and of a roller.

    It stretches by `δ = d · (v_body − v_roller)`, with the displacement of the point of each body
    `v = (radial, tangential, axial) + θ z × p`.

    **Arguments:**

    - `name`: of the spring.
    - `body`: the body on the axis.
    - `stiffness`: at one roller [N/m].
    - `direction`: unit vector d.
    - `places`: the touching point p, from the axis of the body and from that of the roller [m].
    - `radii`: the radii r of u = r θ, of the body and of the roller [m].
    - `tilt`: whether both bodies tilt, about their middles in the plane of the point.
    """
    body_place, roller_place = places
    body_radius, roller_radius = radii
    roller = _with_lever(direction, roller_place, roller_radius)
    return RollerSpring(
        stiffness=stiffness,
        roller=(-roller[0], -roller[1], -roller[2], -roller[3]),
        central=_with_lever(direction, body_place, body_radius),
        name=name,
        body=body,
        roller_tilt=_reversed(_tilting(direction, roller_place, roller_radius)) if tilt else None,
        central_tilt=_tilting(direction, body_place, body_radius) if tilt else None,
    )


def spread_spring(
    name: str,
    body: str,
    stiffness: Scalar,
    direction: Vector,
    spread: Scalar,
    radii: tuple[Scalar, Scalar],
) -> RollerSpring:
    """What springs at several places ζ along the axis add to one in the middle where bodies tilt.

    Each of n springs of stiffness k/n stretches by `δ + ζ d·(ψ × e_z)`, with the tilt ψ of the body
    against the roller. With places that are symmetric about the middle their energy is that of
    `k δ²` and of `k s² (d·(ψ × e_z))²`, s² = Σ ζ²/n.

    **Arguments:**

    - `name`, `body`, `stiffness`, `direction`, `radii`: those of the spring in the middle, of which
      this is a part.
    - `spread`: s [m].
    """
    zero = jnp.zeros_like(stiffness)
    still = (zero, zero, zero, zero)
    central, roller = (
        (-spread * direction[1] / radius, spread * direction[0] / radius) for radius in radii
    )
    return RollerSpring(stiffness, still, still, name, body, _reversed(roller), central)


def contact_springs(
    name: str,
    body: str,
    stiffness: Scalar,
    direction: Vector,
    places: tuple[Place, Place],
    radii: tuple[Scalar, Scalar],
    spread: Scalar | None,
) -> list[RollerSpring]:
    """A spring, and where bodies tilt what its extent along the axis adds.

    **Arguments:** as `contact_spring`, and

    - `spread`: root mean square distance along the axis of the parts of the spring from its middle
      [m]; `None` if no body tilts.
    """
    tilt = spread is not None
    springs = [contact_spring(name, body, stiffness, direction, places, radii, tilt=tilt)]
    if spread is not None:
        springs.append(spread_spring(name, body, stiffness, direction, spread, radii))
    return springs


def contact_places(contact: ThreadContact, side: Side, family: Family) -> tuple[Place, Place]:
    """The contact point of a roller with screw or nut, from the axes of that body and roller [m].

    Where the roller rolls, it lies on the line of centres.
    """
    radius, roller_radius = contact.contact_radius, contact.roller_contact_radius
    inwards = side == "screw"
    if side not in family.sliding:
        zero = jnp.zeros_like(radius)
        return (radius, zero), (-roller_radius if inwards else roller_radius, zero)
    angle, roller_angle = contact.contact_angle_position, contact.roller_angle_position
    outward = roller_radius * jnp.cos(roller_angle)
    return (
        (radius * jnp.cos(angle), radius * jnp.sin(angle)),
        (-outward if inwards else outward, roller_radius * jnp.sin(roller_angle)),
    )


def tangents(normal: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors that are orthogonal to a normal and to each other; it must not lie along y.

    The first lies in the plane of the line of centres and the axis.
    """
    x, y, z = normal
    flat = jnp.sqrt(x**2 + z**2)
    return (z / flat, jnp.zeros_like(y), -x / flat), (-x * y / flat, flat, -y * z / flat)


@physics("tangential_contact")
def tangential_ratio(first: Material, second: Material) -> Scalar:
    """Tangential over normal stiffness of a contact that does not slide, `4 G*/E*` [1].

    `1/G* = (2 − ν₁)/G₁ + (2 − ν₂)/G₂`, `1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂`; for equal bodies
    `2(1 − ν)/(2 − ν)`. Both are tangent stiffnesses, of a circular contact: 8 a G* and 2 a E*
    (Mindlin 1949; Johnson, Contact Mechanics, section 7.2).
    """
    compliance = sum(
        2 * (1 + body.poisson_ratio) * (2 - body.poisson_ratio) / body.youngs_modulus
        for body in (first, second)
    )
    return 4 / (compliance * contact_modulus(first, second))
