"""The choice of a size, and how far requirements must be relaxed, against formulas of their own."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

import prsm_jax
from prsm_jax.catalogue_sizes import catalogue_rows
from prsm_jax.dimensioning import Dimensioning, Requirements, _dimension, dimension
from prsm_jax.dimensioning._limits import margins, relaxations
from prsm_jax.dimensioning._requirements import UNITS
from prsm_jax.dimensioning._sizes import Sizes, size_mechanism

_WANTED = {"load": 10e3, "stroke": 0.3, "speed": 0.1, "life": 1.8e7, "envelope": 0.08}


def _made_up(rows=None) -> Sizes:
    """Every tenth row of the catalogue with capacities of its own."""
    rows = catalogue_rows()[::10] if rows is None else rows
    number = np.arange(1, len(rows) + 1)
    diameter = np.array([row["nominal_diameter_mm"] * 1e-3 for row in rows])
    return Sizes(
        tuple(rows),
        diameter,
        np.array([row["lead_mm"] * 1e-3 for row in rows]),
        np.array([row["nut_outer_diameter_mm"] * 1e-3 for row in rows]),
        np.array([row["nut_length_mm"] * 1e-3 for row in rows]),
        dynamic_capacity=14e3 * number,
        static_capacity=17e3 * number,
        truncation_load=9e3 * number,
        euler_load=9e8 * diameter**2 * number,
        critical_speed=3e3 * diameter * number,
        # From a fifth to fifty times Euler's load of some hundred millimetres.
        yield_load=4e8 * diameter**2,
    )


@pytest.fixture
def made_up(monkeypatch):
    sizes = _made_up()
    monkeypatch.setattr(_dimension, "all_sizes", lambda: sizes)
    return sizes


def _johnson(euler: float, yielding: float) -> float:
    """Timoshenko and Gere 1961: a parabola that joins Euler's curve at half the yield load."""
    return euler if euler <= yielding / 2 else yielding - yielding**2 / (4 * euler)


def _fits(sizes: Sizes, wanted: dict[str, float]) -> np.ndarray:
    """Which sizes fit, from the sentences of the documentation."""
    d, lead, nut, length = sizes.diameter, sizes.lead, sizes.nut_diameter, sizes.nut_length
    force, stroke, speed, life, bore = (wanted[name] for name in UNITS)
    revolutions_per_s = speed / lead
    turns = 1e6 * (sizes.dynamic_capacity / force) ** 3
    free, loaded = stroke + length + 2 * d, stroke + length
    return (
        (nut <= bore)
        & (turns / revolutions_per_s >= life)
        & (sizes.static_capacity >= 2 * force)
        & (np.vectorize(_johnson)(sizes.euler_load / loaded**2, sizes.yield_load) >= 2 * force)
        & (2 * math.pi * revolutions_per_s <= 0.8 * sizes.critical_speed / free**2)
        & (d * 1e3 * revolutions_per_s * 60 <= 100_000)
    )


def _random_requirements(count: int):
    random = np.random.default_rng(7)
    for _ in range(count):
        factors = 10 ** random.uniform(-0.6, 0.6, 5)
        yield {name: _WANTED[name] * f for name, f in zip(_WANTED, factors, strict=True)}


def test_sizes_that_fit_are_those_of_the_formulas():
    sizes, both = _made_up(), set()
    for wanted in _random_requirements(60):
        found = margins(sizes, Requirements(**wanted))
        fits = np.logical_and.reduce([value >= 1 for value in found.values()])
        np.testing.assert_array_equal(fits, _fits(sizes, wanted))
        both |= set(fits.tolist())
    assert both == {True, False}


def test_a_relaxed_requirement_is_enough_and_hardly_more_than_enough():
    """A value that is a hundredth closer to the requirement is not: three digits are given."""
    sizes, seen, which = _made_up(), set(), itertools.cycle(("envelope", "stroke"))
    for wanted in _random_requirements(200):
        # Half of the envelope, or five times the stroke: in both ways some do not fit.
        changed = next(which)
        wanted = {**wanted, changed: wanted[changed] * {"envelope": 0.5, "stroke": 5.0}[changed]}
        if _fits(sizes, wanted).any():
            continue
        relaxed = relaxations(sizes, Requirements(**wanted))
        for name, value in relaxed.items():
            assert _fits(sizes, wanted | {name: value}).any(), (name, wanted)
            closer = value * (0.99 if name == "envelope" else 1.011)
            assert not _fits(sizes, wanted | {name: closer}).any(), (name, wanted)
            assert (value > wanted[name]) == (name == "envelope")
            seen.add(name)
        for name in set(UNITS) - set(relaxed):
            extreme = 1e3 if name == "envelope" else wanted[name] * 1e-7
            assert not _fits(sizes, wanted | {name: extreme}).any(), (name, wanted)
    assert seen == set(UNITS)


def test_the_smallest_nut_is_taken_and_of_its_leads_the_smallest_that_stays_on_its_flanks(
    monkeypatch,
):
    rows = [row for row in catalogue_rows() if row["nominal_diameter_mm"] in (21, 30)]
    enough = np.full(len(rows), 1e7)
    sizes = dataclasses.replace(
        _made_up(rows), dynamic_capacity=enough, static_capacity=enough, critical_speed=enough
    )
    monkeypatch.setattr(_dimension, "all_sizes", lambda: sizes)
    found = dimension(**_WANTED | {"load": 30e3})
    assert found.size is not None
    # 9 kN for each place in the table: the fourth size is the first of 30 kN or more.
    assert (found.size["nominal_diameter_mm"], found.size["lead_mm"]) == (21, 5)
    found = dimension(**_WANTED | {"load": 80e3})
    assert found.size is not None
    assert (found.size["nominal_diameter_mm"], found.size["lead_mm"]) == (21, 2)


def test_the_mechanism_has_the_lengths_and_the_operating_point(made_up):
    found = dimension(**_WANTED)
    assert found.size is not None
    assert found.mechanism is not None
    stage, point = found.mechanism.stages[0], found.mechanism.operating_point
    assert point is not None
    diameter, nut = found.size["nominal_diameter_mm"], found.size["nut_length_mm"]
    assert float(point.load) == 10e3
    rpm = 60 * 100 / found.size["lead_mm"]
    assert float(point.speed) * 30 / math.pi == pytest.approx(rpm, rel=1e-12)
    assert stage.strength is not None
    assert stage.strength.shaft is not None
    shaft = stage.strength.shaft
    for value, millimetres in (
        (shaft.unsupported_length, 300 + nut + 2 * diameter),
        (shaft.loaded_length, 300 + nut),
        (stage.screw.length, 300 + nut + 5 * diameter),
    ):
        assert value is not None
        assert float(value) * 1e3 == pytest.approx(millimetres, rel=1e-12)
    assert float(stage.strength.required_life or 0) == 1.8e7
    assert min(found.margins.values()) >= 1
    assert "DN value" in str(found)
    assert not found.sentences()


@pytest.mark.parametrize("place", [0, 22, 60, 89])
@pytest.mark.parametrize(("load", "speed"), [(500.0, 0.3), (30e3, 0.02)])
def test_the_carriers_settle_in_the_first_third_of_the_duration(place, load, speed):
    """Against the transient: long enough to settle, and not so long that nothing is to be seen."""
    wanted = Requirements(**_WANTED | {"load": load, "speed": speed})
    made = _dimension._mechanism(catalogue_rows()[place], wanted)
    run = prsm_jax.simulate(made)
    assert run.solver.code == 0
    point = made.operating_point
    assert point is not None
    assert point.duration is not None
    duration = float(point.duration)
    assert float(run.time[-1]) == duration
    # One digit, which a person may change.
    assert f"{duration:.0e}"[0] in "125"
    assert float(f"{duration:.0e}") == pytest.approx(duration, rel=1e-12)
    (ratio,) = np.asarray(run.carrier_ratio)
    (settled,) = np.asarray(prsm_jax.steady_state(made).carrier_ratio)
    moving = np.asarray(run.time)[np.abs(ratio - settled) > 1e-3 * settled]
    assert 0.03 < moving[-1] / duration < 1 / 3


def test_what_to_relax_is_said_with_numbers(made_up):
    found = dimension(**_WANTED | {"envelope": 0.02})
    assert found.size is None
    assert found.mechanism is None
    wanted = found.relaxed["envelope"]
    (sentence,) = [one for one in found.sentences() if one.startswith("envelope")]
    assert f"at least {wanted * 1e3:.2f} mm instead of 20.00 mm" in sentence
    assert f"({100 * (wanted / 0.02 - 1):.3g} % more)" in sentence
    assert sentence in " ".join(str(found).split())
    nothing = dataclasses.replace(found, relaxed={})
    assert "no requirement alone is enough" in str(nothing)
    much = dataclasses.replace(found, relaxed={"life": 1.8e3})
    assert "life: at most 0.5000 h instead of 5000 h (0.0100 % of it)" in " ".join(
        str(much).split()
    )
    wide = dataclasses.replace(found, relaxed={"envelope": 0.3})
    assert "envelope: at least 300.0 mm instead of 20.00 mm (15.0 times as much)" in " ".join(
        str(wide).split()
    )


@pytest.mark.parametrize("name", _WANTED)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, "1"])
def test_requirements_that_make_no_sense_are_refused(name, value):
    with pytest.raises((ValueError, TypeError), match=name):
        Requirements(**_WANTED | {name: value})


def test_the_design_of_the_catalogue_passes_check_and_has_the_margins():
    """Against `compute` and `check` of the mechanism itself, by other programs."""
    found = dimension(**_WANTED)
    assert isinstance(found, Dimensioning)
    assert found.mechanism is not None
    assert found.size is not None
    names = ["static_safety", "buckling_safety", "critical_speed_margin", "dynamic_capacity"]
    names.append("rating_life")
    values = {k: float(np.ravel(v)[0]) for k, v in prsm_jax.compute(found.mechanism, names).items()}
    # Other programs of the same formulas: they differ by rounding.
    assert values["static_safety"] / 2 == pytest.approx(found.margins["static_safety"], rel=1e-9)
    assert values["buckling_safety"] / 2 == pytest.approx(found.margins["buckling"], rel=1e-9)
    shares = [1 / found.margins["critical_speed"], 1 / found.margins["dn_value"]]
    assert 1 - values["critical_speed_margin"] == pytest.approx(max(shares), rel=1e-9)
    # By the dynamic capacity; contacts that are truncated under it alone last longer.
    seconds = found.size["lead_mm"] * 1e-3 / 0.1
    turns = 1e6 * (values["dynamic_capacity"] / 10e3) ** 3
    assert turns * seconds / 1.8e7 == pytest.approx(found.margins["life"], rel=1e-9)
    assert values["rating_life"] >= turns
    limits = {"static_safety", "rating_life", "buckling", "screw_speed"}
    findings = prsm_jax.check(found.mechanism)
    assert not [one for one in findings if one.severity == "error" or one.name in limits]


def test_sizes_are_those_of_the_catalogue():
    row = catalogue_rows()[40]
    stage = size_mechanism(row).stages[0]
    assert stage.nut.length is not None
    assert float(stage.nut.length) * 1e3 == pytest.approx(row["nut_length_mm"])
