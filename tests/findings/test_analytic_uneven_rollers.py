"""The finding on errors of parts: its numbers from balances of files without the errors."""

import functools
import re
from typing import Any

import equinox as eqx
import numpy as np
import pytest
from scenes import array

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.findings import margins_of
from prsm_jax.load_sharing import stage_load_distribution, without_each_error

_NAME = "actuator_part_errors"
_PREFIX = "stage.load_sharing.part_errors."
#: Errors of the example in its own units, written here again.
_AMOUNTS = {
    "nut_eccentricity": "5 µm",
    "screw_eccentricity": "4 µm",
    "nut_tilt": "0.05 mrad",
    "screw_tilt": "0.02 mrad",
    "roller_diameter_deviation": "-1 to 1 µm",
    "radial_load": "300 N",
    "overturning_moment": "12 N·m",
}
#: Lines that a file without errors and loads across the axis lacks; its nut is as elastic.
_NONE = ("[stage.load_sharing.part_errors]", *_AMOUNTS)


def _file(drop=(), **changed):
    """The example without the lines of some errors, or with other amounts."""
    lines = file.example_text(_NAME).splitlines()
    kept = [one for one in lines if not any(one.startswith(name) for name in drop)]
    kept = [
        f"{name} = {changed[name]}" if (name := one.split(" ")[0]) in changed else one
        for one in kept
    ]
    return file.loads("\n".join(kept))


@functools.cache
def _largest(drop=()):
    """Largest over mean load of a roller, and largest load of a thread [N], of a file."""
    stage: Any = _file(drop).stages[0]
    found = eqx.filter_jit(stage_load_distribution)(stage, array(12e3))
    assert bool(found.converged)
    rollers = np.asarray(found.nut.forward).sum(axis=-1)
    threads = max(np.max(found.nut.forward), np.max(found.screw.forward))
    return rollers.max() / rollers.mean(), float(threads)


def _finding(mechanism) -> Any:
    found = [one for one in prsm.check(mechanism) if one.name == "uneven_rollers"]
    assert len(found) <= 1
    return found[0] if found else None


def _without_errors():
    return _largest(_NONE)[1]


def _factor(drop=()):
    roller, thread = _largest(drop)
    return max(roller, thread / _without_errors())


def test_numbers_are_those_of_files_without_the_errors():
    """A file without the line of an error has another structure, and no error to multiply by 0."""
    (roller, thread), none = _largest(), _without_errors()
    finding = _finding(prsm.load(_NAME))
    assert finding.severity == "note"
    assert finding.limit == 1.25
    assert finding.value == pytest.approx(max(roller, thread / none), rel=1e-9)
    # The largest of each kind; a direction without an amount is refused, so both lines go.
    left_out = ("screw_eccentricity", "roller_diameter_deviation", "overturning_moment")
    alone = {name: _factor((name, f"{name}_angle")) for name in left_out}
    worst = min(alone, key=lambda name: alone[name])
    assert worst == "screw_eccentricity"
    message = finding.message
    assert f"roller carries {roller:.3g} times the mean" in message
    expected = f"most loaded thread {thread:.4g} N, {thread / none:.3g} times its {none:.4g} N"
    assert expected in message
    assert f"pressure is {np.cbrt(thread / none):.3g} times as high" in message
    assert f"comes from {_PREFIX}{worst}, {_AMOUNTS[worst]}, without which" in message
    assert f"now {finding.value:.3g}, would be {alone[worst]:.3g}; straighten" in message
    given, each = eqx.filter_jit(without_each_error)(prsm.load(_NAME).stages[0], array(12e3))
    assert float(given.thread_load) == pytest.approx(none, rel=1e-9)
    assert float(given.roller_sharing_factor) == pytest.approx(1.0, rel=1e-9)
    assert {name.split(".")[1] for name in each} == set(_AMOUNTS)
    for name, one in each.items():
        short = name.split(".")[1]
        found = float(one.roller_sharing_factor), float(one.thread_load)
        assert max(found[0], found[1] / none) >= alone[worst] * (1 - 1e-9)
        if short in left_out:
            assert found == pytest.approx(_largest((short, f"{short}_angle")), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "amount", "words"),
    [
        ("nut_eccentricity", '"15 um"', f"{_PREFIX}nut_eccentricity, 15 µm, without"),
        ("nut_tilt", '"2 mrad"', f"{_PREFIX}nut_tilt, 2 mrad, without"),
        ("screw_tilt", '"-2 mrad"', f"{_PREFIX}screw_tilt, -2 mrad, without"),
        (
            "roller_diameter_deviation",
            '["0 um", "0 um", "0 um", "12 um", "0 um", "0 um", "0 um", "-3 um", "0 um", "0 um"]',
            f"{_PREFIX}roller_diameter_deviation, -3 to 12 µm, without",
        ),
    ],
)
def test_it_names_the_largest(name, amount, words):
    """Each error in turn is made the largest by far."""
    finding = _finding(_file(**{name: amount}))
    assert finding.severity == "warning"
    assert words in finding.message


def test_severities_at_the_limits():
    """All lengths and angles by one factor; a note from 1.25, a warning from 1.5, else none."""
    text = file.example_text(_NAME)
    start = text.index("[stage.load_sharing.part_errors]")

    def scaled(factor):
        def by(match):
            return f'"{float(match[1]) * factor!r} {match[2]}"'

        errors = re.sub(r'"(-?[\d.]+) (um|mrad)"', by, text[start:])
        return file.loads(text[:start] + errors)

    found = {factor: _finding(scaled(factor)) for factor in (0.2, 1.0, 2.0)}
    assert found[0.2] is None
    assert [found[k].severity for k in (1.0, 2.0)] == ["note", "warning"]
    assert [found[k].limit for k in (1.0, 2.0)] == [1.25, 1.5]
    assert 1.25 < found[1.0].value < 1.5 < found[2.0].value
    assert "(limit 1.25)" in found[1.0].message
    assert "(limit 1.5)" in found[2.0].message


def test_loads_on_a_free_nut_count_as_errors():
    """A moment is named with its number and what takes it instead."""
    finding = _finding(_file(overturning_moment='"60 N m"'))
    name = "stage.load_sharing.free_nut.overturning_moment"
    assert f"most of it comes from {name}, 60 N·m, without which" in finding.message
    assert finding.message.endswith("let guides take the moment")


def test_only_stages_with_errors_have_the_margin():
    def names(mechanism):
        return [one.name for one in margins_of(mechanism)]

    assert "uneven_rollers" not in names(_file(_NONE))
    assert names(prsm.load(_NAME)).count("uneven_rollers") == 1
