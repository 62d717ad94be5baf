"""Excitation orders of inverted, recirculating and differential roller screws by counting.

As in `test_response_counted_orders.py`, bodies are put into space as they move, and an observer
that moves with a roller counts what passes. Time is in turns of the body that turns.
"""

import jax.numpy as jnp
import numpy as np
import pytest
from scenes import example

from prsm_jax.response import excitation_orders, find_order

_TIME = np.linspace(0.0, 40.0, 400_001)
EXAMPLES = {
    "inverted": "humanoid_leg",
    "recirculating": "recirculating_stage",
    "differential": "differential_stage",
}


class _Moving:
    """Angles and axial places of screw, nut and rollers at all times."""

    def __init__(self, kind, ratio):
        self.stage = example(EXAMPLES[kind]).stages[0]
        thread = self.stage.thread
        self.lead, self.starts = float(thread.lead), round(float(thread.starts))
        self.rollers = self.stage.roller_count
        self.carrier = 2 * np.pi * ratio * _TIME
        turned, still = 2 * np.pi * _TIME, np.zeros_like(_TIME)
        advance = -self.lead * _TIME
        if kind == "inverted":
            # The screw moves along the axis, and the rollers with it.
            self.angles, places = {"screw": still, "nut": turned}, {"screw": advance, "nut": still}
            self.along, self.turning, self.held = advance, "nut", "screw"
        else:
            self.angles, places = {"screw": turned, "nut": still}, {"screw": still, "nut": advance}
            # Grooves of a roller do not advance in its own frame: contacts keep their place.
            self.along = advance * (1 - ratio)
            self.turning, self.held = "screw", "nut"
            if kind == "differential":
                places["nut"] = self.along
        self.places = places
        #: Bodies with a thread.
        self.threaded = ("screw",) if kind == "differential" else ("screw", "nut")
        self.orders = excitation_orders(self.stage, jnp.asarray(ratio))

    def threads(self, body):
        """Pitches between the roller's contact and a thread of a body."""
        turned = (self.carrier - self.angles[body]) / (2 * np.pi)
        return ((self.along - self.places[body]) / self.lead - turned) * self.starts

    def runout(self, body):
        """How far an axis that is off by one along the body's own x points at the roller."""
        return np.cos(self.carrier - self.angles[body])

    def flaw(self, body):
        """Above zero while any of the rollers is on a flaw of one degree."""
        signal = np.full_like(_TIME, -1.0)
        for index in range(self.rollers):
            off = self.carrier + 2 * np.pi * index / self.rollers - self.angles[body]
            signal = np.maximum(signal, np.cos(off) - np.cos(np.radians(1.0)))
        return signal


def _per_turn(signal):
    """Passings per turn, from the first to the last."""
    rises = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    step = signal[rises] / (signal[rises] - signal[rises + 1])
    times = _TIME[rises] + step * (_TIME[1] - _TIME[0])
    assert len(times) > 8
    return (len(times) - 1) / (times[-1] - times[0])


@pytest.fixture(scope="module", params=[(k, r) for k in EXAMPLES for r in (0.583, 0.41)])
def moving(request):
    return _Moving(*request.param)


def test_order_is_what_passes_per_turn(moving):
    counted = {
        "carrier": moving.runout(moving.held),
        f"{moving.turning}_rotation": moving.runout(moving.turning),
        "roller_passing_nut": moving.flaw("nut"),
        "roller_passing_screw": moving.flaw("screw"),
    }
    if moving.turning == "nut":
        for body in ("screw", "nut"):
            threads = moving.threads(body)
            counted["thread_passing"] = np.sin(2 * np.pi * threads)
            counted["deviating_start"] = np.sin(2 * np.pi * threads / moving.starts)
            for name in ("thread_passing", "deviating_start"):
                found = float(find_order(moving.orders, name).order)
                assert found == pytest.approx(_per_turn(counted[name]), rel=1e-5)
        # 80 teeth on a screw that does not turn.
        teeth = moving.starts * 16
        counted["screw_gear_mesh"] = np.sin(teeth * (moving.carrier - moving.angles["screw"]))
    else:
        for body in moving.threaded:
            # 40 turns, in rounding of the position.
            threads = moving.threads(body)
            assert np.abs(threads - threads[0]).max() < 1e-10
    assert {order.name for order in moving.orders} == set(counted)
    for name, signal in counted.items():
        # Passings are located by a straight line between samples 1e-4 turns apart.
        expected = _per_turn(signal)
        assert float(find_order(moving.orders, name).order) == pytest.approx(expected, rel=1e-5)


def test_contacts_of_an_order_are_those_of_its_body(moving):
    springs = {order.name: order.springs for order in moving.orders}
    turning, held = (f"{side}_roller" for side in (moving.turning, moving.held))
    assert springs["carrier"] == (held,)
    assert springs[f"{moving.turning}_rotation"] == (turning,)
    assert springs["roller_passing_nut"] == ("nut_roller",)
    assert springs["roller_passing_screw"] == ("screw_roller",)
    assert springs.get("screw_gear_mesh", ("screw_roller",)) == ("screw_roller",)
