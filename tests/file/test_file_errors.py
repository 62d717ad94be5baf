"""Whatever is wrong with a file: one FileError, one line, with place, value and remedy."""

import re
import subprocess
import sys

import pytest

import prsm_jax.file as file
from prsm_jax._errors import FileError, MissingExtraError, UnknownNameError
from prsm_jax.mechanism import get_parameter
from tests.present import present

ACTUATOR = file.example_text("actuator")

#: What is replaced in the actuator's text, by what, and what the error says after the file name.
CASES = [
    ('lead = "10 mm"', 'lead = "10 kg"',
     r'\[\[stage\]\] 1 thread: lead = "10 kg": wrong unit: a mass where a length is expected; give '
     r'a string with a unit such as "10 mm", or a bare number in m'),
    ('lead = "10 mm"', 'leed = "10 mm"',
     r'\[\[stage\]\] 1 thread: leed = "10 mm": unknown key; did you mean lead\?'),
    ('lead = "10 mm"', "", r"\[\[stage\]\] 1 thread: lead: is missing; give the lead of screw"),
    ('lead = "10 mm"', 'lead = "-10 mm"', r'lead = "-10 mm": must be more than 0'),
    ('lead = "10 mm"', "lead = 0", "lead = 0: must be more than 0"),
    ('lead = "10 mm"', "lead = true", "lead = true: not a number"),
    ('lead = "10 mm"', "lead = [1, 2]", "lead = an array: not a number"),
    ('lead = "10 mm"', "lead = {x = 1}", r"\[\[stage\]\] 1 thread.lead: not a number"),
    ('lead = "10 mm"', "lead = nan", "lead = nan: not a finite number"),
    ('lead = "10 mm"', "lead = -inf", "lead = -inf: not a finite number"),
    ('lead = "10 mm"', "lead = 1" + "0" * 400, "a very large integer: not a finite number"),
    ('lead = "10 mm"', "lead = 0x1" + "0" * 9000, "a very large integer: not a finite number"),
    ('lead = "10 mm"', "lead = 1" + "0" * 9000, "is not valid TOML"),
    ('lead = "10 mm"', "lead = 1e999", "not a finite number"),
    ('lead = "10 mm"', 'lead = "9e999 mm"', "not a finite number"),
    ('lead = "10 mm"', "lead = 1979-05-27", "lead = 1979-05-27: not a number"),
    ('lead = "10 mm"', 'lead = "10"', "a plain number where a length is expected"),
    ('lead = "10 mm"', 'lead = "10 furlong"', "there is no unit 'furlong' here; give"),
    ('lead = "10 mm"', 'lead = "9**9**9**9 mm"', "cannot read the unit"),
    ("starts = 5", "starts = 2", r"starts = 2: must be more than 2"),
    ('roller_radius = "4 mm"', "roller_radius = 0", "roller_radius = 0: must be more than 0"),
    ('contact_angle = "45 deg"', 'contact_angle = "90 deg"', "between 0 and 90 deg"),
    ('contact_angle = "45 deg"', 'contact_angle = "0 deg"', "between 0 and 90 deg"),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "between -1 and 0.5"),
    ("poisson_ratio = 0.3", "poisson_ratio = -1", "between -1 and 0.5"),
    ('density = "7850 kg/m^3"', 'density = "-7850 kg/m^3"', "must be more than 0"),
    ('torsional_stiffness = "100 N/um"', "torsional_stiffness = -1",
     r"\[\[stage\]\] 1 nut.support: torsional_stiffness = -1: must be 0 or more"),
    ("loss_factor = 0.01", "loss_factor = 1.5", "from 0 to 1"),
    ("roller_count = 10", "roller_count = 0", "must be a whole number from 1 to 1000"),
    ("roller_count = 10", "roller_count = 10.0", "must be a whole number from 1 to 1000"),
    ("roller_count = 10", "roller_count = true", "must be a whole number"),
    ("roller_count = 10", "roller_count = 999999999999", "must be a whole number"),
    ('curvature = "exact"', 'curvature = "exakt"', 'choose one of "exact", "lisowski2014"'),
    ('bore_radius = "4 mm"', 'bore_radius = "12 mm"',
     r'\[\[stage\]\] 1 screw: bore_radius = "12 mm": must be less than the screw\'s nominal '
     r"radius, 12 mm"),
    ('radial_width = "6 mm"', 'radial_width = "32 mm"', "must be less than twice the radius"),
    ('law = "coulomb"', 'law = "columb"',
     r'\[\[stage\]\] 1 friction.thread: law = "columb": choose one of "coulomb", "lugre"'),
    ('law = "coulomb"', "", 'friction.thread: law: is missing; choose one of "coulomb"'),
    ("[stage.friction.thread]", "[stage.friction.thread]\nx = 1",
     r"friction.thread: x = 1: unknown key; known: coefficient"),
    ("[stage.friction.drag]", "[stage.friction.spline]\nradius = 1\ncoefficient = 0.1\n"
     "[stage.friction.drag]", "stage 1 has friction.spline"),
    ("[stage.thread]", "[stage.threads]", r"1 threads: unknown key; did you mean thread\?"),
    ("[stage.screw.support]", "[stage.screw.suport]", "screw.suport: unknown key; did you mean"),
    ("[[stage]]", "[stage]", r"\[stage\]: must be tables, each under a header in double brackets"),
    ('title = "', 'titel = "', r"titel = .*: unknown key; did you mean title\?"),
    ('title = "Electromechanical actuator"', "title = 3", "title = 3: must be a string"),
    ('speed = "1500 rpm"', 'speed = "25 Hz"', r"\[operating_point\]: speed = .* a frequency"),
    ('duration = "10 s"', 'duration = "-10 s"', r"\[\[duty_cycle\]\] 1: duration = .*more than 0"),
    ('duration = "10 s"', "", r"\[\[duty_cycle\]\] 1: duration: is missing; give the length"),
    ('maximise = "efficiency"', "", r"\[optimise\]: needs one of maximise, minimise and"),
    ('maximise = "efficiency"', 'maximise = "a"\nminimise = "b"', "found maximise and minimise"),
    ('maximise = "efficiency"', "maximise = 3", "maximise = 3: must be a name"),
    ('maximise = "efficiency"', 'maximise = "two words"', "must be a name of letters"),
    ("starts = 4", "starts = 0", r"\[optimise\]: starts = 0: must be a whole number from 1"),
    ('name = "lead"', 'name = "leed"',
     r"1: name = \"leed\": unknown parameter 'leed'; did you mean"),
    ('name = "lead"', 'name = "support"', "unknown parameter 'support'"),
    ('name = "lead"', 'name = "length"', "parameter 'length' is ambiguous"),
    ('name = "lead"', 'name = "roller_count"', "a whole number cannot be varied"),
    ('name = "lead"', 'name = "contact_angle"', "wrong unit: a length where an angle is expected"),
    ('name = "contact_angle"', 'name = "lead"', "moves the same number as 'lead'"),
    ('lower = "5 mm"', 'lower = "5 deg"',
     r"\[\[optimise.variable\]\] 1: lower = .* an angle where"),
    ('lower = "5 mm"', 'lower = "25 mm"', "must be below upper"),
    ('lower = "5 mm"', 'lower = "-5 mm"', "must be more than 0"),
    ('upper = "2.1 GPa"', "",
     r"\[\[optimise.constraint\]\] 1: .* no limit; give lower, upper or equal"),
    ('upper = "2.1 GPa"', "upper = 1\nequal = 1", "has equal and a bound"),
    ('upper = "2.1 GPa"', 'upper = "3 quux"', "there is no unit 'quux' here"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), CASES)
def test_one_line_says_what_is_wrong(old, new, message):
    assert old in ACTUATOR
    with pytest.raises(FileError) as caught:
        file.loads(ACTUATOR.replace(old, new, 1), name="my.toml")
    line = str(caught.value)
    assert line.startswith("my.toml: ")
    assert line.isprintable()
    assert len(line) < 1000
    assert re.search(message, line), line


def test_the_second_stage_is_named():
    text = file.example_text("li2020_two_stage").replace('"12.25 mm"', '"12.25 s"')
    with pytest.raises(FileError, match=r"\[\[stage\]\] 2 friction.spline: radius = "):
        file.loads(text)


def test_several_problems_share_the_line():
    text = ACTUATOR.replace("lead =", "leed =", 1).replace("loss_factor", "loss")
    with pytest.raises(FileError, match=r"leed.*; \[\[stage\]\] 1 friction.rolling_hysteresis"):
        file.loads(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "stage: is missing"),
        ("stage = []", "stage = an array: is empty"),
        ("stage = [1]", "must be tables"),
        ("[[stage]]", r"\[\[stage\]\] 1: thread: is missing"),
        ("x = " + "[" * 100_000, "nested too deeply"),
        ("x = " + "{a=" * 100_000, "nested too deeply"),
        (".".join("a" * 90) + " = 1", "unknown key"),
        (".".join("a" * 100_000) + " = 1", "more than 100 dots"),
        ("x = 1e", "not valid TOML"),
        ("\ud800", "not text"),
        ('"a\\nb\\u0000" = 1', "a b = 1: unknown key"),
        ("a" * 500 + " = 1", "unknown key"),
        ("#" * 1_000_001, "larger than"),
    ],
)
def test_texts_that_are_no_mechanism(text, message):
    with pytest.raises(FileError, match=message) as caught:
        file.loads(text)
    assert str(caught.value).isprintable()


def test_files_that_cannot_be_read(tmp_path):
    latin = tmp_path / "latin.toml"
    latin.write_bytes("title = 'é'".encode("latin-1"))
    large = tmp_path / "large.toml"
    large.write_bytes(b"#" * 1_000_001)
    for source, message in (
        (latin, "is not UTF-8 text"),
        (large, "is larger than"),
        (tmp_path, "is a folder"),
        (tmp_path / "absent.toml", "there is no such file"),
        ("wu2021", "did you mean wu2022"),
        ("nofile", "nor an example of that name; known: actuator, "),
        ("\0", "there is no such file"),
        ("a" * 10_000, "too long"),
        ("/dev/zero", "there is no such file"),
    ):
        with pytest.raises(FileError, match=message):
            file.load(source)


def test_a_byte_order_mark_is_no_text(tmp_path, identical):
    """Editors of Windows put one first; of UTF-16, the line says what to do."""
    text = file.example_text("wu2022")
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert identical(file.load(path), file.load("wu2022"))
    assert identical(file.loads("\ufeff" + text), file.load("wu2022"))
    path.write_bytes(text.encode("utf-16"))
    with pytest.raises(FileError, match="is not UTF-8 text"):
        file.load(path)


def test_unknown_example():
    with pytest.raises(FileError, match="did you mean wu2022"):
        file.example_text("wu2021")


def test_settings_set():
    mechanism = file.load("actuator")
    moved = file.apply_settings(
        mechanism,
        ["lead=12 mm", "roller_count=9", "stage.1.screw.bore_radius = 0.005", "speed=1 rad/s"],
    )
    stage = moved.stages[0]
    assert float(stage.thread.lead) == 0.012
    assert stage.roller_count == 9
    assert float(present(stage.screw.bore_radius)) == 0.005
    assert float(moved.operating_point.speed) == 1.0
    assert float(file.apply_settings(mechanism, ["pitch=1 mm"]).stages[0].thread.lead) == 0.005
    assert file.apply_settings(mechanism, []) is mechanism


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("lead=3 kg", "--set lead=3 kg: wrong unit: a mass where a length is expected"),
        ("leed=3 mm", "--set leed=3 mm: unknown parameter 'leed'"),
        ("length=3 mm", "ambiguous"),
        ("lead", "must be KEY=VALUE"),
        ("lead=", "must be KEY=VALUE"),
        ("=3", "must be KEY=VALUE"),
        ("lead=nan", "not a number"),
        ("lead=-3 mm", "must be more than 0"),
        ("contact_angle=91 deg", "between 0 and 90 deg"),
        ("roller_count=1.5", "must be a whole number"),
        ("roller_count=0", "must be a whole number"),
        ("screw.bore_radius=15 mm", "after --set .*bore_radius must be less than"),
    ],
)
def test_settings_refused(setting, message):
    with pytest.raises(FileError, match=message) as caught:
        file.apply_settings(file.load("actuator"), [setting])
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("length", "first give length in [stage.screw] or [stage.roller] or [stage.nut] or "),
        ("stage.1.screw.length", "first give length in [stage.screw]"),
        ("motor.inertia", "first give inertia in [axis.motor]"),
        ("loss_factor",
         "first give loss_factor in [stage.friction.rolling_hysteresis] or [stage.damping]"),
        ("leed", "did you mean "),
        ("qqqq", "known: coefficient, "),
    ],
)  # fmt: skip
def test_a_number_that_the_mechanism_does_not_have(name, hint):
    with pytest.raises(UnknownNameError) as caught:
        get_parameter(file.load("wu2022"), name)
    assert hint in str(caught.value)


@pytest.mark.parametrize(
    ("name", "text"),
    [("screw.length", "'0.3 m'"), ("required_life", "'2 h'"), ("play.axial_backlash", "0.0")],
)
def test_the_table_that_a_hint_names_gives_the_number(tmp_path, name, text):
    with pytest.raises(UnknownNameError) as caught:
        get_parameter(file.load("wu2022"), name)
    hint = re.fullmatch(r".*; first give (\w+) in (\[[\w.]+\])", str(caught.value))
    key, table = present(hint).groups()
    written = file.example_text("wu2022")
    written = written if f"{table}\n" in written else f"{written}\n{table}\n"
    path = tmp_path / "one.toml"
    path.write_text(written.replace(f"{table}\n", f"{table}\n{key} = {text}\n"))
    value = float(get_parameter(file.load(str(path)), name))
    assert value == {"'0.3 m'": 0.3, "'2 h'": 7200.0, "0.0": 0.0}[text]


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        ("lead=12 mm", "lead=10 mm", "sets the same number as --set {}; leave one of them out"),
        ("lead=12 mm", "stage.1.thread.lead=11 mm", "sets the same number as --set {}; leave one"),
        ("roller_count=9", "roller_count=8", "sets the same number as --set {}; leave one of"),
        ("curvature=exact", "curvature=wu2022", "sets the same number as --set {}; leave one of"),
        # Names of one number: the lead is starts times pitch, and 90 deg is the sum of the angles.
        (
            "thread.lead=12mm",
            "pitch=3mm",
            "changes thread.lead again, which --set {} sets; leave one of them out",
        ),
        (
            "pitch=3mm",
            "lead=12 mm",
            "changes pitch again, which --set {} sets; leave one of them out",
        ),
        (
            "contact_angle=40 deg",
            "flank_angle=45 deg",
            "changes contact_angle again, which --set {} sets; leave one of them out",
        ),
        # One of the two orders is no contradiction.
        (
            "pitch=3 mm",
            "starts=6",
            "changes pitch again, which --set {} sets; leave one of them out, or write that one "
            "after this one",
        ),
        (
            "gear_module=0.6 mm",
            "roller_teeth=20",
            "changes gear_module again, which --set {} sets; leave one of them out, or write that "
            "one after this one",
        ),
    ],
)
def test_settings_that_contradict_each_other_are_refused(first, second, message):
    with pytest.raises(FileError) as caught:
        file.apply_settings(file.load("actuator"), ["speed=1 rpm", first, second])
    assert str(caught.value).startswith(f"--set {second}: {message.format(first)}")
    if message.endswith("out"):
        assert str(caught.value).endswith("leave one of them out")


def test_settings_that_agree_are_accepted():
    actuator = file.load("actuator")
    # 5 starts of 2.4 mm, and 6 of 3 mm.
    for settings, lead in (
        (["lead=12 mm", "pitch=2.4 mm"], 12e-3),
        (["starts=6", "pitch=3 mm"], 18e-3),
        (["lead=11 mm", "lead=11mm", "stage.1.thread.lead=0.011"], 11e-3),
    ):
        moved = file.apply_settings(actuator, settings).stages[0].thread
        assert float(moved.lead) == pytest.approx(lead, rel=1e-12)
    two = file.load("li2020_two_stage")
    both = file.apply_settings(two, ["stage.1.lead=11 mm", "stage.2.lead=9 mm"])
    assert [float(stage.thread.lead) for stage in both.stages] == [11e-3, 9e-3]
    with pytest.raises(FileError) as caught:
        file.apply_settings(two, ["lead=11 mm", "stage.2.lead=9 mm"])
    assert str(caught.value) == (
        "--set stage.2.lead=9 mm: sets the same number as --set lead=11 mm; name the number of a "
        "stage in each"
    )


@pytest.mark.parametrize(
    ("setting", "distance", "length"),
    [("nut_distance=1200 mm", "1.2 m", "180 mm"), ("screw.length=40 mm", "0.11 m", "40 mm")],
)
def test_a_nut_beyond_its_screw_is_refused(setting, distance, length):
    mechanism = file.load("humanoid_leg")
    with pytest.raises(FileError) as caught:
        file.apply_settings(mechanism, [setting])
    assert str(caught.value) == (
        f"after --set {setting}: axis.shaft.nut_distance is {distance}; it must be less than the "
        f"screw's length (stage.screw.length), {length}"
    )
    # Both are checked when all are set.
    file.apply_settings(mechanism, ["nut_distance=1200 mm", "screw.length=1300 mm"])


def test_settings_are_checked_together_at_the_end():
    moved = file.apply_settings(
        file.load("actuator"), ["screw.bore_radius=14 mm", "roller_radius=6 mm"]
    )
    assert float(present(moved.stages[0].screw.bore_radius)) == 0.014


def test_importing_is_light_and_a_missing_extra_is_named():
    code = """
import sys
import prsm_jax.file as file
from prsm_jax.mechanism import Mechanism, Stage, Thread
one = Mechanism((Stage(Thread(5e-3, 5, 2e-3, 0.8), 5),))
heavy = {"pint", "tomlkit"} & set(sys.modules)
assert not heavy, heavy
sys.modules["pint"] = None
for call in (lambda: file.load("wu2022"), lambda: file.dumps(one)):
    try:
        call()
    except file._read.missing_extra("", "", ImportError()).__class__ as error:
        assert "prsm-jax[file]" in str(error) and "pint" in str(error), error
    else:
        raise AssertionError("no error")
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)
    assert issubclass(MissingExtraError, ImportError)
