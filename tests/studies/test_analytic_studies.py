"""A study whose every number has a closed form: squared distances from points, and powers."""

import itertools
import math
import re

import jax.numpy as jnp
import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax import MissingDataError, UnknownNameError, file
from prsm_jax.mechanism import Constraint
from prsm_jax.quantities import _catalogue, quantity
from prsm_jax.studies import cosine, study

BOX = {"lead": (4e-3, 14e-3), "contact_angle": (0.3, 1.3)}
#: Points in millimetres and 0.1 rad; without spin friction the first one is moved.
A, B, MOVED = np.array([6.0, 8.0]), np.array([11.0, 6.0]), np.array([6.0, 9.0])
#: Upper limit of the distance from the lower left corner, in the same units.
LIMIT = 12.0
CORNER = np.array([4.0, 3.0])


def _point(analysis):
    thread = analysis.mechanism.stages[0].thread
    return jnp.stack([thread.lead * 1e3, thread.contact_angle * 10])


def _spins(analysis):
    return analysis.mechanism.stages[0].friction.spin is not None


def _near(analysis):
    return jnp.sum((_point(analysis) - jnp.asarray(A if _spins(analysis) else MOVED)) ** 2)


def _high(analysis):
    return 100 - jnp.sum((_point(analysis) - jnp.asarray(B)) ** 2)


def _power(analysis):
    lead, angle = _point(analysis)
    return lead**0.5 * angle**-2


def _reach(analysis):
    return jnp.sqrt(jnp.sum((_point(analysis) - jnp.asarray(CORNER)) ** 2))


def _of_rolling(analysis):
    if analysis.mechanism.stages[0].friction.rolling_hysteresis is None:
        raise MissingDataError("there is no rolling hysteresis")
    return _point(analysis)[0]


QUANTITIES = {"study_near": _near, "study_high": _high, "study_power": _power}


@pytest.fixture(scope="module")
def catalogue():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_catalogue, "_CATALOGUE", dict(_catalogue._CATALOGUE))
        others = {"study_reach": _reach, "study_of_rolling": _of_rolling}
        for name, function in (QUANTITIES | others).items():
            # One of a limit rests on something.
            assumes = ("equal_contacts",) if name == "study_reach" else ()
            quantity(name, "q", "1", "a quantity of these tests", assumes=assumes)(function)
        yield


SENSES = {"study_near": "minimise", "study_high": "maximise", "study_power": "maximise"}
LIMITS = (
    Constraint("study_reach", upper=LIMIT),
    Constraint("study_of_rolling", upper=1e3),
)


@pytest.fixture(scope="module")
def mechanism():
    return scenes.mechanism(scenes.stage(friction=scenes.FIRST_STAGE_LOSSES))


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def found(catalogue, mechanism, told):
    return study(
        mechanism,
        BOX,
        SENSES,
        limits=LIMITS,
        points=6,
        front_points=7,
        starts=1,
        progress=lambda *words: told.append(words),
    )


def _positions(designs):
    return np.array([[1e3 * one["lead"], 10 * one["contact_angle"]] for one in designs])


def _values(positions):
    """Quantities, and their elasticities by lead and contact angle, at (…, 2) positions."""
    to_a, to_b = positions - A, positions - B
    near, high = np.sum(to_a**2, -1), 100 - np.sum(to_b**2, -1)
    values = {
        "study_near": near,
        "study_high": high,
        "study_power": positions[..., 0] ** 0.5 * positions[..., 1] ** -2.0,
    }
    slopes = {
        "study_near": 2 * to_a * positions / near[..., None],
        "study_high": -2 * to_b * positions / high[..., None],
        "study_power": np.broadcast_to([0.5, -2.0], positions.shape),
    }
    return values, slopes


def _grid():
    axes = np.linspace(4, 14, 6), np.linspace(3, 13, 6)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def test_the_map(found):
    values, slopes = _values(_grid())
    np.testing.assert_allclose(found.map.coordinates["lead"], np.linspace(4e-3, 14e-3, 6))
    for name in SENSES:
        np.testing.assert_allclose(found.map.values[name], values[name], rtol=1e-12)
        # At A the first quantity is 0, up to rounding, and has no elasticity.
        away = np.abs(values[name]) > 1e-9
        np.testing.assert_allclose(
            found.map.elasticities[name][away], slopes[name][away], rtol=1e-11, atol=1e-12
        )
    assert found.map.usable.all()
    reach = np.linalg.norm(_grid() - CORNER, axis=-1)
    np.testing.assert_allclose(
        found.map.violations["study_reach"],
        np.maximum(reach - LIMIT, 0) / LIMIT,
        rtol=1e-12,
        atol=1e-15,
    )
    np.testing.assert_array_equal(found.map.allowed, (reach <= LIMIT) & ~found.map.error)
    # Both are met, or the comparison above is empty.
    assert 0 < found.map.allowed.sum() < found.map.allowed.size


def test_conflicts(found):
    values, slopes = _values(_grid())
    signs = {name: 1 if sense == "maximise" else -1 for name, sense in SENSES.items()}
    known = values["study_near"] > 1e-9
    for first, second in itertools.combinations(SENSES, 2):
        one = found.conflict(second, first)
        assert (one.first, one.second, one.limit) == (first, second, False)
        u, v = signs[first] * slopes[first], signs[second] * slopes[second]
        angle = np.sum(u * v, -1) / np.linalg.norm(u, axis=-1) / np.linalg.norm(v, axis=-1)
        usable = known if "study_near" in (first, second) else np.ones_like(known)
        np.testing.assert_allclose(one.cosine[usable], angle[usable], rtol=1e-9, atol=1e-9)
        judged = np.isfinite(one.cosine)
        assert one.share == np.mean(one.cosine[judged] < 0)
        among = judged & found.map.allowed
        assert one.share_allowed == np.mean(one.cosine[among] < 0)
        # 2e-16 · 1e3 of rounding stands between a slope of 0 and its sign.
        clear = judged & (np.abs(u * v).min(-1) > 1e-9)
        for index, name in enumerate(BOX):
            share = np.mean(((u * v)[..., index] < 0)[judged])
            assert one.by_driver[name] == pytest.approx(share, abs=(judged & ~clear).sum() / 36)
        lowest = np.unravel_index(np.nanargmin(one.cosine), one.cosine.shape)
        np.testing.assert_allclose(_positions([one.most])[0], _grid()[lowest])
        assert one.range == (np.nanmin(one.cosine), np.nanmax(one.cosine))
        with pytest.raises(KeyError):
            found.conflict(first, "lead")


def test_a_quantity_of_a_limit_takes_part(found):
    """Away from the corner the limit is nearer: less of it is better."""
    one = found.conflict("study_power", "study_reach")
    assert one.limit
    assert one.senses == ("maximise", "minimise")
    outward = _grid() - CORNER
    inside = np.linalg.norm(outward, axis=-1) > 0
    away = -outward * _grid()
    angle = away @ [0.5, -2.0] / math.hypot(0.5, 2.0)
    expected = angle[inside] / np.linalg.norm(away, axis=-1)[inside]
    np.testing.assert_allclose(one.cosine[inside], expected, rtol=1e-9, atol=1e-12)
    # A limit is not compared with another one.
    pairs = [(c.first, c.second) for c in found.conflicts if c.limit]
    assert pairs == list(itertools.product(SENSES, ["study_reach", "study_of_rolling"]))


def test_the_cosine():
    """Full agreement, full conflict, right angles, and no direction at all."""
    first = np.array([[1.0, 2.0], [1.0, 2.0], [1.0, 2.0], [0.0, 0.0]])
    second = np.array([[2.0, 4.0], [-3.0, -6.0], [-2.0, 1.0], [1.0, 0.0]])
    np.testing.assert_allclose(cosine(first, second), [1, -1, 0, np.nan], atol=1e-15)


def test_the_front_and_its_gradients(found):
    """The designs on the line between both points, and the exchange along it."""
    assert found.front.converged, str(found.front)
    assert len(found.front.points) == 7
    positions = _positions([one.variables for one in found.front.points])
    values, slopes = _values(positions)
    distance = np.linalg.norm(B - A)
    shares = np.linalg.norm(positions - A, axis=1) / distance
    # The tolerance of the front, relative to the distance.
    np.testing.assert_allclose(positions, A + shares[:, None] * (B - A), atol=2e-5)
    for index, one in enumerate(found.gradients):
        for name in SENSES:
            row = [one.elasticities[name][by] for by in BOX]
            if values[name][index] > 1e-3:
                np.testing.assert_allclose(row, slopes[name][index], rtol=1e-9, atol=1e-9)
        if 0 < index < 6:
            # √f₁ + √f₂ is constant with f₂ = 100 − h: df₁/dh = √(f₁/f₂), which is t/(1 − t).
            first, second = values["study_near"][index], values["study_high"][index]
            slope = math.sqrt(first / (100 - second))
            # Weights are as good as the tolerance of the front, 1e-6, over shares of a sixth.
            assert one.exchange == pytest.approx(slope * second / first, rel=1e-4)


def test_sentences_say_what_the_numbers_say(found):
    for one in found.gradients[1:6]:
        for driver, name in itertools.product(BOX, found.problem.objectives):
            value = one.elasticities[name][driver]
            words, by = (text.replace("_", " ") for text in (name, driver))
            (clause,) = re.findall(rf"1 % more {by} (.+?)[;.](?: |$)", one.sentence)
            verb = "raises" if value > 0 else "lowers"
            said = re.search(rf"{verb} (?:[^%]+ % and |[^%]+ %, )*{words} by ([\d.]+) %", clause)
            assert said, (clause, name, value)
            assert float(said[1]) == pytest.approx(abs(value), rel=0.06)
        exchanged = one.sentence.partition("Along the front, 1 % more study high raises ")[2]
        assert float(exchanged.removeprefix("study near by ").split()[0]) == pytest.approx(
            one.exchange, rel=0.06
        )


def test_without_a_part(found):
    """Without spin the first point lies elsewhere, so the front is another line."""
    spin, rolling = found.variants
    assert (spin.name, spin.parts) == ("spin", ("stage.1.friction.spin",))
    assert spin.misses
    assert spin.error == rolling.error == ""
    designs = [_present(found), *(one.variables for one in found.front.points)]
    positions = _positions(designs)
    moved = np.sum((positions - MOVED) ** 2, -1)
    values, slopes = _values(positions)
    np.testing.assert_allclose(spin.values["study_near"], moved, rtol=1e-12)
    np.testing.assert_allclose(
        spin.changes["study_near"], moved / values["study_near"] - 1, rtol=1e-9
    )
    np.testing.assert_allclose(spin.changes["study_high"], 0, atol=1e-15)
    turned = {
        driver: np.sum(((positions - MOVED) * slopes["study_near"])[:, i] < 0)
        for i, driver in enumerate(BOX)
    }
    assert spin.turned == tuple(
        ("study_near", driver, int(count)) for driver, count in turned.items() if count
    )
    # Its own front, and what its designs are with the spin.
    other = _positions([one.variables for one in spin.front.points])
    shares = np.linalg.norm(other - MOVED, axis=1) / np.linalg.norm(B - MOVED)
    np.testing.assert_allclose(other, MOVED + shares[:, None] * (B - MOVED), atol=2e-5)
    judged, _ = _values(other)
    for name in SENSES:
        np.testing.assert_allclose(spin.complete[name], judged[name], rtol=1e-9)
    assert spin.allowed.all()
    np.testing.assert_allclose(_positions([spin.best("study_near")])[0], MOVED, atol=1e-2)
    area = _area(found, judged) / _area(found, _values(positions[1:])[0])
    assert 0.5 < area < 1
    assert spin.volume == pytest.approx(area, rel=1e-9)
    # Nothing here depends on rolling hysteresis but a limit that is never active.
    assert rolling.without_data == ("study_of_rolling",)
    np.testing.assert_allclose(rolling.changes["study_near"], 0, atol=1e-15)
    assert rolling.volume == pytest.approx(1, abs=1e-5)


def _present(found):
    """The drivers of the present design, which are those of the scene."""
    return {one.name: one.present for one in found.problem.drivers}


def _area(found, values):
    """Area below a staircase of two objectives, up to the reference of the complete front."""
    worst = found.front.reference["study_near"], -found.front.reference["study_high"]
    points = sorted(zip(values["study_near"], -values["study_high"], strict=True))
    area, height = 0.0, worst[1]
    for x, y in points:
        if x < worst[0] and y < height:
            area += (worst[0] - x) * (height - y)
            height = y
    return area


def test_assumptions_of_limits_and_of_the_operating_point(found, mechanism):
    *others, last = found.assumptions
    assert others == list(prsm.assumptions(mechanism, ["study_reach"]))
    assert "carry the same load" in others[0]
    # What [optimise] may say of other points.
    for words in ("at the operating point of the mechanism", "nut_speed", "operating_points"):
        assert words in last
    assert found.to_dict()["assumptions"] == list(found.assumptions)


def test_a_study_says_which_frequencies_jump():
    from prsm_jax.studies._study import _sentences

    assert len(_sentences(["efficiency", "lowest_transverse_frequency"])) == 1
    _, jumps = _sentences(["efficiency", "lowest_mesh_transverse_frequency"])
    assert "jumps to another mode where the share of a mode passes one half" in jumps


def test_progress_names_each_part(told, found):
    names = list(dict.fromkeys(what for what, _, _ in told))
    assert names == ["map", "front", "front without spin", "front without rolling_hysteresis"]
    last = {what: (done, total) for what, done, total in told}
    assert last["map"] == (36, 36)
    assert all(done == total for done, total in last.values())


def test_defaults_come_from_the_file():
    """Drivers, ranges and limits; nothing is computed."""
    from prsm_jax.studies._problem import problem_of

    actuator = scenes.example("actuator")
    problem = problem_of(actuator, None, None, None, None)
    assert problem.bounds == {
        "lead": pytest.approx((5e-3, 20e-3)),
        "contact_angle": pytest.approx((math.pi / 6, math.pi / 3)),
        "roller_radius": pytest.approx((3e-3, 6e-3)),
    }
    assert problem.objectives == ("efficiency", "lowest_mesh_torsional_frequency")
    assert [one.quantity for one in problem.limits] == [
        one.quantity for one in actuator.design_problem.constraints
    ]
    # A quantity of the study is not a limit a second time.
    assert problem.limited == {
        "first_axial_frequency": "maximise",
        "max_pressure_shared": "minimise",
        "nut_axial_stiffness_secant": "maximise",
        "nut_outer_diameter": "minimise",
        "roller_clearance": "maximise",
        "drive_torque": "minimise",
    }
    own = problem_of(scenes.example("wu2022"), ["lead"], None, None, None)
    (lead,) = own.drivers
    assert (lead.lower, lead.upper) == pytest.approx((0.75 * lead.present, 1.25 * lead.present))
    assert own.limits == ()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"drivers": {"lead": (9e-3, 5e-3)}}, "'lead' has the range 9 mm to 5 mm; reverse them"),
        (
            {"drivers": {"contact_angle": (math.pi / 4, math.pi / 4)}},
            "the range 45 deg to 45 deg; the second end must be the larger one",
        ),
        ({"drivers": {"lead": (9e-3, math.inf)}}, r"\(0.009, inf\); give finite numbers"),
        ({"drivers": {"lead": 9e-3}}, r"driver 'lead' has the range 0.009; give \(lower, upper\)"),
        ({"drivers": {"lead": (-1e-3, 5e-3)}}, "driver 'lead': lower end is -0.001 m"),
        ({"drivers": {"roller_count": (4, 9)}}, "whole number and has no derivative"),
        ({"drivers": {}}, "drivers are empty"),
        ({"drivers": "lead"}, "drivers is the text 'lead'"),
        ({"quantities": {"mass": "minimise"}}, "quantities are mass; give two or more"),
        ({"quantities": {"mass": "less", "efficiency": "maximise"}}, "has the sense 'less'"),
        (
            {"quantities": {"natural_frequencies": "maximise", "efficiency": "maximise"}},
            r"'natural_frequencies' has components",
        ),
        ({"objectives": ["efficiency"]}, "objectives are efficiency; a front has two or three"),
        ({"objectives": ["efficiency", "mass"]}, "objectives name mass, which the study has no"),
        ({"points": 1}, "points is 1; give a whole number of 2 or more"),
        # 1000³ designs of lead, contact angle and roller radius.
        ({"points": 1000}, r"1e\+09 designs of 3 drivers; give at most 464"),
        ({"front_points": 2}, "front_points is 2; give a whole number from 3 to 1000"),
        ({"front_points": 1001}, "front_points is 1001; give a whole number from 3 to 1000"),
        ({"starts": 0}, "starts is 0; give a whole number from 1 to 10000"),
        ({"without": ["spinn"]}, r"without names 'spinn', .* did you mean spin\?"),
        ({"without": ["foo"]}, r"without names 'foo', .* does not have; known: .*tooth"),
    ],
)
def test_what_is_refused(given, message, monkeypatch):
    """Before the map is computed, which takes a minute."""
    monkeypatch.setattr("prsm_jax.studies._study.map_over_drivers", None)
    with pytest.raises(ValueError, match=message) as caught:
        study(scenes.example("actuator"), **given)
    assert isinstance(caught.value, UnknownNameError) == ("without" in given)


@pytest.mark.parametrize("avoids", [False, True])
def test_warnings_are_limits_of_the_front_where_the_file_says_so(monkeypatch, avoids):
    seen = []

    def stop(mechanism, *, problem, progress):
        seen.append(problem.avoid_warnings)
        raise StopIteration

    text = file.example_text("wu2022") + "\n[optimise]\nmaximise = 'efficiency'\n"
    text += "avoid_warnings = true\n" if avoids else ""
    text += "[[optimise.variable]]\nname = 'lead'\nlower = '9 mm'\nupper = '11 mm'\n"
    monkeypatch.setattr("prsm_jax.studies._study.pareto", stop)
    monkeypatch.setattr("prsm_jax.studies._study.map_over_drivers", lambda *_: (None, None))
    with pytest.raises(StopIteration):
        study(file.loads(text), ["lead", "contact_angle"])
    assert seen == [avoids]
