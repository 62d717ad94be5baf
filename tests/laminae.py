"""Cut contact ellipses by quadrature over laminae and root searches; nothing of the law's code."""

import numpy as np
from scenes import array, mesh
from scipy.integrate import quad

from prsm_jax.contact import contact_frames, stage_contact
from prsm_jax.geometry import flank_ends
from tests.roots import root_between


def lamina_load(reach):
    """Load of a unit Hertz hemisphere beyond a line, lamina by lamina, over the whole."""
    # A lamina at y is a semi-ellipse of half-width and height √(1 − y²).
    part = quad(lambda y: np.pi / 2 * (1 - y**2), reach, 1)[0]
    return part / (2 * np.pi / 3)


def lamina_risk(reach):
    """Fatigue risk beyond a line over that of the whole, laminae by the 9th power of pressure."""
    whole = quad(lambda y: (1 - y**2) ** 4.5, -1, 1)[0]
    return quad(lambda y: (1 - y**2) ** 4.5, reach, 1)[0] / whole


def pressure_ratio_by_bisection(reaches):
    """σ of σ³ (1 − Σ f(t/σ)) = 1."""

    def excess(ratio):
        return ratio**3 * (1 - sum(lamina_load(min(t / ratio, 1.0)) for t in reaches)) - 1

    return root_between(excess, 1.0, 50.0, xtol=1e-13)


def sides_of(one, load):
    """Contacts, frames and ends of a stage, side by side."""
    meshing = mesh(one.thread)
    found = stage_contact(one, array(load), meshing)
    frames = contact_frames(one.thread, meshing, one.curvature)
    ends = flank_ends(one, meshing if one.curvature == "exact" else None)
    return zip((found.screw.hertz, found.nut.hertz), frames, ends, ("screw", "nut"), strict=True)
