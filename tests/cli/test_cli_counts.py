"""Counts and shares out of range, before anything is read, and unknown numbers: one line each."""

import pytest

_FRONT = ("--maximise", "efficiency", "--minimise", "mass")
_AXIS = ("--axis", "lead=5 mm:6 mm", "--plan", "sobol")
#: Every option of a verb that is a count, with the numbers next to its range.
_COUNTS = {
    ("study", "--points"): (1, 1_000_001),
    ("study", "--front-points"): (2, 1001),
    ("study", "--starts"): (0, 10_001),
    ("pareto", "--points", *_FRONT): (2, 1001),
    ("pareto", "--starts", *_FRONT): (0, 10_001),
    ("optimise", "--starts"): (0, 10_001),
    ("simulate", "--samples"): (1, 1_000_001),
    ("simulate", "--max-steps"): (0, 2**31),
    ("response", "--points"): (1, 1_000_001),
    ("response", "--stage"): (0, None),
    ("campbell", "--harmonics"): (0, 1001),
    ("campbell", "--stage"): (0, None),
    ("modal", "--points"): (2, 1_000_001),
    ("modal", "--stage"): (0, None),
    ("sweep", "--points", *_AXIS): (0, 100_000_001),
    ("sweep", "--chunk", *_AXIS): (0, 100_000_001),
    ("sweep", "--seed", *_AXIS): (-1, None),
    ("tolerance", "--samples"): (15, 100_000_001),
    ("tolerance", "--seed"): (-1, None),
    ("studio", "--port"): (-1, 65_536),
}
_CASES = [
    (verb, option, tuple(others), value)
    for (verb, option, *others), beside in _COUNTS.items()
    for value in {beside[0], -1, beside[1] or -7, 10**30 if beside[1] else -(10**30)}
]


@pytest.mark.parametrize(("verb", "option", "others", "value"), _CASES)
def test_a_count_out_of_range_is_refused_at_once(prsm, tmp_path, verb, option, others, value):
    """Before the file is read: there is none of this name."""
    status, out, err = prsm(verb, "absent.toml", *others, option, value)
    assert (status, out) == (2, "")
    assert err.startswith(f"prsm: {option} {value}: must be a whole number ")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("verb", "option", "others"),
    # The studio imports much before it reads a file.
    [(verb, option, others) for verb, option, *others in _COUNTS if verb != "studio"],
)
def test_the_next_number_is_allowed(prsm, verb, option, others):
    """Then the file is read, and that there is none is said."""
    least, most = _COUNTS[verb, option, *others]
    for value in (least + 1, *(() if most is None else (most - 1,))):
        status, _, err = prsm(verb, "absent.toml", *others, option, value)
        assert (status, "absent.toml" in err) == (2, True), err


@pytest.mark.parametrize("value", ["2.5", "nan", "inf", "many"])
def test_what_is_not_a_whole_number_is_refused(prsm, value):
    """The parser would round 2.5, without notice."""
    status, _, err = prsm("simulate", "absent.toml", "--samples", value)
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith(f"prsm: --samples {value}: must be a whole number from 2 to 1000000")


def test_a_whole_number_may_be_written_as_a_decimal_one(prsm):
    for value in ("1e3", "100.0"):
        status, _, err = prsm("simulate", "absent.toml", "--samples", value)
        assert (status, "absent.toml" in err) == (2, True), err


@pytest.mark.parametrize("value", ["1.5", "0", "1", "-0.5", "nan"])
def test_a_share_out_of_range_names_its_option(prsm, tmp_path, value):
    status, out, err = prsm("tolerance", "absent.toml", f"--wanted-yield={value}")
    assert (status, out) == (2, "")
    assert err.startswith("prsm: --wanted-yield ")
    assert err.endswith(": must be between 0 and 1, such as 0.99\n")
    status, _, err = prsm("tolerance", "absent.toml", "--wanted-yield", "0.5")
    assert (status, "absent.toml" in err) == (2, True), err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("sweep", "actuator", "--axis", "lead=5 mm,6 mm", "--gradients", "efficiency"),
            "--gradients: unknown parameter 'efficiency'; did you mean ",
        ),
        (
            ("sweep", "actuator", "--axis", "lead=5 mm,6 mm", "--gradients", "lead,roller_count"),
            "--gradients: roller_count is a whole number, which has no derivative\n",
        ),
        (
            ("sensitivity", "actuator", "--parameters", "lead,leed"),
            "--parameters: unknown parameter 'leed'; did you mean ",
        ),
        (
            ("calibrate", "wu2022", "--data", "wu2022_torque", "--parameters", "leed"),
            "--parameters: unknown parameter 'leed'; did you mean ",
        ),
    ],
)
def test_an_unknown_number_names_its_option(prsm, words, message):
    status, out, err = prsm(*words)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"prsm: {message}")


def test_the_range_of_a_driver_has_its_smaller_end_first(prsm):
    status, out, err = prsm("study", "lisowski2014", "--driver", "lead=0.5 in: 8 mm")
    assert (status, out) == (2, "")
    assert err == (
        "prsm: --driver lead=0.5 in: 8 mm: the smaller end comes first; write 'lead=8 mm:0.5 in'\n"
    )
