"""The thread geometry of one stage, with the kinematic identity ensured by construction."""

import jax.numpy as jnp

from ...fields import (
    ACUTE_ANGLE,
    NOT_NEGATIVE,
    OF_A_THREAD,
    POSITIVE,
    STARTS,
    Limited,
    Number,
    OptionalNumber,
    Scalar,
    number,
    optional_number,
)


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

    To keep another dimension fixed, set one of the named design variables instead
    (`prsm_jax.mechanism.DESIGN_VARIABLES`), for example `roller_radius_at_fixed_screw_radius`.
    `starts` is a number rather than a static choice so that it can vary continuously in this way;
    the finding `feasible_ratio` reports a value that is not an integer.

    **Raises:** `ValueError` at construction for a known number that is out of its range: a lead or
    radius of 0 or less or of more than a metre, starts of 2 or less, an angle that is not acute.
    """

    lead: Number = number(
        "m", "lead of screw and nut (axial travel per turn), L", limit=OF_A_THREAD
    )
    starts: Number = number("1", "number of thread starts of screw and nut, n", limit=STARTS)
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
    edge_radius: OptionalNumber = optional_number(
        "m",
        "rounding radius of the edges between flanks and crests, of all threads",
        limit=POSITIVE,
    )

    @property
    def flank_angle(self) -> Scalar:
        """Flank angle α, measured from the transverse plane [rad]."""
        return jnp.pi / 2 - self.contact_angle

    @property
    def screw_radius(self) -> Scalar:
        """Nominal screw radius r_s = (n − 2) r_R [m]."""
        return (self.starts - 2) * self.roller_radius

    @property
    def nut_radius(self) -> Scalar:
        """Nominal nut radius r_n = n r_R [m]."""
        return self.starts * self.roller_radius

    @property
    def centre_distance(self) -> Scalar:
        """Distance between screw and roller axes a = r_s + r_R, also the carrier radius [m]."""
        return (self.starts - 1) * self.roller_radius

    @property
    def pitch(self) -> Scalar:
        """Thread pitch p = L/n, also the lead of the single-start roller [m]."""
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
        """Helix angle β_R of roller and nut (equal: the roller rolls in the nut) [rad]."""
        return jnp.arctan2(self.lead, 2 * jnp.pi * self.nut_radius)
