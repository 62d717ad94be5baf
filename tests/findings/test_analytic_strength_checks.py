"""Checks of strength: values, limits, margins and verdicts against closed forms of their own."""

import dataclasses
import functools
import math

import equinox as eqx
import jax.numpy as jnp
import pytest
import scenes

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
