"""Global sensitivities of Ishigami's function and of a linear one, against their closed forms."""

import dataclasses
import json
import math

import numpy as np
import pytest
from uncertainty_scenes import MECHANISM, TOLERANCES

import prsm_jax as prsm
from prsm_jax.uncertainty import active_subspace, morris, sobol_indices

ISHIGAMI, LINEAR, PAIR = "uncertainty_ishigami", "uncertainty_linear", "uncertainty_pair"
PI = math.pi
RANGES = {
    "speed": (100 - PI, 100 + PI),
    "load": (5000 - PI, 5000 + PI),
    "lead": ((10 - PI) * 1e-3, (10 + PI) * 1e-3),
}


def test_sobol_indices_of_ishigami():
    """Variances of sin u + 7 sin² v + 0.1 w⁴ sin u for u, v, w uniform in ±π."""
    a, b = 7.0, 0.1
    alone = (0.5 * (1 + b * PI**4 / 5) ** 2, a**2 / 8, 0.0)
    both = 8 / 225 * b**2 * PI**8
    whole = sum(alone) + both
    found = sobol_indices(MECHANISM, [ISHIGAMI], RANGES, samples=2048)
    first, total = found.of("first_order", ISHIGAMI), found.of("total_order", ISHIGAMI)
    expected = ((alone[0] + both) / whole, alone[1] / whole, both / whole)
    for index, name in enumerate(RANGES):
        # The 95 % intervals of 2048 samples are 0.02 to 0.06.
        assert first[name] == pytest.approx(alone[index] / whole, abs=0.03)
        assert total[name] == pytest.approx(expected[index], abs=0.03)
        assert 0 < found.of("total_order_interval", ISHIGAMI)[name] < 0.1


def test_sobol_indices_of_normal_tolerances_are_the_contributions():
    """3 + 2x − 4y + z with equal variances of all terms, from the tolerances of the mechanism."""
    mechanism = dataclasses.replace(MECHANISM, tolerances=TOLERANCES)
    found = sobol_indices(mechanism, [LINEAR], samples=1024)
    for measure in ("first_order", "total_order"):
        assert list(found.of(measure, LINEAR).values()) == pytest.approx([1 / 3] * 3, abs=0.03)
    assert json.loads(json.dumps(found.to_dict()))["parameters"] == list(found.parameters)
    assert "first order" in found.text()


def test_morris_of_a_linear_quantity_is_exact():
    """Whole ranges of 0.6 mm, 0.3 rad and 1.2 kN with slopes 2, −4 and 1."""
    mechanism = dataclasses.replace(MECHANISM, tolerances=TOLERANCES)
    found = morris(mechanism, [LINEAR], trajectories=8)
    names = [one.name for one in TOLERANCES]
    assert found.of("mean", LINEAR) == pytest.approx(
        dict(zip(names, (1.2, -1.2, 1.2), strict=True)), rel=1e-9
    )
    assert found.of("mean_absolute", LINEAR) == pytest.approx(dict.fromkeys(names, 1.2), rel=1e-9)
    assert max(found.of("standard_deviation", LINEAR).values()) < 1e-9


def test_active_subspace_of_a_linear_quantity():
    """Standardised slopes 0.2, −0.2 and 0.2: one direction, with the eigenvalue 0.12."""
    mechanism = dataclasses.replace(MECHANISM, tolerances=TOLERANCES)
    found = active_subspace(mechanism, [LINEAR], samples=16)
    assert found.eigenvalues is not None
    assert found.directions is not None
    assert found.eigenvalues[0] == pytest.approx([0.12, 0.0, 0.0], abs=1e-12)
    first = found.directions[0, :, 0]
    assert first * np.sign(first[0]) == pytest.approx(np.array([1.0, -1.0, 1.0]) / 3**0.5, rel=1e-9)
    assert list(found.of("activity", LINEAR).values()) == pytest.approx([0.04] * 3, rel=1e-9)


def test_activity_of_ishigami():
    """E[(7 sin 2v)²] π²/3 = 49/2 · π²/3 for the standardised v."""
    found = active_subspace(MECHANISM, [ISHIGAMI], RANGES, samples=1024)
    # A smooth mean over 1,024 Sobol points: an error of about 1/N.
    assert found.of("activity", ISHIGAMI)["load"] == pytest.approx(24.5 * PI**2 / 3, rel=1e-3)


@pytest.mark.parametrize("method", [sobol_indices, morris, active_subspace])
def test_what_is_wrong_is_said(method):
    with pytest.raises(ValueError, match="designs fail, and the method needs all of them"):
        method(MECHANISM, [PAIR], RANGES)
    with pytest.raises(ValueError, match="range of 'lead' is 3; give"):
        method(MECHANISM, [LINEAR], {"lead": 3})
    with pytest.raises(ValueError, match="give a list of names"):
        method(MECHANISM, LINEAR, RANGES)
    with pytest.raises(ValueError, match="the mechanism has no tolerances"):
        method(MECHANISM, [LINEAR])


@pytest.mark.parametrize("method", [sobol_indices, morris, active_subspace])
def test_a_range_of_different_stages_is_refused(method):
    two = prsm.load("li2021_two_stage")
    for stage, lead in ((1, 5e-3), (2, 15e-3)):
        two = prsm.set_parameter(two, f"stage.{stage}.thread.lead", lead)
    words = "'lead': .* differs between the stages .0.005, 0.015.; name the stage: stage.1.thread"
    with pytest.raises(ValueError, match=words):
        method(two, ["nut_speed"], {"lead": (9e-3, 11e-3)})


def test_a_range_of_one_of_two_stages_is_that_of_the_number():
    """In series the nut moves by both leads: 2 mm per turn over the range of one."""
    two = prsm.load("li2021_two_stage")
    two = prsm.set_parameter(two, "stage.1.thread.lead", 5e-3)
    found = morris(
        two, ["nut_speed"], {"stage.2.thread.lead": (9e-3, 11e-3)}, trajectories=4, speed=2 * PI
    )
    mean = found.of("mean", "nut_speed")["stage.2.thread.lead"]
    assert abs(mean) == pytest.approx(2e-3, rel=1e-9)


def test_odd_levels_are_refused():
    with pytest.raises(ValueError, match="levels is 3; it must be an even number"):
        morris(MECHANISM, [LINEAR], RANGES, levels=3)
