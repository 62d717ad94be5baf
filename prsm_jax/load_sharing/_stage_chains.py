"""The chains of a stage: sections, teeth, contacts and gaps from its numbers."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._errors import MissingDataError
from ..contact import (
    ContactFrame,
    HertzContact,
    StageContact,
    ThreadContactSide,
    contact_frames,
    contact_pair,
    meshing_of,
)
from ..fields import CountOrTraced, Scalar
from ..geometry import Meshing
from ..mechanism import LoadSharing, Stage, material_of, nut_outer_radius
from ..numerics import apart, largest, smallest
from ..programs import physics
from ._chains import Chains
from ._flank_law import flank_approach, flank_force
from ._flanks import Flanks
from ._roller_bending import roller_shapes
from ._yamamoto import ToothCompliance, ToothedBody, compliances_of
from .part_errors import (
    GapOpening,
    Places,
    contact_places,
    free_nut_displacements,
    gap_opening,
    joined,
)

#: Stiffness of the regularising springs over that of a typical contact, in double and single
#: precision, and the factor by which they may be softer where play and errors are large.
_REGULARISATION = {True: 1e-12, False: 1e-6}
_SOFTEST = 1e-2
#: Radial stiffness of a roller's support over the stiffness of all its threads: enough to determine
#: its radial position where threads leave it free, too little to carry load elsewhere.
_RADIAL_REGULARISATION = 1e-7


class StageChains(eqx.Module):
    """The chains of a stage, and the contacts that relate forces on threads to pressures."""

    chains: Chains
    #: Hertz contacts of screw and nut side under a normal force of 1 N.
    screw_unit_contact: HertzContact
    nut_unit_contact: HertzContact
    #: Normal force per axial force, screw and nut side.
    screw_normal: Scalar
    nut_normal: Scalar
    #: Whether the threads mesh.
    meshing_converged: Bool[Array, ""]
    #: Numbers of the rollers of each class, from 1.
    rollers: tuple[tuple[int, ...], ...] = eqx.field(static=True)


def sharing_of(stage: Stage) -> LoadSharing:
    """The load sharing data of a stage.

    **Raises:** `MissingDataError` if it has none.
    """
    if stage.load_sharing is None:
        raise MissingDataError(
            "the stage has no load_sharing; give [stage.load_sharing] with thread_count"
        )
    return stage.load_sharing


def roller_classes(stage: Stage) -> tuple[tuple[int, ...], ...]:
    """Numbers of the rollers of each class: the nominal ones first, then each unequal one.

    With errors of parts, or a free nut, each is a class of its own, in the order of their numbers.
    Of a traced number of rollers, which are equal, only the first is named.
    """
    if not isinstance(stage.roller_count, int):
        return ((1,),)
    if stage.load_sharing is not None and stage.load_sharing.rollers_differ:
        missing = {roller.number for roller in stage.unequal_roller if roller.missing}
        return tuple((n,) for n in range(1, stage.roller_count + 1) if n not in missing)
    unequal = {
        roller.number: roller
        for roller in stage.unequal_roller
        if roller.missing or roller.carries_otherwise
    }
    nominal = tuple(n for n in range(1, stage.roller_count + 1) if n not in unequal)
    others = tuple((n,) for n, roller in sorted(unequal.items()) if not roller.missing)
    return ((nominal,) if nominal else ()) + others


def _weights(stage: Stage, rollers, dtype) -> Float[Array, " classes"]:
    """Number of rollers of each class."""
    count: CountOrTraced = stage.roller_count
    if not isinstance(count, int):
        return jnp.asarray(count, dtype)[None]
    return jnp.asarray([len(numbers) for numbers in rollers], dtype)


def places_of(stage: Stage) -> Places | None:
    """Places of the contacts where rollers have loads of their own by their places, else `None`."""
    sharing = sharing_of(stage)
    if not sharing.rollers_differ:
        return None
    return contact_places(stage, roller_classes(stage), sharing.thread_count)


def _section(stage: Stage, body: str) -> tuple[Scalar, Scalar]:
    """Inner and outer radius of a body's section [m].

    **Raises:** `MissingDataError` without the wall thickness of the nut.
    """
    tooth = sharing_of(stage).tooth
    depth = 0.0 if tooth is None else getattr(tooth, f"{body}_dedendum")
    radius = getattr(stage.thread, f"{body}_radius")
    if body == "nut":
        return radius + depth, nut_outer_radius(stage)
    bore = getattr(stage, body).bore_radius
    return jnp.zeros_like(radius) if bore is None else bore, radius - depth


@physics("shaft_torsion")
def _twist(stage: Stage, body: str) -> Scalar:
    """Axial travel of a body's thread by its twist over one pitch, per axial force [m/N].

    A force F on a frictionless thread has the torque F L/2π, and a twist φ moves the thread along
    the axis by φ L/2π: `(L/2π)² p/(G J)`.
    """
    thread, material = stage.thread, material_of(stage, body)
    inner, outer = _section(stage, body)
    advance = thread.lead / (2 * jnp.pi)
    modulus = material.youngs_modulus / (2 * (1 + material.poisson_ratio))
    return advance**2 * thread.pitch / (modulus * jnp.pi / 2 * (outer**4 - inner**4))


def segment_compliances(stage: Stage) -> dict[str, Scalar]:
    """Axial compliance of screw, roller and nut over one pitch [m/N].

    Given, or p/(E A) with what `torsion` adds. Sections reach from the bore to the root of the
    thread where the teeth are given, else to its nominal radius; the nut is a sleeve.

    **Raises:** `MissingDataError` without stiffness, material or wall thickness.
    """
    sharing, thread = sharing_of(stage), stage.thread
    compliances = {}
    for body in ("screw", "roller", "nut"):
        stiffness = getattr(sharing, f"{body}_segment_stiffness")
        if stiffness is not None:
            compliances[body] = 1 / stiffness
            continue
        inner, outer = _section(stage, body)
        area = jnp.pi * (outer**2 - inner**2)
        compliances[body] = thread.pitch / (material_of(stage, body).youngs_modulus * area)
        # Grooves, of rollers or of a differential type's nut, have no torque.
        threaded = body == "screw" or (body == "nut" and thread.family.lead_is_fixed)
        if sharing.torsion and threaded:
            compliances[body] = compliances[body] + _twist(stage, body)
    return compliances


def tooth_compliances(stage: Stage) -> dict[str, ToothCompliance] | None:
    """Yamamoto's compliances per unit length of screw, roller and nut teeth, or `None`.

    **Raises:** `MissingDataError` without material or wall thickness.
    """
    tooth, thread = sharing_of(stage).tooth, stage.thread
    if tooth is None:
        return None
    names, thickness = ("screw", "roller", "nut"), tooth.pitch_line_thickness
    bodies = [
        ToothedBody(
            material_of(stage, body),
            getattr(tooth, f"{body}_dedendum"),
            getattr(thread, f"{body}_radius"),
            nut_outer_radius(stage) if body == "nut" else None,
        )
        for body in names
    ]
    thickness = thread.pitch / 2 if thickness is None else thickness
    found = compliances_of(bodies, thread.flank_angle, thread.pitch, thickness)
    return dict(zip(names, found, strict=True))


def _teeth(stage: Stage) -> dict[str, Scalar] | None:
    """Compliance of one tooth of each body under one contact [m/N], where teeth are given."""
    compliances, tooth = tooth_compliances(stage), sharing_of(stage).tooth
    if compliances is None or tooth is None:
        return None
    teeth = {}
    for body, compliance in compliances.items():
        length = tooth.radial_length
        if length is None:
            # Each turn of screw and nut has one contact per roller, each turn of a roller one per
            # side.
            sharers = 1 if body == "roller" else stage.present_roller_count
            length = 2 * jnp.pi * getattr(stage.thread, f"{body}_radius") / sharers
        own = (compliance.total - compliance.radial) / tooth.effective_length
        teeth[body] = own + compliance.radial / length
    return teeth


def _sum(terms: list[Array | None], count: int, dtype) -> Float[Array, " threads"]:
    return sum((term for term in terms if term is not None), jnp.zeros((count,), dtype))


def _flanks(
    stage: Stage,
    side: str,
    unit: HertzContact,
    frame: ContactFrame,
    rollers,
    teeth: dict[str, Scalar] | None,
    opening: GapOpening | None,
) -> Flanks:
    """Gaps and compliances of one side, a row per class."""
    sharing, dtype = sharing_of(stage), stage.thread.lead.dtype
    count = sharing.thread_count
    # A pitch error closes the gap in front of a tooth and opens the one behind it.
    bodies = ("screw", "roller") if side == "screw" else ("roller", "nut")
    behind, ahead = (getattr(sharing, f"{body}_pitch_error") for body in bodies)
    shift = _sum([None if behind is None else -behind, ahead], count, dtype)
    relief = _sum([getattr(sharing, f"{side}_relief")], count, dtype)
    forward = shift + _sum([relief, getattr(sharing, f"{side}_wear")], count, dtype)

    unequal = {roller.number: roller for roller in stage.unequal_roller}

    def per_class(name: str, default: float) -> Float[Array, "classes 1"] | None:
        values = [getattr(unequal.get(numbers[0]), name, None) for numbers in rollers]
        if all(value is None for value in values):
            return None
        default_value = jnp.full((), default, dtype)
        return jnp.stack([default_value if value is None else value for value in values])[:, None]

    classes = len(rollers)
    thinning = per_class("tooth_thinning", 0.0)
    thinner = jnp.zeros((classes, 1), dtype) if thinning is None else thinning / 2
    reverse = None
    if sharing.has_reverse_flanks:
        play = jnp.zeros((), dtype) if sharing.backlash is None else sharing.backlash / 2
        reverse = (play - shift + relief)[None, :] + thinner
    hertz = unit.approach * frame.normal_per_axial ** (5 / 3)
    tooth = None if teeth is None else teeth[bodies[0]] + teeth[bodies[1]]
    factor = per_class("stiffness_factor", 1.0)
    if factor is None:
        factor = jnp.ones((classes, 1), dtype)
    gap = forward[None, :] + thinner
    if opening is not None:
        gap = gap + opening.radial + opening.axial
        reverse = None if reverse is None else reverse + opening.radial - opening.axial
    return Flanks(
        gap=gap,
        reverse_gap=reverse,
        hertz=hertz / factor ** (2 / 3),
        tooth=None if tooth is None else tooth / factor,
    )


def _under_one_newton(side: ThreadContactSide) -> HertzContact:
    """The same contact under a normal force of 1 N: lengths and pressure by the cube root."""
    hertz, root = side.hertz, jnp.cbrt(side.normal_force)
    return HertzContact(
        semi_major=hertz.semi_major / root,
        semi_minor=hertz.semi_minor / root,
        max_pressure=hertz.max_pressure / root,
        approach=hertz.approach / root**2,
        stiffness=hertz.stiffness / root,
        stiffness_tangent=hertz.stiffness_tangent / root,
        second_elliptic_integral=hertz.second_elliptic_integral,
    )


def regularised(
    chains: Chains,
    load: Scalar | None = None,
    deflection: Scalar | None = None,
    preload: Scalar | None = None,
) -> Chains:
    """The chains with a typical force on a thread, and regularising springs of suitable stiffness.

    The springs are differentiated too. They change loads by about 1e-9.
    """
    zero = jnp.zeros((), chains.weight.dtype)
    load, deflection, preload = (
        zero if one is None else one for one in (load, deflection, preload)
    )
    sides, count = (chains.screw, chains.nut), chains.screw.gap.shape[1]
    reach = jnp.abs(deflection) / 2
    if chains.offset is not None:
        reach = reach + jnp.abs(chains.offset) / 4
    span = zero
    for side in sides:
        span = jnp.maximum(span, largest(side.gap) - smallest(side.gap))
        if side.reverse_gap is not None:
            play = side.gap + side.reverse_gap
            span = jnp.maximum(span, largest(jnp.abs(play)))
            reach = jnp.maximum(reach, -smallest(play) / 2)
    force = (jnp.abs(load) + jnp.abs(preload)) / (jnp.sum(chains.weight) * count)
    if chains.displacements is not None:
        loads = jnp.sum(jnp.abs(chains.displacements.load))
        force = force + loads / (jnp.sum(chains.weight) * count)
    if deflection is not zero or chains.offset is not None or sides[0].reverse_gap is not None:
        for side in sides:
            pressed = jnp.broadcast_to(reach, (*chains.weight.shape, 1))
            force = force + jnp.mean(flank_force(pressed, side.hertz, side.tooth)) / 2
    force = jnp.where(force > 0, force, 1.0)
    length = zero
    for side in sides:
        forces = jnp.broadcast_to(force, (*chains.weight.shape, 1))
        length = length + jnp.mean(flank_approach(forces, side.hertz, side.tooth)) / 2
    regularisation = jnp.maximum(force / (length + span), _SOFTEST * force / length)
    regularisation = _REGULARISATION[zero.dtype == jnp.float64] * regularisation
    radial = _RADIAL_REGULARISATION * force / length * count
    return eqx.tree_at(regularisation_of, chains, (regularisation, force, radial))


def regularisation_of(chains: Chains):
    """The numbers that `regularised` sets, for `eqx.tree_at`."""
    return chains.regularisation, chains.typical_force, chains.radial_regularisation


def stage_chains(
    stage: Stage, meshing: Meshing | None = None, contact: StageContact | None = None
) -> StageChains:
    """The chains of a stage, without regularisation (see `regularised`).

    **Arguments:**

    - `stage`: the stage; needs `load_sharing`, materials, and sections or segment stiffnesses.
    - `meshing`: its meshing, if known already; only the `"exact"` curvatures use it.
    - `contact`: its contacts under some load above 0, if known already.

    **Raises:** `MissingDataError` if data are missing.
    """
    sharing, dtype = sharing_of(stage), stage.thread.lead.dtype
    meshing = meshing_of(stage, meshing)
    frames = contact_frames(stage.thread, meshing, stage.curvature)
    rollers = roller_classes(stage)
    if contact is None:
        units = contact_pair(stage, frames, (jnp.ones((), dtype), jnp.ones((), dtype)))
    else:
        units = _under_one_newton(contact.screw), _under_one_newton(contact.nut)
    teeth = apart(_teeth, whole=True)(stage)
    places = places_of(stage)

    def opening_of(side: str) -> GapOpening | None:
        errors = sharing.part_errors
        if errors is None or places is None:
            return None
        return gap_opening(stage, errors, side, rollers, places)

    weight = _weights(stage, rollers, dtype)
    of_nut = of_rollers = None
    if sharing.free_nut is not None and places is not None:
        both = sharing.has_reverse_flanks
        of_nut = free_nut_displacements(stage, sharing.free_nut, places, both)
    if sharing.roller_bending is not None:
        section = _section(stage, "roller")
        of_rollers = roller_shapes(stage, sharing, section, weight, places)
    flanks = [
        _flanks(stage, side, unit, frame, rollers, teeth, opening_of(side))
        for side, unit, frame in zip(("screw", "nut"), units, frames, strict=True)
    ]
    segments = (sharing.thread_count - 1,)
    compliances = {
        body: jnp.broadcast_to(value, segments)
        for body, value in segment_compliances(stage).items()
    }
    offset, split = None, None
    if sharing.split_nut is not None:
        split, offset = sharing.split_nut.after_thread - 1, sharing.split_nut.offset
        spacer = sharing.split_nut.spacer_stiffness
        if spacer is not None:
            compliances["nut"] = compliances["nut"].at[split].set(1 / spacer)
    chains = Chains(
        weight=weight,
        screw=flanks[0],
        nut=flanks[1],
        screw_segment=compliances["screw"],
        roller_segment=compliances["roller"],
        nut_segment=compliances["nut"],
        regularisation=jnp.zeros((), dtype),
        typical_force=jnp.ones((), dtype),
        radial_regularisation=jnp.zeros((), dtype),
        offset=offset,
        split=split,
        same_end=sharing.mounting == "same_end",
        displacements=joined(of_nut, of_rollers),
    )
    meshed = jnp.asarray(True) if meshing is None else meshing.converged
    normals = [frame.normal_per_axial for frame in frames]
    return StageChains(chains, units[0], units[1], normals[0], normals[1], meshed, rollers)
