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
        assert "Remedy: raise the pitch, or lower stage.strength.permissible" in finding.message
        assert float(read[3]) == pytest.approx(_POINTS[read[2]], rel=1e-3)
        assert float(read[1]) > _POINTS[read[2]]


_LOWER = re.compile(
    r"lower stage\.strength\.permissible_pressure from ([\d.]+) to ([\d.]+) GPa, and with it"
)
_ADDENDUM = re.compile(r"raise stage\.thread\.\w+ from [\d.]+ to [\d.]+ mm")
_THREADS, _LOAD = "engage more threads or rollers", "lower the load"


def _remedies(found):
    """Remedies of the findings, the addenda that each begins with left out."""
    sentences = [f.message.split("Remedy: ")[1] for f in found]
    assert sentences
    assert all(_ADDENDUM.match(one) for one in sentences)
    return [_ADDENDUM.sub("", one, count=1).strip(", ") for one in sentences]


def _with_threads(scene, factor):
    return eqx.tree_at(
        lambda m: m.stages[0].engaged_threads, scene, factor * scene.stages[0].engaged_threads
    )


def _with_load(scene, load):
    return eqx.tree_at(lambda m: m.operating_point.load, scene, load * np.ones(()))


@pytest.mark.parametrize("pressure", [2.9e9, 4.2e9])
def test_at_a_derived_static_capacity_only_the_pressure_shortens_the_ellipse(pressure):
    """The ellipse at a given Hertz pressure is the same for any number of threads and any load."""
    scene = screw_of_30_mm(5e-3, addendum=0.1, strength=Strength(permissible_pressure=pressure))
    found, remedies = _found(scene), []
    for finding in found:
        assert _THREADS not in finding.message
        assert _LOAD not in finding.message
        read = _LOWER.search(finding.message)
        assert read is not None, finding.message
        assert float(read[1]) == pytest.approx(pressure * 1e-9)
        remedies.append(float(read[2]) * 1e9)
    for changed in (_with_threads(scene, 3.0), _with_load(scene, 1e3)):
        same = _found(changed)
        np.testing.assert_allclose([f.value for f in same], [f.value for f in found], rtol=1e-9)
    cured = prsm.set_parameter(scene, "permissible_pressure", min(remedies))
    assert not _found(cured)
    # No lower than needed: three digits.
    assert _found(prsm.set_parameter(scene, "permissible_pressure", 1.01 * min(remedies)))


@pytest.mark.parametrize("fatigue_rule", ["equivalent_balls", "lundberg_palmgren"])
def test_at_a_derived_dynamic_capacity_only_the_thread_is_named(fatigue_rule):
    """The capacity grows with the number of threads: three times as many change the cut little."""
    data = Strength(material_factor=0.6, fatigue_rule=fatigue_rule)
    scene = screw_of_30_mm(5e-3, addendum=0.08, load=1e3, strength=data)
    assert set(_remedies(_found(scene))) == {""}
    assert _found(_with_load(scene, 100.0))
    assert _found(_with_threads(scene, 2.0))
    assert not _found(_raised(scene, _found(scene))[0])


def test_at_given_capacities_more_threads_help_and_a_lower_load_does_not():
    scene = _scene("given")
    assert set(_remedies(_found(scene))) == {f"or {_THREADS}"}
    assert _found(_with_load(scene, 100.0))
    assert not _found(_with_threads(scene, 10.0))


def test_under_a_load_more_threads_and_a_lower_load_help():
    scene = _with_load(_scene("pressures alone"), 200e3)
    assert set(_remedies(_found(scene))) == {f"{_THREADS}, or {_LOAD}"}
    assert not _found(_with_load(scene, 1e3))
    assert not _found(_with_threads(scene, 20.0))


def test_a_load_beside_a_capacity_is_named_for_what_it_is():
    """Neither a lower load nor more threads shorten the ellipse at the static capacity."""
    data = Strength(permissible_pressure=2.9e9)
    scene = screw_of_30_mm(5e-3, addendum=0.08, load=150e3, strength=data)
    for remedy in _remedies(_found(scene)):
        assert remedy == (
            "(more engaged threads or rollers, or a lower load, would help at the operating load "
            "and the largest load only)"
        )
    assert {f.message.count("at the operating load of 150 kN") for f in _found(scene)} == {1}
    assert _found(_with_load(_with_threads(scene, 20.0), 1e3))


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
