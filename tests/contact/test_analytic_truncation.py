"""Ellipses longer than the flank, against direct integration over laminae and ellipses."""

import re

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from laminae import lamina_load, lamina_risk, pressure_ratio_by_bisection, sides_of
from scenes import array, example, mechanism, mesh, stage, stage_contact, thread
from scipy.integrate import quad
from truncation_scenes import screw_of_30_mm, without_addenda

import prsm_jax as prsm
from benchmarks.references.meshing import Design
from benchmarks.references.truncated import contact_pressure, hertz_pressure
from prsm_jax import strength
from prsm_jax.contact import (
    contact_frames,
    half_extent,
    hertz_contact,
    load_beyond,
    pressure_ratio,
    risk_beyond,
    risk_ratio,
    share_within,
    truncation,
)
from prsm_jax.geometry import flank_ends, flanks_end
from prsm_jax.halfspace import flank_contact, tangent_plane
from prsm_jax.mechanism import LoadSharing, ScrewShaft, Strength, ThreadTooth
from tests.present import present
from tests.roots import root_between

_compute = eqx.filter_jit(prsm.compute)


@pytest.mark.parametrize("reach", [-0.6, 0.0, 0.3, 0.7, 0.99])
def test_shares_beyond_a_line_are_those_of_the_laminae(reach):
    np.testing.assert_allclose(load_beyond(array(reach)), lamina_load(reach), rtol=1e-12)
    # Quadrature of 1e-13 over a part that may be 1e-9 of the whole.
    np.testing.assert_allclose(risk_beyond(array(reach)), lamina_risk(reach), atol=1e-13)


@pytest.mark.parametrize("reaches", [(0.7, 2.0), (0.9, 0.5), (0.28, 0.28), (1.05, 0.2), (0.05, 3)])
def test_pressure_risk_and_load_are_those_of_laminae_at_one_approach(reaches):
    pressure, onsets = array(2e9), tuple(array(2e9 * t) for t in reaches)
    ratio = pressure_ratio_by_bisection(reaches)
    np.testing.assert_allclose(pressure_ratio(pressure, onsets), ratio, rtol=1e-11)
    kept = 1 - sum(lamina_risk(min(t / ratio, 1.0)) for t in reaches)
    np.testing.assert_allclose(risk_ratio(pressure, onsets), ratio**10 * kept, rtol=1e-9)
    # At the pressure that results, the load is the one that was given.
    within = share_within(pressure * ratio, onsets)
    np.testing.assert_allclose(within * ratio**3, 1, rtol=1e-12)
    np.testing.assert_allclose(truncation(pressure, onsets), max(0, 1 - min(reaches)), rtol=1e-14)


def test_a_whole_ellipse_is_hertz_exactly():
    onsets = array(3e9), array(2.5e9)
    for pressure in (0.0, 1e3, 2.5e9):
        found = array(pressure)
        assert float(pressure_ratio(found, onsets)) == 1.0
        assert float(risk_ratio(found, onsets)) == 1.0
        assert float(share_within(found, onsets)) == 1.0
        assert float(truncation(found, onsets)) == 0.0


def _nearest(one, plane, end, size):
    """Nearest point of an end in the tangent plane, by rays: distance and direction."""
    thread, grows = one.thread, end.kind == "crest"
    nominal = float(getattr(thread, f"{end.body}_radius"))
    add = float(thread.roller_addendum if end.body == "roller" else thread.screw_addendum)
    limit = nominal + (add if grows != (end.body == "nut") else -add)
    centre = float(thread.centre_distance) if end.body == "roller" else 0.0
    origin, major, minor = (np.asarray(v) for v in (plane.origin, plane.major, plane.minor))

    def beyond(distance, angle):
        foot = origin + distance * (np.cos(angle) * major + np.sin(angle) * minor)
        return np.hypot(foot[0] - centre, foot[1]) - limit

    best = (np.inf, 0.0)
    for angle in np.linspace(0, 2 * np.pi, 721):
        if beyond(0.0, angle) * beyond(size, angle) < 0:
            best = min(best, (root_between(beyond, 0.0, size, args=(angle,)), angle))
    return best


@pytest.mark.parametrize("lead", [5e-3, 20e-3])
def test_ends_and_extents_are_those_in_the_tangent_plane(lead):
    """By rays over the plane, and the ellipse's support by its points; no formula in common."""
    one = screw_of_30_mm(lead).stages[0]
    meshing = mesh(one.thread)
    for hertz, frame, ends, side in sides_of(one, 6e5):
        assert {(e.kind, e.body) for e in ends} == {("crest", side), ("crest", "roller")}
        assert {e.way for e in ends} == {"to_roller_axis", "from_roller_axis"}
        plane = tangent_plane(one.thread, meshing, side)
        for end in ends:
            distance, angle = _nearest(one, plane, end, 5 * float(end.distance))
            # The end bends by half its distance over the body's radius, which is above 5 mm.
            np.testing.assert_allclose(end.distance, distance, rtol=float(end.distance) / 5e-3)
            turn = np.linspace(0, 2 * np.pi, 20001)
            ellipse = float(hertz.semi_major) * np.cos(turn), float(hertz.semi_minor) * np.sin(turn)
            support = np.max(ellipse[0] * np.cos(angle) + ellipse[1] * np.sin(angle))
            # The end turns by the same angle along it, and the ellipse is not round.
            bend = float(end.distance) / 5e-3
            np.testing.assert_allclose(
                half_extent(hertz, frame.curvature, end), support, rtol=2e-3 + 0.03 * bend
            )


def test_roots_lie_as_far_inwards_as_crests_of_the_same_height_outwards():
    """Lengths on a flank are in proportion to differences of radii: r − h, r + h and r + 2h."""
    height = 0.1e-3

    def distances(crest):
        # Rollers half as high again, so that nobody's height serves for another.
        tooth = ThreadTooth(*(array(x) for x in (8e-4, height, 1.5 * height, height)))
        one = stage(
            geometry=thread(5e-3, 5e-3, screw_addendum=crest, roller_addendum=1.5 * crest),
            load_sharing=LoadSharing(20, tooth=tooth),
        )
        ends = [end for side in flank_ends(one, mesh(one.thread)) for end in side]
        kinds = [(end.kind, end.body, end.way) for end in ends]
        return kinds, np.array([float(end.distance) for end in ends])

    kinds, single = distances(height)
    _, double = distances(2 * height)
    assert len(kinds) == 8
    for place in range(0, 8, 2):
        (crest, body, way), (root, same, other) = kinds[place : place + 2]
        assert (crest, root, body == same, way != other) == ("crest", "root", True, True)
        steps = 2 * (double[place] - single[place])
        np.testing.assert_allclose(single[place] + single[place + 1], steps, rtol=1e-9)


def test_the_half_extent_is_regular_at_a_circle():
    """Between the minor and the major semi-axis, and continuous where they are one."""
    one = screw_of_30_mm(5e-3).stages[0]
    _, frame, ends, _ = next(iter(sides_of(one, 1e5)))

    def extent(squared, tilt):
        curvature = eqx.tree_at(
            lambda c: (c.difference_squared, c.rolling),
            frame.curvature,
            (squared, (frame.curvature.total + tilt * jnp.sqrt(squared + 1e-300)) / 2),
        )
        contact = hertz_contact(
            array(100.0), curvature.total, curvature.difference_squared, array(1.15e11)
        )
        end = eqx.tree_at(lambda e: e.coefficient, ends[0], None, is_leaf=lambda x: x is None)
        return half_extent(contact, curvature, end), contact

    total = float(frame.curvature.total)
    for share in (0.0, 1e-7, 0.9e-5, 1.1e-5, 1e-3):
        squared = array((share * total) ** 2)
        for tilt in (-1.0, 0.3, 1.0):
            found, contact = extent(squared, tilt)
            low, high = float(contact.semi_minor), float(contact.semi_major)
            expected = np.sqrt((low**2 + high**2) / 2 + tilt * (high**2 - low**2) / 2)
            # The series of a circle is good to the square of 1e-5.
            np.testing.assert_allclose(found, expected, rtol=1e-9)
        assert np.isfinite(jax.grad(lambda s: extent(s, 0.3)[0])(squared))


def test_a_30_by_5_mm_screw_near_its_capacity():
    """The nut side at 0.95 C_0a: a semi-axis of 0.40 mm and 0.28 mm of flank."""
    whole = _compute(without_addenda(screw_of_30_mm(5e-3)), ["static_capacity"])
    load = 0.95 * float(whole["static_capacity"][0])
    hertz, _, ends, _ = list(sides_of(screw_of_30_mm(5e-3).stages[0], load))[1]
    np.testing.assert_allclose(float(hertz.semi_major), 0.40e-3, rtol=0.015)
    np.testing.assert_allclose([float(e.distance) for e in ends], 0.28e-3, rtol=0.015)


def _static_by_bisection(one, permissible):
    """C_0a by laminae: load under which the worse side has the permissible pressure."""
    loads = []
    for hertz, frame, ends, _ in sides_of(one, 1e4):
        reaches = [float(e.distance / half_extent(hertz, frame.curvature, e)) for e in ends]

        def pressure(load, hertz=hertz, reaches=reaches):
            scale = (load / 1e4) ** (1 / 3)
            ratio = pressure_ratio_by_bisection([t / scale for t in reaches])
            return float(hertz.max_pressure) * scale * ratio / permissible - 1

        loads.append(root_between(pressure, 1e4, 1e7, rtol=1e-12))
    return min(loads)


@pytest.mark.parametrize("lead", [2e-3, 5e-3])
def test_static_capacity_is_the_root_of_the_pressure(lead):
    one = screw_of_30_mm(lead)
    found = _compute(one, ["static_capacity"])["static_capacity"][0]
    np.testing.assert_allclose(found, _static_by_bisection(one.stages[0], 4.2e9), rtol=1e-9)
    # Under its own capacity the largest pressure is the permissible one.
    at_limit = prsm.set_parameter(one, "operating_point.load", float(found))
    pressure = _compute(at_limit, ["max_pressure"])["max_pressure"]
    np.testing.assert_allclose(pressure, 4.2e9, rtol=1e-11)


def test_capacities_do_not_fall_with_the_lead_where_flanks_are_short():
    """At a given diameter and number of starts; whole ellipses would give 3 to 1 from 2 to 6 mm.

    The least lead has the shortest flanks: there the contact is nearly a line as long as the flank.
    """
    names = ["static_capacity", "dynamic_capacity"]
    cut, whole = [], []
    for lead in (2e-3, 4e-3, 6e-3):
        one = screw_of_30_mm(lead)
        for of, found in ((cut, one), (whole, without_addenda(one))):
            values = _compute(found, names)
            of.append([float(values[name][0]) for name in names])
    cut, whole = np.asarray(cut), np.asarray(whole)
    assert (cut < whole * (1 + 1e-12)).all()
    np.testing.assert_allclose(whole[0, 0] / whole[2, 0], 3.0, rtol=1e-2)
    assert 1.2 < cut[0, 0] / cut[2, 0] < 1.4


def test_life_under_loads_that_are_not_cut_is_that_of_whole_ellipses():
    names = ["dynamic_capacity", "rating_life", "truncation_load", "contact_truncation"]
    light, heavy = (screw_of_30_mm(4e-3, load=load) for load in (20e3, 200e3))
    for one, cut in ((light, False), (heavy, True)):
        found, whole = (
            {k: float(np.max(v)) for k, v in _compute(m, names[:2]).items()}
            for m in (one, without_addenda(one))
        )
        assert found["dynamic_capacity"] < whole["dynamic_capacity"]
        more = {k: float(np.max(v)) for k, v in _compute(one, names[2:]).items()}
        assert (more["contact_truncation"] > 0) == cut
        load = float(one.operating_point.load)
        assert (load > more["truncation_load"]) == cut
        expected = max(0.0, 1 - (more["truncation_load"] / load) ** (1 / 3))
        np.testing.assert_allclose(more["contact_truncation"], expected, atol=1e-13)
        if cut:
            assert found["rating_life"] < 0.97 * whole["rating_life"]
        else:
            np.testing.assert_allclose(found["rating_life"], whole["rating_life"], rtol=1e-12)


def test_the_capacity_is_the_load_of_a_million_turns():
    one = screw_of_30_mm(3e-3)
    capacity = float(_compute(one, ["dynamic_capacity"])["dynamic_capacity"][0])
    under = prsm.set_parameter(one, "operating_point.load", capacity)
    np.testing.assert_allclose(_compute(under, ["rating_life"])["rating_life"], 1e6, rtol=1e-10)


def _fatigue_by_laminae(one, load):
    """Load of whole ellipses with the same risk over the load; both sides as the code has them."""
    fatigue = strength.truncated_fatigue(one)
    total, grown = 0.0, 0.0
    for side, risk, (hertz, frame, ends, _) in zip(
        fatigue.sides, fatigue.risks, sides_of(one, load), strict=True
    ):
        assert side is not None
        reaches = [float(e.distance / half_extent(hertz, frame.curvature, e)) for e in ends]
        ratio = pressure_ratio_by_bisection(reaches)
        kept = 1 - sum(lamina_risk(min(t / ratio, 1.0)) for t in reaches)
        total, grown = total + float(risk), grown + float(risk) * ratio**10 * kept
    return (grown / total) ** 0.3


def test_fatigue_is_that_of_the_laminae_that_are_left():
    one = screw_of_30_mm(3e-3).stages[0]
    factor = strength.truncated_fatigue(one).load_factor(array(3e5))
    np.testing.assert_allclose(factor, _fatigue_by_laminae(one, 3e5), rtol=1e-9)
    assert float(factor) > 1.05


def test_damage_adds_up_to_the_life():
    """Phases that are cut and phases that are not: Σ D_i of a cycle is its turns over the life."""
    spectrum = strength.LoadSpectrum(
        jnp.asarray([2e4, 3e5, 1e5]), jnp.asarray([5e4, 1.0, 5e2]), jnp.ones(3)
    )
    one = screw_of_30_mm(4e-3).stages[0]
    capacity, fatigue = strength.dynamic_capacity(one), strength.truncated_fatigue(one)
    life = strength.rating_life(one, capacity, spectrum, fatigue).revolutions
    used = strength.damage(one, capacity, spectrum, fatigue)
    np.testing.assert_allclose(jnp.sum(used), spectrum.revolutions / life, rtol=1e-12)
    without = strength.rating_life(one, capacity, spectrum).revolutions
    assert float(life) != pytest.approx(float(without), rel=1e-2)


def test_capacities_that_are_given_hold_as_they_are():
    given = Strength(static_capacity=1e5, dynamic_capacity=5e4)
    one = screw_of_30_mm(2e-3, strength=given, load=5e4)
    names = ["static_capacity", "dynamic_capacity", "rating_life"]
    found = _compute(one, names)
    np.testing.assert_allclose([float(found[n][0]) for n in names], [1e5, 5e4, 1e6], rtol=1e-12)


@eqx.filter_jit
def _on_true_flanks(one, side, load):
    found = flank_contact(one, side, load, (48, 48), extent=1.45, tolerance=1e-5)
    middle = found.surface.pressure[23:25, 23:25]
    return jnp.sqrt(jnp.mean(middle**2)) / found.hertz.max_pressure, found.surface.code


@pytest.mark.parametrize("side", ["screw", "nut"])
@pytest.mark.parametrize(
    ("lead", "pressure", "lowest", "highest"),
    [
        # Not cut: the half-space's own error, of 48 cells a side.
        (5e-3, 2.5e9, -2e-3, 2e-3),
        # Cut by 0.3 and 0.5 of the half-extent: laminae give more, as an edge of a half-space
        # bears more than its lamina.
        (5e-3, 4.2e9, 0.0, 0.04),
        (2e-3, 2.5e9, 0.0, 0.08),
        # By 0.7, where the contact point is as near to both edges as it is wide.
        (2e-3, 4.2e9, -0.03, 0.08),
    ],
)
def test_pressure_at_the_contact_point_against_half_spaces(side, lead, pressure, lowest, highest):
    """The law over the solver on the true flanks, which end sharply; errors as documented."""
    one = screw_of_30_mm(lead).stages[0]
    index = ("screw", "nut").index(side)
    hertz, _, _, _ = list(sides_of(one, 1e4))[index]
    load = 1e4 * (pressure / float(hertz.max_pressure)) ** 3
    reference, code = _on_true_flanks(one, side, array(load))
    assert int(code) == 0
    onset = strength.side_onsets(one)[index]
    law = float(pressure_ratio(array(pressure), onset.onsets))
    assert lowest <= law / float(reference) - 1 <= highest


@pytest.mark.parametrize("side", ["screw", "nut"])
def test_half_spaces_agree_with_those_of_numpy(side):
    """The solver and its gap, against NumPy with flanks and displacements of its own."""
    design = Design(3e-3, 5.0, 5e-3, np.pi / 4, 5e-3 / np.sin(np.pi / 4))
    modulus = 210e9 / (1 - 0.3**2) / 2
    unit, _, _ = hertz_pressure(design, side, 100.0, modulus)
    force, height = 100.0 * (3.5e9 / unit) ** 3, 0.2 * 3e-3 / 5
    expected = contact_pressure(design, side, (height, height), force, modulus, 160)
    one = screw_of_30_mm(3e-3).stages[0]
    total = force * 10 * float(present(one.engaged_threads))
    found, code = _on_true_flanks(one, side, array(total))
    assert int(code) == 0
    # 48 cells a side, whose rows change the cut by up to a cell: an edge of first order.
    np.testing.assert_allclose(found, expected, rtol=0.02)
    onset = strength.side_onsets(one)[("screw", "nut").index(side)]
    law = float(pressure_ratio(array(3.5e9), onset.onsets))
    # Cut by 0.43 to 0.48 of the half-extent at both ends.
    assert 0.0 < law / expected - 1 < 0.07


def test_findings_name_the_end_and_both_sides_of_the_threshold():
    bare = eqx.tree_at(
        lambda m: m.stages[0].strength, screw_of_30_mm(5e-3), None, is_leaf=lambda x: x is None
    )
    onset = float(_compute(bare, ["truncation_load"])["truncation_load"][0])
    below, above = (
        prsm.set_parameter(bare, "operating_point.load", onset * share)
        for share in (0.9999, 1.0001)
    )
    assert not [f for f in prsm.check(below) if f.name == "contact_truncation"]
    (found,) = [f for f in prsm.check(above) if f.name == "contact_truncation"]
    assert (found.severity, found.stage) == ("warning", 1)
    np.testing.assert_allclose(found.value, 1 - 1.0001 ** (-1 / 3), rtol=1e-6)
    for words in ("screw side", "crest of the screw", f"{onset * 1e-3:.4g} kN", "screw_addendum"):
        assert words in found.message


_PASSES = re.compile(
    r"above (?P<onset>[\d.]+) kN the contact ellipse on the (?P<side>\w+) side "
    r"passes the crest of the (?P<body>\w+): "
    r"at the operating load of (?P<load>[\d.]+) kN by (?P<cut>[\d.]+) of (?P<half>[\d.]+) mm "
    r"\((?P<share>[\d.]+)% of its half-extent, (?P<lost>[\d.]+)% of its load\).*"
    r"raise stage.thread.(?P<name>\w+) from (?P<now>[\d.]+) to (?P<wanted>[\d.]+) mm"
)


def test_every_number_of_the_finding():
    """Read back from its sentence: lengths by crests and half-extents, loads, and the remedy."""
    geometry = {"screw_addendum": 0.2e-3, "roller_addendum": 0.21e-3}
    scene = screw_of_30_mm(5e-3, load=420e3)
    scene = eqx.tree_at(lambda m: m.stages[0].strength, scene, None, is_leaf=lambda x: x is None)
    for name, value in geometry.items():
        scene = prsm.set_parameter(scene, name, value)
    one = scene.stages[0]
    found = [f for f in prsm.check(scene) if f.name == "contact_truncation"]
    ends = flank_ends(one, mesh(one.thread))
    contact = stage_contact(one, array(420e3), mesh(one.thread))
    frames = contact_frames(one.thread, mesh(one.thread), one.curvature)
    seen = set()
    for finding in found:
        read = _PASSES.search(finding.message)
        assert read is not None, finding.message
        side, body = read["side"], read["body"]
        k = ("screw", "nut").index(side)
        (end,) = [e for e in ends[k] if (e.kind, e.body) == ("crest", body)]
        half = float(half_extent((contact.screw, contact.nut)[k].hertz, frames[k].curvature, end))
        reach = float(end.distance) / half
        shown = {name: float(read[name]) for name in ("share", "cut", "half", "lost", "load")}
        expected = {
            "share": 100 * (1 - reach),
            "cut": 1e3 * (half - float(end.distance)),
            "half": 1e3 * half,
            # Of a parabola in each lamina: the integral of (1 − y²)·3/4 past the line.
            "lost": 100 * quad(lambda y: 0.75 * (1 - y**2), reach, 1)[0],
            "load": 420.0,
        }
        assert shown == pytest.approx(expected, rel=6e-3, abs=5.1e-3)
        assert float(read["onset"]) == pytest.approx(420.0 * reach**3, rel=6e-4)
        np.testing.assert_allclose(finding.value, 1 - reach, rtol=1e-9)
        # The nut's thread is as high as the screw's. 45 degrees take 1/√2 of a length on the flank.
        assert read["name"] == ("roller_addendum" if body == "roller" else "screw_addendum")
        now = geometry[read["name"]] * 1e3
        assert float(read["now"]) == pytest.approx(now, rel=6e-3)
        wanted = now + expected["cut"] / np.sqrt(2)
        assert float(read["wanted"]) == pytest.approx(wanted, rel=6e-3)
        seen.add((side, body))
    assert seen == {("screw", "screw"), ("screw", "roller"), ("nut", "nut"), ("nut", "roller")}


def test_findings_name_capacity_loads_and_roots():
    one = screw_of_30_mm(5e-3, load=1e3)
    found = {f.message for f in prsm.check(one) if f.name == "contact_truncation"}
    assert len(found) == 4
    for message in found:
        assert "static capacity" in message
        assert "operating load" not in message
    # Crests as high as no tooth can be leave nothing at the largest load.
    high = screw_of_30_mm(5e-3, addendum=0.4, load=1e3)
    assert not [f for f in prsm.check(high) if f.name == "contact_truncation"]
    shallow = Strength(
        permissible_pressure=4.2e9, shaft=ScrewShaft("fixed_free", root_radius=15e-3 - 0.1e-3)
    )
    rooted = screw_of_30_mm(5e-3, addendum=0.4, load=1e3, strength=shallow)
    (finding,) = [f for f in prsm.check(rooted) if f.name == "contact_truncation"]
    assert "root of the screw" in finding.message
    assert "deepen" in finding.message


def test_a_flank_ends_only_where_the_file_says_so():
    assert flanks_end(screw_of_30_mm(5e-3).stages[0])
    assert not flanks_end(without_addenda(screw_of_30_mm(5e-3)).stages[0])
    with pytest.raises(prsm.MissingDataError, match="screw_addendum"):
        prsm.compute(mechanism(stage()), ["contact_truncation"])
    # One crest alone is an end too.
    one = stage(geometry=thread(screw_addendum=0.1e-3))
    assert [len(side) for side in flank_ends(one, mesh(one.thread))] == [1, 1]


def test_shipped_examples_are_not_cut_in_operation():
    for name in ("actuator", "wu2022"):
        found = _compute(example(name), ["contact_truncation_largest"])
        assert float(found["contact_truncation_largest"][0]) == 0.0


def test_a_contact_beyond_its_flank_is_marked():
    """Numbers stay finite, and the result says that they are not to be used."""
    one = screw_of_30_mm(20e-3, addendum=0.02, load=1e4)
    names = ["max_pressure", "static_capacity", "dynamic_capacity", "contact_truncation"]
    values, valid = eqx.filter_jit(prsm.quantities.compute_checked)(one, names)
    assert not bool(valid)
    assert all(np.isfinite(v).all() for v in values.values())
    assert float(values["contact_truncation"][0]) > 1


def test_what_rests_on_whole_ellipses_says_so():
    """By name of the keys that are missing; and with them, what is still left out."""
    one = screw_of_30_mm(5e-3)
    for name in ("max_pressure", "static_capacity", "dynamic_capacity", "rating_life"):
        told = prsm.assumptions(without_addenda(one), [name])
        assert [s for s in told if "screw_addendum, roller_addendum" in s]
        told = prsm.assumptions(one, [name])
        assert [s for s in told if "concentration of pressure at the edge" in s]
        assert not [s for s in told if "screw_addendum" in s]
    assert not [s for s in prsm.assumptions(one, ["axial_stiffness"]) if "edge" in s]
