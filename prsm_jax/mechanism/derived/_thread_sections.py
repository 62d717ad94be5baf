r"""Sections of threaded bodies from the profile of their threads, for masses by that profile.

A plane across the axis cuts a helical thread in the same curve at every height, turned about the
axis. With the radius $r(s)$ of the profile over a pitch $p$, the section inside this curve has the
area and the polar second moment

$$A = \frac{\pi}{p}\int_0^p r^2\,\mathrm{d}s, \qquad
I = \frac{\pi}{2p}\int_0^p r^4\,\mathrm{d}s,$$

those of the same profile turned about the axis (theorem of Pappus and Guldin), so volume and moment
of inertia are exact over any length. By parts, with half the thickness $h(y)$ of a tooth at the
height $y$ above the nominal radius, $r = R + \sigma y$, addendum $a$ and dedendum $d$,

$$\int_0^p r^k\,\mathrm{d}s
= p\,(R - \sigma d)^k + 2 k \sigma \int_{-d}^{a} h\,r^{k-1}\,\mathrm{d}y,$$

which needs no derivatives of the profile. $\sigma$ is +1, and −1 for a nut.
"""

from typing import Literal, NamedTuple, TypeAlias

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._errors import MissingDataError
from ...fields import Scalar
from ...programs import physics
from .._mechanism import Stage

ThreadedPart: TypeAlias = Literal["screw", "roller", "nut"]

#: The greatest height of a tooth, as a share of that of a pointed one.
_HIGHEST = 0.98
#: Shares of the greatest height: the addendum of a thread where it is not given, and the clearance
#: between crest and root where no dedendum is given.
_USUAL_ADDENDUM, _CLEARANCE = 0.7, 0.1
#: Gauss–Legendre rule over a flank: exact for straight flanks; for arcs, whose radius is several
#: heights, it errs by rounding.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


class ThreadHeights(NamedTuple):
    """Heights of the crests above the nominal radii and depths of the roots below them [m]."""

    screw_addendum: Scalar
    roller_addendum: Scalar
    screw_dedendum: Scalar
    roller_dedendum: Scalar
    nut_dedendum: Scalar

    def of(self, body: ThreadedPart) -> tuple[Scalar, Scalar]:
        """Addendum and dedendum of a body; the thread of the nut is as high as the screw's [m]."""
        addendum = self.roller_addendum if body == "roller" else self.screw_addendum
        return addendum, getattr(self, f"{body}_dedendum")


def thread_heights(stage: Stage) -> ThreadHeights:
    """Heights and depths of the threads of a stage, as given or as usual [m].

    The greatest height is 0.98 of that of a pointed tooth. Addenda: given, or 0.7 of the greatest
    height. Dedenda: those of `load_sharing.tooth` and, for the screw, of
    `strength.shaft.root_radius`; otherwise the addendum of the thread that meshes there and a
    clearance of 0.1 of the greatest height. Larger values are cut to the greatest height.

    **Arguments:**

    - `stage`: the stage.
    """
    thread = stage.thread
    greatest = _HIGHEST * thread.pitch / (4 * jnp.tan(thread.flank_angle))
    screw, roller = (
        jnp.minimum(_USUAL_ADDENDUM * greatest if given is None else given, greatest)
        for given in (thread.screw_addendum, thread.roller_addendum)
    )
    depths: dict[str, Scalar] = {
        "screw": roller + _CLEARANCE * greatest,
        "roller": screw + _CLEARANCE * greatest,
        "nut": roller + _CLEARANCE * greatest,
    }
    if stage.load_sharing is not None and stage.load_sharing.tooth is not None:
        tooth = stage.load_sharing.tooth
        depths = {body: getattr(tooth, f"{body}_dedendum") for body in depths}
    shaft = None if stage.strength is None else stage.strength.shaft
    if shaft is not None and shaft.root_radius is not None:
        depths["screw"] = thread.screw_radius - shaft.root_radius
    return ThreadHeights(screw, roller, *(jnp.minimum(depths[body], greatest) for body in depths))


class ThreadSection(NamedTuple):
    """The section inside the thread of a body (outside it, for a nut up to a radius of 0)."""

    #: A [m²].
    area: Scalar
    #: Polar second moment of area I [m⁴].
    polar_moment: Scalar


def _nominal_half_thickness(stage: Stage, body: ThreadedPart) -> Scalar:
    """Half the axial thickness of a tooth at the nominal radius: p/4, less half the thinning."""
    play = None if stage.strength is None else stage.strength.play
    thinning = None if play is None else getattr(play, f"{body}_tooth_thinning")
    half = stage.thread.pitch / 4
    return half if thinning is None else half - thinning / 2


def pointed_height(stage: Stage, body: ThreadedPart) -> Scalar:
    r"""Height above the nominal radius at which the two flanks of a tooth meet [m].

    With half the thickness $h_0$ at the nominal radius, p/4 less half the thinning, and the flank
    angle α: $h_0/\tan α$ for the straight flanks of screw and nut;
    $\sqrt{ρ^2 - (ρ\cos α - h_0)^2} - ρ\sin α$ for the arcs of a roller. Arcs that end before they
    meet ($h_0 > ρ\cos α$) have $ρ(1 - \sin α)$, the height of their ends. 0 for teeth that are
    thinned to nothing.

    **Arguments:**

    - `stage`: the stage.
    - `body`: `"screw"`, `"roller"` or `"nut"`.
    """
    thread = stage.thread
    half = jnp.maximum(_nominal_half_thickness(stage, body), 0.0)
    if body != "roller":
        return half / jnp.tan(thread.flank_angle)
    radius, angle = thread.profile_radius, thread.flank_angle
    level, centre = radius * jnp.cos(angle), radius * jnp.sin(angle)
    rest = jnp.maximum(level - half, 0.0)
    # A quotient in place of the difference of nearly equal numbers.
    return (level - rest) * (level + rest) / (jnp.sqrt(radius**2 - rest**2) + centre)


def _half_thickness(
    stage: Stage, body: ThreadedPart, height: Float[Array, "*batch nodes"]
) -> Float[Array, "*batch nodes"]:
    """Half the axial thickness of a tooth at heights above the nominal radius [m]."""
    thread, nominal = stage.thread, _nominal_half_thickness(stage, body)
    angle = thread.flank_angle[..., None]
    if body == "roller":
        # √(ρ² − (y + ρ sin α)²) − ρ cos α without the difference of nearly equal numbers.
        radius = thread.profile_radius[..., None]
        centre, level = radius * jnp.sin(angle), radius * jnp.cos(angle)
        square = level**2 - height * (height + 2 * centre)
        arc = jnp.where(square > 0, jnp.sqrt(jnp.where(square > 0, square, 1.0)), 0.0)
        change = -height * (height + 2 * centre) / (arc + level)
    else:
        change = -height * jnp.tan(angle)
    # A pointed tooth ends below its crest, and teeth that touch have no root between them.
    return jnp.clip(nominal[..., None] + change, 0.0, thread.pitch[..., None] / 2)


@physics("thread_section")
def thread_section(stage: Stage, body: ThreadedPart) -> ThreadSection:
    """Area and polar second moment of the section within the thread of a body [m², m⁴].

    Edges are sharp, without roundings and chamfers. Of a nut it is the section of the opening.

    **Arguments:**

    - `stage`: the stage.
    - `body`: `"screw"`, `"roller"` or `"nut"`.

    **Raises:** `MissingDataError` without the addendum of the body.
    """
    thread = stage.thread
    needed = "roller_addendum" if body == "roller" else "screw_addendum"
    if getattr(thread, needed) is None:
        raise MissingDataError(
            f'mass_rule = "thread_profile" needs the height of the thread of the {body}; give '
            f'stage.thread.{needed}, or choose mass_rule = "nominal_cylinder"'
        )
    radius: Scalar = getattr(thread, f"{body}_radius")
    outward = -1.0 if body == "nut" else 1.0
    addendum, dedendum = thread_heights(stage).of(body)
    middle, reach = (addendum - dedendum) / 2, (addendum + dedendum) / 2
    shape = (1,) * middle.ndim + (_NODES.size,)
    nodes = jnp.asarray(_NODES, middle.dtype).reshape(shape)
    weights = jnp.asarray(_WEIGHTS, middle.dtype).reshape(shape)
    height = middle[..., None] + reach[..., None] * nodes
    flank = reach[..., None] * weights * _half_thickness(stage, body, height)
    at = radius[..., None] + outward * height
    root = radius - outward * dedendum
    area = root**2 + 4 * outward / thread.pitch * jnp.sum(flank * at, axis=-1)
    fourth = root**4 + 8 * outward / thread.pitch * jnp.sum(flank * at**3, axis=-1)
    return ThreadSection(jnp.pi * area, jnp.pi / 2 * fourth)
