"""The state behind the page: numbers of the Python API, steps, files."""

import dataclasses
import math
import shlex

import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.report import analyse
from prsm_jax.studio import History, Session, _session, studio_variables
from prsm_jax.studio._snippets import status_html

_DEGREE = math.pi / 180


def test_the_variables_are_those_of_the_table_in_engineering_units(session):
    shown = [(v.name, v.unit.label, v.limits, v.step) for v in session.variables]
    assert shown == [
        ("contact_angle", "deg", "35 to 55 deg", 0.1),
        ("roller_radius", "mm", "2.5 to 4 mm", 0.01),
        ("operating_point.speed", "rpm", "150 to 1200 rpm", 10.0),
        ("operating_point.load", "kN", "1 to 8 kN", 0.01),
    ]
    # As the file says.
    assert session.design == pytest.approx(
        {
            "contact_angle": 45 * _DEGREE,
            "roller_radius": 3e-3,
            "operating_point.speed": 20 * math.pi,
            "operating_point.load": 4e3,
        },
        rel=1e-15,
    )


def test_without_a_table_the_usual_variables_are_moved():
    variables = studio_variables(prsm.load("lisowski2014"))
    of_load = ("operating_point.speed", "operating_point.load")
    assert [v.name for v in variables] == [
        "lead",
        "contact_angle",
        "roller_radius",
        "roller_profile_radius",
        *of_load,
    ]
    for one in variables:
        value = float(prsm.get_parameter(prsm.load("lisowski2014"), one.name))
        assert one.lower < value < one.upper
    # Stages that differ are moved one by one.
    stages = [v.name for v in studio_variables(prsm.load("li2020_two_stage"))]
    assert len(stages) == len(set(stages))
    for name in stages:
        usual = ("contact_angle", "lead", "roller_radius", "roller_profile_radius", *of_load)
        assert name in usual or (name.startswith(("stage.1.", "stage.2.")))


def test_speed_and_load_are_moved_unless_they_are_absent_or_zero():
    actuator = prsm.load("actuator")
    back = prsm.set_parameter(actuator, "operating_point.speed", -100.0)
    (speed,) = [v for v in studio_variables(back) if v.name == "operating_point.speed"]
    assert (speed.label, speed.lower, speed.upper) == ("speed", -200.0, -25.0)
    still = prsm.set_parameter(actuator, "operating_point.speed", 0.0)
    names = [v.name for v in studio_variables(still)]
    assert (names[-1], "operating_point.speed" in names) == ("operating_point.load", False)
    bare = dataclasses.replace(actuator, operating_point=None)
    assert not any("operating" in v.name for v in studio_variables(bare))


def test_a_moved_load_is_in_the_numbers_and_in_the_saved_file(session, small, tmp_path):
    session.set("operating_point.load", 5.5)
    session.set("operating_point.speed", 900)
    saved = prsm.load(session.save("loaded"))
    assert float(saved.operating_point.load) == pytest.approx(5500.0, rel=1e-12)
    assert float(saved.operating_point.speed) == pytest.approx(30 * math.pi, rel=1e-12)
    moved = prsm.set_parameter(prsm.load(small), "operating_point.load", 5500.0)
    pressure = float(prsm.compute(moved, ["max_pressure"])["max_pressure"])
    numbers = session.numbers()
    found = numbers.values[numbers.quantities.index("max_pressure")]
    assert found == pytest.approx(pressure, rel=1e-12)
    session.undo()
    session.undo()
    assert session.design["operating_point.load"] == 4000.0


def test_numbers_are_exactly_those_of_the_python_api(session, small):
    session.set("contact_angle", 47.5)
    session.set("roller_radius", 2.9)
    numbers = session.numbers()
    mechanism = prsm.load(small)
    for name, value in (("contact_angle", 47.5 / (180 / math.pi)), ("roller_radius", 2.9 / 1e3)):
        mechanism = prsm.set_parameter(mechanism, name, value)
    names = ["efficiency", "drive_torque", "max_pressure", "nut_radius"]
    table = prsm.sensitivity(mechanism, names, list(numbers.variables), kinks=False)
    assert numbers.quantities == table.quantities == (*names[:-1], "nut_radius[1]")
    assert np.array_equal(numbers.values, np.asarray(table.values))
    steps = np.array([session.design[name] for name in numbers.variables]) / 100
    # One multiplication: no more than its rounding.
    np.testing.assert_allclose(numbers.changes, np.asarray(table.gradient) * steps, rtol=4e-16)
    assert numbers.valid
    verdicts = session.verdicts()
    assert verdicts.findings == prsm.check(mechanism)
    assert verdicts.checks == prsm.strength_checks(mechanism)


def test_changes_are_differences_of_values(session):
    numbers = session.numbers()
    row = numbers.quantities.index("max_pressure")
    for column, name in enumerate(numbers.variables):
        # 1 % up and down: the third derivative is left, 1e-4 of the change.
        up, down = (
            session.numbers({**session.design, name: session.design[name] * factor})
            for factor in (1.01, 0.99)
        )
        difference = (up.value("max_pressure") - down.value("max_pressure")) / 2
        assert numbers.changes[row, column] == pytest.approx(difference, rel=1e-3)
        share = difference / numbers.value("max_pressure")
        assert numbers.relative[row, column] == pytest.approx(share, rel=1e-3)
    assert numbers.changes[numbers.quantities.index("nut_radius[1]")] == pytest.approx(
        [0.0, 0.01 * 15e-3, 0.0, 0.0]
    )


def test_limits_of_the_table(session):
    (limit,) = session.limits(session.numbers())
    assert (limit.quantity, limit.at_most, limit.verdict) == ("nut_radius[1]", True, "fail")
    assert (limit.value, limit.limit) == pytest.approx((15e-3, 14e-3), rel=1e-15)
    # 15 mm against 14 mm.
    assert limit.margin == pytest.approx(-1 / 14, rel=1e-12)
    session.set("roller_radius", 2.8)
    (limit,) = session.limits(session.numbers())
    assert limit.margin == pytest.approx(0.0, abs=1e-12)


def test_the_report_has_the_limits_and_the_status_of_the_page(session, small):
    """Nothing but the limit of [optimise] is broken in the file."""
    limits = session.limits(session.numbers())
    assert session.verdicts().status != "fail"
    data = analyse(prsm.load(small), transient=False)
    assert data.status == "fail"
    assert data.limits is not None
    (one,), (shown,) = data.limits, limits
    assert dataclasses.replace(one, value=0.0, margin=0.0) == dataclasses.replace(
        shown, value=0.0, margin=0.0
    )
    assert (one.value, one.margin) == pytest.approx((shown.value, shown.margin), rel=1e-12)
    assert 'class="status fail"' in status_html(session.verdicts(), limits, 1)
    session.set("roller_radius", 2.8)
    moved = session.mechanism()
    data = analyse(moved, transient=False)
    assert data.status == session.verdicts().status != "fail"
    assert status_html(session.verdicts(), session.limits(session.numbers()), 1).startswith(
        f'<p class="status {data.status}"'
    )


def test_the_report_names_the_command_that_opens_the_studio_with_its_design(
    small, tmp_path, monkeypatch
):
    given = {}
    monkeypatch.setattr(_session, "analyse", lambda mechanism, **more: given.update(more))
    monkeypatch.setattr(_session, "write_report", lambda place, data: place / "report.html")
    session = Session(
        small, tmp_path / "a b", ["youngs_modulus=205 GPa"], options=["--plugin", "my laws.py"]
    )
    session.set("roller_radius", 3.5)
    assert session.report() == tmp_path / "a b" / "report" / "report.html"
    words = shlex.split(given["command"])
    settings = ("youngs_modulus=205 GPa", "roller_radius=3.5 mm")
    assert given["origin"].settings == settings
    assert words == [
        *("prsm", "studio", small, "--out", str(tmp_path / "a b")),
        *("--set", settings[0], "--set", settings[1], "--plugin", "my laws.py"),
    ]
    again = Session(small, tmp_path / "b", settings)
    assert again.design == pytest.approx(dict(session.design), rel=1e-12)


def test_steps_are_undone_and_done_again(session):
    first, version = dict(session.design), session.version
    # A slider that is dragged is one step.
    for shown in (46.0, 47.0, 48.0):
        session.move("contact_angle", shown)
    assert session.can_undo
    session.commit()
    session.set("roller_radius", 3.5)
    last = dict(session.design)
    moved = {"contact_angle": 48 * _DEGREE, "roller_radius": 3.5e-3}
    assert last == pytest.approx({**first, **moved})
    session.undo()
    assert session.design["roller_radius"] == first["roller_radius"]
    assert session.design["contact_angle"] == last["contact_angle"]
    session.undo()
    assert dict(session.design) == first
    assert not session.can_undo
    session.undo()
    assert dict(session.design) == first
    session.redo()
    session.redo()
    assert dict(session.design) == last
    assert not session.can_redo
    session.undo()
    session.set("contact_angle", 50.0)
    # A new step forgets those that were undone.
    assert not session.can_redo
    assert session.version > version


def test_a_move_that_was_not_committed_is_undone_too():
    history = History.of({"a": 1.0}).moved({"a": 2.0}).committed().moved({"a": 3.0})
    assert dict(history.undone().present) == {"a": 2.0}
    assert dict(history.undone().redone().present) == {"a": 3.0}
    assert history.redone() is history
    assert history.committed().committed() == history.committed()


@pytest.mark.parametrize(
    ("shown", "words"),
    [
        *((value, str(value)) for value in (34.9, 55.1, math.inf)),
        *((value, "not a number") for value in (math.nan, "much", "", None)),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_values_beyond_the_limits_are_refused(session, shown, words):
    before = session.design
    with pytest.raises(prsm.PrsmError, match=f"contact angle is {words}; give 35 to 55 deg"):
        session.set("contact_angle", shown)
    assert session.design == before
    with pytest.raises(prsm.PrsmError, match="unknown variable 'lead'; known: contact_angle"):
        session.set("lead", 8.0)


def test_a_limit_itself_is_allowed(session):
    for shown in (35.0, 55.0):
        session.set("contact_angle", shown)
        assert session.design["contact_angle"] == pytest.approx(shown * _DEGREE, rel=1e-15)


def test_a_saved_file_gives_the_same_numbers(session, tmp_path):
    session.set("contact_angle", 47.3)
    session.set("roller_radius", 2.7)
    path = session.save("mine")
    assert path == tmp_path / "chosen" / "mine.toml"
    assert "# kept by an edit" in path.read_text(encoding="utf-8")
    again = Session(str(path), tmp_path / "chosen")
    assert again.design == session.design
    assert np.array_equal(again.numbers().values, session.numbers().values)
    assert list((tmp_path / "chosen").iterdir()) == [path]


def test_a_design_that_was_not_moved_is_saved_as_it_was(session, small):
    session.set("contact_angle", 50.0)
    session.undo()
    path = session.save("same.toml")
    with open(small, encoding="utf-8") as file:
        assert path.read_text(encoding="utf-8") == file.read()


def test_an_existing_file_is_replaced_only_if_asked(session):
    path = session.save("mine.toml")
    before = path.read_text(encoding="utf-8")
    session.set("contact_angle", 50.0)
    with pytest.raises(prsm.PrsmError, match=r"mine\.toml: exists already"):
        session.save("mine.toml")
    assert path.read_text(encoding="utf-8") == before
    session.save("mine.toml", replace=True)
    assert path.read_text(encoding="utf-8") != before


def test_two_designs_are_compared(session):
    session.keep(session.numbers())
    first = session.design
    session.set("contact_angle", 50.0)
    assert session.kept is not None
    assert session.kept.design == first
    session.back_to_kept()
    assert session.design == first
    session.undo()
    assert session.design["contact_angle"] == pytest.approx(50 * _DEGREE)
    session.forget()
    with pytest.raises(prsm.PrsmError, match="no design is kept"):
        session.back_to_kept()
