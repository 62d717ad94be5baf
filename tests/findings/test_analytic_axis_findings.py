"""The finding on the position loop of an axis: loop against anti-resonance, by closed forms."""

import numpy as np
import pytest
from scenes import example

import prsm_jax as prsm

_GAIN = "axis.motor.controller.proportional_gain"


def _found(gain):
    mechanism = prsm.set_parameter(example("actuator_axis"), _GAIN, gain)
    return [one for one in prsm.check(mechanism) if one.name == "position_loop"]


def test_the_position_loop_is_compared_with_the_first_anti_resonance():
    """The loop's frequency grows with √K_p; the anti-resonance does not see the motor."""
    names = ["position_loop_frequency", "antiresonance_frequency"]
    mechanism = example("actuator_axis")
    loop, held = (float(one) for one in prsm.compute(mechanism, names).values())
    gain = float(prsm.get_parameter(mechanism, _GAIN))
    # What the motor moves, by the file: rotor, screw; nut, rollers, carriers, load.
    screw = np.pi * 7850 * 0.5 * 0.012**2
    nut = np.pi * 7850 * 0.08 * (0.03**2 - 0.02**2) + 10 * np.pi * 7850 * 0.05 * 0.004**2
    nut += 2 * np.pi * 7850 * 0.004 * (0.019**2 - 0.013**2)
    inertia = 3e-3 + screw * 0.012**2 / 2 + (300 + nut) * (0.01 / (2 * np.pi)) ** 2
    assert loop == pytest.approx(np.sqrt(gain / inertia) / (2 * np.pi), rel=1e-12)
    assert held > 3 * loop
    assert _found(gain) == []
    for ratio, severity, words in (
        (2.9, "note", "differs from that of the motor"),
        (1.01, "note", "differs from that of the motor"),
        (0.99, "warning", "the controller holds the motor while the load vibrates"),
    ):
        (finding,) = _found(gain * (held / ratio / loop) ** 2)
        assert finding.severity == severity
        assert finding.value == pytest.approx(ratio, rel=1e-9)
        assert words in finding.message
        assert f"{held:.4g} Hz with the motor held, is {ratio:.2f} times" in finding.message
        assert f"position loop, {held / ratio:.4g} Hz, but should be 3 times" in finding.message
    assert _found(gain * (held / 3.01 / loop) ** 2) == []
