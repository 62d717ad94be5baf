"""What `print` shows of every result, turned back to SI by units of its own."""

import ast
import dataclasses
import functools
import math
import re
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import reading_scenes as made
from reading_units import assert_reads, to_si
from study_scene import made as made_study

import prsm_jax
import prsm_jax.halfspace
from prsm_jax.fields import units_of
from prsm_jax.response import Campbell, ExcitationOrder, FrequencyResponse
from prsm_jax.results import Result
from prsm_jax.strength import LoadSpectrum, RatingLife
from prsm_jax.text import Line, aligned, html_table

_ROOT = Path(prsm_jax.__file__).parent
#: One of each kind, of which no two numbers are alike. Made at first use: what is compiled while
#: tests are collected is compiled by every worker at the same time.
_MADE = {
    "steady": lambda: made.steady(stages=2),
    "transient": made.transient,
    "bodies": lambda: made.body_forces(times=3),
    "hertz": made.hertz,
    "contact": made.contact_pair,
    "meshing": made.meshing,
    "line": lambda: made.line_contact()[1],
    "distribution": made.distribution,
    "curve": made.curve,
    "modes": made.modes,
    "loci": made.loci,
    "flank": made.flank_contact,
    "life": lambda: RatingLife(jnp.asarray(3.21e8), jnp.asarray(4.56e7), jnp.asarray(7.89e5)),
}


@functools.cache
def _scene(name):
    return _MADE[name]()


def _classes() -> list[type]:
    """Every class of results that there is."""
    found, left = [], [Result]
    while left:
        one = left.pop()
        left += one.__subclasses__()
        found.append(one)
    return [one for one in found if one.__module__.startswith("prsm_jax.")]


def _printed(result) -> dict[str, str]:
    """Values by label of what is printed; continued lines are put together."""
    title, *lines = str(result).splitlines()
    assert title
    rows: dict[str, str] = {}
    label = ""
    for line in lines:
        assert line.startswith("  ")
        name, _, value = line[2:].partition("  ")
        label = name or label
        rows[label] = f"{rows.get(label, '')} {value.strip()}".strip()
    return rows


def _assert_value(text: str, value, unit: str):
    """Up to four numbers are listed, of more the ends are shown."""
    numbers = np.abs(np.ravel(value)) if np.iscomplexobj(value) else np.ravel(value)
    if numbers.dtype == bool:
        expected = {numbers.size: "yes", 0: "no"}.get(int(numbers.sum()))
        assert text == (expected or f"yes: {numbers.sum()} of {numbers.size}")
        return
    if numbers.size > 4:
        numbers = np.unique([numbers.min(), numbers.max()])
    numbers = numbers.tolist()
    # The unit stands once, after the last number.
    parts = re.split(r", | … ", text)
    label = parts[-1].partition(" ")[2]
    words = [one if one is parts[-1] or not label else f"{one} {label}" for one in parts]
    assert len(words) == len(numbers), text
    largest = max(abs(float(one)) for one in numbers)
    for word, number in zip(words, numbers, strict=True):
        if unit == "1" and float(number).is_integer() and number < 1e7:
            assert word == str(int(number))
            continue
        # A number beside one 50 times as large has fewer than three digits in the unit of both.
        coarse = () if abs(float(number)) == largest else ("coarse",)
        assert_reads(word, (float(number), unit, *coarse))


def _assert_fields(result, prefix: str, rows: dict[str, str]) -> int:
    count = 0
    for field in dataclasses.fields(result):
        value, label = getattr(result, field.name), prefix + field.name.replace("_", " ")
        unit = units_of(type(result)).get(field.name)
        if isinstance(value, Result):
            count += _assert_fields(value, f"{label}: ", rows)
        elif unit is None or value is None or label not in rows:
            continue
        elif field.name == "efficiency":
            shown = float(rows[label].removesuffix(" %")) / 100
            assert shown == pytest.approx(float(value), rel=6e-4)
            count += 1
        else:
            parts = value if isinstance(value, dict) else {None: value}
            for name, part in parts.items():
                _assert_value(rows[label if name is None else f"{label}: {name}"], part, unit)
                count += 1
    return count


#: Fields with units that every scene prints, which a change of `lines` must not lose.
_COUNTS = {
    "steady": 14,
    "transient": 14,
    "bodies": 18,
    "hertz": 6,
    "contact": 18,
    "meshing": 10,
    "line": 17,
    "distribution": 13,
    "curve": 5,
    "flank": 13,
    "life": 3,
}


@pytest.mark.parametrize("name", _COUNTS)
def test_every_field_with_a_unit_reads_as_its_number(name):
    rows = _printed(_scene(name))
    assert _assert_fields(_scene(name), "", rows) == _COUNTS[name], rows


def test_losses_have_a_line_each():
    rows = _printed(_scene("steady"))
    for name, power in _scene("steady").losses.items():
        assert_reads(rows[f"losses: {name.replace('_', ' ')}"], (float(power), "W"))


def test_frequencies_are_listed_by_family():
    rows = _printed(_scene("modes"))
    for group in _scene("modes").groups:
        times = f" (×{group.multiplicity})" if group.multiplicity > 1 else ""
        text = rows[f"{group.family}{times}"]
        label = text.rpartition(" ")[2]
        listed = text.removesuffix(label).strip().split(", ")
        moving = [f for f in np.asarray(group.frequencies).tolist() if f > 0]
        assert len(listed) == len(moving)
        for word, frequency in zip(listed, moving, strict=True):
            assert float(to_si(float(word), label)) == pytest.approx(frequency, rel=6e-4)


def test_frequencies_that_are_not_defined_are_no_rigid_motions():
    modes = jax.tree.map(lambda leaf: leaf * jnp.nan, _scene("modes"))
    rows = _printed(modes)
    assert "rigid motions" not in rows
    assert all("not defined" in text for text in rows.values())


@pytest.mark.parametrize("name", _MADE)
def test_a_print_is_short_and_a_repr_is_one_line(name):
    lines = str(_scene(name)).splitlines()
    assert 2 <= len(lines) <= 25
    assert max(map(len, lines)) <= 79
    assert len(repr(_scene(name))) <= 100
    assert "\n" not in repr(_scene(name))


@pytest.mark.parametrize("name", _MADE)
def test_a_batch_shows_the_ends_and_the_number_of_designs(name):
    one = _scene(name)
    scales = (1.0, 1.3, 0.9)

    def scaled(leaf):
        if not jnp.issubdtype(leaf.dtype, jnp.inexact):
            return jnp.stack([leaf] * len(scales))
        return jnp.stack([leaf * scale for scale in scales])

    batch = jax.tree.map(scaled, one)
    assert batch.batch_shape == (3,)
    assert str(batch).splitlines()[0] == f"{str(one).splitlines()[0]} of 3 designs"
    assert " of 3 designs" in repr(batch)
    if name == "steady":
        for label in ("drive torque", "contact force"):
            value = getattr(batch, label.replace(" ", "_"))
            _assert_value(_printed(batch)[label], value, {"d": "N·m", "c": "N"}[label[0]])


@pytest.mark.parametrize("name", _MADE)
def test_inside_a_trace_names_and_shapes_are_shown(name):
    said = []

    def look(result):
        said.append((str(result), repr(result), result._repr_html_()))
        return jax.tree.leaves(result)[0]

    jax.eval_shape(look, _scene(name))
    words, short, page = said[0]
    assert " inside a trace" in words.splitlines()[0]
    assert " inside a trace" in short
    assert "<table>" in page
    assert "float64[" in words or "arrays" in words
    # Known numbers inside a trace of something else cannot be computed with, either.
    jax.eval_shape(lambda x: (said.append(str(_scene(name))), x)[1], 1.0)
    assert said[1].splitlines()[0] == words.splitlines()[0]


def test_what_is_no_number_does_not_stop_the_printing():
    shapes = jax.eval_shape(lambda state: state, _scene("steady"))
    assert "efficiency" in str(shapes)
    assert "bool" in str(jax.tree.map(lambda _: True, _scene("steady")))
    assert "str" in str(jax.tree.map(lambda _: "x", _scene("steady")))
    odd = eqx.tree_at(lambda s: s.efficiency, _scene("steady"), jnp.zeros((2, 3)))
    assert "of 2 × 3 designs" in str(odd)


#: Unit of each field by what it is, written here a second time.
_UNITS = {
    "N": (
        "axial_force carrier_axial_force carrier_force contact_force force forward load "
        "normal_force nut_contact_force nut_load nut_on_roller nut_radial_force pin_on_roller "
        "reverse ring_gear_force ring_gear_on_roller screw_contact_force screw_friction_on_roller "
        "screw_normal_on_roller screw_roller_axial_force spacer_force spline_friction "
        "spring_force thrust_bearing_force"
    ),
    "m": (
        "approach approach_difference arc axial_gap contact_place contact_radius deflection depth "
        "depths nut_displacement "
        "displacement distance gap half_width max_half_width position radius "
        "roller_contact_radius roller_deflection semi_major semi_minor"
    ),
    "N/m": (
        "axial_stiffness line_load nut_each nut_roller roller_stiffness screw_each screw_roller "
        "stiffness stiffness_tangent tangent_stiffness"
    ),
    "1": (
        "at_pole carrier_ratio converged edge_ratio efficiency error_estimate error_over_time "
        "friction_coefficient iterations "
        "loaded_share lobes normal_per_axial order parabola_fit power_balance_residual rejected "
        "residual revolutions sliding solved steps"
    ),
    "J": "stored_energy",
    "Pa": "max_pressure pressure value",
    "N·m": (
        "anti_rotation_torque drag_torque drive_torque nut_moment_on_roller nut_overturning_moment "
        "screw_moment_on_roller thrust_bearing_torque"
    ),
    "s": "duration time time_constant",
    "rad/s": "carrier_speed screw_speed speed",
    "W": "input_power load_power losses output_power power",
    "N·s/m": "damping_across_slip damping_along_slip",
    "m/s": "slip_speed",
    "rad": (
        "contact_angle_position nut_lean roller_angle roller_angle_position roller_lean "
        "turned_angle"
    ),
    "m²": "area",
    "Hz": "frequency",
}


def test_every_field_has_the_unit_of_what_it_is():
    expected = {name: unit for unit, names in _UNITS.items() for name in names.split()}
    for cls in _classes():
        for name, unit in units_of(cls).items():
            assert unit == expected[name], f"{cls.__name__}.{name}"


def test_units_of_fields_are_those_of_their_comments():
    """A field says its unit twice: for `print`, and in brackets for the reader of the page."""
    compared = 0
    for cls in _classes():
        if cls is Result:
            continue
        path = _ROOT.parent / Path(*cls.__module__.split(".")).with_suffix(".py")
        source = path.read_text(encoding="utf-8").splitlines()
        tree = ast.parse("\n".join(source))
        node = next(
            n for n in ast.walk(tree) if isinstance(n, ast.ClassDef) and n.name == cls.__name__
        )
        for field in node.body:
            if not (isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)):
                continue
            unit = units_of(cls).get(field.target.id)
            line, words = field.lineno - 2, []
            while source[line].strip().startswith("#:"):
                words.insert(0, source[line].strip().removeprefix("#:").strip())
                line -= 1
            stated = re.findall(r"\[([^\]/]+(?:/[^\]]+)?)\]", " ".join(words))
            if unit is not None and len(stated) == 1:
                assert stated[0] == unit, f"{cls.__name__}.{field.target.id}"
                compared += 1
    assert compared > 50


def test_a_locked_thread_has_no_efficiency():
    rows = _printed(made.steady(output=-500.0, locked=True))
    assert rows["efficiency"] == "none"
    batch = Line("efficiency", np.array([0.8, 0.85, -0.2, np.nan, 0.83]), "1", "efficiency")
    assert batch.text == "80.00 … 85.00 %; none: 1 of 5; not defined: 1 of 5"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (12, "1", "12"),
        (5.0, "1", "5"),
        (5000 * 3600, "s", "5000 h"),
        (math.inf, "s", "∞ h"),
        (math.nan, "m", "not defined"),
        (None, "m", "–"),
        (np.zeros(0), "m", "none"),
        (np.array([1e-3, 2.5e-3]), "m", "1.000, 2.500 mm"),
        (np.array([True, False, True]), "1", "yes: 2 of 3"),
        (np.array([3 + 4j, 0.0]), "N", "5.000, 0 N"),
        (np.full(9, 0.02), "m", "20.00 mm"),
        (3.2e-7, "m²", "0.3200 mm²"),
    ],
)
def test_numbers_in_words(value, unit, text):
    assert Line("", value, unit).text == text


def test_text_from_users_is_shown_literally():
    title = "<script>alert('x')</script>\nA \x1b[31mred & long title"
    mechanism = dataclasses.replace(prsm_jax.load("wu2022"), title=title)
    page = mechanism._repr_html_()
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert "\x1b" not in str(mechanism) + repr(mechanism)
    assert len(repr(mechanism).splitlines()) == 1
    assert "<b>" not in html_table("<b>", [Line("<b>", "<b>")])
    assert aligned("a\nb", []) == "a b"


def test_a_study_is_shown_in_a_notebook_as_text():
    study = made_study("efficiency", "mass")
    assert study._repr_html_().startswith("<pre>")
    assert repr(study).startswith("<DriverStudy: ")
    assert "\n" not in repr(study)
    assert "\n" not in repr(study.front)


def test_a_mechanism_prints_its_main_numbers():
    mechanism = prsm_jax.load("li2020_two_stage")
    rows = _printed(mechanism)
    stages = mechanism.stages
    point = mechanism.operating_point
    assert point is not None
    assert_reads(rows["load"], (float(point.load), "N"))
    assert_reads(rows["speed"], (float(point.speed), "rad/s"))
    _assert_value(rows["lead"], np.array([float(s.thread.lead) for s in stages]), "m")
    radii = np.array([(float(s.thread.starts) - 2) * float(s.thread.roller_radius) for s in stages])
    _assert_value(rows["screw diameter"], 2 * radii, "m")
    assert rows["stages"] == "2"
    assert len(str(mechanism).splitlines()) <= 25
    assert repr(mechanism) == "<Mechanism 'Li et al. 2020, two stages': 2 stages>"


def test_derivatives_by_a_mechanism_have_no_units():
    mechanism = prsm_jax.load("wu2022")
    slopes = jax.tree.map(lambda leaf: -3.0 * jnp.ones_like(leaf), mechanism)
    rows = _printed(slopes)
    assert "may be a derivative" in rows["note"]
    assert rows["lead"] == "\N{MINUS SIGN}3"


def test_responses_and_orders_print_their_own_words():
    frequency = jnp.asarray([100.0, 250.0, 300.0])
    value = jnp.asarray([1e-9 + 0j, 4e-9 - 3e-9j, 1e-10 + 0j])
    poles = jnp.zeros(3, bool)
    response = FrequencyResponse(frequency, value, poles, "screw u", "nut u", "receptance")
    rows = _printed(response)
    assert rows["force at"] == "screw u"
    assert rows["receptance of"] == "nut u"
    assert rows["largest at"] == "250.0 Hz"
    assert rows["magnitude"].endswith(" m/N")
    assert "5.000·10⁻⁹" in rows["magnitude"]
    order = ExcitationOrder(
        jnp.asarray(2.5), jnp.asarray(3.0), "roller_pass", ("screw_roller",), "rollers pass"
    )
    assert _printed(order)["order"] == "2.500"
    diagram = Campbell(made.modes(), (order,), jnp.asarray(0.4), 3, 10, True)
    rows = _printed(diagram)
    assert rows["order: roller pass"] == "2.500"
    assert rows["harmonics"] == "3"
    assert any(label.startswith("frequencies: torsional") for label in rows)
    spectrum = LoadSpectrum(
        *(jnp.asarray([a, b]) for a, b in ((4e3, -7e3), (62.8, 31.4), (9.0, 4.0)))
    )
    turns = _printed(spectrum)["revolutions"].split(", ")
    assert [float(one) for one in turns] == pytest.approx(
        [62.8 / 6.283185, 31.4 / 6.283185], rel=1e-3
    )


def test_a_stress_field_prints_the_stress_after_von_mises():
    field = made.subsurface()
    text = _printed(field)["von Mises stress"]
    low, high = (float(one) for one in text.removesuffix(" MPa").split(" … "))
    t = np.asarray(field.tensor)
    normal = (t[..., 0, 0] - t[..., 1, 1]) ** 2 + (t[..., 1, 1] - t[..., 2, 2]) ** 2
    normal += (t[..., 2, 2] - t[..., 0, 0]) ** 2
    shear = t[..., 0, 1] ** 2 + t[..., 1, 2] ** 2 + t[..., 2, 0] ** 2
    stress = np.sqrt(normal / 2 + 3 * shear) * 1e-6
    assert (low, high) == pytest.approx((stress.min(), stress.max()), rel=6e-4, abs=1e-12)
