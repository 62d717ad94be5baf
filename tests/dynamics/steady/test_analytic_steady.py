"""Steady state: closed forms of the efficiency, power balance, limits, symmetry, locking."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scenes import (
    ALL_LOSSES,
    FIRST_STAGE_LOSSES,
    LOSS_NAMES,
    array,
    mechanism,
    mesh,
    stage,
    stage_contact,
    steady_state,
    thread,
)

import prsm_jax as prsm
from benchmarks.references.contact import forward_efficiency
from benchmarks.references.meshing import Design
from prsm_jax.friction import (
    CoulombFriction,
    Drag,
    Friction,
    SpinFriction,
    SplineFriction,
    ThrustBearingFriction,
    ViscousFriction,
)


def _coulomb(friction, **geometry):
    return mechanism(
        stage(friction=Friction(thread=CoulombFriction(friction)), geometry=thread(**geometry))
    )


@pytest.mark.parametrize(
    ("friction", "closed", "full"), [(0.05, 0.9047, 0.904735), (0.1, 0.8182, 0.818087)]
)
def test_efficiency_at_45_degrees(friction, closed, full):
    """(1 − μ)/(1 + μ) forward and backward; r_s 15, r_R 5, L 10 mm: independent reference."""
    one = _coulomb(friction, roller_radius=5e-3)
    assert (1 - friction) / (1 + friction) == pytest.approx(closed, abs=1e-4)
    assert steady_state(one).efficiency == pytest.approx(full, abs=6e-7)
    backward = steady_state(one, speed=-100.0)
    # O(λ²), with λ = 6° on the screw.
    assert backward.efficiency == pytest.approx(closed, abs=1.5e-3)


@pytest.mark.parametrize("lead", [1e-6, 1e-5, 1e-4, 1e-3, 10e-3, 20e-3])
def test_efficiency_against_forty_digits_from_micrometres_to_screw_diameters(lead):
    """The screw's contact moves by 12 mm/rad and slips by 0.2 µm/rad at the smallest lead: by
    subtraction the drive torque was 1e-8 off there, and is now as good as anywhere."""
    one = _coulomb(0.05, lead=lead)
    roller = 4e-3
    design = Design(lead, 5.0, roller, np.pi / 4, roller / np.sin(np.pi / 4))
    assert steady_state(one).efficiency == pytest.approx(
        forward_efficiency(design, 0.05), rel=2e-15
    )


@given(st.floats(0.01, 0.2), st.floats(30, 60))
def test_efficiency_in_closed_form_at_small_leads(friction, angle):
    """η_f = (1 − μ tan α)/(1 + μ cot α), η_b = (1 − μ cot α)/(1 + μ tan α), to O(λ²)."""
    tangent = np.tan(np.radians(90 - angle))
    forward = (1 - friction * tangent) / (1 + friction / tangent)
    backward = (1 - friction / tangent) / (1 + friction * tangent)
    for lead, bound in ((10e-3, 2e-2), (1e-3, 2e-4), (1e-4, 2e-6)):
        one = _coulomb(friction, lead=lead, contact_angle=np.radians(angle))
        # λ_s² is (L/2πr_s)²; the bound falls with it.
        assert steady_state(one).efficiency == pytest.approx(forward, abs=bound)
        assert steady_state(one, speed=-100.0).efficiency == pytest.approx(backward, abs=bound)


@given(st.floats(0.01, 0.3), st.floats(1e-3, 25e-3), st.floats(30, 60))
def test_exact_efficiency(friction, lead, angle):
    """η_f = 1/(1 + 2π μ‖v‖/(Ω L (1/Q − μ v̂_z))), Q = √(1 + tan²α + tan²λ_sR), no approximation."""
    geometry = {"lead": lead, "contact_angle": np.radians(angle)}
    steady = steady_state(_coulomb(friction, **geometry))
    radius = float(mesh(thread(**geometry)).screw.contact_radius)
    helix = lead / (2 * np.pi * radius)
    q = np.sqrt(1 + np.tan(np.radians(90 - angle)) ** 2 + helix**2)
    slip = float(steady.slip_speed[0])
    axial = 100.0 * lead / (2 * np.pi) / slip
    per_turn = 2 * np.pi * friction * slip / (100.0 * lead * (1 / q - friction * axial))
    assert steady.efficiency == pytest.approx(1 / (1 + per_turn), rel=1e-13)


@given(st.floats(1e-3, 25e-3), st.floats(30, 60), st.floats(2e-3, 10e-3))
def test_steady_slip_runs_along_the_flank_generator(lead, angle, radius):
    """‖v‖ → v_n/sin α, whatever the lead and the diameter, to O(λ²)."""
    one = _coulomb(0.05, lead=lead, contact_angle=np.radians(angle), roller_radius=radius)
    expected = 100.0 * lead / (2 * np.pi) / np.cos(np.radians(angle))
    helix = lead / (2 * np.pi * 3 * radius)
    assert steady_state(one).slip_speed[0] == pytest.approx(expected, rel=1e-12 + 4 * helix**2)


@given(st.floats(0.0, 0.5), st.floats(-500, 500), st.floats(1.0, 1e5))
def test_carrier_ratio_is_geometry(friction, speed, load):
    """ζ∞ depends on neither friction, speed nor load: f·d = 0 is linear in ω."""
    reference = steady_state(_coulomb(0.05)).carrier_ratio[0]
    found = steady_state(_coulomb(friction), speed, load).carrier_ratio[0]
    assert found == pytest.approx(float(reference), rel=1e-14)


@given(st.floats(0, 0.5), st.floats(2e-3, 20e-3), st.floats(2e-3, 20e-3), st.floats(5e-3, 3e-2))
def test_spline_alone(friction, first, second, radius):
    """Li et al. 2020, equation 35: 1/(1 + μ_SS L₁L₂/(2π r_SS (L₁ + L₂))), exact."""
    two = mechanism(
        stage(friction=Friction(), geometry=thread(lead=first)),
        stage(
            friction=Friction(spline=SplineFriction(friction, radius)),
            geometry=thread(5e-3, lead=second),
        ),
    )
    steady = steady_state(two)
    share = friction * first * second / (2 * np.pi * radius * (first + second))
    assert steady.efficiency == pytest.approx(1 / (1 + share), rel=1e-13)
    assert set(steady.losses) == {"spline"}


def test_no_friction_no_loss():
    steady = steady_state(mechanism(stage(friction=Friction())))
    assert steady.efficiency == pytest.approx(1, rel=1e-14)
    assert steady.losses == {}
    assert steady.drive_torque == pytest.approx(7000 * 10e-3 / (2 * np.pi), rel=1e-14)


def test_thrust_bearing_and_drag_alone():
    """μ r F and T beside F L/2π."""
    useful = 7000 * 10e-3 / (2 * np.pi)
    bearing = mechanism(stage(friction=Friction(thrust_bearing=ThrustBearingFriction(0.01, 0.02))))
    expected = useful / (useful + 0.01 * 0.02 * 7000)
    assert steady_state(bearing).efficiency == pytest.approx(expected, rel=1e-13)
    drag = mechanism(stage(friction=Friction(drag=Drag(0.3))))
    assert steady_state(drag).efficiency == pytest.approx(useful / (useful + 0.3), rel=1e-13)
    # Driven back, drag takes its torque from the screw.
    backward = steady_state(drag, speed=-100.0).efficiency
    assert backward == pytest.approx((useful - 0.3) / useful, rel=1e-13)


def test_spin_loss_in_closed_form():
    """Nut side: pure spin, 3/8 μ F a E(m) (n − 1) ζ Ω |n_z|. Screw side: μ F ω_n² ⟨x'²⟩/v.

    ⟨x'²⟩ lies between b²/5 and a²/5; the next term takes a few per cent of it.
    """
    friction = Friction(thread=CoulombFriction(0.05), spin=SpinFriction(0.05))
    one = mechanism(stage(friction=friction))
    steady = steady_state(one)
    ratio, meshing = float(steady.carrier_ratio[0]), mesh(one.stages[0].thread)
    # The nut carries the load itself, with 20 threads of each of ten rollers.
    nut = stage_contact(one.stages[0], array(7000.0)).nut
    moment = 3 / 8 * 0.05 * 200 * float(nut.normal_force) * float(nut.hertz.semi_major)
    moment *= float(nut.hertz.second_elliptic_integral)
    nut_side = moment * 400 * ratio * abs(float(meshing.nut.normal[2]))

    # The ellipse of the screw side is that of the force that friction makes of the load.
    force = float(steady.contact_force[0])
    axial = force * -float(meshing.screw.normal[2]) * 10
    ellipse = stage_contact(one.stages[0], array(axial)).screw
    assert ellipse.normal_force == pytest.approx(force / 20, rel=1e-13)
    rate = 100 * (1 + 4 * ratio) * float(meshing.screw.normal[2])
    most = 10 * 0.05 * force * rate**2 / float(steady.slip_speed[0]) / 5
    screw_side = float(steady.losses["spin"]) - nut_side
    least = most * float(ellipse.hertz.semi_minor) ** 2
    assert 0.95 * least < screw_side < most * float(ellipse.hertz.semi_major) ** 2
    assert 0.01 < steady.losses["spin"] / steady.losses["thread_sliding"] < 0.12


def _jittered(base, generator):
    """Every number of a mechanism times a factor between 0.8 and 1.25."""

    def jitter(leaf):
        return leaf * np.exp(generator.uniform(np.log(0.8), np.log(1.25)))

    return jax.tree.map(jitter, base)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_power_balance_of_random_mechanisms(count):
    """Input = output + every named loss, to rounding, for 1 to 4 stages with all losses.

    Driving and driven back, with the load on either side. The residual is relative to the
    largest power; the terms are products of about twenty factors.
    """
    stages = [stage(friction=FIRST_STAGE_LOSSES)]
    stages += [stage(friction=ALL_LOSSES, geometry=thread((4 + k) * 1e-3)) for k in range(1, count)]
    base = mechanism(*stages)
    generator = np.random.default_rng(count)
    for _ in range(12):
        one = _jittered(base, generator)
        for speed, load in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            point = one.operating_point
            steady = steady_state(one, speed * point.speed, load * point.load)
            # Rollers may overlap: a steady state, of a mechanism that cannot be built.
            assert steady.computed
            assert steady.power_balance_residual < 1e-12
            assert set(steady.losses) == LOSS_NAMES - ({"spline"} if count == 1 else set())
            # Not only their sum is right: none of them is a source.
            assert all(float(power) > 0 for power in steady.losses.values())
            lost = sum(float(power) for power in steady.losses.values())
            assert steady.input_power == pytest.approx(float(steady.output_power) + lost, rel=1e-12)
            ratio = float(steady.output_power / steady.input_power)
            assert steady.efficiency == pytest.approx(ratio, rel=1e-12)


@pytest.mark.parametrize("friction", [Friction(), FIRST_STAGE_LOSSES])
def test_only_modelled_losses_are_named(friction):
    names = {
        {"thread": "thread_sliding"}.get(name, name)
        for name in ("thread", "spin", "rolling_hysteresis", "spline", "thrust_bearing", "drag")
        if getattr(friction, name) is not None
    }
    assert set(steady_state(mechanism(stage(friction=friction))).losses) == names


def _finite(tree):
    return all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(tree))


def test_standstill_is_the_motion_about_to_begin():
    """At zero speed: the forces of the slowest motion, no power, and nothing undefined."""
    one = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    still, slow = steady_state(one, speed=0.0), steady_state(one, speed=1e-9)
    assert _finite(still)
    assert still.efficiency == pytest.approx(float(slow.efficiency), rel=1e-14)
    assert still.drive_torque == pytest.approx(float(slow.drive_torque), rel=1e-14)
    assert all(float(power) == 0 for power in still.losses.values())
    assert still.slip_speed[0] == 0
    viscous = mechanism(stage(friction=Friction(thread=ViscousFriction(25.0))))
    assert steady_state(viscous, speed=0.0).efficiency == pytest.approx(1, rel=1e-13)


def test_zero_load():
    """The limit of small loads: Coulomb's efficiency does not depend on the load; drag takes all.

    The elastic contact shrinks with the load, so spin and hysteresis vanish faster than it.
    """
    coulomb = _coulomb(0.05)
    unloaded = steady_state(coulomb, load=0.0)
    assert _finite(unloaded)
    assert unloaded.efficiency == pytest.approx(float(steady_state(coulomb).efficiency), rel=1e-12)
    dragged = steady_state(mechanism(stage(friction=FIRST_STAGE_LOSSES)), load=0.0)
    assert _finite(dragged)
    assert abs(dragged.efficiency) < 1e-20
    assert dragged.drive_torque == pytest.approx(0.05, rel=1e-12)
    assert dragged.losses["drag"] == pytest.approx(0.05 * 100, rel=1e-12)


@given(st.sampled_from([-150.0, -1.0, 2.0, 80.0]), st.floats(10, 2e4))
def test_negative_load_is_the_mechanism_seen_from_its_other_end(speed, load):
    one = mechanism(stage(friction=FIRST_STAGE_LOSSES))
    positive, negative = steady_state(one, speed, load), steady_state(one, -speed, -load)
    assert negative.efficiency == pytest.approx(float(positive.efficiency), rel=1e-15)
    assert negative.drive_torque == pytest.approx(-float(positive.drive_torque), rel=1e-15)
    np.testing.assert_allclose(negative.contact_force, positive.contact_force, rtol=1e-15)
    np.testing.assert_allclose(negative.nut_load, -positive.nut_load, rtol=1e-15)


def test_self_locking_when_driven_back():
    """μ > tan α: the load cannot turn the screw, which shows as a negative efficiency."""
    limit = np.tan(np.radians(15))
    for friction, locks in ((0.9 * limit, False), (1.1 * limit, True)):
        one = _coulomb(friction, lead=1e-3, contact_angle=np.radians(75))
        backward = steady_state(one, speed=-100.0)
        assert backward.valid
        assert (float(backward.efficiency) < 0) == locks
        assert steady_state(one).efficiency > 0


def test_locking_forward_is_marked_invalid():
    """μ > cot α: the axial balance has no pushing contact; neighbours in a batch live on."""
    frictions = jnp.asarray([0.05, 0.9, 1.1, 0.2])
    base = _coulomb(0.05, lead=1e-3)
    batch = jax.vmap(lambda f: prsm.set_parameter(base, "friction.thread.coefficient", f))(
        frictions
    )
    steady = jax.jit(jax.vmap(prsm.steady_state))(batch)
    assert steady.valid.tolist() == [True, True, False, True]
    assert _finite(steady)
    alone = steady_state(_coulomb(0.2, lead=1e-3)).efficiency
    assert steady.efficiency[3] == pytest.approx(float(alone), rel=1e-14)


def test_losses_that_stop_the_carrier_are_marked_invalid():
    """Spin with far more friction than sliding: no carrier speed balances it."""
    friction = Friction(thread=CoulombFriction(0.001), spin=SpinFriction(0.5))
    steady = steady_state(mechanism(stage(friction=friction)))
    assert not steady.valid
    assert _finite(steady)


def test_unmeshed_design_is_marked_invalid():
    flat = thread(lead=100e-3, roller_profile_radius=0.2)
    steady = steady_state(mechanism(stage(geometry=flat)))
    assert not steady.valid
    assert _finite(steady)


@pytest.mark.usefixtures("unchecked")
def test_errors_name_the_remedy():
    one = mechanism()
    without = eqx.tree_at(lambda m: m.operating_point, one, None)
    with pytest.raises(prsm.MissingDataError, match=r"pass speed=… or give"):
        prsm.steady_state(without, load=1.0)
    with pytest.raises(ValueError, match="first screw does not move"):
        mechanism(stage(friction=ALL_LOSSES))
    spinning = mechanism(stage(friction=Friction(spin=SpinFriction(0.05))))
    with pytest.raises(prsm.MissingDataError, match=r"\[stage\.friction\.thread\]"):
        prsm.steady_state(spinning)
