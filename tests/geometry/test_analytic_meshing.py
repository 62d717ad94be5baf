"""Meshing against a second formulation, and what a point of contact has to fulfil."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from hypothesis import assume, given, strategies as st
from scenes import array, mesh, stage, thread

import prsm_jax as prsm
from prsm_jax.dynamics import slip_velocity, stage_kinematics
from prsm_jax.geometry import flanks_of
from prsm_jax.geometry._flanks import nut_side_gap, screw_side_gap
from prsm_jax.geometry._meshing import _steepness, starting_slope
from prsm_jax.mechanism import DESIGN_VARIABLES

_kinematics = eqx.filter_jit(stage_kinematics)
_slip = eqx.filter_jit(slip_velocity)

#: Designs over the range in which roller screws are built, and somewhat beyond.
DESIGNS = st.builds(
    lambda radius, starts, angle, helix, profile: thread(
        radius,
        lead=2 * np.pi * np.tan(np.radians(helix)) * radius * starts,
        contact_angle=np.radians(angle),
        starts=float(starts),
        roller_profile_radius=profile * radius / np.cos(np.radians(angle)),
    ),
    radius=st.floats(1e-3, 20e-3),
    starts=st.integers(3, 9),
    angle=st.floats(30, 60),
    helix=st.floats(0.05, 6),
    profile=st.floats(0.9, 2.0),
)


def _two_angles(geometry):
    """Contact radii and angles from the helix and flank angles at the contact (magnitudes).

    φ_s + φ_R = atan(tan λ_s / tan α) + atan(tan λ_R / tan α_R), tan²α + tan²λ_s = tan²α_R +
    tan²λ_R, and the sine rule for the radii; solved by SciPy.
    """
    centre = float(geometry.centre_distance)
    screw_radius, roller_radius = float(geometry.screw_radius), float(geometry.roller_radius)
    lead, pitch = float(geometry.lead), float(geometry.pitch)
    profile, flank = float(geometry.profile_radius), np.tan(float(geometry.flank_angle))
    origin = roller_radius - profile * np.sin(float(geometry.flank_angle))

    def parts(angles):
        total = np.sin(angles[0] + angles[1])
        screw, roller = centre * np.sin(angles[1]) / total, centre * np.sin(angles[0]) / total
        screw_helix, roller_helix = lead / (2 * np.pi * screw), pitch / (2 * np.pi * roller)
        depth = roller - origin
        roller_flank = depth / np.sqrt(profile**2 - depth**2)
        return screw, roller, screw_helix, roller_helix, roller_flank

    def residual(angles):
        _, _, screw_helix, roller_helix, roller_flank = parts(angles)
        turned = np.arctan(screw_helix / flank) + np.arctan(roller_helix / roller_flank)
        return [
            (angles[0] + angles[1]) / turned - 1,
            (flank**2 + screw_helix**2) / (roller_flank**2 + roller_helix**2) - 1,
        ]

    helix = np.tan(float(geometry.screw_helix_angle)) + np.tan(float(geometry.roller_helix_angle))
    start = helix / (flank * (1 + screw_radius / roller_radius))
    ratio = screw_radius / roller_radius
    solution = scipy.optimize.root(residual, [start, start * ratio], tol=1e-13)
    assume(np.max(np.abs(solution.fun)) < 1e-12)
    screw, roller, *_ = parts(solution.x)
    return screw, roller, *solution.x


@given(DESIGNS)
def test_two_angle_form(geometry):
    """The package solves for the slope of the profile; the two-angle form gives the same contact.

    Tolerance: SciPy's residual of 1e-12 on angles that the sine rule divides by each other.
    """
    meshing = mesh(geometry)
    assume(bool(meshing.converged))
    screw, roller, screw_angle, roller_angle = _two_angles(geometry)
    found = meshing.screw
    assert found.contact_radius == pytest.approx(screw, rel=1e-10)
    assert found.roller_contact_radius == pytest.approx(roller, rel=1e-10)
    assert -found.contact_angle_position == pytest.approx(screw_angle, rel=1e-9)
    assert -found.roller_angle_position == pytest.approx(roller_angle, rel=1e-9)


@jax.jit
def _steepest_difference(geometry):
    """Gradient of the gap at the contact found, by differentiation of the heights themselves."""
    flanks, contact = flanks_of(geometry), mesh(geometry).screw
    turn = contact.contact_angle_position
    point = contact.contact_radius * jnp.stack([jnp.cos(turn), jnp.sin(turn)])
    return jnp.max(jnp.abs(jax.grad(lambda p: screw_side_gap(flanks, p[0], p[1]))(point)))


@given(DESIGNS, st.floats(-1.0, 2.0), st.floats(0.0, 1.3))
def test_what_meshes_touches_however_flat_the_profile_or_steep_the_helix(geometry, flat, steep):
    """Profile radii from a tenth to a hundred times r_R / sin α, leads up to twenty times as large.

    Where the search says that it found a contact the gap has no slope; where it did not, its
    numbers are finite all the same.
    """
    centred = geometry.roller_radius / jnp.sin(geometry.flank_angle)
    extreme = eqx.tree_at(
        lambda t: (t.roller_profile_radius, t.lead),
        geometry,
        (centred * 10**flat, geometry.lead * 10**steep),
    )
    found = mesh(extreme)
    assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(found))
    if found.converged:
        # Slopes are of order one to ten and contacts of order of the centre distance.
        assert _steepest_difference(extreme) < 1e-10


@given(DESIGNS, st.floats(0.5, 2.0))
def test_derivative_of_the_steepness(geometry, factor):
    """The derivative by hand that Newton uses is that of the residual."""
    flanks = flanks_of(geometry)
    slope = starting_slope(flanks) * factor
    (_, by_hand), (differentiated, _) = _steepness_and_change(flanks, slope)
    assert by_hand == pytest.approx(float(differentiated), rel=1e-11)


@jax.jit
def _steepness_and_change(flanks, slope):
    return jax.jvp(lambda s: _steepness(flanks, s), (slope,), (jnp.ones_like(slope),))


@given(DESIGNS)
def test_usual_designs_mesh(geometry):
    """With the profile arc centred on the roller axis or beyond, a common normal exists."""
    centred = eqx.tree_at(
        lambda t: t.roller_profile_radius,
        geometry,
        geometry.roller_radius / jnp.sin(geometry.flank_angle),
    )
    assert mesh(centred).converged


@given(DESIGNS, st.floats(-300, 300), st.floats(-3, 3))
def test_slip_is_tangential_at_every_carrier_speed(geometry, speed, ratio):
    """n̂·v = 0 to 1e-12 of |v|: neither surface moves into the other."""
    assume(abs(speed) > 1e-3)
    kinematics = _kinematics(stage(geometry=geometry))
    assume(bool(kinematics.meshing.converged))
    slip = np.asarray(_slip(kinematics, array(speed), array(speed * ratio)))
    normal = np.asarray(kinematics.meshing.screw.normal)
    assert np.linalg.norm(normal) == pytest.approx(1, rel=1e-15)
    assert abs(normal @ slip) <= 1e-12 * np.linalg.norm(slip)


def test_slip_would_not_be_tangential_with_the_angles_mirrored():
    """The test above can fail: the contact on the other side of the centre line is far off."""
    kinematics = _kinematics(stage())
    mirrored = np.asarray(kinematics.meshing.screw.normal) * [1, -1, 1]
    slip = np.asarray(_slip(kinematics, array(1.0), array(0.0)))
    assert abs(mirrored @ slip) > 1e-3  # a millimetre per radian


@eqx.filter_jit
def _nut_slope(geometry):
    point = jnp.stack([geometry.nut_radius, jnp.zeros_like(geometry.nut_radius)])
    return jax.grad(lambda p: nut_side_gap(flanks_of(geometry), p[0], p[1]))(point)


@given(DESIGNS)
def test_nut_contact_lies_on_the_line_of_centres(geometry):
    """Roller and nut have one helix angle: equal gradients, no gap and no slip at (r_n, 0)."""
    slope_x, slope_y = _nut_slope(geometry)
    assert abs(slope_x) < 1e-12
    assert abs(slope_y) < 1e-12
    # The roller turns at −(n − 1) ω while its axis circles at ω: the contact point stands still.
    speed = geometry.centre_distance - (geometry.starts - 1) * geometry.roller_radius
    assert abs(speed) <= 1e-15 * geometry.nut_radius


@eqx.filter_jit
def _position(geometry):
    side = mesh(geometry).screw
    return jnp.stack(
        [
            side.contact_angle_position,
            side.roller_angle_position,
            side.contact_radius,
            side.roller_contact_radius,
        ]
    )


_forward = eqx.filter_jit(jax.jacfwd(_position))
_reverse = eqx.filter_jit(jax.jacrev(_position))


@pytest.mark.parametrize("lead", [0.0, 1e-9, 1e-6])
def test_lead_to_zero(lead):
    """Contact on the line of centres, approached linearly with the closed small-angle slope.

    φ_s = (tan λ_s + tan λ_R)/(tan α (1 + r_s/r_R)), exact to first order in the lead.
    """
    # No thread has a lead of 0, and none is built with it; the law holds there all the same.
    geometry = eqx.tree_at(lambda t: t.lead, thread(), array(lead))
    slope = (1 / (2 * np.pi * 12e-3) + 1 / (2 * np.pi * 20e-3)) / 4
    found = np.asarray(_position(geometry))
    # The cubic term at a lead of 1e-6 m is 1e-9 of the linear one.
    np.testing.assert_allclose(found[:2], [-slope * lead, -3 * slope * lead], rtol=1e-8)
    np.testing.assert_allclose(found[2:], [12e-3, 4e-3], rtol=1e-8)
    for derivative in (_forward(geometry), _reverse(geometry)):
        assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(derivative))
        np.testing.assert_allclose(derivative.lead[:2], [-slope, -3 * slope], rtol=1e-7)
        # Quadratic in the lead: 2 × second derivative, a few units per metre.
        np.testing.assert_allclose(derivative.lead[2:], 0, atol=1e-9 + 20 * lead)


@given(
    DESIGNS,
    st.sampled_from(
        [v.name for v in DESIGN_VARIABLES] + ["lead", "roller_radius", "contact_angle", "starts"]
    ),
    st.floats(0.8, 1.3),
)
def test_kinematic_identity_under_every_design_variable(geometry, name, factor):
    """r_n = r_s + 2 r_R = n r_R, a = r_s + r_R and L = n p, whatever moves."""
    before = prsm.Mechanism((stage(geometry=geometry),))
    value = factor * float(prsm.get_parameter(before, name))
    after = prsm.set_parameter(before, name, value)
    assert prsm.get_parameter(after, name) == pytest.approx(value, rel=1e-14)
    moved = after.stages[0].thread
    radius, screw = float(moved.roller_radius), float(moved.screw_radius)
    # Rounding, amplified by the difference n − 2 when the ratio is small.
    assert moved.nut_radius == pytest.approx(screw + 2 * radius, rel=1e-14)
    assert moved.nut_radius == pytest.approx(float(moved.starts) * radius, rel=1e-14)
    assert moved.centre_distance == pytest.approx(screw + radius, rel=1e-14)
    assert moved.lead == pytest.approx(float(moved.starts * moved.pitch), rel=1e-14)
    assert moved.flank_angle + moved.contact_angle == pytest.approx(np.pi / 2, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "fixed"),
    [
        ("roller_radius_at_fixed_screw_radius", ("screw_radius", "lead", "contact_angle")),
        ("starts_at_fixed_pitch", ("pitch", "roller_radius", "contact_angle")),
        ("pitch", ("starts", "roller_radius", "screw_radius")),
        ("screw_radius", ("starts", "lead", "contact_angle")),
        ("flank_angle", ("starts", "lead", "roller_radius")),
        ("roller_profile_radius", ("starts", "lead", "roller_radius", "contact_angle")),
    ],
)
def test_design_variables_hold_what_they_say(name, fixed):
    before = prsm.Mechanism((stage(),))
    after = prsm.set_parameter(before, name, 1.1 * float(prsm.get_parameter(before, name)))
    for other in fixed:
        value = float(prsm.get_parameter(before, other))
        assert prsm.get_parameter(after, other) == pytest.approx(value, rel=1e-14)


def test_curvatures_of_a_gap_known_in_closed_form():
    """At zero lead both flanks are surfaces of revolution, with text-book curvatures.

    Roller: 1/ρ along the profile and sin α/r_R across; screw (a cone): 0 and sin α/r_s; nut the
    same with the opposite sign. Directions coincide.
    """
    geometry = thread(contact_angle=np.radians(50), roller_profile_radius=7e-3)
    geometry = eqx.tree_at(lambda t: t.lead, geometry, array(0.0))
    sine = np.sin(np.radians(40))
    meshing = mesh(geometry)
    for side, sign, radius in ((meshing.screw, 1, 12e-3), (meshing.nut, -1, 20e-3)):
        profile, across = 1 / 7e-3, sine / 4e-3 + sign * sine / radius
        curvature = side.curvature
        assert curvature.total == pytest.approx((profile + across) / 2, rel=1e-13)
        squared = ((profile - across) / 2) ** 2
        assert curvature.difference_squared == pytest.approx(squared, rel=1e-11)
        assert curvature.rolling == pytest.approx(across / 2, rel=1e-13)
