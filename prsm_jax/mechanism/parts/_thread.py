"""The thread geometry of one stage, with the kinematic identity ensured by construction."""

import dataclasses

import equinox as eqx
import jax.numpy as jnp

from ...fields import (
    ACUTE_ANGLE,
    NOT_NEGATIVE,
    OF_A_THREAD,
    POSITIVE,
    RADIUS_RATIO,
    STARTS,
    Limit,
    Limited,
    Number,
    OptionalNumber,
    Scalar,
    check_related,
    number,
    optional_number,
)
from ._family import FAMILIES, Family, RollerScrewType

_FREE_RATIO = "a type whose starts do not set its radii needs radius_ratio"


class Thread(Limited):
    r"""Threads of screw, rollers and nut of one stage.

    Five numbers are free; everything else follows from them, so the identity
    $r_n = r_s + 2 r_R = n r_R$ always holds:

    | free | follows when it changes |
    |---|---|
    | `lead` $L$ | pitch $p = L/n$ and the helix angles |
    | `starts` $n$ | radii of screw $(n-2) r_R$ and nut $n r_R$, centre distance, pitch, ring gear |
    | `roller_radius` $r_R$ | all radii, in proportion (`starts` sets the ratio), gear module |
    | `contact_angle` $\lambda$ | flank angle $\alpha = 90° - \lambda$; default profile radius |
    | `roller_profile_radius` $\rho$ | nothing; when absent it is $r_R / \sin\alpha$ |

    These are the free numbers of a standard roller screw. In an inverted one
    $r_s = n r_R$ and $r_n = (n + 2) r_R$. In a recirculating and in a differential one the starts
    do not determine the radii: `radius_ratio` $k$ is free as well, $r_n = k r_R$ and
    $r_s = (k - 2) r_R$ (see `Family`).

    To keep another dimension fixed, set one of the named design variables instead
    (`prsm_jax.mechanism.DESIGN_VARIABLES`), for example `roller_radius_at_fixed_screw_radius`.
    `starts` is a number rather than a static choice so that it can vary continuously in this way;
    the finding `feasible_ratio` reports a value that is not an integer.

    **Raises:** `ValueError` at construction for a known number that is out of its range: a lead or
    radius of 0 or less or of more than a metre, starts of 2 or less where they determine the radii,
    an angle that is not acute.
    """

    lead: Number = number(
        "m", "lead of screw and nut (axial travel per turn), L", limit=OF_A_THREAD
    )
    starts: Number = number("1", "number of thread starts of screw and nut, n", limit=POSITIVE)
    roller_radius: Number = number(
        "m", "nominal (pitch) radius of the roller, r_R", limit=OF_A_THREAD
    )
    contact_angle: Number = number(
        "rad",
        "contact angle, from the transverse plane to the flank normal, λ",
        limit=ACUTE_ANGLE,
    )
    roller_profile_radius: OptionalNumber = optional_number(
        "m",
        "radius of the roller's convex thread profile, ρ; r_R / sin α when absent",
        limit=OF_A_THREAD,
    )
    screw_addendum: OptionalNumber = optional_number(
        "m",
        "height of the screw's thread above its nominal radius",
        limit=NOT_NEGATIVE,
    )
    roller_addendum: OptionalNumber = optional_number(
        "m",
        "height of the roller's thread above its nominal radius",
        limit=NOT_NEGATIVE,
    )
    radius_ratio: OptionalNumber = optional_number(
        "1",
        "nut radius over roller radius, r_n/r_R, of the types whose starts do not determine it",
        limit=RADIUS_RATIO,
    )
    edge_radius: OptionalNumber = optional_number(
        "m",
        "rounding radius of the edges between flanks and crests, of all threads",
        limit=POSITIVE,
    )

    #: Type of roller screw; a stage sets that of its thread.
    type: RollerScrewType = eqx.field(static=True, default="standard", metadata={"of_owner": True})

    def __check_init__(self) -> None:
        if self.radius_ratio is None:
            limit = dataclasses.replace(self.starts_limit, hint=_FREE_RATIO)
            check_related(("starts",), self.starts, limit)

    @property
    def family(self) -> Family:
        """Description of the type of roller screw."""
        return FAMILIES[self.type]

    @property
    def starts_limit(self) -> Limit:
        """Permitted numbers of starts, which the type of roller screw determines."""
        if self.family.starts is None:
            return STARTS
        lower, upper = self.family.starts
        words = f"from {lower:g} to {upper:g} in a {self.type} roller screw"
        return Limit(lower, upper, words, True, True)

    def _radii_apart(self, rollers: int) -> Scalar:
        """Nut radius minus a number of roller radii, over the roller radius."""
        beyond = self.family.ratio_beyond_starts
        ratio = self.radius_ratio if beyond is None else self.starts
        assert ratio is not None
        less = rollers - (beyond or 0)
        if less == 0:
            return ratio
        return ratio - less if less > 0 else ratio + -less

    @property
    def screw_ratio(self) -> Scalar:
        """Screw radius over roller radius r_s/r_R; n − 2 in a standard roller screw."""
        return self._radii_apart(2)

    def for_screw_ratio(self, ratio: Scalar) -> dict[str, Scalar]:
        """The number that sets the ratio of the radii, by name, for a ratio r_s/r_R."""
        beyond = self.family.ratio_beyond_starts
        shift = 2 - (beyond or 0)
        return {"radius_ratio" if beyond is None else "starts": shift + ratio if shift else ratio}

    @property
    def nut_ratio(self) -> Scalar:
        """Nut radius over roller radius r_n/r_R; n in a standard roller screw."""
        return self._radii_apart(0)

    @property
    def rolling_ratio(self) -> Scalar:
        """Ratio κ of the radii of held body and roller, negative for rollers around a held screw.

        A roller that rolls on the held body turns against the carrier at −κ ω. It is n in a
        standard roller screw; of a recirculating one it is that of ideal rolling.
        """
        return -self.screw_ratio if self.family.held == "screw" else self.nut_ratio

    @property
    def ideal_carrier_ratio(self) -> Scalar:
        """Carrier speed over that of the body that turns, for rolling on the nominal circles.

        r_s / (2 a), or r_n / (2 a) where the nut turns.
        """
        turning = self.screw_radius if self.family.turning == "screw" else self.nut_radius
        return turning / (2 * self.centre_distance)

    @property
    def ideal_travel(self) -> Scalar:
        """Axial travel per turn for rolling on the nominal circles; the lead, unless the nut has
        grooves [m].
        """
        if self.family.lead_is_fixed:
            return self.lead
        return self.lead * (1 - self.ideal_carrier_ratio)

    @property
    def roller_lead(self) -> Scalar:
        """Lead of the roller, negative for the other hand than the screw's; 0 for grooves [m]."""
        hand = self.family.roller_hand
        return self.pitch if hand == 1 else hand * self.pitch

    @property
    def flank_angle(self) -> Scalar:
        """Flank angle α, measured from the transverse plane [rad]."""
        return jnp.pi / 2 - self.contact_angle

    @property
    def screw_radius(self) -> Scalar:
        """Nominal screw radius r_s; (n − 2) r_R in a standard roller screw [m]."""
        return self.screw_ratio * self.roller_radius

    @property
    def nut_radius(self) -> Scalar:
        """Nominal nut radius r_n = r_s + 2 r_R; n r_R in a standard roller screw [m]."""
        return self.nut_ratio * self.roller_radius

    @property
    def centre_distance(self) -> Scalar:
        """Distance between screw and roller axes a = r_s + r_R, also the carrier radius [m]."""
        return self._radii_apart(1) * self.roller_radius

    @property
    def pitch(self) -> Scalar:
        """Thread pitch p = L/n, also the lead of a single-start roller [m]."""
        return self.lead / self.starts

    @property
    def profile_radius(self) -> Scalar:
        """Radius of the roller's thread profile ρ, given or r_R / sin α [m]."""
        if self.roller_profile_radius is not None:
            return self.roller_profile_radius
        return self.roller_radius / jnp.sin(self.flank_angle)

    @property
    def screw_helix_angle(self) -> Scalar:
        """Helix angle of the screw at its nominal radius, tan λ_s = L / (2π r_s) [rad]."""
        return jnp.arctan2(self.lead, 2 * jnp.pi * self.screw_radius)

    @property
    def roller_helix_angle(self) -> Scalar:
        """Helix angle β_R of the roller, equal to that of the body that carries it; 0 for grooves.

        That body is the nut in a standard and the screw in an inverted roller screw [rad].
        """
        family = self.family
        if family.roller_hand == 0:
            return jnp.zeros_like(self.lead)
        radius = self.nut_radius if family.carrying == "nut" else self.screw_radius
        return jnp.arctan2(self.lead, 2 * jnp.pi * radius)
