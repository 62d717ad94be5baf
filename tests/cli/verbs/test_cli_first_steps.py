"""The first hour on the command line: help, completion, doctor, and the questions of new."""

import importlib.metadata
import json
import shlex
import subprocess

import jax
import pytest

from prsm_jax.cli import main
from prsm_jax.cli._app import EXAMPLES
from prsm_jax.cli._verbs import app
from prsm_jax.cli.verbs.first_steps import _doctor, _installed, _new, _questions
from prsm_jax.dimensioning import Dimensioning, Requirements

_VERBS = sorted(name for name in app if not name.startswith("-"))


@pytest.fixture(autouse=True)
def _place(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    monkeypatch.setenv("COLUMNS", "80")


def test_every_verb_has_an_example():
    assert set(_VERBS) <= set(EXAMPLES)


@pytest.mark.parametrize("verb", _VERBS)
def test_the_help_of_a_verb_fits_80_columns_and_ends_with_an_example_that_is_valid(verb, capsys):
    assert main([verb, "--help"]) == 0
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    assert max(map(len, lines)) <= 80
    text = " ".join(" ".join(lines[-2:]).split())
    command = EXAMPLES[verb]
    assert text.endswith(f"Example: {command}")
    words = shlex.split(command)
    assert words[:2] == ["prsm", verb]
    # The words are read as the command line would read them; nothing runs.
    found, bound, _ = app.parse_args(words[1:], exit_on_error=False, print_error=False)
    assert found.__name__ == verb.replace("-", "_")
    # Its first word is an argument of its own, or an option.
    assert words[2].startswith("--") or words[2] in str([*bound.arguments.values()])
    assert bound.arguments


def test_a_wrong_example_would_be_found():
    from cyclopts import CycloptsError

    with pytest.raises(CycloptsError):
        app.parse_args(["check", "a", "--sett", "b"], exit_on_error=False, print_error=False)


def test_help_of_all_verbs_fits_80_columns(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 80
    assert all(f" {verb} " in text for verb in _VERBS)
    assert "--install-completion" in text


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_completes_verbs_and_options(shell, tmp_path):
    path = app.install_completion(shell=shell, output=tmp_path / "script", add_to_startup=False)
    text = path.read_text(encoding="utf-8")
    assert all(verb in text for verb in _VERBS)
    # In fish, `-l` is an option's long name.
    assert ("-l envelope" if shell == "fish" else "--envelope") in text
    if shell == "bash":
        subprocess.run(["bash", "-n", str(path)], check=True, timeout=30)


def test_examples_are_listed_with_what_they_are(capsys):
    assert main(["example"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if "wu2022" in line]
    assert rows[0].split(maxsplit=1) == ["wu2022", "Wu et al. 2022, single stage"]
    assert main(["example", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found["titles"]) == found["examples"]
    assert found["titles"]["actuator"] == "Electromechanical actuator"


def _doctor_says(capsys) -> tuple[int, dict]:
    status = main(["doctor", "--json", "-"])
    return status, json.loads(capsys.readouterr().out)


def test_doctor_sees_precision_and_devices(capsys):
    status, found = _doctor_says(capsys)
    assert (status, found["ok"], found["problems"]) == (0, True, [])
    assert found["precision"] == "float64"
    assert found["backend"] == jax.default_backend()
    assert found["devices"][0] == {
        "platform": jax.devices()[0].platform,
        "kind": jax.devices()[0].device_kind,
    }
    assert found["cache"] == {"folder": None, "files": 0, "size_bytes": 0}


def test_doctor_finds_single_precision(capsys):
    jax.config.update("jax_enable_x64", False)
    try:
        status, found = _doctor_says(capsys)
    finally:
        jax.config.update("jax_enable_x64", True)
    assert (status, found["ok"], found["precision"]) == (1, False, "float32")
    assert "single precision" in found["problems"][0]


def test_programs_that_cannot_be_kept_are_a_note(capsys, monkeypatch, tmp_path):
    """All verbs work without them."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("PRSM_JAX_CACHE", str(tmp_path / "file" / "cache"))
    before = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    jax.config.update("jax_compilation_cache_dir", None)
    try:
        status, found = _doctor_says(capsys)
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    assert (status, found["ok"], found["problems"]) == (0, True, [])
    assert found["cache"]["folder"] is None
    assert any("compiled programs are not kept" in note for note in found["notes"])


def test_doctor_finds_a_device_that_does_not_compute(capsys, monkeypatch):
    def fail():
        raise RuntimeError("no device\nat all")

    monkeypatch.setattr(jax, "devices", fail)
    status, found = _doctor_says(capsys)
    assert status == 1
    assert found["devices"] == []
    assert "JAX cannot compute: RuntimeError: no device" in found["problems"][0]


@pytest.fixture
def installed(monkeypatch):
    """`installed(versions, requirements)` replaces what is known of packages."""

    def replace(versions, requirements):
        def version(name):
            if name not in versions:
                raise importlib.metadata.PackageNotFoundError(name)
            return versions[name]

        monkeypatch.setattr(_installed.importlib.metadata, "version", version)
        monkeypatch.setattr(_installed.importlib.metadata, "requires", lambda _: requirements)

    return replace


_REQUIRED = [
    "jax>=0.7",
    "numpy>=2",
    "pint>=0.24 ; extra == 'file'",
    "rich>=13 ; extra == 'cli'",
    "prsm-jax[file] ; extra == 'cli'",
    "h5py>=3 ; extra == 'export'",
    "old ; python_version < '3'",
]


def test_doctor_names_what_is_missing_and_what_installs_it(installed, capsys):
    installed({"jax": "0.6.9", "numpy": "2.1", "rich": "13.0"}, _REQUIRED)
    status, found = _doctor_says(capsys)
    assert status == 1
    assert found["packages"]["jax"] == "0.6.9"
    assert found["packages"]["pint"] is None
    assert "old" not in found["packages"]
    rows = {one["extra"]: one for one in found["extras"]}
    # Of an extra within an extra as well.
    assert rows["cli"]["missing"] == rows["file"]["missing"] == ["pint"]
    assert rows["export"] == {
        "extra": "export",
        "missing": ["h5py"],
        "command": "pip install 'prsm-jax[export]'",
    }
    assert found["problems"] == [
        "jax: version 0.6.9 (>=0.7 is needed); pip install --upgrade 'prsm-jax'",
        "pint: missing (>=0.24 is needed); pip install --upgrade 'prsm-jax[cli]'",
    ]


def test_a_missing_extra_is_no_fault(installed, capsys):
    versions = {"jax": "0.9", "numpy": "2.1", "rich": "13.0", "pint": "0.25"}
    installed(versions, _REQUIRED)
    status, found = _doctor_says(capsys)
    assert (status, found["ok"]) == (0, True)
    assert main(["doctor"]) == 0
    assert "pip install 'prsm-jax[export]'" in capsys.readouterr().out


def test_doctor_without_metadata_says_how_to_install(monkeypatch, capsys):
    def missing(_):
        raise importlib.metadata.PackageNotFoundError("prsm-jax")

    monkeypatch.setattr(_doctor, "extras", lambda: missing(""))
    status, found = _doctor_says(capsys)
    assert status == 1
    assert "pip install -e" in found["problems"][0]


def test_doctor_names_a_card_that_is_not_used(monkeypatch, capsys):
    monkeypatch.setattr(_doctor.shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(jax, "devices", lambda: [jax.local_devices(backend="cpu")[0]])
    status, found = _doctor_says(capsys)
    assert status == 0
    assert "NVIDIA card" in found["notes"][0]


_OPTIONS = {"load": "10 kN", "stroke": "300 mm", "speed": "0.1 m/s", "life": "5000 h"}
_OPTIONS["envelope"] = "80 mm"


def _words(**changes) -> list[str]:
    given = {**_OPTIONS, **changes}
    return [
        word for name, text in given.items() if text is not None for word in (f"--{name}", text)
    ]


@pytest.fixture
def asked(monkeypatch):
    """What `new` would look for."""
    seen = []

    def dimension(**wanted):
        seen.append(wanted)
        return Dimensioning(Requirements(**wanted), None, None, {}, {}, 90)

    monkeypatch.setattr(_new, "dimension", dimension)
    return seen


class _Terminal:
    """A person who types these lines."""

    def __init__(self, *lines):
        self.lines = list(lines)

    def isatty(self):
        return True

    def readline(self):
        return f"{self.lines.pop(0)}\n" if self.lines else ""


def test_new_asks_for_what_is_not_given_until_it_can_be_read(asked, monkeypatch, capsys):
    typed = ("10 kN", "300", "300 mm", "0 mm/s", "100 mm/s", "500 km", "80 mm")
    monkeypatch.setattr(_questions.sys, "stdin", _Terminal(*typed))
    assert main(["new"]) == 1
    # 500 km at 0.1 m/s take 5e6 s.
    expected = {"load": 1e4, "stroke": 0.3, "speed": 0.1, "life": 5e6, "envelope": 0.08}
    assert asked == [pytest.approx(expected, rel=1e-12)]
    words = capsys.readouterr().err
    assert words.count("Axial load on the nut (such as 10 kN): ") == 1
    assert words.count("Largest speed of the nut (such as 100 mm/s): ") == 2
    assert "a plain number where a length is expected; give it with its unit, such as 300" in words
    assert "bare number" not in words
    assert "must be above 0 and finite" in words


def test_answers_are_read_with_their_units(asked, monkeypatch, capsys):
    answers = _Terminal("500 km", "eighty", "80,5 mm", "80 mm")
    monkeypatch.setattr(_questions.sys, "stdin", answers)
    assert main(["new", *_words(life=None, envelope=None)]) == 1
    (found,) = asked
    expected = {"load": 1e4, "stroke": 0.3, "speed": 0.1, "life": 5e5 / 0.1, "envelope": 0.08}
    assert found == pytest.approx(expected, rel=1e-12)
    words = capsys.readouterr().err
    assert "Diameter of the bore for the nut (such as 80 mm): " in words
    assert "not a number with a unit" in words
    assert "decimal comma; write 80.5 mm\n" in words


def test_a_travel_is_given_before_the_speed_is_asked_for(asked, monkeypatch, capsys):
    monkeypatch.setattr(_questions.sys, "stdin", _Terminal("0.2 m/s"))
    assert main(["new", *_words(speed=None, life="500 km")]) == 1
    (found,) = asked
    assert (found["speed"], found["life"]) == pytest.approx((0.2, 500e3 / 0.2), rel=1e-12)
    assert "wrong unit" not in capsys.readouterr().err


def test_a_travel_without_a_speed_names_the_speed(asked, capsys):
    assert main(["new", *_words(speed=None, life="500 km")]) == 2
    words = capsys.readouterr().err
    assert "give --speed '100 mm/s'; or" in " ".join(words.split())
    # A life that is neither time nor travel is refused before a question.
    assert main(["new", *_words(speed=None, life="5 kN")]) == 2
    assert "--life 5 kN: wrong unit" in capsys.readouterr().err
    assert not asked


def test_new_without_a_terminal_names_the_options(asked, capsys):
    assert main(["new", *_words(life=None, envelope=None)]) == 2
    words = capsys.readouterr().err
    assert "give --life '5000 h', --envelope '80 mm'" in words
    assert not asked


def test_new_ends_with_the_answers(asked, monkeypatch, capsys):
    monkeypatch.setattr(_questions.sys, "stdin", _Terminal())
    assert main(["new", *_words(load=None)]) == 2
    assert "no answer for load; give --load" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("load", "10 kg", "--load 10 kg: wrong unit"),
        ("stroke", "-3 mm", "--stroke -3 mm: must be above 0"),
        ("life", "5 kN", "--life 5 kN: wrong unit"),
        ("speed", "nan", "--speed nan: "),
        ("envelope", "", "--envelope : "),
    ],
)
def test_an_option_that_cannot_be_used_is_named(asked, capsys, name, text, words):
    assert main(["new", *(f"--{k}={v}" for k, v in {**_OPTIONS, name: text}.items())]) == 2
    assert words in capsys.readouterr().err
    assert not asked


def test_new_replaces_a_file_only_by_force(asked, tmp_path, capsys):
    path = tmp_path / "my_screw.toml"
    path.write_text("mine")
    assert main(["new", *_words()]) == 2
    assert "exists already; give another name, or --force" in capsys.readouterr().err
    assert path.read_text() == "mine"
    assert not asked
    # Without a size that fits, it stays.
    assert main(["new", *_words(), "--force"]) == 1
    assert path.read_text() == "mine"
    assert main(["new", "absent/x.toml", *_words()]) == 2
    assert "there is no folder" in capsys.readouterr().err
    assert main(["new", ".", *_words()]) == 2
    assert "is a folder" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--load", "--stroke", "--speed", "--life", "--envelope"])
def test_a_negative_value_is_a_value_and_not_an_option(option, capsys):
    """With a space as with an equals sign; that it must be above 0 is said."""
    messages = []
    for words in ([option, "-5 kN"], [f"{option}=-5 kN"]):
        assert main(["new", "screw.toml", *words]) == 2
        messages.append(capsys.readouterr().err)
    assert messages[0] == messages[1]
    assert messages[0].startswith(f"prsm: {option} -5 kN: ")


@pytest.mark.parametrize(
    ("words", "option", "value"),
    [
        (["steady", "actuator", "--set", "-lead=5 mm"], "--set", "-lead=5 mm"),
        (["study", "actuator", "--driver", "-lead"], "--driver", "-lead"),
    ],
)
def test_where_a_value_cannot_begin_with_a_minus_the_remedy_is_said(words, option, value, capsys):
    assert main(words) == 2
    assert capsys.readouterr().err == (
        f"prsm: {option} {value}: a value that begins with a minus is taken for an option; write "
        f"{option}='{value}'\n"
    )
