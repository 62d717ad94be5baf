"""Bodies on the axis of a stage."""

import equinox as eqx

from ...fields import Scalar
from ...mechanism import Side, Thread


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


def nominal_radius(thread: Thread, side: Side) -> Scalar:
    """r of u = r θ of screw or nut [m]."""
    return thread.screw_radius if side == "screw" else thread.nut_radius
