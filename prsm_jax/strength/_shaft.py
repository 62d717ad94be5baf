"""Buckling and critical speed of the screw."""

import math

import jax.numpy as jnp

from .._errors import MissingDataError
from ..fields import Scalar
from ..mechanism import (
    EndConditions,
    ScrewShaft,
    Stage,
    material_of,
    screw_root_radius,
    screw_section,
)
from ..programs import physics
from ._contacts import strength_of

#: Length of a half wave over that of the column (Timoshenko and Gere 1961, chapter 2).
_EFFECTIVE_LENGTH: dict[EndConditions, float] = {
    "fixed_free": 2.0,
    "supported_supported": 1.0,
    "fixed_supported": math.pi / 4.493409457909064,  # tan x = x
    "fixed_fixed": 0.5,
}
#: First roots of the frequency equations of bending (Blevins 1979, table 8-1): cos x cosh x = −1,
#: sin x = 0, tan x = tanh x, cos x cosh x = 1.
_BENDING_ROOT: dict[EndConditions, float] = {
    "fixed_free": 1.8751040687119612,
    "supported_supported": math.pi,
    "fixed_supported": 3.9266023120479187,
    "fixed_fixed": 4.730040744862704,
}


def shaft_of(stage: Stage) -> ScrewShaft:
    """The shaft data of a stage.

    **Raises:** `MissingDataError` if there are none.
    """
    shaft = strength_of(stage).shaft
    if shaft is None:
        raise MissingDataError(
            "the stage has no shaft data; give [stage.strength.shaft] with end_conditions"
        )
    return shaft


def root_radius(stage: Stage) -> Scalar:
    """Radius at the root of the screw's thread [m].

    As given; else r_s minus the dedendum of the tooth of `load_sharing`; else the largest that the
    crests of the rollers allow, r_s minus their addendum.

    **Raises:** `MissingDataError` if neither is known.
    """
    shaft_of(stage)
    return screw_root_radius(stage)


def unsupported_length(stage: Stage) -> Scalar:
    """Longest length between the supports of the screw; the nut is not a support [m].

    **Raises:** `MissingDataError` if neither it nor the screw's length is given.
    """
    shaft = shaft_of(stage)
    if shaft.unsupported_length is not None:
        return shaft.unsupported_length
    if stage.screw.length is None:
        raise MissingDataError(
            "the unsupported length is not known; give stage.strength.shaft.unsupported_length, "
            "or stage.screw.length"
        )
    return stage.screw.length


def loaded_length(stage: Stage) -> Scalar:
    """Longest length under axial load: as given, or the unsupported length [m].

    **Raises:** `MissingDataError` as in `unsupported_length`.
    """
    length = shaft_of(stage).loaded_length
    return unsupported_length(stage) if length is None else length


def _section(stage: Stage) -> tuple[Scalar, Scalar]:
    """Area [m²] and square of the radius of gyration [m²] of the root's section."""
    shaft_of(stage)
    section = screw_section(stage)
    return section.area, section.gyration_squared


def shaft_axial_stiffness(stage: Stage) -> Scalar:
    """Axial stiffness E A/l of the screw between its thrust bearing and the nut [N/m].

    With the root's section over the loaded length, from the bearing at one end to the nut at the
    far end.

    **Raises:** `MissingDataError` without shaft data or material.
    """
    area, _ = _section(stage)
    return material_of(stage, "screw").youngs_modulus * area / loaded_length(stage)


def slenderness_ratio(stage: Stage, length: Scalar | None = None) -> Scalar:
    """Effective length over radius of gyration of the root's section.

    **Arguments:**

    - `stage`: the stage, with shaft data.
    - `length`: loaded length [m]; default: that of the file.

    **Raises:** `MissingDataError` if data are missing.
    """
    length = loaded_length(stage) if length is None else length
    _, gyration_squared = _section(stage)
    return _EFFECTIVE_LENGTH[shaft_of(stage).end_conditions] * length / jnp.sqrt(gyration_squared)


@physics("buckling")
def buckling_load(stage: Stage, length: Scalar | None = None) -> Scalar:
    r"""Axial load at which the screw buckles [N].

    With the slenderness $s$ = effective length over radius of gyration, Euler's
    $\sigma = \pi^2 E/s^2$ above $s_1 = \sqrt{2\pi^2 E/\sigma_y}$, and below it Johnson's parabola
    $\sigma = \sigma_y (1 - \sigma_y s^2/(4\pi^2 E))$, which joins at $\sigma_y/2$ with the same
    slope (Timoshenko and Gere 1961; Johnson 1893). Euler alone if no yield strength is given.

    Range: a straight screw loaded on its axis, with the section of the thread's root. A factor of
    safety must be added (catalogues of ball screws use 2).

    **Arguments:**

    - `stage`: the stage, with shaft data.
    - `length`: loaded length [m], from the nut to the bearing that takes the load; default that of
        the file.

    **Raises:** `MissingDataError` if lengths, root radius or material are missing.
    """
    area, _ = _section(stage)
    modulus = material_of(stage, "screw").youngs_modulus
    square = slenderness_ratio(stage, length) ** 2
    strength = shaft_of(stage).yield_strength
    if strength is None:
        return area * jnp.pi**2 * modulus / square
    slender = square > 2 * jnp.pi**2 * modulus / strength
    euler = jnp.pi**2 * modulus / jnp.where(slender, square, 1.0)
    johnson = strength * (1 - strength * square / (4 * jnp.pi**2 * modulus))
    return area * jnp.where(slender, euler, johnson)


def buckling_stress(stage: Stage, length: Scalar | None = None) -> Scalar:
    """Buckling load over the section of the thread's root [Pa].

    **Arguments:** as in `buckling_load`.

    **Raises:** `MissingDataError` as `buckling_load`.
    """
    area, _ = _section(stage)
    return buckling_load(stage, length) / area


@physics("whirling")
def critical_speed(stage: Stage, length: Scalar | None = None) -> Scalar:
    r"""Speed at which the screw whirls, its first bending frequency [rad/s].

    $\Omega = (\beta/l)^2 \sqrt{E I/(\rho A)}$ with the section of the thread's root for stiffness
    and mass (as in catalogues of ball screws and in ISO 3408 practice), $\beta$ from the end
    conditions (Blevins 1979).

    Range: a slender screw (l above 20 radii of gyration; shear and rotary inertia neglected), no
    axial load, rigid bearings, the nut in the position of least support.

    **Arguments:**

    - `stage`: the stage, with shaft data and the density of the screw.
    - `length`: unsupported length [m]; default: that of the file.

    **Raises:** `MissingDataError` if lengths, root radius, material or density are missing, or if
    the screw does not turn.
    """
    if stage.thread.family.turning != "screw":
        raise MissingDataError(
            f"the screw of an {stage.type} roller screw does not turn, so it has no critical speed"
        )
    length = unsupported_length(stage) if length is None else length
    material = material_of(stage, "screw")
    if material.density is None:
        raise MissingDataError("the screw's material has no density; give it for critical speeds")
    _, gyration_squared = _section(stage)
    wave = _BENDING_ROOT[shaft_of(stage).end_conditions] / length
    return wave**2 * jnp.sqrt(material.youngs_modulus * gyration_squared / material.density)


def dn_value(stage: Stage, speed: Scalar) -> Scalar:
    """Nominal diameter times speed, limited by lubrication and roller inertia [m·rad/s].

    **Arguments:**

    - `stage`: the stage.
    - `speed`: of the body that turns [rad/s].

    **Raises:** `MissingDataError` if the stage has no shaft data.
    """
    shaft_of(stage)
    return 2 * stage.thread.screw_radius * jnp.abs(speed)


def permissible_speed(stage: Stage, length: Scalar | None = None) -> Scalar:
    """Lower of the permissible share of the critical speed and the speed at the DN limit.

    Where the nut turns it is the speed at the DN limit.

    **Arguments:**

    - `stage`: the stage, with shaft data.
    - `length`: unsupported length [m]; default: that of the file.

    **Returns:** the screw speed [rad/s].

    **Raises:** `MissingDataError` as in `critical_speed`.
    """
    shaft = shaft_of(stage)
    if stage.thread.family.turning != "screw" and shaft.dn_limit is not None:
        return shaft.dn_limit / (2 * stage.thread.screw_radius)
    speed = shaft.permissible_speed_share * critical_speed(stage, length)
    if shaft.dn_limit is None:
        return speed
    return jnp.minimum(speed, shaft.dn_limit / (2 * stage.thread.screw_radius))
