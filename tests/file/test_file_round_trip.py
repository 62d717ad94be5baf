"""What is written reads back bit for bit, and a write is all or nothing."""

import dataclasses
import os

import equinox as eqx
import jax.numpy as jnp
import pytest

import prsm_jax.file as file
from prsm_jax._errors import FileError
from prsm_jax.mechanism import set_parameter
from tests.present import present


@pytest.mark.parametrize("name", file.example_names())
def test_examples_survive_exactly(identical, name):
    mechanism = file.load(name)
    text = file.dumps(mechanism)
    again = file.loads(text)
    assert identical(mechanism, again)
    assert again.design_problem == mechanism.design_problem
    assert file.dumps(again) == text


def test_an_optimised_mechanism_survives_exactly(identical, tmp_path):
    mechanism = set_parameter(file.load("actuator"), "roller_profile_radius", jnp.sqrt(2.0) * 4e-3)
    mechanism = set_parameter(mechanism, "lead", 1 / 97)
    path = tmp_path / "optimised.toml"
    file.dump(mechanism, path)
    assert identical(mechanism, file.load(path))
    assert identical(mechanism, file.load(str(path)))


def test_units_of_limits_are_written_when_the_caller_knows_them():
    mechanism = file.load("actuator")
    text = file.dumps(
        mechanism,
        {"max_pressure_shared": "Pa", "first_axial_frequency": "Hz", "unused": "m"},
    )
    assert 'upper = "2.1 GPa"' in text
    assert 'lower = "7.5 kHz"' in text
    assert file.loads(text).design_problem == mechanism.design_problem


def test_engineering_units_are_chosen():
    text = file.dumps(file.load("actuator"))
    for line in (
        'speed = "1500 rpm"',
        'load = "12 kN"',
        'lead = "10 mm"',
        'contact_angle = "45 deg"',
        'youngs_modulus = "210 GPa"',
        'density = "7850 kg/m^3"',
        'radial_stiffness = "200 N/um"',
        "starts = 5",
        "coefficient = 0.06",
    ):
        assert line in text.splitlines()


def test_a_failing_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "mechanism.toml"
    file.dump(file.load("wu2022"), path)
    before = path.read_bytes()

    def refuse(*_):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(FileError, match="cannot be written: disk full"):
        file.dump(file.load("actuator"), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["mechanism.toml"]


def test_a_mechanism_that_cannot_be_read_back_is_not_written(tmp_path):
    path = tmp_path / "mechanism.toml"
    mechanism = file.load("wu2022")
    for change, message in (
        (set_parameter(mechanism, "lead", -0.01, checked=False), "must be more than 0"),
        (set_parameter(mechanism, "lead", jnp.nan), "finite"),
    ):
        with pytest.raises(FileError, match=message):
            file.dump(change, path)
    with pytest.raises(ValueError, match=r"shape \(3,\).*one after the other"):
        file.dump(set_parameter(mechanism, "lead", jnp.ones(3)), path)
    renamed = dataclasses.replace(file.load("actuator").design_problem.variables[0], name="leed")
    problem = dataclasses.replace(
        present(file.load("actuator").design_problem), variables=(renamed,)
    )
    with pytest.raises(FileError, match="leed"):
        file.dump(dataclasses.replace(mechanism, design_problem=problem), path)
    assert not path.exists()


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(FileError, match=r"mechanism\.toml: cannot be written: No such file"):
        file.dump(file.load("wu2022"), tmp_path / "absent" / "mechanism.toml")


def test_no_part_of_an_example_appears_from_nowhere():
    stage = file.load("li2020_two_stage").stages[0]
    assert stage.ring_gear is None
    assert stage.friction is not None
    assert stage.friction.spin is None
    assert eqx.tree_equal(stage.screw.mass, None)
