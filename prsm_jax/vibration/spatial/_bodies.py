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
    radial_support: Scalar
    torsional_support: Scalar
    name: str = eqx.field(static=True)
    #: Along z, with everything that is fixed to it in this direction [kg]; `None` if the body
    #: itself is fixed to another one in z.
    axial_mass: Scalar | None = None
    axial_support: Scalar | None = None
    #: Of tilts about x and y, moment of inertia and stiffness over r² [kg, N/m]; `None` if the body
    #: does not tilt by itself.
    tilt_mass: Scalar | None = None
    tilt_support: Scalar | None = None


def nominal_radius(thread: Thread, side: Side) -> Scalar:
    """r of u = r θ of screw or nut [m]."""
    return thread.screw_radius if side == "screw" else thread.nut_radius


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
