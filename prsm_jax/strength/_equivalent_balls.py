r"""The dynamic capacity by the formula of ball screws, with balls in place of thread contacts.

A ball of the diameter $D_w = 2\sqrt{\rho\,r_R/\sin\alpha}$ has the same product of curvature radii
as the roller's thread (profile ρ, $r_R/\sin\alpha$ along the roller), and so about the same contact
area and the same static capacity. All N z contacts of a side are the balls of one track, which
Lundberg and Palmgren's capacity of a bearing ring, in newtons and millimetres and for a flank that
is straight across the track, takes to

$$C_{s,n} = 98.1\,\gamma^{0.3}\frac{(1\mp\gamma)^{1.39}}{(1\pm\gamma)^{1/3}}\,D_w^{1.8}
(N z)^{2/3}\,\frac{F_a}{F_n},\qquad \gamma = r_R/a,$$

with the upper signs on the screw side; balls above 25.4 mm grow weaker, $3.647\,D_w^{1.4}$ in place
of $D_w^{1.8}$. Source: Lundberg and Palmgren 1947, ISO 281; ISO 3408-5 has the same powers of $D_w$
and of the number of balls for ball screws. No standard exists for roller screws;
`docs/catalogue_witness.md` compares this formula with a maker's catalogue.
"""

import jax.numpy as jnp

from ..contact import contact_frames, engaged_threads, meshing_of
from ..fields import Scalar
from ..geometry import Meshing
from ..mechanism import Stage
from ._contacts import thread_share

#: Capacity of one contact over D_w^1.8, N and mm, of a ring with a straight profile.
_CONTACT = 98.1
#: Diameter of balls from which on the power of 1.8 becomes 1.4 [mm]; 25.4^0.4 is 3.647.
_LARGE = 25.4
#: Exponent of the two sides' capacities in their sum of risks, 3 · 10/9.
_SIDES = 10 / 3


def equivalent_ball_diameter(stage: Stage) -> Scalar:
    r"""Diameter of the ball that stands for a thread contact, $2\sqrt{\rho\,r_R/\sin\alpha}$ [m].

    **Arguments:**

    - `stage`: the stage.
    """
    thread = stage.thread
    along = thread.roller_radius / jnp.sin(thread.flank_angle)
    return 2 * jnp.sqrt(thread.profile_radius * along)


def equivalent_ball_capacity(stage: Stage, meshing: Meshing | None = None) -> Scalar:
    """Dynamic axial capacity for a material factor of 1 and equal shares of the load [N].

    Its derivatives jump where a ball is 25.4 mm thick.

    **Arguments:**

    - `stage`: the stage; needs `engaged_threads`.
    - `meshing`: its meshing, if already known; used only by the `"exact"` convention.

    **Raises:** `MissingDataError` if engaged threads are not given.
    """
    contacts = stage.present_roller_count * engaged_threads(stage) * thread_share(stage)
    ratio = stage.thread.roller_radius / stage.thread.centre_distance
    frames = contact_frames(stage.thread, meshing_of(stage, meshing), stage.curvature)
    diameter = 1e3 * equivalent_ball_diameter(stage)
    power = diameter**1.4 * jnp.minimum(diameter, _LARGE) ** 0.4
    common = _CONTACT * ratio**0.3 * power * contacts ** (2 / 3)
    sides = [
        common * (1 - sign * ratio) ** 1.39 / (1 + sign * ratio) ** (1 / 3) / frame.normal_per_axial
        for sign, frame in zip((1, -1), frames, strict=True)
    ]
    # Risks of both sides add up, relative to the weaker one so that no power overflows.
    weaker = jnp.minimum(*sides)
    return weaker * sum((weaker / side) ** _SIDES for side in sides) ** (-1 / _SIDES)
