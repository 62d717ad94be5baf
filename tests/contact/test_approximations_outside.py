"""Approximations of a user's own, in everything that rests on the contact ellipse.

With the exact κ, K times k and E times e, Hertz's equations give a ∝ e^{1/3}, p₀ ∝ e^{-2/3} and
δ ∝ k e^{-1/3}: every result follows from the exact one by powers of the two factors. What is
compared is then the same arithmetic but for these powers, so 1e-12 is rounding.
"""

import dataclasses
import json
import re
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from extensions import FOLDER, extension
from scenes import STEEL, array, mechanism, stage, steady_state

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.contact import (
    axis_ratio_of,
    complete_elliptic_integrals,
    contact_approximation,
    hertz_contact,
)
from prsm_jax.friction import Friction, RollingHysteresis
from prsm_jax.mechanism import ContactMethod, LoadSharing, Material, Nut, Strength
from prsm_jax.strength import cycles_per_turn
from tests.present import present

K, E = 0.99, 1.01


@dataclasses.dataclass(frozen=True)
class Off:
    """The exact ellipse, with both integrals off by factors."""

    first: float = K
    second: float = E

    def __call__(self, anisotropy):
        ratio = axis_ratio_of(anisotropy)
        first, second = complete_elliptic_integrals(ratio)
        return ratio, self.first * first, self.second * second


def _one(method: ContactMethod = "exact", **more: Any):
    """Curvatures in closed form, whose programs are small."""
    strength = Strength(permissible_pressure=4.2e9, material_factor=1.0)
    parts: dict[str, Any] = {"curvature": "wu2022", "strength": strength} | more
    return mechanism(stage(contact_method=method, **parts))


def _ratios(found, exact):
    return {name: float(np.ravel(found[name])[0] / np.ravel(exact[name])[0]) for name in exact}


#: By what the equations say, in powers of the two factors. Capacities: p₀ ∝ F^{1/3}; the risk of
#: Lundberg and Palmgren is ∝ p₀^{31/3} a a^{1-7/3}, and the capacity its power -3/10.
POWERS = {
    "max_pressure": (0, -2 / 3),
    "semi_major_screw": (0, 1 / 3),
    "semi_minor_screw": (0, 1 / 3),
    "approach_nut": (1, -1 / 3),
    "axial_stiffness": (-1, 1 / 3),
    "max_shear_stress_screw": (0, -2 / 3),
    "static_capacity": (0, 2),
    "dynamic_capacity": (0, 2.1),
}


def test_pressures_stiffness_and_strength_follow_the_equations():
    exact, own = (prsm.compute(_one(method), POWERS) for method in ("exact", Off()))
    for name, ratio in _ratios(own, exact).items():
        first, second = POWERS[name]
        assert ratio == pytest.approx(K**first * E**second, rel=1e-12), name


def test_fatigue_takes_the_axis_ratio_of_the_approximation():
    """All contacts are circles: capacities for two numbers of starts differ by p₀ and a alone."""
    capacities, expected = [], []
    for starts in (4.0, 8.0):
        one = prsm.set_parameter(_one(extension("circle").circle), "starts", starts)
        capacities.append(float(prsm.compute(one, ["dynamic_capacity"])["dynamic_capacity"][0]))
        (part,) = one.stages
        geometry, risk = part.thread, 0.0
        turns = [float(x) for x in cycles_per_turn(part)]
        ball = np.cos(np.pi / 4) / float(geometry.roller_radius)
        normal = 1 / np.cos(float(geometry.roller_helix_angle))
        for radius, sign, cycles in (
            (float(geometry.screw_radius), 1, turns[0]),
            (float(geometry.nut_radius), -1, turns[2]),
        ):
            total = ball + sign * np.cos(np.pi / 4) / (2 * radius)
            semi_axis = (normal / total) ** (1 / 3)
            tracks = radius * cycles ** (10 / 9)
            tracks += 10 * float(geometry.roller_radius) * turns[1] ** (10 / 9)
            risk += (normal / semi_axis**2) ** (31 / 3) * semi_axis ** (2 - 7 / 3) * tracks
        expected.append(risk**-0.3)
    assert capacities[0] / capacities[1] == pytest.approx(expected[0] / expected[1], rel=1e-12)


def _shared(method: ContactMethod = "exact", youngs_modulus=210e9):
    chains = LoadSharing(
        20,
        screw_segment_stiffness=2e9,
        roller_segment_stiffness=3e8,
        nut_segment_stiffness=4e9,
    )
    material = Material(youngs_modulus, 0.3, 7850.0)
    return _one(method, load_sharing=chains, material=material, strength=None)


def test_load_sharing_is_that_of_another_modulus():
    """δ ∝ k F^{2/3} E*^{-2/3}: K off by k shifts loads as a modulus times k^{-3/2} does."""
    names = ("axial_stiffness", "max_pressure_shared", "largest_thread_load")
    softer = prsm.compute(_shared(youngs_modulus=210e9 * K**-1.5), names)
    ratios = _ratios(prsm.compute(_shared(Off(second=1.0)), names), softer)
    # The pressure under a load is ∝ E*^{2/3}, and does not depend on K.
    # Loads are solved to 1e-10 of the mean, not to rounding.
    assert ratios == pytest.approx(
        {"axial_stiffness": 1.0, "max_pressure_shared": K, "largest_thread_load": 1.0},
        rel=1e-9,
    )
    exact = prsm.compute(_shared(), names)
    assert abs(_ratios(softer, exact)["largest_thread_load"] - 1) > 1e-4


def test_losses_and_friction_by_pressure_follow_the_equations():
    """p₀ off by e^{-2/3} rubs as a film stronger by e^{2/3}; the half-length is off by e^{1/3}."""
    law = extension("solid_lubricant").SolidLubricantFriction

    def rolling(method, strength, loss):
        friction = Friction(law(array(strength), array(0.01)), rolling_hysteresis=loss)
        return mechanism(stage(friction=friction, contact_method=method))

    own = rolling(Off(), 25e6, RollingHysteresis(0.05))
    same = rolling("exact", 25e6 * E ** (2 / 3), RollingHysteresis(0.05 * E ** (1 / 3)))
    exact = rolling("exact", 25e6, RollingHysteresis(0.05))
    steady = [steady_state(one) for one in (own, same, exact)]
    for name in ("thread_sliding", "rolling_hysteresis"):
        losses = [float(state.losses[name]) for state in steady]
        assert losses[0] == pytest.approx(losses[1], rel=1e-12)
        assert abs(losses[0] / losses[2] - 1) > 1e-3
    scene = prsm.Scenario(array(100.0), array(7e3), array(1e-3), samples=3)
    runs = [
        prsm.simulate(one, scene, method=prsm.QuasiSteady(), throw=False) for one in (own, same)
    ]
    assert int(runs[0].solver.code) == 0
    np.testing.assert_allclose(runs[0].drive_torque, runs[1].drive_torque, rtol=1e-12)


def test_gradients_and_a_sweep():
    angles = np.array([0.6, 0.7, 0.8])
    exact, own = (
        prsm.sweep(_one(method), {"contact_angle": angles}, ["max_pressure"])
        for method in ("exact", Off())
    )
    np.testing.assert_allclose(
        own.max_pressure.values, exact.max_pressure.values * E ** (-2 / 3), rtol=1e-12
    )

    def pressure(angle, one):
        moved = prsm.set_parameter(one, "contact_angle", angle)
        return prsm.compute(moved, ["max_pressure"])["max_pressure"]

    for mode in (jax.grad, jax.jacfwd):
        slopes = [
            float(jax.jit(mode(pressure))(array(0.7), _one(method))) for method in ("exact", Off())
        ]
        assert slopes[1] == pytest.approx(slopes[0] * E ** (-2 / 3), rel=1e-12)


def test_an_optimum_lies_where_the_approximation_puts_the_limit():
    """The limit of the pressure is active: the exact pressure there is higher by e^{2/3}."""
    nut = Nut(mass=2.2, inertia=9e-4, wall_thickness=8e-3)
    best = prsm.optimise(
        _one(Off(), nut=nut),
        {"roller_radius": (3e-3, 8e-3)},
        minimise="nut_outer_diameter",
        constraints={"max_pressure": (None, 1.2e9)},
        starts=1,
    )
    assert best.converged, str(best)
    assert best.constraints[0].active
    assert best.mechanism.stages[0].contact_method == Off()
    exact = dataclasses.replace(best.mechanism.stages[0], contact_method="exact")
    found = prsm.compute(dataclasses.replace(best.mechanism, stages=(exact,)), ["max_pressure"])[
        "max_pressure"
    ]
    # SLSQP keeps a limit to 1e-9 or better of its value.
    assert float(found) == pytest.approx(1.2e9 * E ** (2 / 3), rel=1e-8)


def test_a_circle_is_exact_where_it_claims_to_be():
    circle = extension("circle").circle
    one = hertz_contact(array(100.0), array(50.0), array(0.0), array(1e11))
    for method in (circle, "circle"):
        own = hertz_contact(array(100.0), array(50.0), array(0.0), array(1e11), method)
        for name in ("max_pressure", "approach", "semi_major"):
            assert float(getattr(own, name)) == pytest.approx(float(getattr(one, name)), rel=1e-13)
    # For one call, in place of that of the stage.
    for of_stage, of_call in (("exact", circle), (circle, None), (Off(), "circle")):
        (contact,) = prsm.thread_contacts(_one(of_stage), method=of_call)
        assert float(contact.nut.hertz.semi_minor) == float(contact.nut.hertz.semi_major)
    (contact,) = prsm.thread_contacts(_one(circle), method="exact")
    assert float(contact.nut.hertz.semi_minor) < 0.9 * float(contact.nut.hertz.semi_major)


def test_files_know_an_approximation_by_its_name():
    circle = extension("circle").circle
    text = file.dumps(_one("circle"))
    assert 'contact_method = "circle"' in text
    assert file.loads(text).stages[0].contact_method is circle
    assert file.loads(text.replace('"circle"', '"lisowski"')).stages[0].contact_method == "lisowski"
    assert "contact_method" not in file.dumps(_one())
    # The choice is not frozen once it is a function.
    back = file.apply_settings(_one(circle), ["contact_method=exact"])
    assert back.stages[0].contact_method == "exact"
    with pytest.raises(prsm.FileError, match=r"stage\.contact_method is Off, which files do not"):
        file.dumps(_one(Off()))
    contact_approximation("nearly_hertz")(Off())
    assert file.loads(file.dumps(_one(Off()))).stages[0].contact_method == Off()


KNOWN = "exact, antoine, power, hamrock_brewe, hamrock_brewe_log, lisowski"


@pytest.mark.usefixtures("unchecked")
def test_an_unknown_name_is_refused_with_those_known():
    with pytest.raises(ValueError, match=f"contact_method is 'circle'; choose one of {KNOWN}$"):
        stage(contact_method="circle")
    with pytest.raises(ValueError, match=f"method is 'circle'; choose one of {KNOWN}, or give"):
        hertz_contact(array(1.0), array(1.0), array(0.0), array(1.0), "circle")
    text = file.dumps(_one("power")).replace('"power"', '"circle"')
    quoted = re.escape(", ".join(f'"{word}"' for word in KNOWN.split(", ")))
    with pytest.raises(prsm.FileError, match=f'method = "circle": choose one of {quoted}$'):
        file.loads(text)
    extension("circle")
    with pytest.raises(ValueError, match=f"is 'circel'; choose one of {KNOWN}, circle$"):
        stage(contact_method="circel")
    with pytest.raises(ValueError, match="contact_method is a list, which is not hashable"):
        stage(contact_method=type("list", (list,), {"__call__": lambda self, x: x})())


@pytest.mark.usefixtures("unchecked")
def test_a_name_may_be_defined_twice_but_not_taken():
    def named(value):
        @contact_approximation("of_a_cell")
        def own(anisotropy):
            one = jnp.ones_like(anisotropy)
            return one, value * one, jnp.pi / 2 * one

        return _one("of_a_cell")

    # A cell that is run again, changed: the program of the first is not taken.
    first, second = (
        float(prsm.compute(named(value), ["approach_nut"])["approach_nut"][0])
        for value in (1.5, 3.0)
    )
    assert second == pytest.approx(2 * first, rel=1e-14)
    with pytest.raises(ValueError, match=r"own has a method of this name; choose another"):
        contact_approximation("of_a_cell")(Off())
    with pytest.raises(ValueError, match="'lisowski': the package has a method of this name"):
        contact_approximation("lisowski")(Off())
    with pytest.raises(ValueError, match="a name is lower-case words joined by underscores"):
        contact_approximation("My method")
    with pytest.raises(TypeError, match="must be a function of the anisotropy"):
        contact_approximation("number")(3.0)  # pyright: ignore[reportArgumentType]


def test_assumptions_name_the_approximation():
    exact = prsm.assumptions(_one(), ["max_pressure", "mass"])
    extension("circle")
    added = set(prsm.assumptions(_one("circle"), ["max_pressure", "mass"])) - set(exact)
    (sentence,) = added
    assert sentence.startswith("Contact ellipses are those of the approximation circle")
    assert prsm.assumptions(_one(Off()), ["mass"]) == ()
    assert not any("approximation" in text for text in exact)


def test_on_the_command_line(tmp_path, capsys, monkeypatch):
    """Loaded by `--plugin`; programs of earlier runs are not taken for it."""
    from prsm_jax.cli import _plugins, main
    from prsm_jax.programs import _stored

    monkeypatch.setattr(_plugins, "_loaded", [])
    file.dump(mechanism(stage(curvature="wu2022", material=STEEL)), tmp_path / "one.toml")
    words = ["contact", str(tmp_path / "one.toml"), "--set", "contact_method=circle"]
    assert main(words) == 2
    assert f"'circle' is not one of {KNOWN}" in capsys.readouterr().err
    assert main([f"--plugin={FOLDER / 'circle.py'}", *words, "--json", "-"]) == 0
    nut = json.loads(capsys.readouterr().out)["stages"][0]["nut"]
    assert nut["semi_major_m"] == nut["semi_minor_m"]
    assert _stored._is_known(_one())
    assert _stored._is_known(_one("power"))
    assert not _stored._is_known(_one("circle"))
    assert present(_one("circle").stages[0].contact_method).__module__.startswith("prsm_plugin_")
