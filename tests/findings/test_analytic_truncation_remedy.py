"""What the finding contact_truncation says of other results, and whether its remedy is enough."""

import re

import equinox as eqx
import numpy as np
import pytest
from truncation_scenes import screw_of_30_mm, without_addenda

import prsm_jax as prsm
from prsm_jax.mechanism import Strength

_RAISE = re.compile(r"raise stage\.thread\.(\w+) from ([\d.]+) to ([\d.]+) mm")
_TOO_HIGH = re.compile(
    r"([\d.]+) mm of stage\.thread\.(\w+) .* flanks of a tooth end at ([\d.]+) mm"
)
#: Of a pitch of 1 mm at 45°, in millimetres: p/4 for straight flanks, less for the rollers' arcs of
#: ρ = 5 mm/sin 45°, √(ρ² − (5 − 1/4)²) − 5.
_POINTS = {"screw_addendum": 0.25, "roller_addendum": np.sqrt(50 - 4.75**2) - 5}


def _found(mechanism):
    return [f for f in prsm.check(mechanism) if f.name == "contact_truncation"]


def _raised(mechanism, found):
    """The mechanism with the addenda that the findings ask for, and these addenda [mm]."""
    wanted: dict[str, float] = {}
    for finding in found:
        read = _RAISE.search(finding.message)
        assert read is not None, finding.message
        name, now, proposed = read[1], float(read[2]), float(read[3])
        assert proposed > now
        assert proposed <= _POINTS[name]
        assert len(read[3].strip("0.")) <= 6
        wanted[name] = max(wanted.get(name, 0.0), proposed)
    for name, value in wanted.items():
        mechanism = prsm.set_parameter(mechanism, name, value * 1e-3)
    return mechanism, wanted


_STRENGTHS = {
    "given": {"static_capacity": 120e3, "dynamic_capacity": 50e3},
    "derived": {"permissible_pressure": 2.9e9, "material_factor": 0.6},
    "balls": {
        "static_capacity": 120e3,
        "material_factor": 0.6,
        "fatigue_rule": "equivalent_balls",
    },
    "static derived": {"permissible_pressure": 2.9e9, "dynamic_capacity": 50e3},
    "pressures alone": {},
}


def _scene(kind, addendum=0.1):
    return screw_of_30_mm(5e-3, addendum=addendum, strength=Strength(**_STRENGTHS[kind]))


@pytest.mark.parametrize("kind", ["given", "derived"])
def test_one_step_is_enough(kind):
    """Capacities that follow from contacts grow with the addenda, and with them the ellipses."""
    scene = _scene(kind)
    found = _found(scene)
    assert found
    raised, wanted = _raised(scene, found)
    assert set(wanted) == {"screw_addendum", "roller_addendum"}
    assert not {"contact_truncation", "pointed_tooth"} & {f.name for f in prsm.check(raised)}
    # Not more than needed: a hundredth less is too low.
    for name, value in wanted.items():
        assert _found(prsm.set_parameter(raised, name, 0.99e-3 * value))


def test_an_addendum_that_is_nearly_enough_is_raised():
    """From 0.1 µm to 1 µm below what is needed, where three digits of both are often the same."""
    scene, wanted = _raised(_scene("given"), _found(_scene("given")))
    name = "roller_addendum"
    # The end of the range in which there is a finding.
    low, high = 0.9 * wanted[name], wanted[name]
    for _ in range(24):
        middle = (low + high) / 2
        cut = _found(prsm.set_parameter(scene, name, middle * 1e-3))
        low, high = (middle, high) if cut else (low, middle)
    for below in (1e-4, 3e-4, 1e-3):
        nearly = prsm.set_parameter(scene, name, (low - below) * 1e-3)
        found = _found(nearly)
        assert found
        assert not _found(_raised(nearly, found)[0])


def test_no_addendum_beyond_the_point_of_a_tooth():
    """At 5 GPa crests would have to be higher than pointed teeth are."""
    scene = screw_of_30_mm(5e-3, addendum=0.2, strength=Strength(permissible_pressure=5e9))
    found = _found(scene)
    assert found
    for finding in found:
        read = _TOO_HIGH.search(finding.message)
        assert read is not None, finding.message
        assert "Remedy: raise the pitch, engage more threads" in finding.message
        assert float(read[3]) == pytest.approx(_POINTS[read[2]], rel=1e-3)
        assert float(read[1]) > _POINTS[read[2]]


@pytest.mark.parametrize("kind", _STRENGTHS)
def test_the_finding_names_the_results_that_include_the_truncation(kind):
    """They, and they alone, are other than those of flanks without ends."""
    scene = _scene(kind) if kind != "pressures alone" else _scene(kind, addendum=0.08)
    (sentence, *_) = {re.split(r"\)\. |\. Remedy", f.message)[1] for f in _found(scene)}
    included, left_out = sentence.split(" take this into account, but not ")
    assert left_out.endswith("the concentration of pressure at the edge")
    known = {
        "static_capacity": ("static capacity", kind != "pressures alone"),
        "dynamic_capacity": ("dynamic capacity", kind != "pressures alone"),
        "rating_life": ("life", kind != "pressures alone"),
        # Under a load that cuts the ellipse.
        "max_pressure": ("pressures", True),
    }
    loaded = eqx.tree_at(lambda m: m.operating_point.load, scene, 200e3 * np.ones(()))
    names = [name for name, (_, given) in known.items() if given]
    values = [prsm.compute(one, names) for one in (loaded, without_addenda(loaded))]
    for name in names:
        words = known[name][0]
        changed = not np.allclose(values[0][name], values[1][name], rtol=1e-9, atol=0)
        both = included.replace("Capacities", "static capacity, dynamic capacity").lower()
        assert (words in both) == changed, (name, sentence)
        left = left_out.replace("given capacities", "static capacity, dynamic capacity")
        if words != "pressures":
            assert (words in left.replace("given ", "")) == (not changed), (name, sentence)
