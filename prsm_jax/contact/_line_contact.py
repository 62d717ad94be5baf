"""Line contact of a ring with a screw by shape functions: slices side by side."""

from typing import Annotated

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._errors import MissingDataError
from ..fields import In, Scalar
from ..geometry import contact_zone, fit_parabola, ring_vertex
from ..mechanism import LineContact, Stage, material_of
from ..numerics import above_or_nan, below_or_nan, find_root
from ..programs import physics
from ..results import Result
from ._thread_contact import engaged_threads
from .hertz import contact_modulus

#: Edges of the slices, from the inner to the outer end of the zone.
_EDGES = 129

Edges = Float[Array, " edges"]


class SliceGeometry(Result):
    """Geometry of the slices of an unloaded line contact, at the edges of the slices."""

    #: Distance from the roller axis [m].
    radius: Annotated[Edges, In("m")]
    #: Arc coordinate of the smallest gap, from the line of centres [m].
    arc: Annotated[Edges, In("m")]
    #: Normal gap at the first touch of any slice [m].
    gap: Annotated[Edges, In("m")]
    #: Half the second derivative of the normal gap along the arc [1/m].
    coefficient: Edges
    #: Axial force per unit of normal force.
    normal: Edges
    converged: Bool[Array, ""]


class LineContactResult(Result):
    """Line contact under an axial force: per slice, and in total."""

    slices: SliceGeometry
    #: Normal force per length of the contact line [N/m].
    line_load: Annotated[Edges, In("N/m")]
    #: Half-width of the contact [m].
    half_width: Annotated[Edges, In("m")]
    #: Pressure in the middle of the contact width [Pa].
    pressure: Annotated[Edges, In("Pa")]
    #: Depth of contact, how far the undeformed flanks overlap [m].
    depth: Annotated[Edges, In("m")]
    #: Axial force of this contact [N].
    axial_force: Annotated[Scalar, In("N")]
    normal_force: Annotated[Scalar, In("N")]
    #: Normal approach from the first touch [m].
    approach: Annotated[Scalar, In("m")]
    #: Axial force per axial approach, as a tangent [N/m].
    stiffness_tangent: Annotated[Scalar, In("N/m")]
    max_pressure: Annotated[Scalar, In("Pa")]
    max_half_width: Annotated[Scalar, In("m")]
    #: Share of the contact zone that carries load.
    loaded_share: Annotated[Scalar, In("1")]
    #: Largest line load over its mean on the loaded part: 1 if all slices carry equal loads, 2 for
    #: a load that falls linearly from an edge.
    edge_ratio: Annotated[Scalar, In("1")]
    #: Coefficient of determination of the fit of a parabola to the exact gap, at the slice with
    #: the largest pressure over the width of its contact.
    parabola_fit: Annotated[Scalar, In("1")]
    converged: Annotated[Bool[Array, ""], In("1")]


@physics("line_contact_geometry")
def slice_geometry(contact: LineContact, edges: int = _EDGES) -> SliceGeometry:
    """Divide the zone in which both flanks exist into slices of equal radial width.

    **Arguments:**

    - `contact`: the flanks.
    - `edges`: number of edges, one more than slices.
    """
    inner, outer = contact_zone(contact)
    share = jnp.linspace(0.0, 1.0, edges, dtype=inner.dtype)
    radius = inner + share * (outer - inner)
    vertex = jax.vmap(lambda r: ring_vertex(contact, r))(radius)
    # Relative to the first touch; absolute heights are arbitrary.
    gap = vertex.normal * (vertex.gap - jnp.min(vertex.gap))
    return SliceGeometry(
        radius=radius,
        arc=vertex.arc,
        gap=gap,
        coefficient=vertex.normal * vertex.coefficient,
        normal=vertex.normal,
        converged=jnp.all(vertex.converged) & (outer > inner),
    )


def _overlap_per_slice(
    overlap: Edges,
) -> tuple[Float[Array, " slices"], Float[Array, " slices"]]:
    """Mean of max(0, u) over each slice, u linear between its edges, and the share with u > 0.

    Exact; the mean is smooth in u.
    """
    lower, upper = jnp.minimum(overlap[:-1], overlap[1:]), jnp.maximum(overlap[:-1], overlap[1:])
    crossed = below_or_nan(lower) & above_or_nan(upper)
    height = jnp.where(crossed, upper - lower, 1.0)
    part = jnp.where(crossed, upper**2 / (2 * height), 0.0)
    mean = jnp.where(below_or_nan(lower), part, (lower + upper) / 2)
    return mean, jnp.where(crossed, upper / height, jnp.where(upper > 0, 1.0, 0.0))


@physics("line_contact")
def line_contact_under_force(
    contact: LineContact, axial_force: Scalar, modulus: Scalar, edges: int = _EDGES
) -> LineContactResult:
    """Line contact of a screw with a ring without a lead, by shape functions.

    In every slice at the distance r from the roller axis the gap along the arc is a parabola. Each
    slice is an independent Hertz line contact: with the normal coefficient A and the line load P,
    `B² = 2P/(π E* A)` and `p₀ = 2P/(π B)`, and its depth of contact is `A B² = 2P/(π E*)`. So with
    the gap e(r) the line load is `P(r) = (π E*/2) (δ − e(r))` where this is positive, and 0
    elsewhere. The force is the integral of P over the contact line; δ follows from the force.

    Slices do not influence their neighbours: the free ends of a line have no stress concentration
    here, and δ is not the approach of two half-spaces, which grows with the logarithm of the
    length. Where `edge_ratio` is near 2 or `loaded_share` is small, the flanks bear on an edge,
    which requires a contact solver on the true surfaces.

    **Arguments:**

    - `contact`: the flanks.
    - `axial_force`: axial force on this contact [N]; at or below zero the contact is open.
    - `modulus`: contact modulus E* [Pa].
    - `edges`: number of slices plus one.

    **Returns:** a `LineContactResult`; `converged` is false where the flanks do not overlap or no
    approach was found. Differentiable, through the load by the implicit function theorem.
    """
    slices = slice_geometry(contact, edges)
    width = (slices.radius[-1] - slices.radius[0]) / (edges - 1)
    # Length of the contact line, which runs along the ring's generator.
    length = width / jnp.cos(contact.roller_profile_angle)
    axial = (slices.normal[:-1] + slices.normal[1:]) / 2
    spring = jnp.pi / 2 * modulus
    loaded = above_or_nan(axial_force)
    force = jnp.where(loaded, axial_force, 1.0)

    # In units of the approach at which all slices share the load, negative overlaps included. There
    # the force is overestimated, so Newton's steps on a convex function cannot overshoot.
    mean_axial = jnp.mean(axial)
    mean_gap = jnp.mean(axial * (slices.gap[:-1] + slices.gap[1:]) / 2) / mean_axial
    unit = force / (spring * length * (edges - 1) * mean_axial) + mean_gap

    def carried(approach: Scalar) -> Scalar:
        return spring * length * jnp.sum(axial * _overlap_per_slice(approach - slices.gap)[0])

    scaled, root_converged = find_root(
        lambda share: carried(share * unit) / force - 1,
        jnp.ones_like(unit),
        tolerance=1e-12 if unit.dtype == jnp.float64 else 1e-5,
        max_steps=64,
    )
    approach = jnp.where(loaded, scaled * unit, 0.0)

    overlap = approach - slices.gap
    depth = jnp.maximum(overlap, 0.0)
    touching = above_or_nan(depth)
    line_load = spring * depth
    safe = jnp.where(touching, line_load, 1.0)
    half_width = jnp.where(
        touching, jnp.sqrt(2 * safe / (jnp.pi * modulus * slices.coefficient)), 0.0
    )
    pressure = jnp.where(touching, jnp.sqrt(2 * safe * modulus * slices.coefficient / jnp.pi), 0.0)
    mean_overlap, share = _overlap_per_slice(overlap)
    per_slice = spring * mean_overlap
    loaded_share = jnp.mean(share)
    mean_load = jnp.mean(per_slice) / jnp.where(above_or_nan(loaded_share), loaded_share, 1.0)
    has_load = above_or_nan(mean_load)
    worst = jnp.argmax(pressure)
    radius = slices.radius[worst]
    fit = fit_parabola(
        contact,
        radius,
        ring_vertex(contact, radius),
        jnp.where(touching[worst], half_width[worst], width),
    )
    return LineContactResult(
        slices=slices,
        line_load=line_load,
        half_width=half_width,
        pressure=pressure,
        depth=depth,
        axial_force=length * jnp.sum(axial * per_slice),
        normal_force=length * jnp.sum(per_slice),
        approach=approach,
        stiffness_tangent=jnp.where(loaded, spring * length * jnp.sum(axial**2 * share), 0.0),
        max_pressure=jnp.max(pressure),
        max_half_width=jnp.max(half_width),
        loaded_share=loaded_share,
        edge_ratio=jnp.where(
            has_load, jnp.max(line_load) / jnp.where(has_load, mean_load, 1.0), 1.0
        ),
        parabola_fit=fit.determination,
        converged=slices.converged & root_converged,
    )


def line_contact(stage: Stage, load: Scalar, edges: int = _EDGES) -> LineContactResult:
    """Line contact of one ring with the screw; all rings of all rollers share the load equally.

    **Arguments:**

    - `stage`: the stage; needs `line_contact`, materials and `engaged_threads`.
    - `load`: axial load of the stage [N]; its sign is ignored.
    - `edges`: number of slices plus one.

    **Returns:** a `LineContactResult`; see `line_contact_under_force`.

    **Raises:** `MissingDataError` if the flanks, materials or engaged threads are not given.
    """
    if stage.line_contact is None:
        raise MissingDataError(
            "the stage has no line_contact; give [stage.line_contact], the flanks of screw and ring"
        )
    modulus = contact_modulus(material_of(stage, "roller"), material_of(stage, "screw"))
    shared = jnp.abs(load) / (stage.present_roller_count * engaged_threads(stage))
    return line_contact_under_force(stage.line_contact, shared, modulus, edges)
