"""Errors of parts in a file: units, the way back, and what the verb prints."""

from typing import Any

import equinox as eqx
import jax
import numpy as np
import pytest
from error_scenes import LOAD, shared, stage_with

import prsm_jax as prsm
from prsm_jax import file
from prsm_jax.cli.verbs._contact import _lines_across as lines_across

# Of ten rollers, in micrometres.
_TABLES = """
[stage.load_sharing.part_errors]
nut_eccentricity = "8 um"
nut_tilt = "0.1 mrad"
nut_tilt_angle = "60 deg"
roller_diameter_deviation = ["1 um", 0, 0, "2 um", 0, "-2 um", "1 um", 0, "-1 um", "0 um"]

[stage.load_sharing.free_nut]
radial_load = "0.4 kN"
overturning_moment = "6 N m"
overturning_moment_angle = "45 deg"
"""


def _mechanism(tables=_TABLES) -> Any:
    text = file.example_text("actuator_load_sharing")
    return file.loads(text[: text.index("[stage.load_sharing.split_nut]")] + tables)


def test_units_and_the_way_back():
    mechanism = _mechanism()
    sharing = mechanism.stages[0].load_sharing
    errors, nut = sharing.part_errors, sharing.free_nut
    read = (errors.nut_eccentricity, errors.nut_tilt, errors.nut_tilt_angle, nut.radial_load)
    np.testing.assert_allclose(read, (8e-6, 1e-4, np.pi / 3, 400.0), rtol=1e-14)
    assert float(nut.overturning_moment) == 6.0
    np.testing.assert_allclose(errors.roller_diameter_deviation[3:6], (2e-6, 0.0, -2e-6))
    again = file.loads(file.dumps(mechanism))
    assert jax.tree.structure(again) == jax.tree.structure(mechanism)
    pairs = zip(jax.tree.leaves(again), jax.tree.leaves(mechanism), strict=True)
    assert all(np.allclose(a, b, rtol=1e-15, atol=0) for a, b in pairs)
    moved: Any = prsm.set_parameter(mechanism, "stage.1.load_sharing.part_errors.nut_tilt", 2e-4)
    assert float(moved.stages[0].load_sharing.part_errors.nut_tilt) == 2e-4


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (('"-1 um", "0 um"]', '"-1 um"]'), "roller_diameter_deviation has 9 numbers"),
        (('nut_tilt = "0.1 mrad"', ""), "nut_tilt_angle, but no nut_tilt"),
        (('"8 um"', '"8 N"'), "nut_eccentricity"),
    ],
)
def test_wrong_tables(changed, words):
    with pytest.raises(ValueError, match=words):
        _mechanism(_TABLES.replace(*changed))


def test_quantities_of_errors():
    """They are those of the distribution; equal rollers do not have them."""
    stage = stage_with({"nut_eccentricity": 5e-6})
    mechanism = prsm.Mechanism((stage,), prsm.mechanism.OperatingPoint(100.0, LOAD))
    found = shared(stage)
    names = ["roller_load_unbalance", "nut_radial_force", "largest_thread_load"]
    values = eqx.filter_jit(lambda m: prsm.compute(m, names))(mechanism)
    loads = np.asarray(found.nut.roller_load)
    assert float(values[names[0]][0]) == pytest.approx(loads.std() / loads.mean(), rel=1e-9)
    force = np.hypot(*np.asarray(found.nut_radial_force))
    assert float(values[names[1]][0]) == pytest.approx(force, rel=1e-9)
    largest = float(max(found.screw.forward.max(), found.nut.forward.max()))
    assert float(values[names[2]][0]) == pytest.approx(largest, rel=1e-9)
    equal = prsm.Mechanism((stage_with(),), mechanism.operating_point)
    with pytest.raises(prsm.MissingDataError, match="part_errors"):
        prsm.compute(equal, ["roller_load_unbalance"])
    # Rollers under unequal loads have unequal stiffnesses: no symmetric vibration.
    assert prsm.vibration.vibration_system(stage, _threads(stage, found)).symmetric is False


def test_printed_lines():
    """Vectors by their lengths, in the order of the table; a nut that is held has not moved."""
    numbers: dict[str, Any] = {
        "roller_load_unbalance": 0.25,
        "nut_radial_force_n": [-30.0, 40.0],
        "nut_overturning_moment_nm": [0.0, -2.5],
        "nut_displacement_m": [3e-6, 4e-6],
        "nut_lean_rad": [0.0, 1e-4],
    }
    printed = [(value, unit) for _, value, unit in lines_across(numbers)]
    assert printed[:3] == [(0.25, "1"), (50.0, "N"), (2.5, "N·m")]
    assert printed[3:] == [(pytest.approx(5e-6), "m"), (1e-4, "rad")]
    assert len(lines_across(numbers | {"nut_displacement_m": None})) == 3


def _threads(stage, found) -> Any:
    from prsm_jax.stiffness import thread_stiffness

    threads: Any = thread_stiffness(stage, lambda: found)
    np.testing.assert_allclose(threads.nut_each, found.nut.stiffness)
    return threads
