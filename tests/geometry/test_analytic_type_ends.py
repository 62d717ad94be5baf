"""Ends of flanks where the contact lies beside the line of centres in a nut, by a walk to them."""

import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example, mesh

from prsm_jax.geometry import flank_ends, flanks_of, nut_side_hessian
from tests.present import present


def test_ways_to_the_crests_of_nut_and_roller():
    """Along the tangent plane, straight away from the axis of each body, by geometry in NumPy.

    The gap's coefficient along such a way is the second derivative of the axial gap along its
    projection, times half the normal's axial part.

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
    flanks = flanks_of(thread)
    hessian = nut_side_hessian(flanks, jnp.asarray(point[0]), jnp.asarray(point[1]))
    bend = np.array([[hessian.xx, hessian.xy], [hessian.xy, hessian.yy]], dtype=float)
    found = {end.body: end for end in ends if end.kind == "crest"}
    for body, axis in axes.items():
        arm = point - axis
        radial = arm / np.linalg.norm(arm)
        steepest = radial - (radial @ normal) * normal
        steepest /= np.linalg.norm(steepest)
        rate = steepest @ radial
        away = crests[body] - np.linalg.norm(arm)
        away = -away if body == "nut" else away
        assert float(found[body].distance) == pytest.approx(away / rate, rel=1e-12)
        coefficient = abs(normal[2]) / 2 * steepest[:2] @ bend @ steepest[:2]
        assert float(present(found[body].coefficient)) == pytest.approx(coefficient, rel=1e-12)
