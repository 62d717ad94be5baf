"""Checks of strength: values, limits, margins and verdicts against closed forms of their own."""

import dataclasses
import functools
import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
import scenes
from truncation_scenes import screw_of_30_mm

import prsm_jax as prsm
from prsm_jax.findings import (
    Finding,
    StrengthCheck,
    check_from,
    margin_numbers,
    status_of,
    strength_checks_from,
)
from prsm_jax.mechanism import ScrewShaft, Strength
from tests.present import present

_C0, _CA, _HOURS, _LENGTH, _ROOT = 60e3, 45e3, 500.0, 0.4, 9.5e-3


@functools.cache
def _mechanism():
    """Capacities as from a catalogue, so that no contact is computed, and a shaft."""
    mechanism = scenes.example("wu2022")
    data = Strength(
        static_capacity=_C0,
        dynamic_capacity=_CA,
        required_life=3600 * _HOURS,
        shaft=ScrewShaft("fixed_supported", unsupported_length=_LENGTH, root_radius=_ROOT),
    )
    # The critical speed needs a density, which the example lacks.
    steel = dataclasses.replace(present(mechanism.stages[0].material), density=7850.0)
    stage = dataclasses.replace(mechanism.stages[0], strength=data, material=steel)
    return dataclasses.replace(mechanism, stages=(stage,))


def _at(load, speed=100.0):
    point = present(_mechanism().operating_point)
    changed = dataclasses.replace(point, load=jnp.asarray(load), speed=jnp.asarray(speed))
    return eqx.tree_at(lambda m: m.operating_point, _mechanism(), changed)


def _inverted(rpm):
    """The leg with capacities as from a catalogue, so that no contact is computed."""
    mechanism = scenes.example("humanoid_leg")
    data = Strength(
        static_capacity=_C0,
        dynamic_capacity=_CA,
        shaft=present(present(mechanism.stages[0].strength).shaft),
    )
    stage = dataclasses.replace(mechanism.stages[0], strength=data, gear=None, friction=None)
    point = dataclasses.replace(
        present(mechanism.operating_point), speed=jnp.asarray(rpm * math.pi / 30)
    )
    return dataclasses.replace(mechanism, stages=(stage,), operating_point=point, duty_cycle=None)


def _checks(mechanism) -> dict[str, StrengthCheck]:
    return {one.name: one for one in prsm.strength_checks(mechanism)}


def test_values_limits_and_margins_by_hand():
    """Rounding only: every number is a product of a few others."""
    load, speed = 7e3, 100.0
    found = _checks(_at(load, speed))
    safety = found["static_safety"]
    assert safety.value == pytest.approx(_C0 / load, rel=1e-12)
    assert (safety.limit, safety.at_most, safety.unit) == (1.0, False, "1")
    assert safety.margin == pytest.approx(1 - load / _C0, rel=1e-12)
    life = found["rating_life"]
    hours = 1e6 * (_CA / load) ** 3 / (speed / (2 * math.pi)) / 3600
    assert life.value / 3600 == pytest.approx(hours, rel=1e-12)
    assert (life.limit, life.unit) == (3600 * _HOURS, "s")
    assert life.margin == pytest.approx(hours / _HOURS - 1, rel=1e-9)
    # Euler, one end fixed and one supported: the smallest root of tan x = x is 4.4934.
    inertia = math.pi / 4 * _ROOT**4
    euler = 212e9 * inertia * 4.493409457909064**2 / _LENGTH**2
    buckling = found["buckling"]
    # Catalogues round the square of the root over π² to 2.05 or less.
    assert buckling.value == pytest.approx(euler / load, rel=5e-3)
    assert buckling.limit == 2.0
    assert buckling.margin == pytest.approx(0.5 - 1 / buckling.value, rel=1e-9)
    turning = found["screw_speed"]
    assert (turning.value, turning.unit, turning.at_most) == (speed, "rad/s", True)
    assert turning.limit is not None
    assert turning.margin == pytest.approx(1 - speed / turning.limit, rel=1e-12)
    assert {found[n].verdict for n in ("static_safety", "rating_life", "buckling")} == {"pass"}
    for name, value in (("static_capacity", _C0), ("dynamic_capacity", _CA)):
        assert found[name].value == pytest.approx(value)
        assert (found[name].limit, found[name].margin) == (None, None)
        assert found[name].verdict == "no limit"
    assert "rating_life_time" not in found


@pytest.mark.parametrize(
    ("name", "load", "speed", "verdict"),
    [
        ("static_safety", 0.999 * _C0, 100.0, "pass"),
        ("static_safety", 1.001 * _C0, 100.0, "fail"),
        # 500 h at 100 rad/s: (C/F)³ = 500 · 3600 · 100/(2π) / 1e6.
        ("rating_life", 0.999 * _CA / (1.8e6 * 50 / math.pi / 1e6) ** (1 / 3), 100.0, "pass"),
        ("rating_life", 1.001 * _CA / (1.8e6 * 50 / math.pi / 1e6) ** (1 / 3), 100.0, "warning"),
    ],
)
def test_verdicts_change_at_the_limit(name, load, speed, verdict):
    one = _checks(_at(load, speed))[name]
    assert one.verdict == verdict
    assert one.margin is not None
    assert (one.margin >= 0) == (verdict == "pass")
    assert abs(one.margin) < 4e-3


@pytest.mark.parametrize("share", [0.4, 0.9, 1.1])
def test_buckling_warns_below_2_and_fails_below_1(share):
    own = _checks(_at(7e3))["buckling"]
    one = _checks(_at(share * own.value * 7e3))["buckling"]
    assert one.value == pytest.approx(1 / share, rel=1e-9)
    assert one.verdict == ("pass" if share < 0.5 else "warning" if share < 1 else "fail")


@pytest.mark.parametrize(
    ("share", "limit", "verdict"),
    [(0.7, "permissible", "pass"), (0.9, "permissible", "warning"), (1.1, "critical", "fail")],
)
def test_the_screw_speed_is_shown_beside_the_limit_that_it_passes(share, limit, verdict):
    """By hand: Ω = (3.9266/l)² √(E r²/(4 ρ)) of a solid round bar; 0.8 of it is permissible."""
    critical = (3.9266023120479187 / _LENGTH) ** 2 * math.sqrt(212e9 * _ROOT**2 / 4 / 7850.0)
    limits = {"critical": critical, "permissible": 0.8 * critical}
    mechanism = _at(7e3, share * critical)
    one = _checks(mechanism)["screw_speed"]
    assert one.verdict == verdict
    assert one.limit == pytest.approx(limits[limit], rel=1e-9)
    assert one.margin == pytest.approx(1 - one.value / limits[limit], abs=1e-9)
    found = [f for f in prsm.check(mechanism) if f.name == "screw_speed"]
    assert [f.limit for f in found] == ([] if verdict == "pass" else [one.limit])
    if found:
        rpm = share * critical * 30 / math.pi, limits[limit] * 30 / math.pi
        said = {"critical": "its critical speed", "permissible": "the permissible speed"}[limit]
        words = f"the screw turns at {rpm[0]:.5g} rpm, above {said} of {rpm[1]:.5g} rpm"
        assert words in found[0].message
        assert "shorten the unsupported length" in found[0].message


def test_a_shorter_shaft_is_no_remedy_where_the_dn_value_limits_the_speed():
    """A DN limit of 120,000 mm rpm is reached far below the critical speed."""
    own = _at(7e3)
    rpm = 1.01 * 120 / (2 * float(own.stages[0].thread.screw_radius))
    mechanism = eqx.tree_at(
        lambda m: m.stages[0].strength.shaft.dn_limit,
        _at(7e3, rpm * math.pi / 30),
        jnp.asarray(120 * math.pi / 30),
        is_leaf=lambda leaf: leaf is None,
    )
    (finding,) = [f for f in prsm.check(mechanism) if f.name == "screw_speed"]
    assert finding.limit == pytest.approx(rpm / 1.01 * math.pi / 30, rel=1e-9)
    assert "DN limit" in finding.message
    assert "shorten" not in finding.message


@pytest.mark.parametrize(("rpm", "verdict"), [(5900.0, "pass"), (6100.0, "warning")])
def test_where_the_nut_turns_the_dn_value_limits_its_speed(rpm, verdict):
    """120,000 mm rpm of a screw of 20 mm: 6000 rpm. Its screw has no critical speed."""
    mechanism = _inverted(rpm)
    one = _checks(mechanism)["screw_speed"]
    assert one.verdict == verdict
    assert one.limit is not None
    assert one.limit * 30 / math.pi == pytest.approx(6000, rel=1e-9)
    assert one.margin == pytest.approx(1 - rpm / 6000, abs=1e-9)
    (finding,) = [f for f in prsm.check(mechanism) if f.name == "screw_speed"] or [None]
    assert (finding is None) == (verdict == "pass")
    if finding is not None:
        assert "the nut turns at 6100 rpm, above the permissible speed of 6000" in finding.message
        assert "DN limit" in finding.message
        assert "ends" not in finding.message


@pytest.mark.parametrize("load", [7e3, 50e3, 70e3])
@pytest.mark.parametrize("speed", [100.0, 4e3])
def test_verdicts_are_those_of_check(load, speed):
    """Every finding of a name that is a check has its verdict, and no check has another."""
    mechanism = _at(load, speed)
    checks = _checks(mechanism)
    severities = {"fail": "error", "warning": "warning"}
    found = {one.name: one.severity for one in prsm.check(mechanism) if one.severity != "note"}
    said = {n: severities[c.verdict] for n, c in checks.items() if c.verdict in severities}
    assert said == {name: found[name] for name in checks if name in found}


def test_a_value_that_does_not_exist_fails():
    mechanism = _at(7e3)
    numbers = margin_numbers(mechanism)
    names = [one.name for one in prsm.findings.margins_of(mechanism)]
    place = names.index("static_safety")
    broken = {"value": jnp.asarray(float("nan"))}
    changed = [broken if i == place else n for i, n in enumerate(numbers.margins)]
    found = strength_checks_from(mechanism, numbers._replace(margins=changed), {})
    assert {one.verdict for one in found if one.name == "static_safety"} == {"fail"}
    assert check_from(mechanism, numbers) == prsm.check(mechanism)


def test_a_pressure_has_the_permissible_one_as_its_limit():
    mechanism, numbers = _at(7e3), margin_numbers(_at(7e3))

    def pressure(given, value):
        path = lambda m: m.stages[0].strength.permissible_pressure  # noqa: E731
        one = eqx.tree_at(path, mechanism, given, is_leaf=lambda x: x is None)
        found = strength_checks_from(one, numbers, {"max_pressure": value})
        return next(c for c in found if c.name == "max_pressure")

    assert pressure(None, 2e9).verdict == "no limit"
    kept, broken = (pressure(jnp.asarray(4e9), p) for p in (3.9e9, 4.1e9))
    assert (kept.verdict, broken.verdict) == ("pass", "fail")
    assert kept.limit == broken.limit == 4e9
    assert kept.margin == pytest.approx(0.025)
    assert broken.margin == pytest.approx(-0.025)


def test_the_status_is_the_worst_verdict():
    one = _checks(_at(7e3))["static_safety"]
    said = lambda verdict: dataclasses.replace(one, verdict=verdict)  # noqa: E731
    finding = lambda severity: Finding("x", severity, 1, 0.0, 0.0, "words")  # noqa: E731
    assert status_of((said("pass"), said("no limit")), (finding("note"),)) == "pass"
    # Nothing has a limit that could be kept.
    assert status_of((), ()) == "no checks"
    assert status_of((said("no limit"),), (finding("note"),)) == "no checks"
    assert status_of((said("warning"),), ()) == "warning"
    assert status_of((said("pass"),), (finding("warning"),)) == "warning"
    assert status_of((said("warning"), said("fail")), ()) == "fail"
    assert status_of((said("pass"),), (finding("error"),)) == "fail"
    # What was not checked does not pass.
    assert status_of((), None) == "warning"


def _two_stages(permissible, **data):
    """Both stages of an example, equally loaded, with one permissible pressure each [Pa]."""
    mechanism = scenes.example("li2021_two_stage")
    stages = tuple(
        dataclasses.replace(
            stage,
            load_sharing=None,
            material=scenes.STEEL,
            engaged_threads=jnp.asarray(20.0),
            strength=Strength(permissible_pressure=one, **data),
        )
        for stage, one in zip(mechanism.stages, permissible, strict=True)
    )
    return dataclasses.replace(mechanism, stages=stages)


def _pressure_rows(mechanism):
    rows = [one for one in prsm.strength_checks(mechanism) if one.name == "max_pressure"]
    return {one.stage: one for one in rows}


def test_each_stage_has_its_own_permissible_pressure():
    contacts = prsm.thread_contacts(_two_stages((1e9, 1e9)))
    first, second = (
        max(float(one.screw.hertz.max_pressure), float(one.nut.hertz.max_pressure))
        for one in contacts
    )
    assert abs(first / second - 1) > 0.05
    rows = _pressure_rows(_two_stages((1.01 * first, 1.01 * second)))
    assert {number: row.verdict for number, row in rows.items()} == {1: "pass", 2: "pass"}
    for number, value in ((1, first), (2, second)):
        assert rows[number].value == pytest.approx(value, rel=1e-12)
        assert rows[number].limit == pytest.approx(1.01 * value, rel=1e-12)
    rows = _pressure_rows(_two_stages((1.01 * first, 0.99 * second)))
    assert {number: row.verdict for number, row in rows.items()} == {1: "pass", 2: "fail"}


@pytest.mark.parametrize(("share", "verdict"), [(1.01, "no limit"), (0.99, "fail")])
def test_a_pressure_without_the_preload_proves_nothing(share, verdict):
    """It is that of the operating load alone; the preload can only raise it."""
    play = prsm.mechanism.AxialPlay(preload_force=20e3, arrangement="double_nut")
    pressure = float(_pressure_rows(_two_stages((1e9, 1e9)))[1].value)
    rows = _pressure_rows(_two_stages((share * pressure, 1e12), play=play))
    assert rows[1].value == pytest.approx(pressure, rel=1e-12)
    assert (rows[1].verdict, rows[1].limit is None) == (verdict, verdict == "no limit")


def test_the_pressure_with_the_preload_has_a_verdict():
    """In closed form: 2^{3/2} times the preload frees the other nut, so one nut carries it all.

    Below that load the stage fails at a limit between both pressures.
    """
    opening = 2**1.5 * 5e3
    play = prsm.mechanism.AxialPlay(preload_force=5e3, arrangement="double_nut")

    def rows(load, permissible):
        two = dataclasses.replace(
            _two_stages((permissible, 1e12), play=play),
            operating_point=prsm.mechanism.OperatingPoint(10.0, load),
        )
        found = [one for one in prsm.strength_checks(two) if one.stage == 1]
        return {one.name: one for one in found}

    at_opening = rows(opening, 1e12)
    pressure = at_opening["max_pressure"].value
    assert at_opening["preloaded_pressure"].value == pytest.approx(pressure, rel=1e-9)
    assert at_opening["preloaded_pressure"].verdict == "pass"
    assert at_opening["max_pressure"].verdict == "no limit"
    # Without a load each nut carries the preload alone: the cube root of 2^{3/2} less pressure.
    idle = rows(0.0, 0.99 * pressure / 2**0.5)
    assert idle["max_pressure"].value == 0
    assert idle["preloaded_pressure"].value == pytest.approx(pressure / 2**0.5, rel=1e-9)
    assert idle["preloaded_pressure"].limit == pytest.approx(0.99 * pressure / 2**0.5)
    assert idle["preloaded_pressure"].verdict == "fail"
    assert idle["preloaded_pressure"].margin == pytest.approx(1 - 1 / 0.99, rel=1e-7)


def test_a_stage_with_a_preload_is_judged_beside_one_without():
    play = prsm.mechanism.AxialPlay(preload_force=5e3, arrangement="double_nut")
    both = _two_stages((1e12, 1e12), play=play)
    bare = dataclasses.replace(
        both.stages[1], strength=dataclasses.replace(present(both.stages[1].strength), play=None)
    )
    one = dataclasses.replace(both, stages=(both.stages[0], bare))
    rows = {(row.name, row.stage): row for row in prsm.strength_checks(one)}
    expected = {(row.name, row.stage): row for row in prsm.strength_checks(both)}
    name = "preloaded_pressure"
    assert rows[name, 1].value == pytest.approx(expected[name, 1].value, rel=1e-12)
    assert rows[name, 1].verdict == "pass"
    assert (name, 2) not in rows
    assert rows["max_pressure", 1].verdict == "no limit"
    assert rows["max_pressure", 2].verdict == "pass"
    # A pressure that does not exist does not keep its limit.
    failed = strength_checks_from(both, margin_numbers(both), {name: [math.nan, 1e9]})
    assert [row.verdict for row in failed if row.name == name] == ["fail", "pass"]


def test_with_unequal_threads_the_pressure_with_the_preload_can_only_fail():
    """It is that of equal threads, of which the most loaded one carries more."""
    play = prsm.mechanism.AxialPlay(preload_force=5e3, arrangement="double_nut")
    sharing = present(scenes.example("actuator_load_sharing").stages[0].load_sharing)
    mechanism = scenes.equal_shares("actuator")

    def row(permissible, **given):
        stage = dataclasses.replace(
            mechanism.stages[0],
            load_sharing=dataclasses.replace(sharing, **given),
            strength=Strength(permissible_pressure=permissible, play=play),
        )
        found = prsm.strength_checks(dataclasses.replace(mechanism, stages=(stage,)))
        return next(one for one in found if one.name == "preloaded_pressure")

    assert row(1e12, split_nut=None).verdict == "no limit"
    assert row(1e9, split_nut=None).verdict == "fail"
    # The loads of the threads of a modelled split nut include its preload.
    assert row(1e9).verdict == "no limit"


def test_self_locking_is_judged_by_the_load_that_drives_also_at_standstill():
    """Coulomb friction does not depend on the speed, so neither does the verdict."""
    mechanism = scenes.equal_shares("wu2022")
    mechanism = prsm.set_parameter(mechanism, "thread.coefficient", 0.6)
    mechanism = prsm.set_parameter(mechanism, "contact_angle", math.radians(60.0))
    found = {}
    for speed in (10.0, 0.0):
        still = prsm.set_parameter(mechanism, "speed", speed)
        (row,) = (one for one in prsm.strength_checks(still) if one.name == "self_locking")
        found[speed] = row.value, row.verdict
        assert "self_locking" in {one.name for one in prsm.check(still)}
    assert found[0.0][0] == pytest.approx(found[10.0][0], rel=1e-12)
    assert found[0.0][0] < 0
    assert found[0.0][1] == "no limit"


@pytest.mark.parametrize(
    ("data", "load", "expected"),
    [
        ({"permissible_pressure": 2.9e9, "material_factor": 0.6}, 5e3, "static_capacity"),
        ({"static_capacity": 40e3, "dynamic_capacity": 50e3}, 5e3, "dynamic_capacity"),
        ({"static_capacity": 40e3, "dynamic_capacity": 50e3}, 60e3, "operating_load"),
    ],
)
def test_the_share_of_an_ellipse_names_the_load_at_which_it_holds(data, load, expected):
    """The largest of the loads, for all threads carry the same."""
    scene = screw_of_30_mm(5e-3, addendum=0.1, load=load, strength=Strength(**data))
    names = ("static_capacity", "dynamic_capacity")
    values = prsm.compute(scene, names)
    loads = {name: float(np.ravel(values[name])[0]) for name in names} | {"operating_load": load}
    assert max(loads, key=lambda name: loads[name]) == expected
    checks = prsm.strength_checks(scene)
    ends = [one for one in checks if one.name == "contact_truncation"]
    assert {one.at_load for one in ends} == {"the " + expected.replace("_", " ")}
    assert {one.at_load for one in checks if one.name != "contact_truncation"} == {""}
    assert {one.to_dict()["at_load"] for one in ends} == {ends[0].at_load}
    # The finding has the share at this load.
    for found in (f for f in prsm.check(scene) if f.name == "contact_truncation"):
        start = f"{ends[0].at_load.removeprefix('the ')} of"
        (part,) = [p for p in found.message.split("at the ") if p.startswith(start)]
        assert f"({found.value:.2%} of its" in part


def test_a_screw_that_is_nearly_self_locking_is_turned_by_the_load_after_the_remedy():
    """Lower friction or a larger lead; a contact angle about 45° has hardly any effect."""

    start = prsm.set_parameter(prsm.load("actuator"), "stage.friction.thread.coefficient", 0.3)
    start = prsm.set_parameter(start, "lead", 1e-3)
    (found,) = [f for f in prsm.check(start) if f.name == "self_locking"]
    assert found.severity == "warning"
    assert found.message.endswith(
        "for the load to turn it, lower the friction or raise the lead; for the load to be held, "
        "add a brake"
    )
    for name, better in (("stage.friction.thread.coefficient", 0.2), ("lead", 2e-3)):
        helped = prsm.set_parameter(start, name, better)
        assert "self_locking" not in {f.name for f in prsm.check(helped)}
    for angle in (35, 40, 50, 55):
        other = prsm.set_parameter(start, "contact_angle", math.radians(angle))
        assert "self_locking" in {f.name for f in prsm.check(other)}
