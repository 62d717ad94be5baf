"""Wu et al. 2022, Tables 4 to 6: the published pattern, and what a stable structure has instead."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scenes import array, example, modal

import prsm_jax as prsm
from prsm_jax.validation import Row, validate
from prsm_jax.validation.wu2022._wu2022_indefinite import static_energies
from prsm_jax.validation.wu2022._wu2022_matrix import (
    ROLLER_MASS,
    eigen,
    published_matrices,
    published_modes,
    stable_matrices,
)
from prsm_jax.validation.wu2022._wu2022_shapes import assurance

COUNT = 7
DATA = Path(prsm.__file__).parent / "validation" / "data"


@pytest.fixture(scope="module")
def stage():
    return example("wu2022").stages[0]


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    return {row.item: row for row in validate("wu2022")}


@pytest.fixture(scope="module")
def table_6() -> dict[str, np.ndarray]:
    with (DATA / "wu2022_table6.csv").open(encoding="utf-8") as file:
        lines = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(lines) == COUNT + 10
    modes = list(lines[0])[1:]
    return {mode: np.array([float(line[mode]) for line in lines]) for mode in modes}


def test_table_6_is_transcribed_mass_normalised(stage, table_6):
    """φᵀ M φ = 1 within what two decimals leave; a slip in any large entry would show.

    17 entries of ±0.005 on masses up to 2.2 kg move the sum by at most 0.015.
    """
    _, mass = published_matrices(stage, COUNT)
    for mode, shape in table_6.items():
        assert shape @ (mass * shape) == pytest.approx(1.0, abs=0.015), mode


def test_table_6_is_reproduced_to_the_printed_digit(rows):
    found = [row for item, row in rows.items() if "entries of the shape" in item]
    assert len(found) == 10
    assert all((row.published, row.computed) == (17.0, 17.0) for row in found)
    # The carrier's and the rollers' shapes are those of the stable structure as well.
    for row in found:
        shared = row.item.startswith(("Table 6: f1,", "Table 6: r,"))
        assert row.verdict == ("reproduced" if shared else "fault reproduced"), row
        assert shared or row.own < 17
    misprints = [row for item, row in rows.items() if item.startswith("Table 6: t4, entry")]
    assert [row.published for row in misprints] == [0.007, 0.005]
    assert [row.verdict for row in misprints] == ["misprint explained"] * 2


def test_shapes_tell_the_patterns_apart(stage, table_6):
    """The published eigenspaces hold the printed shapes; those of the stable model do not.

    Rounding to two decimals leaves a criterion above 0.9998; only the carrier mode and the
    roller modes, which no sign can change, agree with the stable model.
    """
    modes = published_modes(stage, COUNT)
    matrix, mass = stable_matrices(stage, COUNT)
    values, vectors = eigen(matrix, mass)
    for name, shape in table_6.items():
        assert assurance(modes[name].shapes, mass, shape) > 0.9998, name
        clusters = [
            assurance(vectors[:, np.abs(values / value - 1) < 1e-9], mass, shape)
            for value in values
        ]
        assert (max(clusters) > 0.9998) == (name in ("f1", "r")), name


def test_published_shapes_solve_the_published_problem(stage):
    matrix, mass = published_matrices(stage, COUNT)
    modes = published_modes(stage, COUNT)
    assert sum(mode.shapes.shape[1] for mode in modes.values()) == COUNT + 10
    for mode in modes.values():
        squared = (2 * np.pi * mode.frequency) ** 2 * (-1 if mode.negative else 1)
        residual = matrix @ mode.shapes - squared * mass[:, None] * mode.shapes
        assert np.abs(residual).max() < 1e-9 * np.abs(matrix).max()


def test_six_displacements_release_energy(stage):
    """As many negative directions as negative eigenvalues, each worth ½ (K − k N or k N/2) u²."""
    matrix, mass = published_matrices(stage, COUNT)
    values, _ = eigen(matrix, mass)
    negative = np.nonzero(np.diag(matrix) < 0)[0]
    assert negative.tolist() == [0, 1, 5, 6, 7, 8]
    assert int((values < 0).sum()) == 6
    energies = static_energies()
    released, stored = energies["ring gear turned"]
    mesh = COUNT * 2.464e8
    assert released == pytest.approx(0.5e-12 * (3.380e6 - mesh), rel=1e-12)
    assert stored == pytest.approx(0.5e-12 * (3.380e6 + mesh), rel=1e-12)
    assert all(one < 0 < other for one, other in energies.values())
    assert np.linalg.eigvalsh(stable_matrices(stage, COUNT)[0]).min() > 0


def test_the_stable_matrix_is_the_model_of_the_toolkit(stage):
    """Same numbers (0.033 kg, m r²), other coordinates and assembly: the same frequencies."""
    radius = float(stage.thread.roller_radius)
    roller = dataclasses.replace(
        stage.roller, mass=array(ROLLER_MASS), inertia=array(ROLLER_MASS * radius**2)
    )
    parts = {
        name: dataclasses.replace(body, inertia=array(float(body.mass) * float(at) ** 2))
        for name, body, at in (
            ("screw", stage.screw, stage.thread.screw_radius),
            ("nut", stage.nut, stage.thread.nut_radius),
            ("ring_gear", stage.ring_gear, stage.thread.nut_radius),
        )
    }
    whole = example("wu2022")
    changed = dataclasses.replace(stage, roller=roller, **parts)
    frequencies = modal(dataclasses.replace(whole, stages=(changed,))).frequencies
    values, _ = eigen(*stable_matrices(stage, COUNT))
    np.testing.assert_allclose(frequencies, np.sqrt(values) / (2 * np.pi), rtol=1e-9)


def test_the_explanation_says_which_and_why(rows):
    row = rows["Tables 5 and 6, N = 7: eigenvalues below zero"]
    assert row.computed == 6.0
    for name in ("f3 5151 Hz", "f5 22308 Hz", "t1 2995 Hz twice", "t2 5712 Hz twice"):
        assert name in row.note


@pytest.mark.parametrize(
    ("item", "published", "computed", "tolerance"),
    [
        # 7850 kg/m³ π (4 mm)² l with l³ = 3 E I/K; by hand.
        ("mass of the roller, a cylinder as long as", 0.0326, 0.03294, 1e-5),
        ("mass of the screw, a cylinder as long as", 1.265, 1.0911, 1e-4),
        # G π r²/2l with l = m/(ρ π r²); by hand.
        ("torsional stiffness of the screw", 6.241e4, 5.218e7, 1e4),
        ("torsional stiffness of the nut", 9.359e6, 7.696e9, 1e6),
    ],
)
def test_audit_of_table_4(rows, item, published, computed, tolerance):
    (row,) = [row for name, row in rows.items() if name.startswith(f"Table 4: {item}")]
    assert row.published == published
    assert row.computed == pytest.approx(computed, abs=tolerance)
    expected = "not comparable" if item.startswith("mass") else "differs because"
    assert row.verdict == expected
