"""Threads fit on their bodies: engaged threads along the roller and in the nut."""

import json
from typing import Any

import numpy as np
import pytest
import scenes

import prsm_jax as prsm
from prsm_jax.mechanism import AxialPlay, Gear, LoadSharing, Nut, Roller, SplitNut, Strength
from prsm_jax.optimisation import optimise
from tests.roots import root_between

NAME = "thread_length"


def _mechanism(roller=None, nut=None, width=None, **more):
    """Twenty threads of a pitch of 2 mm, 40 mm, on bodies of known masses."""
    parts: dict[str, Any] = {
        "roller": Roller(mass=0.03, inertia=4e-7, length=roller),
        "nut": Nut(mass=2.2, inertia=9e-4, length=nut),
        "gear": None if width is None else Gear(np.radians(20), roller_teeth=16, face_width=width),
        "sharing": "equal",
    }
    return scenes.frictionless(**(parts | more))


def _found(mechanism):
    return [f for f in prsm.check(mechanism) if f.name == NAME]


@pytest.mark.parametrize(
    ("roller", "nut", "bodies"),
    [
        (None, None, []),
        # Exactly as long as the thread: 20 times 2 mm.
        (40e-3, 40e-3, []),
        (39.9e-3, 40e-3, ["roller"]),
        (40e-3, 39.9e-3, ["nut"]),
        (30e-3, 35e-3, ["roller", "nut"]),
    ],
)
def test_bodies_are_as_long_as_the_engaged_threads(roller, nut, bodies):
    found = _found(_mechanism(roller, nut))
    lengths = {"roller": roller, "nut": nut}
    assert [(f.severity, f.impossible) for f in found] == [("error", True)] * len(bodies)
    for finding, body in zip(found, bodies, strict=True):
        length = lengths[body]
        assert (finding.value, finding.limit) == pytest.approx((40e-3, length), rel=1e-12)
        assert "20 threads (stage.engaged_threads) with a pitch of 2 mm" in finding.message
        words = f"stage.{body}.length is {1e3 * length:.4g} mm, which holds {int(length / 2e-3)}"
        assert words in finding.message


@pytest.mark.parametrize(
    ("roller", "width", "severity"),
    [
        # The contacts of 20 threads are 38 mm apart: 38 + 2 × 6.
        (50e-3, 6e-3, None),
        (49.9e-3, 6e-3, "warning"),
        (50e-3, 6.1e-3, "warning"),
        # 16 mm are between the gears, eight threads.
        (40e-3, 12e-3, "warning"),
        (39e-3, 12e-3, "error"),
    ],
)
def test_gears_leave_room_for_the_threads(roller, width, severity):
    """Gears are at the ends of a roller; only a roller that is too short cannot be made."""
    found = _found(_mechanism(roller, width=width))
    assert [f.severity for f in found] == ([] if severity is None else [severity])
    if severity == "warning":
        between = roller - 2 * width
        assert (found[0].value, found[0].limit) == pytest.approx((38e-3, between), rel=1e-9)
        assert f"a roller has {1e3 * between:.4g} mm" in found[0].message
        assert f"engage the {int(between / 2e-3 + 1e-6)} that" in found[0].message


def test_threads_of_load_sharing_count_too():
    shared = _mechanism(40e-3, load_sharing=LoadSharing(25), sharing="unstated")
    (found,) = _found(shared)
    assert found.value == pytest.approx(50e-3, rel=1e-12)
    assert "25 threads (stage.load_sharing.thread_count)" in found.message
    alone = _mechanism(
        40e-3, load_sharing=LoadSharing(25), engaged_threads=None, sharing="unstated"
    )
    assert _found(alone)[0].value == found.value


@pytest.mark.parametrize(
    ("roller", "nut", "width", "count"),
    [
        # 17 threads on the roller, 15 in the nut.
        (35e-3, 31e-3, None, 15),
        # 17 threads between gears on 34 mm of 39 mm: from the first to the last of 18.
        (39e-3, None, 2.5e-3, 18),
        (35e-3, None, 8e-3, 10),
    ],
)
@pytest.mark.parametrize("both", [False, True])
def test_the_number_in_the_error_leaves_neither_error_nor_warning(roller, nut, width, count, both):
    keys = ["stage.engaged_threads", *(["stage.load_sharing.thread_count"] if both else [])]

    def with_count(number):
        more: dict[str, Any] = {"load_sharing": LoadSharing(number)} if both else {}
        more |= {"sharing": "unstated"} if both else {}
        return _mechanism(roller, nut, width, engaged_threads=float(number), **more)

    errors = [f for f in _found(with_count(20)) if f.severity == "error"]
    assert errors
    for finding in errors:
        assert f"cannot be made; lower {' and '.join(keys)} to {count}, lower" in finding.message
    names = {NAME, "engaged_threads"}
    assert not names & {f.name for f in prsm.check(with_count(count))}
    assert names & {f.name for f in prsm.check(with_count(count + 1))}


def test_threads_of_two_nuts_are_not_all_on_one_roller():
    """Load sharing has the 40 threads of both nuts, the lengths may be those of one."""
    two = Strength(play=AxialPlay(preload_force=3e3, arrangement="double_nut"))
    one = Strength(play=AxialPlay(preload_force=3e3, arrangement="split_nut"))
    halves = LoadSharing(40, split_nut=SplitNut(20, preload=3e3))
    more: dict[str, Any] = {"load_sharing": halves, "sharing": "unstated"}
    assert not _found(_mechanism(40e-3, strength=two, **more))
    assert _found(_mechanism(40e-3, strength=one, **more))[0].value == pytest.approx(80e-3)


def test_an_optimum_has_room_for_its_threads():
    """The lead that 20 threads on 50 mm allow: 5 × 50 mm/20, less a micrometre of the length."""
    start = _mechanism(50e-3)
    best = optimise(start, {"lead": (5e-3, 20e-3)}, maximise="nut_speed")
    assert best.feasible
    lead = best.optimum.variables["lead"]
    assert 12.499e-3 < lead < 12.5e-3
    assert not _found(best.mechanism)
    json.dumps(best.to_dict(), allow_nan=False)


def test_rings_are_called_rings():
    """Ten rings of 6/3.222 mm."""
    one = prsm.set_parameter(scenes.example("ring_roller"), "roller.length", 15e-3)
    (found,) = _found(one)
    pitch = 6e-3 / 3.2222222222222223
    assert found.value == pytest.approx(10 * pitch, rel=1e-12)
    assert "10 rings (stage.engaged_threads)" in found.message


def _pointed(mechanism):
    return [f for f in prsm.check(mechanism) if f.name == "pointed_tooth"]


def _thinned(thinning):
    return AxialPlay(
        screw_tooth_thinning=thinning, roller_tooth_thinning=thinning, nut_tooth_thinning=thinning
    )


def _heights(half, flank, radius):
    """Where the flanks of teeth 2 half thick meet, found by bisection of their thickness."""

    def arc(y):
        return (
            half + np.sqrt(radius**2 - (y + radius * np.sin(flank)) ** 2) - radius * np.cos(flank)
        )

    top = radius * (1 - np.sin(flank))
    return half / np.tan(flank), top if arc(top) > 0 else root_between(arc, 0, top, xtol=1e-15)


@pytest.mark.parametrize(
    ("contact_angle", "radius", "thinning"),
    [(45.0, 5.6e-3, 0.0), (35.0, 4e-3, 0.0), (60.0, 3e-3, 0.08e-3), (45.0, 0.6e-3, 0.0)],
)
def test_teeth_are_no_higher_than_their_flanks(contact_angle, radius, thinning):
    """A pitch of 2 mm: half a millimetre from the middle of a tooth to its flank, less thinning."""
    play = _thinned(thinning)
    screw, roller = _heights(0.5e-3 - thinning / 2, np.radians(90 - contact_angle), radius)
    for factor, bodies in ((1 - 1e-6, []), (1 + 1e-6, ["screw", "roller", "nut"])):
        geometry = scenes.thread(
            contact_angle=np.radians(contact_angle),
            roller_profile_radius=radius,
            screw_addendum=screw * factor,
            roller_addendum=roller * factor,
        )
        found = _pointed(_mechanism(geometry=geometry, strength=Strength(play=play)))
        assert [(f.severity, f.impossible) for f in found] == [("error", True)] * len(bodies)
        for finding, body in zip(found, bodies, strict=True):
            limit = roller if body == "roller" else screw
            assert (finding.value, finding.limit) == pytest.approx(
                (limit * factor, limit), rel=1e-9
            )
            assert f"the flanks of the {body}'s teeth meet {1e3 * limit:.4g} mm" in finding.message


def test_an_addendum_of_two_pitches():
    """2 mm at a pitch of 1 mm and 45°: a quarter of the pitch is possible."""
    geometry = scenes.thread(lead=5e-3, screw_addendum=2e-3)
    found = _pointed(_mechanism(geometry=geometry))
    assert [f.limit for f in found] == pytest.approx([0.25e-3, 0.25e-3], rel=1e-12)
    assert "stage.thread.screw_addendum is 2 mm, but with a pitch of 1 mm" in found[0].message


def test_teeth_thinned_to_nothing_have_no_height():
    play = _thinned(1.1e-3)
    geometry = scenes.thread(screw_addendum=0.1e-3, roller_addendum=0.1e-3)
    found = _pointed(_mechanism(geometry=geometry, strength=Strength(play=play)))
    assert [f.limit for f in found] == [0.0] * 3


def test_an_optimum_has_teeth_that_exist():
    """The smallest lead for teeth 0.3 mm high at 45°: five pitches of four times this height."""
    start = _mechanism(geometry=scenes.thread(screw_addendum=0.3e-3))
    best = optimise(start, {"lead": (4e-3, 12e-3)}, minimise="nut_speed")
    assert best.feasible
    assert best.optimum.variables["lead"] == pytest.approx(5 * 4 * 0.301e-3, rel=1e-6)
    assert not _pointed(best.mechanism)


def test_two_numbers_of_threads_must_be_equal():
    both = _mechanism(engaged_threads=16.0, load_sharing=LoadSharing(20), sharing="unstated")
    (found,) = [f for f in prsm.check(both) if f.name == "engaged_threads"]
    assert found.message.startswith(
        "stage.engaged_threads is 16 and stage.load_sharing.thread_count 20, but they must be "
        "equal: capacities"
    )
