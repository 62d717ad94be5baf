"""Meshing and motion of every type of roller screw, from the velocities of rigid bodies.

The references take points and normals from the meshing, and velocities from ω × r alone.
"""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from scenes import mesh

from prsm_jax.geometry import flanks_of, nut_side_hessian, screw_side_hessian, tangent_tensor
from prsm_jax.geometry._flanks import nut_side_gap, screw_side_gap
from prsm_jax.mechanism import ROLLER_SCREW_TYPES, Stage, Thread

_GAPS = {"screw": screw_side_gap, "nut": nut_side_gap}
_HESSIANS = {"screw": screw_side_hessian, "nut": nut_side_hessian}


def _thread(kind, radius=2e-3, ratio=5.0, helix=4.0, angle=45.0, profile=1.0):
    """A thread of a type: ratio r_n/r_R (standard), helix angle of the screw [deg]."""
    free = kind in ("recirculating", "differential")
    starts = min(round(ratio) - 3, 2) if free else round(ratio)
    if free:
        screw = (ratio - 2) * radius
    else:
        screw = (starts - 2 if kind == "standard" else starts) * radius
    geometry = Thread(
        lead=2 * np.pi * screw * np.tan(np.radians(helix)),
        starts=float(starts),
        roller_radius=radius,
        contact_angle=np.radians(angle),
        roller_profile_radius=profile * radius / np.cos(np.radians(angle)),
        radius_ratio=ratio if free else None,
    )
    return Stage(geometry, 5, type=kind).thread


def _threads(kind):
    return st.builds(
        lambda **numbers: _thread(kind, **numbers),
        radius=st.floats(1e-3, 10e-3),
        # Free ratios need not be whole.
        ratio=st.integers(4, 9).map(float) if kind in ("standard", "inverted") else st.floats(4, 9),
        helix=st.floats(0.1, 6),
        angle=st.floats(35, 55),
        profile=st.floats(0.9, 1.4),
    )


def _leads(geometry):
    """Leads of screw, roller and nut over 2π, from the table of the types [m/rad]."""
    lead, pitch = float(geometry.lead), float(geometry.lead) / float(geometry.starts)
    roller = {"standard": pitch, "inverted": -pitch}.get(geometry.type, 0.0)
    nut = 0.0 if geometry.type == "differential" else lead
    return np.array([lead, roller, nut]) / (2 * np.pi)


def axial_velocities(geometry, screw, roller, nut, carrier):
    """Axial velocities of screw, roller and nut at angular speeds [rad/s]; the screw's is 0.

    A thread of lead 2πh whose contact point is at rest in the carrier's frame moves there at the
    velocity v − h (ω − ω_c), which is the same for all three bodies.
    """
    h = _leads(geometry)
    common = -h[0] * (screw - carrier)
    return np.array([0.0, common + h[1] * (roller - carrier), common + h[2] * (nut - carrier)])


def approach(geometry, meshing, speeds, carrier):
    """n̂·v of the bodies at both contacts over the largest term of the product."""
    screw, roller, nut = speeds
    axial = axial_velocities(geometry, screw, roller, nut, carrier)
    distance = float(geometry.centre_distance)
    found = []
    for side, speed, own in (("screw", screw, axial[0]), ("nut", nut, axial[2])):
        contact = getattr(meshing, side)
        radius, angle = float(contact.contact_radius), float(contact.contact_angle_position)
        x, y = radius * np.cos(angle), radius * np.sin(angle)
        body = np.array([-speed * y, speed * x, own])
        around = carrier * np.array([0.0, distance, 0.0])
        rolls = around + np.array([-roller * y, roller * (x - distance), axial[1]])
        terms = np.asarray(contact.normal) * (body - rolls)
        size = np.abs(np.asarray(contact.normal)) @ (np.abs(body) + np.abs(rolls))
        found.append(abs(terms.sum()) / (size or 1.0))
    return found


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
@given(data=st.data())
def test_no_contact_opens_or_closes_at_any_speeds(kind, data):
    """n̂·v = 0 at both contacts, for every speed of screw, roller, nut and carrier, to rounding."""
    geometry = data.draw(_threads(kind))
    meshing = mesh(geometry)
    assert bool(meshing.converged)
    speeds = [data.draw(st.floats(-1, 1)) for _ in range(3)]
    carrier = data.draw(st.floats(-1, 1))
    assert max(approach(geometry, meshing, speeds, carrier)) < 1e-13


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_gaps_are_smallest_at_the_contacts(kind):
    """Both gaps of the true flanks have a minimum there, with the curvatures of the meshing."""
    geometry = _thread(kind)
    meshing = mesh(geometry)
    flanks = flanks_of(geometry)
    for side, gap in _GAPS.items():
        contact = getattr(meshing, side)
        radius, angle = contact.contact_radius, contact.contact_angle_position
        point = radius * jnp.stack([jnp.cos(angle), jnp.sin(angle)])
        slope = jax.grad(lambda p, gap=gap: gap(flanks, p[0], p[1]))(point)
        bend = jax.hessian(lambda p, gap=gap: gap(flanks, p[0], p[1]))(point)
        # Slopes of the flanks are of order one.
        np.testing.assert_allclose(slope, 0.0, atol=1e-13)
        assert np.linalg.eigvalsh(bend)[0] > 0
        # Half the trace of cos γ G^{-1} H, with the metric G = 1 + g gᵀ of the tangent plane.
        x, y, z = (float(part) for part in contact.normal_parts)
        g = np.array([x, y]) / z
        metric = np.eye(2) + np.outer(g, g)
        total = abs(z) * np.trace(np.linalg.solve(metric, bend)) / 2
        np.testing.assert_allclose(contact.curvature.total, total, rtol=1e-12)


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_where_rollers_slide_and_where_they_roll(kind):
    """A roller rolls where its helix angle is that of the body; elsewhere it touches aside."""
    geometry = _thread(kind)
    meshing = mesh(geometry)
    leads = np.abs(_leads(geometry))
    helix = leads / [float(geometry.screw_radius), 2e-3, float(geometry.nut_radius)]
    expected = {
        "standard": ("screw",),
        "inverted": ("nut",),
        "recirculating": ("screw", "nut"),
        "differential": ("screw",),
    }[kind]
    assert geometry.family.sliding == expected
    for side, own in (("screw", helix[0]), ("nut", helix[2])):
        aside = float(getattr(meshing, side).contact_angle_position)
        if side in expected:
            assert abs(aside) > 1e-3
            # Both flanks are equally steep, so against a body of a larger helix angle the roller's
            # arc touches where it is steeper: farther from its axis.
            radius = float(getattr(meshing, side).roller_contact_radius)
            assert (radius > 2e-3) == (own > helix[1])
        else:
            assert aside == 0
            assert own == pytest.approx(helix[1], rel=1e-14)


def test_radii_of_the_types():
    """r_n = r_s + 2 r_R in all of them."""
    radii = {
        "standard": (6e-3, 10e-3),
        "inverted": (10e-3, 14e-3),
        "recirculating": (6e-3, 10e-3),
        "differential": (6e-3, 10e-3),
    }
    for kind, (screw, nut) in radii.items():
        geometry = _thread(kind)
        assert float(geometry.screw_radius) == pytest.approx(screw, rel=1e-15)
        assert float(geometry.nut_radius) == pytest.approx(nut, rel=1e-15)
        assert float(geometry.centre_distance) == pytest.approx((screw + nut) / 2, rel=1e-15)


def test_a_nut_without_lead_touches_its_rollers_on_the_line_of_centres():
    """In the limit of a small lead a recirculating nut is a body of rings: φ ~ L."""
    small, large = (
        float(mesh(_thread("recirculating", helix=helix)).nut.contact_angle_position)
        for helix in (0.001, 0.01)
    )
    assert large / small == pytest.approx(10, rel=1e-4)
    # y = h r_R/(a tan α), from the gradients of both flanks to first order.
    geometry = _thread("recirculating", helix=0.001)
    first = _leads(geometry)[0] * 2e-3 / 8e-3
    assert small == pytest.approx(first / 10e-3, rel=1e-4)


@functools.partial(jax.jit, static_argnums=1)
def _by_any_point(flanks, side, contact):
    """Curvatures and gap at a contact by the equations for any point of the transverse plane."""
    turn = contact.contact_angle_position
    x, y = contact.contact_radius * jnp.cos(turn), contact.contact_radius * jnp.sin(turn)
    normal = contact.normal_parts
    slope = -normal[0] / normal[2], -normal[1] / normal[2]
    tensor, _ = tangent_tensor(slope, _HESSIANS[side](flanks, x, y))
    matrix = jnp.array([[tensor.xx, tensor.xy], [tensor.xy, tensor.yy]])
    along = jnp.stack(slope) / jnp.hypot(*slope)
    across = jnp.stack([-along[1], along[0]])
    bends = jnp.linalg.eigvalsh(matrix)
    return {
        "total": jnp.sum(bends) / 2,
        "difference_squared": ((bends[1] - bends[0]) / 2) ** 2,
        "rolling": across @ matrix @ across / 2,
        "twist": along @ matrix @ across / 2,
        "gap": _GAPS[side](flanks, x, y),
    }


@pytest.mark.parametrize("kind", ROLLER_SCREW_TYPES)
def test_curvatures_and_gap_are_those_of_any_point(kind):
    """Closed forms at contacts, aside of the line of centres and on it, against general ones.

    The latter turn second derivatives over x and y into the tangent plane, and take heights from
    distances and angles.
    """

    @settings(max_examples=20)
    @given(_threads(kind))
    def check(geometry):
        meshing = mesh(geometry)
        assume(bool(meshing.converged))
        flanks, gap = flanks_of(geometry), 0.0
        for side in ("screw", "nut"):
            contact = getattr(meshing, side)
            expected = _by_any_point(flanks, side, contact)
            size = float(expected["total"])
            for name, power in (
                ("total", 1), ("difference_squared", 2), ("rolling", 1), ("twist", 1)
            ):  # fmt: skip
                value = float(getattr(contact.curvature, name))
                # Rounding, some tens of operations.
                assert value == pytest.approx(float(expected[name]), abs=1e-13 * size**power)
            gap += float(expected["gap"])
        # Differences of heights of the order of the radii.
        size = float(geometry.nut_radius)
        assert float(meshing.axial_gap) == pytest.approx(gap, abs=1e-14 * size)

    check()
