"""Second derivatives against closed forms and against central differences of gradients."""

import json

import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.cli import main
from prsm_jax.sensitivities import sensitivity

PARAMETERS = ("lead", "contact_angle", "roller_radius")


def test_second_derivatives_of_hertz_theory():
    """p₀ = c F^a z^b, a = 1/3, b = −1/3: ∂²p₀/∂F² = a (a − 1) p₀/F², ∂²p₀/∂F∂z = a b p₀/(F z)."""
    table = sensitivity(
        scenes.mechanism(),
        ["max_pressure", "nut_speed"],
        ["operating_point.load", "engaged_threads"],
        second=True,
    )
    pressure = float(table.values[0])
    load, threads = (float(values[0]) for values in table.parameter_values)
    a, b = 1 / 3, -1 / 3
    expected = pressure * np.array(
        [
            [a * (a - 1) / load**2, a * b / (load * threads)],
            [a * b / (load * threads), b * (b - 1) / threads**2],
        ]
    )
    np.testing.assert_allclose(table.hessian[0], expected, rtol=1e-11)
    # The speed of the nut follows from the lead alone.
    np.testing.assert_array_equal(table.hessian[1], np.zeros((2, 2)))


def test_second_derivatives_against_differences_of_gradients():
    """All pairs at once: a step of one parameter moves the gradient by all."""
    mechanism, names = scenes.mechanism(), ["efficiency", "max_pressure"]
    table = sensitivity(mechanism, names, PARAMETERS, second=True)
    found = np.asarray(table.hessian)
    np.testing.assert_array_equal(found, np.swapaxes(found, 1, 2))
    for column, name in enumerate(PARAMETERS):
        centre = float(prsm.get_parameter(mechanism, name))
        # Richardson from two steps: truncation h⁴ ~ 1e-12, rounding 1e-16/h ~ 1e-12.
        slopes = []
        for step in (1e-3, 5e-4):
            ends = [
                sensitivity(
                    prsm.set_parameter(mechanism, name, centre * (1 + sign * step)),
                    names,
                    PARAMETERS,
                    kinks=False,
                ).gradient
                for sign in (1, -1)
            ]
            slopes.append((np.asarray(ends[0]) - np.asarray(ends[1])) / (2 * step * centre))
        reference = (4 * slopes[1] - slopes[0]) / 3
        # Relative to a value's own scale: the pressure hardly feels the lead.
        sizes = [float(prsm.get_parameter(mechanism, other)) for other in PARAMETERS]
        scale = np.abs(reference) + 1e-3 * np.abs(np.asarray(table.values))[:, None] / (
            centre * np.array(sizes)
        )
        error = np.abs(found[:, :, column] - reference) / scale
        assert error.max() < 1e-6, (name, error)


def test_stages_move_together():
    """v = Ω (L₁ + L₂) / 2π has no second derivative by leads, and none by a name of both."""
    two = scenes.mechanism(scenes.stage(), scenes.stage())
    table = sensitivity(two, ["nut_speed"], ["lead", "operating_point.speed"], second=True)
    # ∂²v/∂L∂Ω = 2/2π, as L stands for both leads.
    mixed = 1 / np.pi
    np.testing.assert_allclose(table.hessian[0], [[0, mixed], [mixed, 0]], atol=1e-15)


def test_the_table_and_the_verb_have_them(capsys):
    given = ["sensitivity", "wu2022", "--quantities", "nut_speed"]
    given += ["--parameters", "lead,operating_point.speed"]
    assert main([*given, "--second", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    ((first, second),) = found["hessian"]
    # v = Ω L / 2π.
    assert first == [pytest.approx(0.0, abs=1e-15), pytest.approx(1 / (2 * np.pi), rel=1e-12)]
    assert second == [first[1], pytest.approx(0.0, abs=1e-15)]
    assert main([*given, "--json", "-"]) == 0
    assert "hessian" not in json.loads(capsys.readouterr().out)


def test_the_text_has_the_units_of_both():
    """v = Ω L / 2π: 1 rpm and 1 mm are 1/60 mm/s."""
    table = sensitivity(
        prsm.load("wu2022"), ["nut_speed"], ["lead", "operating_point.speed"], second=True
    )
    (line,) = [row for row in table.text().splitlines() if "per mm rpm" in row]
    assert line.split()[-3:-1] == ["lead", "operating_point.speed"]
    assert float(line.split()[-1]) == pytest.approx(1 / 60, rel=1e-5)
