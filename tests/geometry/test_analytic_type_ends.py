"""Ends of flanks where the contact lies beside the line of centres in a nut, by a walk to them."""

import numpy as np
import pytest
from scenes import example, mesh

from prsm_jax.geometry import flank_ends
from tests.present import present


def test_distances_to_the_crests_of_nut_and_roller():
    """Along the tangent plane, straight away from the axis of each body, by geometry in NumPy.

    A crest is a circle about that axis; the steepest way to it in the plane is the projection of
    the radial direction. Its curvature over this way is left out, as in the package.
    """
    (stage,) = example("humanoid_leg").stages
    meshing = mesh(stage.thread)
    _, ends = flank_ends(stage, meshing)
    contact, thread = meshing.nut, stage.thread
    angle = float(contact.contact_angle_position)
    assert abs(angle) > 1e-3
    point = float(contact.contact_radius) * np.array([np.cos(angle), np.sin(angle), 0.0])
    normal = np.array([float(part) for part in contact.normal_parts])
    axes = {"nut": np.zeros(3), "roller": np.array([float(thread.centre_distance), 0.0, 0.0])}
    crests = {
        "nut": float(thread.nut_radius - present(thread.screw_addendum)),
        "roller": float(thread.roller_radius + present(thread.roller_addendum)),
    }
    found = {end.body: float(end.distance) for end in ends if end.kind == "crest"}
    for body, axis in axes.items():
        arm = point - axis
        radial = arm / np.linalg.norm(arm)
        steepest = radial - (radial @ normal) * normal
        rate = steepest @ radial / np.linalg.norm(steepest)
        away = crests[body] - np.linalg.norm(arm)
        away = -away if body == "nut" else away
        assert found[body] == pytest.approx(away / rate, rel=1e-12)
