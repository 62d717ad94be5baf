"""Bodies on the axis of a stage."""

import equinox as eqx
import jax.numpy as jnp

from ...fields import Scalar
from ...mechanism import Side, Stage, Support, Thread


class SpatialBody(eqx.Module):
    """A body on the axis with its springs to the housing."""

    #: In x and y [kg].
    mass: Scalar
    #: J/r² [kg].
    equivalent_mass: Scalar
    #: Stiffness of the springs to the housing, the torsional one over r² [N/m].
    radial_support: Scalar
    torsional_support: Scalar
    name: str = eqx.field(static=True)
    #: Along z, with everything that is fixed to it in this direction [kg]; `None` if the body
    #: itself is fixed to another one in z.
    axial_mass: Scalar | None = None
    #: Along z [N/m].
    axial_support: Scalar | None = None
    #: Of tilts about x and y, moment of inertia and stiffness over r² [kg, N/m]; `None` if the body
    #: does not tilt by itself.
    tilt_mass: Scalar | None = None
    tilt_support: Scalar | None = None


def nominal_radius(thread: Thread, side: Side) -> Scalar:
    """r of u = r θ of screw or nut [m]."""
    return thread.screw_radius if side == "screw" else thread.nut_radius


def moving_with(stage: Stage, side: Side) -> tuple[str, ...]:
    """Screw or nut, and the bodies that move along the axis with it."""
    # Where rollers keep their place in neither body, a cage in the nut guides them.
    beside = stage.thread.family.carrying or "nut"
    names = (side, "ring_gear") if side == "nut" else (side,)
    return (*names, "carrier") if side == beside else names


def has_support(stage: Stage, names: tuple[str, ...], direction: str) -> bool:
    """Whether one of these bodies has a support in a direction, be it of stiffness 0."""
    bodies = (getattr(stage, name) for name in names)
    given = [None if body is None else body.support for body in bodies]
    return any(
        one is not None and getattr(one, f"{direction}_stiffness") is not None for one in given
    )


def supports(stage: Stage, names: tuple[str, ...], direction: str, like: Scalar) -> Scalar:
    """Sum of the supports of bodies that are fixed to each other; zero where none is given."""
    total = jnp.zeros_like(like)
    for name in names:
        body = getattr(stage, name)
        support: Support | None = None if body is None else body.support
        stiffness = None if support is None else getattr(support, f"{direction}_stiffness")
        if stiffness is not None:
            total = total + stiffness
    return total
