"""The files of `docs/extensions`, each from outside of the package, against closed forms."""

import dataclasses
import json
import os
import re
import subprocess
import sys
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from extensions import FOLDER, extension
from scenes import array, example, mechanism, simulate, stage

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.friction import CoulombFriction, Friction
from prsm_jax.quantities import _catalogue
from prsm_jax.report import analyse, report_section, write_report
from tests.compilation_cache import cache_folder
from tests.present import present

PAGE = FOLDER.parent / "extending.md"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_the_page_shows_the_file(path):
    shown = re.findall(r"^```py\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.M | re.S)
    assert path.read_text(encoding="utf-8") in shown


def _one():
    return mechanism(stage(friction=Friction(CoulombFriction(array(0.05)))))


def _stop(**changes):
    numbers = {"load": 500.0, "position": 0.02, "stiffness": 2e6, "damping": 1e3} | changes
    return extension("stop_load").StopLoad(*(array(x) for x in numbers.values()))


TRAVEL = 10e-3 / (2 * np.pi)


def _pressed(position, screw_speed):
    deflection = np.maximum(np.asarray(position) - 0.02, 0.0)
    pressed = 2e6 * deflection + 1e3 * TRAVEL * np.asarray(screw_speed)
    return 500.0 + np.where(deflection > 0, np.maximum(pressed, 0.0), 0.0)


def test_a_load_under_a_prescribed_torque():
    """The nut runs into the stop and is thrown back."""
    scene = prsm.TorqueScenario(array(2.0), _stop(), array(0.2), samples=201)
    run = simulate(_one(), scene, method="rosenbrock")
    assert int(run.solver.code) == 0
    np.testing.assert_allclose(run.load, _pressed(run.position, run.screw_speed), rtol=1e-9)
    assert np.max(present(run.position)) > 0.02
    assert np.min(run.screw_speed) < 0 < np.max(run.screw_speed)


def test_a_load_at_a_prescribed_speed_and_its_derivative():
    scene = prsm.Scenario(array(400.0), _stop(), array(0.05), samples=51)
    run = simulate(_one(), scene)
    expected = _pressed(400.0 * TRAVEL * np.asarray(run.time), run.screw_speed)
    np.testing.assert_allclose(run.load, expected, rtol=1e-9)
    assert expected[-1] > 1e4

    def last(stiffness):
        moved = prsm.Scenario(array(400.0), _stop(stiffness=stiffness), array(0.05), samples=51)
        return prsm.simulate(_one(), moved, gradient="forward", throw=False).drive_torque[-1]

    slope = float(jax.jvp(last, (array(2e6),), (array(1.0),))[1])
    ends = [float(last(array(2e6 * (1 + sign * 1e-3)))) for sign in (-1, 1)]
    assert slope == pytest.approx((ends[1] - ends[0]) / 4e3, rel=1e-6)


def test_a_profile():
    chirp = extension("chirp_profile").ChirpProfile(*(array(x) for x in (100.0, 20.0, 5.0, 100.0)))
    run = simulate(_one(), prsm.Scenario(chirp, array(5e3), array(0.2), samples=101))
    time = np.asarray(run.time)
    expected = 100 + 20 * np.sin(2 * np.pi * (5 * time + 50 * time**2))
    np.testing.assert_allclose(run.screw_speed, expected, rtol=1e-12)
    assert int(run.solver.code) == 0


@pytest.mark.parametrize("part", ["speed", "load"])
def test_a_file_says_which_function_it_cannot_hold(part):
    functions: dict[str, Any] = {"speed": array(10.0), "load": array(500.0)}
    functions[part] = _stop() if part == "load" else (lambda time: 10.0 + time)
    scene = prsm.Scenario(functions["speed"], functions["load"], array(0.1))
    with pytest.raises(
        prsm.FileError, match=rf"scenario.{part} is a \w+, which a file cannot hold"
    ):
        file.dumps(dataclasses.replace(_one(), scenario=scene))


@pytest.fixture
def own_quantity():
    before = dict(_catalogue._CATALOGUE)
    yield extension("torque_per_mass")
    _catalogue._CATALOGUE.clear()
    _catalogue._CATALOGUE.update(before)


def test_a_quantity_may_be_defined_twice(own_quantity):
    actuator = example("actuator")

    def values():
        return prsm.compute(actuator, ["torque_per_mass", "drive_torque", "mass"])

    first = values()
    expected = first["drive_torque"] / first["mass"]
    assert float(first["torque_per_mass"]) == pytest.approx(float(expected), rel=1e-14)

    # The cell again, changed: the compiled program of the first is not taken.
    def changed(analysis):
        return 2 * own_quantity.torque_per_mass(analysis)

    changed.__module__ = own_quantity.torque_per_mass.__module__
    changed.__qualname__ = own_quantity.torque_per_mass.__qualname__
    prsm.quantity("torque_per_mass", "M/m", "N·m/kg", "twice")(changed)
    assert float(values()["torque_per_mass"]) == pytest.approx(2 * float(expected), rel=1e-14)
    with pytest.raises(ValueError, match="'torque_per_mass' exists already"):
        prsm.quantity("torque_per_mass", "M/m", "N·m/kg", "of another")(lambda analysis: 0.0)  # pyright: ignore[reportArgumentType]


def test_a_section_of_the_report(tmp_path, monkeypatch):
    from prsm_jax.report.document import _sections

    monkeypatch.setattr(_sections, "_own", {})
    section = extension("rollers_section").rollers
    report_section("rollers", "Rollers")(section)
    write_report(tmp_path, analyse(example("lisowski2014")))
    for name in ("report.html", "report.md"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert "Rollers by stage" in text
        assert text.rindex("Rollers by stage") < text.rindex("Provenance")
    with pytest.raises(ValueError, match="'strength' exists already"):
        report_section("strength", "Mine")


def _prsm(folder, *words):
    environment = dict(os.environ, PRSM_JAX_CACHE=cache_folder())
    return subprocess.run(
        [sys.executable, "-m", "prsm_jax.cli._main", *map(str, words)],
        cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip


def test_a_verb_and_a_law_on_the_command_line(tmp_path):
    """In processes of their own: what a plugin adds stays in the process."""
    verb = _prsm(tmp_path, "--plugin", FOLDER / "loads_verb.py", "loads", "actuator", 5, 20,
                 "--json", "-")  # fmt: skip
    assert verb.returncode == 0, verb.stderr
    told = json.loads(verb.stdout)
    np.testing.assert_allclose(told["loads_n"], [5e3, 20e3])
    expected = [
        float(prsm.steady_state(example("actuator"), load=x).efficiency) for x in (5e3, 2e4)
    ]
    np.testing.assert_allclose(told["efficiency"], expected, rtol=1e-9)

    law = extension("solid_lubricant").SolidLubricantFriction(25e6, 0.01)
    one = mechanism(stage(friction=Friction(law)))
    file.dump(one, tmp_path / "one.toml")
    without = _prsm(tmp_path, "steady", "one.toml")
    assert without.returncode == 2
    assert 'law = "solid_lubricant": choose one of "coulomb"' in without.stderr
    with_law = _prsm(tmp_path, f"--plugin={FOLDER / 'solid_lubricant.py'}", "steady", "one.toml",
                     "--json", "-")  # fmt: skip
    assert with_law.returncode == 0, with_law.stderr
    found = json.loads(with_law.stdout)["efficiency"]
    assert found == pytest.approx(float(prsm.steady_state(one).efficiency), rel=1e-9)


@pytest.mark.parametrize(
    ("plugin", "words"),
    [
        ("nowhere.py", "there is no such file"),
        ("no_such_module_at_all", "there is no Python file, entry point of prsm_jax.plugins or"),
        ("broken.py", "ZeroDivisionError: division by zero"),
        ("", "name a module, a Python file or an entry point"),
    ],
)
def test_a_plugin_that_cannot_be_loaded(plugin, words, tmp_path, capsys, monkeypatch):
    from prsm_jax.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.py").write_text("1 / 0\n", encoding="utf-8")
    assert main([f"--plugin={plugin}", "quantities"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert len(err.splitlines()) == 1


def test_stored_programs_are_not_those_of_a_plugin(monkeypatch, tmp_path):
    """A plugin may change between two runs; what it computes is compiled anew."""
    from prsm_jax.cli import _plugins, _programs
    from prsm_jax.programs import _files

    monkeypatch.setattr(_plugins, "_loaded", [sys])
    monkeypatch.setattr(_files, "_key", lambda *_: pytest.fail("asked for a stored program"))
    found = _programs.run_stored("one", lambda m: {"x": jnp.ones(())}, example("wu2022"))
    assert float(found["x"]) == 1.0


def test_two_plugins_of_one_name_are_two(tmp_path, monkeypatch):
    """A file is not a module of the same name, and a law of another file not the same law."""
    from prsm_jax.cli import _plugins, load_plugin

    monkeypatch.setattr(_plugins, "_loaded", [])
    text = (
        "import prsm_jax as prsm\n"
        "@prsm.friction_law('of_two_files')\n"
        "class Own(prsm.FrictionLaw):\n"
        "    def friction_coefficient(self, sliding):\n"
        "        return 0.1\n"
    )
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "html.py").write_text(text, encoding="utf-8")
    load_plugin(str(tmp_path / "first" / "html.py"))
    assert "html" not in sys.modules or "prsm" not in vars(sys.modules["html"])
    with pytest.raises(prsm.PrsmError, match="has this name; choose another"):
        load_plugin(str(tmp_path / "second" / "html.py"))


def test_stored_programs_are_not_those_of_a_users_own_classes(monkeypatch):
    from prsm_jax.programs import _files, _stored

    class Own(prsm.FrictionLaw):
        def friction_coefficient(self, sliding):  # pyright: ignore[reportIncompatibleMethodOverride]
            return 0.1

    monkeypatch.setattr(_files, "_key", lambda *_: pytest.fail("asked for a stored program"))
    _stored.run_stored(
        "one", lambda m: {"x": jnp.ones(())}, mechanism(stage(friction=Friction(Own())))
    )


def test_a_verb_does_not_take_a_name_that_is_taken():
    from prsm_jax.cli import verb

    def steady():
        """Not the package's."""

    with pytest.raises(ValueError, match="the verb 'steady' exists already"):
        verb(steady)
