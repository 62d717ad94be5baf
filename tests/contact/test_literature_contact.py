"""Published contact pressures and stiffnesses: Lisowski 2014, Wu et al. 2022, text-book Hertz."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scenes import array, example, mesh, stage, stage_contact, thread

import prsm_jax as prsm
from prsm_jax.contact import contact_frames, contact_modulus, hertz_contact
from prsm_jax.mechanism import GivenStiffness, Material
from tests.present import present

_hertz = eqx.filter_jit(hertz_contact)
BEARING_STEEL = Material(210e9, 0.3)


def test_sphere_on_plane():
    """Johnson 1985, section 4.2: a³ = 3FR/4E*, p₀ = 3F/2πa², δ = a²/R, dF/dδ = 2 E* a.

    Sphere of 10 mm radius, 100 N. The digits are those printed here; seven of them are given.
    """
    modulus = contact_modulus(BEARING_STEEL, BEARING_STEEL)
    result = _hertz(array(100.0), array(1 / 10e-3), array(0.0), modulus)
    assert result.semi_major * 1e3 == pytest.approx(0.1866256, rel=3e-7)
    assert result.semi_minor == pytest.approx(float(result.semi_major), rel=1e-15)
    assert result.max_pressure / 1e6 == pytest.approx(1370.879, rel=4e-7)
    assert result.approach * 1e3 == pytest.approx(3.482910e-3, rel=3e-7)
    assert result.stiffness_tangent / 1e3 == pytest.approx(43067.44, rel=2e-7)
    assert result.stiffness_tangent == pytest.approx(1.5 * float(result.stiffness), rel=1e-15)

    semi_axis = (3 * 100.0 * 10e-3 / (4 * float(modulus))) ** (1 / 3)
    assert result.semi_major == pytest.approx(semi_axis, rel=1e-14)
    assert result.max_pressure == pytest.approx(150 / (np.pi * semi_axis**2), rel=1e-14)
    assert result.approach == pytest.approx(semi_axis**2 / 10e-3, rel=1e-14)
    assert result.stiffness_tangent == pytest.approx(2 * float(modulus) * semi_axis, rel=1e-14)


def _one_pair(convention):
    """The pair of threads of Lisowski 2014: d_s 30, d_R 10, d_n 50, p 2 mm, E 211 GPa."""
    return stage(
        1,
        geometry=thread(roller_radius=5e-3),
        engaged_threads=1.0,
        material=Material(211e9, 0.3),
        curvature=convention,
    )


@pytest.mark.parametrize(
    ("load", "screw", "nut"),
    [
        (25.0, 999, 969),
        (50.0, 1259, 1221),
        # The paper prints 1585 for the nut too, which breaks its own F^{1/3} law.
        (100.0, 1585, 1539.6),
    ],
)
def test_lisowski_2014_pressures_as_published(load, screw, nut):
    """Lisowski 2014, Table 2: Hertz pressures [MPa], within 0.2 % (the paper's are rounded)."""
    contact = stage_contact(_one_pair("lisowski2014"), array(load))
    assert contact.screw.hertz.max_pressure / 1e6 == pytest.approx(screw, rel=2e-3)
    assert contact.nut.hertz.max_pressure / 1e6 == pytest.approx(nut, rel=2e-3)


@pytest.mark.parametrize(
    ("load", "screw", "nut"),
    [(25.0, 1000.2, 969.9), (50.0, 1260.2, 1221.9), (100.0, 1587.8, 1539.6)],
)
def test_lisowski_2014_pressures_with_exact_hertz(load, screw, nut):
    """The paper's curvatures in exact Hertz theory; independently computed reference."""
    contact = stage_contact(_one_pair("lisowski2014"), array(load))
    # Half a unit of the last printed digit.
    assert contact.screw.hertz.max_pressure / 1e6 == pytest.approx(screw, abs=0.05)
    assert contact.nut.hertz.max_pressure / 1e6 == pytest.approx(nut, abs=0.05)


_FLANK_CURVATURES = [
    (25.0, 1349.6, 1137.8),
    (50.0, 1700.4, 1433.5),
    (100.0, 2142.4, 1806.1),
]


@pytest.mark.parametrize(("load", "screw", "nut"), _FLANK_CURVATURES)
def test_lisowski_2014_with_exact_flank_curvatures(load, screw, nut):
    """The same loads on the true flanks, F/cos α₀ along the normal; independent reference."""
    pair = _one_pair("exact")
    frames = contact_frames(pair.thread, mesh(pair.thread), "exact")
    modulus = contact_modulus(present(pair.material), present(pair.material))
    for frame, published in zip(frames, (screw, nut), strict=True):
        curvature = frame.curvature
        force = array(load / np.cos(np.pi / 4))
        result = _hertz(force, curvature.total, curvature.difference_squared, modulus)
        # Half a unit of the last printed digit.
        assert result.max_pressure / 1e6 == pytest.approx(published, abs=0.05)


@pytest.mark.parametrize(("load", "screw", "nut"), _FLANK_CURVATURES)
def test_exact_convention_adds_the_helix_to_the_normal_force(load, screw, nut):
    """`exact` takes the common normal, F √(1 + tan²α + tan²λ): up to 0.1 % more pressure."""
    pair = _one_pair("exact")
    contact, meshing = stage_contact(pair, array(load)), mesh(pair.thread)
    for side, geometry, published in (
        (contact.screw, meshing.screw, screw),
        (contact.nut, meshing.nut, nut),
    ):
        helix = float(pair.thread.lead) / (2 * np.pi * float(geometry.contact_radius))
        factor = np.sqrt(1 + np.tan(np.pi / 4) ** 2 + helix**2)
        assert side.normal_force == pytest.approx(load * factor, rel=1e-14)
        increase = float(side.hertz.max_pressure) / 1e6 / published
        # F^{1/3}, and the reference's last printed digit.
        assert increase == pytest.approx((factor / np.sqrt(2)) ** (1 / 3), abs=5e-5)
        assert 1.0 < increase < 1.0012


def test_exact_curvatures_against_the_simple_set():
    """Roller 1/R, sin α/r_R; screw 0, sin α/r_s; nut 0, −sin α/r_n: ellipses 8 % off, p₀ 0.4 %."""
    geometry = thread(roller_radius=5e-3)
    modulus = contact_modulus(BEARING_STEEL, BEARING_STEEL)
    exact = contact_frames(geometry, mesh(geometry), "exact")
    simple = contact_frames(geometry, mesh(geometry), "wu2022")  # is that set at r_R = R sin α
    for one, other in zip(exact, simple, strict=True):
        results = [
            _hertz(array(100.0), c.curvature.total, c.curvature.difference_squared, modulus)
            for c in (one, other)
        ]
        ratios = [r.semi_minor / r.semi_major for r in results]
        assert 0.02 < abs(float(ratios[0] / ratios[1]) - 1) < 0.12
        assert results[0].max_pressure == pytest.approx(float(results[1].max_pressure), rel=5e-3)
        assert results[0].approach == pytest.approx(float(results[1].approach), rel=5e-3)


def test_wu_2022_axial_stiffness_of_one_contact():
    """Wu et al. 2022, equations 36 to 47, at 100 N; independently computed reference.

    The paper does not print the value for one contact; four digits are given.
    """
    one = stage(1, engaged_threads=1.0, material=Material(212e9, 0.29), curvature="wu2022")
    contact = stage_contact(one, array(100.0))
    assert contact.screw.axial_stiffness == pytest.approx(12.68e6, rel=4e-4)
    assert contact.nut.axial_stiffness == pytest.approx(13.80e6, rel=4e-4)


def _wu_without_given_threads():
    """Wu's mechanism with its thread stiffnesses derived, the gear's as in Table 4."""
    return eqx.tree_at(
        lambda m: m.stages[0].stiffness,
        example("wu2022"),
        GivenStiffness(ring_roller=2.464e8),
    )


_TREND = (
    "thread_stiffness_screw",
    "thread_stiffness_nut",
    "torsional_frequencies",
    "transverse_frequencies",
    "roller_frequency",
    "lowest_mesh_torsional_frequency",
)


@eqx.filter_jit
def _each(mechanisms):
    return jax.vmap(lambda mechanism: prsm.compute(mechanism, _TREND))(mechanisms)


def _along(mechanism, name, values):
    """All quantities of the trends over one design variable."""
    # The batch is made outside of the program, so that one program serves every variable.
    return _each(jax.vmap(lambda value: prsm.set_parameter(mechanism, name, value))(values))


def _rises(values):
    return bool(np.all(np.diff(values, axis=0) > 0))


def _bends(values):
    """Signs of the second differences."""
    return set(np.sign(np.diff(values, 2, axis=0)).ravel().tolist())


@pytest.mark.parametrize("name", ["roller_radius", "roller_radius_at_fixed_screw_radius"])
def test_wu_2022_figure_10_stiffness_over_roller_radius(name):
    """Rises with the roller radius, ever more slowly (whatever else is held fixed)."""
    found = _along(_wu_without_given_threads(), name, jnp.linspace(2e-3, 6e-3, 9))
    for side in ("screw", "nut"):
        stiffness = found[f"thread_stiffness_{side}"]
        assert _rises(stiffness)
        assert _bends(stiffness) == {-1.0}


def test_wu_2022_figures_11_and_12_over_contact_angle():
    """Stiffness rises with the contact angle, ever faster, and so do the roller modes.

    Figure 12 says "the first" frequency, which cannot be the carrier's: it holds no contact
    stiffness. All others rise; those that hang on the contacts alone (the roller modes, the
    highest torsional mode) ever faster, while the lowest mesh-dominated one, in series with the
    supports of Table 4, rises ever more slowly.
    """
    angles = jnp.radians(jnp.linspace(30.0, 60.0, 9))
    found = _along(_wu_without_given_threads(), "contact_angle", angles)
    for side in ("screw", "nut"):
        assert _rises(found[f"thread_stiffness_{side}"])
        assert _bends(found[f"thread_stiffness_{side}"]) == {1.0}
    assert _rises(found["torsional_frequencies"])
    assert _rises(found["transverse_frequencies"])
    assert _rises(found["roller_frequency"])
    assert _bends(found["roller_frequency"]) == {1.0}
    assert _bends(found["torsional_frequencies"][:, -1]) == {1.0}
    assert _bends(found["lowest_mesh_torsional_frequency"]) == {-1.0}
