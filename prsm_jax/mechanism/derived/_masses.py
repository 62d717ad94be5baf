"""Masses and inertias: given, or derived from dimensions by the mass rule of the stage.

By default bodies are cylinders with bores; with `mass_rule = "thread_profile"` screw, rollers and
nut have the exact volume of their threads.

All functions are pure in the numbers; which branch is taken depends on the data that are present.
Each raises `MissingDataError` if neither a value nor the dimensions for it are given.
"""

import jax.numpy as jnp

from ..._errors import MissingDataError
from ...fields import Scalar
from .._mechanism import Stage
from ..parts import Carrier, Material, Nut, RingGear, Roller, Screw, total_factor
from ._thread_sections import ThreadSection, thread_section


def material_of(stage: Stage, body: str) -> Material:
    """The material of a body (`"screw"`, `"roller"`, …): its own, or the stage's.

    **Raises:** `MissingDataError` if neither is given.
    """
    part = getattr(stage, body)
    own = part.material if part is not None else None
    if own is not None:
        return own
    if stage.material is not None:
        return stage.material
    raise MissingDataError(
        f"the {body} has no material; give [stage.material] or [stage.{body}.material] with "
        "youngs_modulus and poisson_ratio"
    )


def _density(stage: Stage, body: str, needed_for: str) -> Scalar:
    density = material_of(stage, body).density
    if density is None:
        raise MissingDataError(
            f"the {body} has no {needed_for} and its material no density; "
            f"give stage.{body}.{needed_for} or the density"
        )
    return density


def _needs(value: Scalar | None, body: str, name: str, needed_for: str) -> Scalar:
    if value is None:
        raise MissingDataError(
            f"the {body} has neither {needed_for} nor {name}; give stage.{body}.{needed_for}, or "
            f"stage.{body}.{name} to derive it from dimensions"
        )
    return value


def _annulus(stage: Stage, body: str, needed_for: str) -> tuple[Scalar, Scalar, Scalar]:
    """Inner radius, outer radius and length of the cylinder that represents a body [m]."""
    part, thread = getattr(stage, body), stage.thread
    length = _needs(part.length, body, "length", needed_for)
    if isinstance(part, Screw | Roller):
        outer = thread.screw_radius if isinstance(part, Screw) else thread.roller_radius
        inner = jnp.zeros_like(outer) if part.bore_radius is None else part.bore_radius
    elif isinstance(part, Nut | RingGear):
        inner = thread.nut_radius
        outer = inner + _needs(part.wall_thickness, body, "wall_thickness", needed_for)
    else:
        width = _needs(part.radial_width, body, "radial_width", needed_for)
        inner = thread.centre_distance - width / 2
        outer = thread.centre_distance + width / 2
    return inner, outer, length


def _follows_profile(stage: Stage, body: str) -> bool:
    """Whether a derived mass is that of a thread profile; ring gear and carriers have no thread."""
    return stage.mass_rule == "thread_profile" and body in ("screw", "roller", "nut")


def _profile_section(stage: Stage, body: str, needed_for: str) -> tuple[ThreadSection, Scalar]:
    """Section of the material of a threaded body, and its length [m]."""
    inner, outer, length = _annulus(stage, body, needed_for)
    thread = thread_section(stage, body)  # type: ignore[arg-type]
    other = outer if body == "nut" else inner
    cylinder = ThreadSection(jnp.pi * other**2, jnp.pi / 2 * other**4)
    larger, smaller = (cylinder, thread) if body == "nut" else (thread, cylinder)
    return (
        ThreadSection(
            larger.area - smaller.area,
            larger.polar_moment - smaller.polar_moment,
        ),
        length,
    )


def body_mass(stage: Stage, body: str) -> Scalar:
    """Mass of one piece of a body [kg]: given, or π ρ l (R² − r²).

    With `mass_rule = "thread_profile"`, a screw, roller or nut has ρ l A with the area A of its
    section (`thread_section`).

    **Arguments:**

    - `stage`: the stage.
    - `body`: `"screw"`, `"roller"`, `"nut"`, `"ring_gear"` or `"carrier"`.

    **Raises:** `MissingDataError` if the body is absent or its data are incomplete.
    """
    part: Screw | Roller | Nut | RingGear | Carrier | None = getattr(stage, body)
    if part is None:
        raise MissingDataError(f"the stage has no {body}; give [stage.{body}]")
    if part.mass is not None:
        return part.mass
    if _follows_profile(stage, body):
        section, length = _profile_section(stage, body, "mass")
        return _density(stage, body, "mass") * length * section.area
    inner, outer, length = _annulus(stage, body, "mass")
    return jnp.pi * _density(stage, body, "mass") * length * (outer**2 - inner**2)


def body_inertia(stage: Stage, body: str) -> Scalar:
    """Moment of inertia of one piece of a body about its own axis [kg·m²].

    Given, or ½ m (R² + r²) of the cylinder with bore (the mass given or derived). With
    `mass_rule = "thread_profile"`, a screw, roller or nut has m I / A with area and polar second
    moment of its section (`thread_section`).

    **Arguments:**

    - `stage`: the stage.
    - `body`: `"screw"`, `"roller"`, `"nut"`, `"ring_gear"` or `"carrier"`.

    **Raises:** `MissingDataError` if the body is absent or its data are incomplete.
    """
    part = getattr(stage, body)
    if part is None:
        raise MissingDataError(f"the stage has no {body}; give [stage.{body}]")
    if part.inertia is not None:
        return part.inertia
    if _follows_profile(stage, body):
        section, _ = _profile_section(stage, body, "inertia")
        return body_mass(stage, body) * section.polar_moment / section.area
    inner, outer, _ = _annulus(stage, body, "inertia")
    return body_mass(stage, body) * (outer**2 + inner**2) / 2


def tilting_inertia(stage: Stage, body: str) -> Scalar:
    """Moment of inertia of screw, roller or nut about a diameter through its middle [kg·m²].

    `J/2 + m l²/12` of a body of uniform section, with its moment of inertia J about the axis, mass
    m and length l.

    **Arguments:**

    - `stage`: the stage.
    - `body`: `"screw"`, `"roller"` or `"nut"`.

    **Raises:** `MissingDataError` if the body is absent or its data are incomplete.
    """
    inertia, mass = body_inertia(stage, body), body_mass(stage, body)
    length = getattr(stage, body).length
    if length is None:
        raise MissingDataError(f"the tilt of the {body} needs its length; give stage.{body}.length")
    return inertia / 2 + mass * length**2 / 12


def _mean(stage: Stage, nominal: Scalar) -> Scalar:
    total = total_factor(stage.unequal_roller, stage.roller_count, "mass_factor")
    return nominal if isinstance(total, int) else nominal * (total / stage.present_roller_count)


def mean_roller_mass(stage: Stage) -> Scalar:
    """Mean mass of the rollers present [kg]; `body_mass` if all are equal.

    **Raises:** `MissingDataError` as in `body_mass`.
    """
    return _mean(stage, body_mass(stage, "roller"))


def mean_roller_inertia(stage: Stage) -> Scalar:
    """Mean moment of inertia of the rollers present, about their own axes [kg·m²].

    **Raises:** `MissingDataError` as in `body_inertia`.
    """
    return _mean(stage, body_inertia(stage, "roller"))


def nut_outer_radius(stage: Stage) -> Scalar:
    """Outer radius of the nut r_n + wall [m]."""
    wall = _needs(stage.nut.wall_thickness, "nut", "wall_thickness", "outer radius")
    return stage.thread.nut_radius + wall


def nut_unit_mass(stage: Stage) -> Scalar:
    """Mass of the nut with what it carries [kg]: rollers; ring gear, carriers if present.

    In an inverted roller screw, where the screw carries the rollers, that of the screw with them.

    **Raises:** `MissingDataError` as in `body_mass`.
    """
    held = body_mass(stage, stage.thread.family.held)
    mass = held + stage.present_roller_count * mean_roller_mass(stage)
    if stage.ring_gear is not None:
        mass = mass + body_mass(stage, "ring_gear")
    if stage.carrier is not None:
        mass = mass + stage.carrier.count * body_mass(stage, "carrier")
    return mass


def stage_mass(stage: Stage) -> Scalar:
    """Mass of all bodies of a stage [kg]: screw, rollers, nut; ring gear, carriers if present."""
    return body_mass(stage, stage.thread.family.turning) + nut_unit_mass(stage)
