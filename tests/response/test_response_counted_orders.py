"""Excitation orders by counting on moving helicoids, with no formula for an order in sight.

Bodies are put into space as they move: the screw turns in its place, the nut slides by one lead
per turn without turning, and the rollers travel with the nut on a carrier that turns at any share
of the screw's speed. A roller's own spin follows from rolling in the nut. An observer sits where a
roller touches, moves with it, and counts what passes. Time is in turns of the screw.
"""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm
from prsm_jax.response import excitation_orders, find_order
from tests.present import present

_CRITICAL = "lowest_critical_speed"
#: Turns of the screw, enough for six digits: the time from the first to the last passing counts.
_TURNS = 40.0
_TIME = np.linspace(0.0, _TURNS, 400_001)


@dataclasses.dataclass(frozen=True)
class _Stage:
    """Plain numbers of a stage, and where its bodies are at the times `_TIME`."""

    screw_radius: float
    roller_radius: float
    starts: int
    lead: float
    rollers: int
    roller_teeth: int
    carrier_ratio: float

    @property
    def pitch(self):
        return self.lead / self.starts

    @property
    def ring_teeth(self):
        return round(self.roller_teeth * self.nut_radius / self.roller_radius)

    @property
    def nut_radius(self):
        return self.screw_radius + 2 * self.roller_radius

    @property
    def carrier_angle(self):
        return 2 * np.pi * self.carrier_ratio * _TIME

    @property
    def travel(self):
        """Axial position of nut and rollers."""
        return -self.lead * _TIME

    @property
    def roller_angle(self):
        """The roller's point at the nut stands still: a ω + r_R ω_R = 0 in space."""
        centre = self.screw_radius + self.roller_radius
        return -centre / self.roller_radius * self.carrier_angle

    def observer(self, angle, radius):
        """A point that moves with a roller, at an angle of the carrier, about the screw's axis."""
        turned = self.carrier_angle + angle
        return radius * np.cos(turned), radius * np.sin(turned), self.travel


def _seen_from(point, angle, travel, axis=(0.0, 0.0)):
    """Cylindrical coordinates of a point in a body that has turned and travelled."""
    x, y, z = point[0] - axis[0], point[1] - axis[1], point[2]
    turned = np.arctan2(y, x) - angle
    return np.hypot(x, y), turned, z - travel


def _threads_above(point, angle, travel, lead, starts, axis=(0.0, 0.0)):
    """Height over the first flank of a helicoid z = (lead/2π) θ + k lead/starts, in pitches."""
    _, theta, z = _seen_from(point, angle, travel, axis)
    return (z - lead * theta / (2 * np.pi)) * starts / lead


def _passings(signal):
    """Times at which a signal rises through zero."""
    rises = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    step = signal[rises] / (signal[rises] - signal[rises + 1])
    return _TIME[rises] + step * (_TIME[1] - _TIME[0])


def _per_turn(signal):
    """Passings per turn of the screw."""
    times = _passings(signal)
    assert len(times) > 8
    return (len(times) - 1) / (times[-1] - times[0])


def _thread_signal(stage, angle=0.0):
    """The screw's threads at the contact: a wave that is zero twice per pitch."""
    point = stage.observer(angle, stage.screw_radius)
    above = _threads_above(point, 2 * np.pi * _TIME, 0.0, stage.lead, stage.starts)
    return np.sin(2 * np.pi * above)


def _start_signal(stage, angle=0.0, body="screw"):
    """A wave that is zero twice while each of the starts, told apart by number, passes once."""
    if body == "screw":
        point, turned = stage.observer(angle, stage.screw_radius), 2 * np.pi * _TIME
        above = _threads_above(point, turned, 0.0, stage.lead, stage.starts)
    else:
        point = stage.observer(angle, stage.nut_radius)
        above = _threads_above(point, 0.0, stage.travel, stage.lead, stage.starts)
    return np.sin(2 * np.pi * above / stage.starts)


def _screw_runout(stage, angle=0.0):
    """How far an axis that is off by one along the screw's own x points at the roller."""
    x, y, _ = stage.observer(angle, 1.0)
    return np.cos(2 * np.pi * _TIME) * x + np.sin(2 * np.pi * _TIME) * y


def _nut_runout(stage, angle=0.0):
    x, _, _ = stage.observer(angle, 1.0)
    return x


def _gear_signal(stage, angle=0.0):
    """Teeth of the ring gear, which does not turn, at the roller."""
    point = stage.observer(angle, stage.nut_radius)
    return np.sin(stage.ring_teeth * np.arctan2(point[1], point[0]))


def _flaw_signal(stage, turned):
    """A flaw of one degree on a body: above zero while any of the rollers is on it."""
    signal = np.full_like(_TIME, -1.0)
    for index in range(stage.rollers):
        off = stage.carrier_angle + 2 * np.pi * index / stage.rollers - turned
        signal = np.maximum(signal, np.cos(off) - np.cos(np.radians(1.0)))
    return signal


COUNTED = {
    "carrier": _nut_runout,
    "deviating_start": _start_signal,
    "screw_rotation": _screw_runout,
    "roller_passing_nut": lambda stage: _flaw_signal(stage, 0.0),
    "roller_passing_screw": lambda stage: _flaw_signal(stage, 2 * np.pi * _TIME),
    "thread_passing": _thread_signal,
    "ring_gear_mesh": _gear_signal,
}
#: Those with one pattern at each roller, whose phase tells the number of periods around the screw.
PHASED = ("carrier", "deviating_start", "screw_rotation", "thread_passing", "ring_gear_mesh")


def _scene(carrier_ratio):
    """Wu's stage: plain numbers of its file, and its excitations at this carrier ratio."""
    stage = example("wu2022").stages[0]
    thread = stage.thread
    plain = _Stage(
        screw_radius=float(thread.screw_radius),
        roller_radius=float(thread.roller_radius),
        starts=round(float(thread.starts)),
        lead=float(thread.lead),
        rollers=stage.roller_count,
        roller_teeth=round(float(present(stage.gear.roller_teeth))),
        carrier_ratio=carrier_ratio,
    )
    return plain, excitation_orders(stage, jnp.asarray(carrier_ratio))


# Ideal rolling, and a carrier that slips.
@pytest.fixture(scope="module", params=[0.375, 0.3421])
def scene(request):
    return _scene(request.param)


@pytest.mark.parametrize("name", COUNTED)
def test_order_is_what_passes_per_turn(scene, name):
    stage, orders = scene
    order = find_order(orders, name)
    # Passings are located by a straight line between samples 1e-4 turns apart.
    assert float(order.order) == pytest.approx(_per_turn(COUNTED[name](stage)), rel=1e-5)


def test_every_order_is_counted(scene):
    _, orders = scene
    assert {order.name for order in orders} == set(COUNTED)


@pytest.mark.parametrize("name", PHASED)
def test_lobes_are_the_delay_from_roller_to_roller(scene, name):
    """A roller a little further on sees the same, earlier or later by lobes · angle."""
    stage, orders = scene
    order = find_order(orders, name)
    angle = 1e-3
    here, there = _passings(COUNTED[name](stage)), _passings(COUNTED[name](stage, angle))
    delay = there[5] - here[5]
    periods = abs(delay) * float(order.order)
    assert periods == pytest.approx(float(order.lobes) * angle / (2 * np.pi), rel=1e-3)


def test_lobes_of_the_screws_section_pass_with_the_threads(scene):
    """The section of the screw in the rollers' plane stands still in space.

    Seen from the rollers its lobes therefore pass n times per turn of the carrier, not n times per
    turn of the screw against it.
    """
    stage, orders = scene

    def radius(angle):
        """The screw's surface in the plane of the rollers, in a direction of space."""
        point = (np.cos(angle), np.sin(angle), stage.travel)
        above = _threads_above(point, 2 * np.pi * _TIME, 0.0, stage.lead, stage.starts)
        return stage.screw_radius + 0.1 * stage.pitch * np.sin(2 * np.pi * above)

    still = radius(np.full_like(_TIME, 0.3))
    # 40 turns of 10 mm, in rounding of the position.
    np.testing.assert_allclose(still, still[0], rtol=1e-11)
    counted = _per_turn(radius(stage.carrier_angle) - stage.screw_radius)
    assert float(find_order(orders, "screw_starts").order) == pytest.approx(counted, rel=1e-5)
    assert find_order(orders, "screw_starts").name == "thread_passing"


def test_one_start_of_the_nut_deviates(scene):
    stage, orders = scene
    counted = _per_turn(_start_signal(stage, body="nut"))
    assert float(find_order(orders, "deviating_start").order) == pytest.approx(counted, rel=1e-5)


def test_the_rollers_threads_and_teeth_keep_step(scene):
    """The spin that follows from rolling lets the roller's own threads and teeth pass as often."""
    stage, orders = scene
    centre = stage.observer(0.0, stage.screw_radius + stage.roller_radius)[:2]
    point = stage.observer(0.0, stage.screw_radius)
    above = _threads_above(point, stage.roller_angle, stage.travel, stage.pitch, 1, centre)
    counted = _per_turn(np.sin(2 * np.pi * above))
    assert float(find_order(orders, "thread_passing").order) == pytest.approx(counted, rel=1e-5)
    pitch_point = stage.observer(0.0, stage.nut_radius)
    _, theta, _ = _seen_from(pitch_point, stage.roller_angle, stage.travel, centre)
    counted = _per_turn(np.sin(stage.roller_teeth * theta))
    assert float(find_order(orders, "ring_gear_mesh").order) == pytest.approx(counted, rel=1e-5)


def test_a_ring_gear_of_another_number_of_teeth_meshes_at_its_own_order():
    """The carrier passes all teeth of the ring gear in each of its turns, whatever the rollers'."""
    mechanism = example("wu2022")
    (stage,) = mechanism.stages
    gear = dataclasses.replace(present(stage.gear), ring_teeth=jnp.asarray(77.0))
    other = dataclasses.replace(stage, gear=gear)
    mesh = find_order(excitation_orders(other, 0.375), "ring_gear_mesh")
    assert (float(mesh.order), float(mesh.lobes)) == (77 * 0.375, 77.0)
    speeds = [
        float(prsm.compute(dataclasses.replace(mechanism, stages=(one,)), [_CRITICAL])[_CRITICAL])
        for one in (stage, other)
    ]
    teeth = float(present(present(stage.gear).roller_teeth) * stage.thread.starts)
    # The gear's stiffness hardly depends on the teeth of the ring, and the modes less.
    assert speeds[1] / speeds[0] == pytest.approx(teeth / 77, rel=2e-3)
