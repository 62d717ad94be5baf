"""The section of the screw's root, which bends, twists and stretches."""

from typing import NamedTuple

import jax.numpy as jnp

from ..._errors import MissingDataError
from ...fields import Scalar
from .._mechanism import Stage


class ScrewSection(NamedTuple):
    """The annulus of root and bore."""

    #: π (R² − r²) [m²].
    area: Scalar
    #: Square of the radius of gyration about a diameter, (R² + r²)/4 [m²].
    gyration_squared: Scalar

    @property
    def polar_moment(self) -> Scalar:
        """Second moment of area about the axis, π/2 (R⁴ − r⁴) [m⁴]."""
        return 2 * self.area * self.gyration_squared


def screw_root_radius(stage: Stage) -> Scalar:
    """Radius at the root of the screw's thread [m].

    As given; else r_s minus the dedendum of the tooth of `load_sharing`; else the largest that the
    crests of the rollers allow, r_s minus their addendum.

    **Raises:** `MissingDataError` if neither is known.
    """
    shaft = None if stage.strength is None else stage.strength.shaft
    if shaft is not None and shaft.root_radius is not None:
        return shaft.root_radius
    sharing = stage.load_sharing
    if sharing is not None and sharing.tooth is not None:
        return stage.thread.screw_radius - sharing.tooth.screw_dedendum
    if stage.thread.roller_addendum is None:
        raise MissingDataError(
            "the root radius of the screw is not known; give stage.strength.shaft.root_radius, or "
            "stage.thread.roller_addendum to derive it"
        )
    return stage.thread.screw_radius - stage.thread.roller_addendum


def screw_section(stage: Stage) -> ScrewSection:
    """The section of the screw at the root of its thread.

    **Raises:** `MissingDataError` as in `screw_root_radius`.
    """
    root, bore = screw_root_radius(stage), stage.screw.bore_radius
    inner = jnp.zeros_like(root) if bore is None else bore
    return ScrewSection(jnp.pi * (root**2 - inner**2), (root**2 + inner**2) / 4)
