"""A solid with a true helical thread, built without boolean operations.

A plane across the axis cuts the body in the same closed curve at every height, turned about the
axis by `2π z / lead`. Each piece of this curve (crest, flank, root, flank, for each start) sweeps
one surface over the whole length; neighbours share a helix, and two planes close the ends. Surfaces
are B-splines of degree 5 through points of the exact ones, with the same knots along the helix, so
that shared edges are equal.
"""

import itertools
import math
from typing import Any

import numpy as np

from ..._errors import PrsmError
from ._bodies import ThreadedBody
from ._library import opencascade

#: Degree of B-splines, and points for each turn of the helix and of arcs across it.
_DEGREE, _PER_TURN = 5, 24
#: Points over a flank.
_FLANK = 13
#: Gap of edges that are sewn together [mm]; they are equal but for rounding.
_GAP = 1e-5


def solid_of(body: ThreadedBody) -> Any:
    """The solid of a body, centred on the origin with its axis along z, in millimetres.

    **Arguments:**

    - `body`: its dimensions.

    **Raises:** `PrsmError` if the faces do not close.
    """
    builder = opencascade("BRepBuilderAPI")
    checks = opencascade("BRepCheck")
    library = opencascade("BRepLib")
    kinds = opencascade("TopAbs")
    explorers = opencascade("TopExp")
    shapes = opencascade("TopoDS")

    surfaces = [_swept(body, *piece) for piece in _section(body)]
    faces = [_face(part) for surface in surfaces for part in _parts(body, surface)]
    sewing = builder.BRepBuilderAPI_Sewing(_GAP)
    for face in [*faces, *_ends(body, surfaces), *_other_cylinder(body)]:
        sewing.Add(face)
    sewing.Perform()
    shells = explorers.TopExp_Explorer(sewing.SewedShape(), kinds.TopAbs_SHELL)
    if sewing.NbFreeEdges() or not shells.More():
        raise PrsmError(f"the faces of a body do not close: {sewing.NbFreeEdges()} free edges")
    solid = builder.BRepBuilderAPI_MakeSolid(shapes.TopoDS.Shell(shells.Current())).Solid()
    library.BRepLib.OrientClosedSolid_s(solid)
    if not checks.BRepCheck_Analyzer(solid).IsValid():
        raise PrsmError("the faces of a body make no valid solid")
    return solid


def _section(body: ThreadedBody) -> list[tuple[np.ndarray, np.ndarray]]:
    """Pieces of the profile over all starts: radii and axial positions of points [mm]."""
    heights = np.linspace(-body.dedendum, body.addendum, _FLANK)
    halves = np.asarray(body.half_thickness(heights))
    radii = np.asarray(body.radius_at(heights))
    pieces = []
    for start in range(body.starts):
        middle = start * body.pitch
        crest = _along(body, middle - halves[-1], middle + halves[-1])
        root = _along(body, middle + halves[0], middle + body.pitch - halves[0])
        pieces += [
            (radii, middle - halves),
            (np.full_like(crest, radii[-1]), crest),
            (radii[::-1], middle + halves[::-1]),
            (np.full_like(root, radii[0]), root),
        ]
    return pieces


def _along(body: ThreadedBody, start: float, end: float) -> np.ndarray:
    """Positions along a crest or root, as close as those along the helix."""
    count = _DEGREE + 2 + math.ceil(_PER_TURN * (end - start) / body.lead)
    return np.linspace(start, end, count)


def _swept(body: ThreadedBody, radii: np.ndarray, along: np.ndarray) -> Any:
    """The surface that a piece of the profile sweeps: u across the helix, v along it."""
    collections = opencascade("collections")
    geom = opencascade("Geom")
    gp = opencascade("gp")
    from scipy.interpolate import make_interp_spline

    count = max(_DEGREE + 2, 1 + math.ceil(_PER_TURN * body.length / body.lead))
    v = np.linspace(0.0, 1.0, count)
    z = (v - 0.5) * body.length
    angle = body.hand * 2 * np.pi / body.lead * (z[None, :] - along[:, None])
    points = np.stack(
        [radii[:, None] * np.cos(angle), radii[:, None] * np.sin(angle), z + 0 * angle], axis=-1
    )
    across = make_interp_spline(np.linspace(0.0, 1.0, len(radii)), points, k=_DEGREE)
    helical = make_interp_spline(v, np.moveaxis(across.c, 1, 0), k=_DEGREE)
    poles = collections.Array2_gp_Pnt(1, len(radii), 1, count)
    for row in range(len(radii)):
        for column in range(count):
            poles.SetValue(row + 1, column + 1, gp.gp_Pnt(*helical.c[column, row].tolist()))
    knots, many = zip(*(_knots(one.t) for one in (across, helical)), strict=True)
    return geom.Geom_BSplineSurface(poles, *knots, *many, _DEGREE, _DEGREE)


def _knots(repeated: np.ndarray) -> tuple[Any, Any]:
    """Knots and how often each occurs."""
    collections = opencascade("collections")

    knots, counts = np.unique(repeated, return_counts=True)
    values, many = collections.Array1_double(1, len(knots)), collections.Array1_int(1, len(knots))
    for index, (knot, count) in enumerate(zip(knots, counts, strict=True), start=1):
        values.SetValue(index, float(knot))
        many.SetValue(index, int(count))
    return values, many


def _parts(body: ThreadedBody, surface: Any) -> list[Any]:
    """A surface in parts of half a turn: readers err at faces that go around more than once."""
    geom = opencascade("Geom")

    count = math.ceil(2 * body.length / body.lead)
    ends = np.linspace(0.0, 1.0, count + 1).tolist()
    parts = []
    for start, end in itertools.pairwise(ends):
        part = geom.Geom_BSplineSurface(surface)
        part.Segment(0.0, 1.0, start, end)
        parts.append(part)
    return parts


def _face(surface: Any) -> Any:
    builder = opencascade("BRepBuilderAPI")

    return builder.BRepBuilderAPI_MakeFace(surface, 1e-7).Face()


def _ends(body: ThreadedBody, surfaces: list[Any]) -> list[Any]:
    """Plane faces at both ends, between the thread and the other cylinder."""
    builder = opencascade("BRepBuilderAPI")
    gp = opencascade("gp")
    repairs = opencascade("ShapeFix")

    faces = []
    for v in (0.0, 1.0):
        centre, axis = gp.gp_Pnt(0.0, 0.0, (v - 0.5) * body.length), gp.gp_Dir(0.0, 0.0, 1.0)
        thread = builder.BRepBuilderAPI_MakeWire()
        for surface in surfaces:
            thread.Add(builder.BRepBuilderAPI_MakeEdge(surface.VIso(v)).Edge())
        wires = [thread.Wire()]
        if body.other_radius:
            circle = gp.gp_Circ(gp.gp_Ax2(centre, axis), body.other_radius)
            wires.append(
                builder.BRepBuilderAPI_MakeWire(
                    builder.BRepBuilderAPI_MakeEdge(circle).Edge()
                ).Wire()
            )
        if body.inward:
            wires.reverse()
        face = builder.BRepBuilderAPI_MakeFace(gp.gp_Pln(centre, axis), wires[0], True)
        for hole in wires[1:]:
            face.Add(hole)
        # The orientation of a hole is the other one.
        oriented = repairs.ShapeFix_Face(face.Face())
        oriented.FixOrientation()
        faces.append(oriented.Face())
    return faces


def _other_cylinder(body: ThreadedBody) -> list[Any]:
    """The face of a bore, or the outside of a nut; none without a bore."""
    builder = opencascade("BRepBuilderAPI")
    gp = opencascade("gp")

    if not body.other_radius:
        return []
    foot = gp.gp_Ax3(gp.gp_Pnt(0.0, 0.0, -body.length / 2), gp.gp_Dir(0.0, 0.0, 1.0))
    cylinder = gp.gp_Cylinder(foot, body.other_radius)
    return [builder.BRepBuilderAPI_MakeFace(cylinder, 0.0, 2 * math.pi, 0.0, body.length).Face()]
