"""Published numbers: verdicts follow from the numbers, and known differences are known."""

import csv
import json
import math
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

import prsm_jax as prsm
from prsm_jax.file import load
from prsm_jax.validation import (
    VERDICTS,
    Row,
    at_most,
    consistent,
    differs,
    fault,
    formula,
    inconsistent,
    markdown,
    misprint,
    not_comparable,
    number,
    published_pressures,
    sources,
    summary,
    table,
    trend,
    unexplained,
    validate,
)
from prsm_jax.validation._row import half_unit
from prsm_jax.validation.wu2022._wu2022_frequencies import stable_frequencies
from prsm_jax.validation.wu2022._wu2022_matrix import published_matrices, published_modes
from tests.docs.printed import differences
from tests.docs.validation_page import PAGE, page
from tests.present import present

#: Rows whose reason can be put in, and how near the printed number then comes (see the notes).
PUT_IN = {
    ("wu2022", "Table 3: radius of the roller's profile"): 0.002,
    ("wu2022", "Table 4: gear mesh stiffness, equations 48 to 50 at 10 mm face width"): 2e-4,
    ("wu2022", "Table 4: torsional stiffness of the screw"): 0.04,
    ("wu2022", "Table 4: torsional stiffness of the nut"): 0.2,
    ("wu2022", "equation 89: roller mode"): 4e-5,
    ("li2020", "equation 35, second form: efficiency with spline friction 0.10 alone"): 5e-7,
    ("li2020", "equation 35, second form: efficiency with spline friction 0.20 alone"): 5e-7,
    ("li2021", "equation 23 as printed: steady efficiency"): 0.01,
    **{
        (
            "lisowski2014",
            f"{table}: Hertz pressure with the curvatures of the flanks, {side} side, {load} N",
        ): 0.002
        for table, side in (("Table 1", "screw"), ("Table 2", "nut"))
        for load in (25, 50, 100)
    },
    (
        "lisowski2014",
        "equation 3: pressure of the nut at 25 N with its curvature radius as printed, positive",
    ): 0.002,
    ("shape_function", "Table 2 from Table 1's geometry under 55 N: largest pressure"): 0.02,
    ("shape_function", "Table 2 from Table 1's geometry under 55 N: half width"): 0.01,
    (
        "shape_function",
        "Table 2 from Table 1's geometry under 55 N: largest depth of contact",
    ): 0.07,
}
#: The printed 1585 MPa is the screw side's.
CORRECTED = {"Table 2: Hertz pressure with the curvatures of the flanks, nut side, 100 N": 1540.0}
#: Bounds that are wider than a tenth of the number.
WIDE = {
    # A discretisation error, which a change of the grid moves.
    "section 4: error at low load from elements of 0.01 mm, screw side, 25 N",
    "section 4: error at low load from elements of 0.01 mm, nut side, 50 N",
}
KEYS = {"source", "item", "published", "computed", "relative_difference", "verdict", "note"}
#: Claims of the papers that this model does not bear out; see the note of the row.
KNOWN = {"abstract: ring gear force at the start, stage 1 above stage 2"}
DATA = Path(prsm.__file__).parent / "validation" / "data"


@pytest.fixture(scope="module")
def rows() -> tuple[Row, ...]:
    return validate()


@pytest.fixture(scope="module")
def by_item(rows) -> dict[tuple[str, str], Row]:
    return {(row.source, row.item): row for row in rows}


def test_every_source_has_rows_and_items_are_unique(rows):
    assert {row.source for row in rows} == set(sources())
    assert len({(row.source, row.item) for row in rows}) == len(rows)
    assert all(citation for citation in sources().values())


def test_rows_are_complete_and_json(rows):
    dumped = json.loads(json.dumps([row.to_dict() for row in rows], allow_nan=False))
    for row in dumped:
        assert set(row) >= KEYS
        assert row["verdict"] in VERDICTS
        assert row["item"]
        assert row["published"] not in ("", None)
        assert row["computed"] not in ("", None)
        if row["verdict"] not in ("reproduced", "trend reproduced"):
            assert len(row["note"]) > 10, row


def test_verdicts_follow_from_the_numbers(rows):
    for row in rows:
        if row.verdict in ("reproduced", "formula agrees", "fault reproduced", "paper consistent"):
            assert isinstance(row.published, float)
            assert isinstance(row.computed, float)
            assert row.tolerance is not None
            assert abs(row.computed - row.published) <= row.tolerance, row
        if isinstance(row.published, float) and isinstance(row.computed, float):
            published = row.published
            expected = None if published == 0 else row.computed / published - 1
            assert row.relative_difference == expected
        else:
            assert row.relative_difference is None


def test_wider_tolerances_are_few_and_explained(rows):
    """Anything looser than 2 % of the number would prove little, and has to say why."""
    loose = [
        row
        for row in rows
        if row.verdict == "reproduced"
        and row.tolerance is not None
        and row.tolerance > 0.02 * abs(float(row.published))
    ]
    assert all(row.note for row in loose)
    # Zero has no 2 %.
    loose = [row for row in loose if row.published != 0]
    assert {row.item for row in loose} <= {
        "section 3.1: carrier 1 steady after",
        "section 3.1: efficiency at the start, below",
        "Table 1: deviation of the finite elements, screw side, 100 N",
        "Table 2: deviation of the finite elements, nut side, 100 N",
        "Table 2: largest depth of contact",
        "Table 2: deviation of the model from finite elements, largest pressure",
    }


def test_the_page_of_published_numbers_is_that_of_the_rows(rows):
    """Written by `python -m tests.docs.validation_page`."""
    wrong = differences(PAGE.read_text(encoding="utf-8"), page(rows))
    assert not wrong, wrong


def test_only_the_known_claims_are_not_reproduced(rows):
    assert {row.item for row in rows if row.verdict == "not reproduced"} == KNOWN


@pytest.mark.parametrize(
    ("source", "item", "published", "computed", "tolerance"),
    [
        # Reference values of an independent implementation, to the digits that it gives.
        ("li2020", "section 3.2: efficiency at the start", 0.60, 0.60624, 5e-6),
        ("li2020", "section 3.2: steady efficiency", 0.87, 0.8708, 6e-5),
        ("li2021", "section 3.1: efficiency at the start, below", 0.45, 0.4417, 5e-5),
        ("li2021", "section 3.1: steady efficiency", 0.80, 0.8060, 5e-5),
        ("li2021", "section 3.1: carrier 1 steady after", 0.14, 0.134, 1e-3),
        ("li2021", "section 3.1: carrier 2 steady after", 0.46, 0.4635, 5e-3),
        ("lisowski2014", "Table 1: Hertz pressure on the screw side, 25 N", 999, 1000.2, 0.05),
        ("lisowski2014", "Table 1: Hertz pressure on the screw side, 50 N", 1259, 1260.2, 0.05),
        ("lisowski2014", "Table 1: Hertz pressure on the screw side, 100 N", 1585, 1587.8, 0.05),
        ("lisowski2014", "Table 2: Hertz pressure on the nut side, 25 N", 969, 969.9, 0.05),
        ("lisowski2014", "Table 2: Hertz pressure on the nut side, 50 N", 1221, 1221.9, 0.05),
        ("lisowski2014", "Table 2: Hertz pressure on the nut side, 100 N", 1585, 1539.6, 0.06),
        ("shape_function", "Table 2: largest depth of contact", 1.1e-4, 1.18e-4, 5e-7),
        ("shape_function", "coefficient cos ψ cos k a that Table 2 implies", 0.0338, 0.0503, 5e-5),
        (
            "wu2022",
            "Table 4: gear mesh stiffness, equations 48 to 50 at 10 mm face width",
            2.464e8,
            1.64285e8,
            5e2,
        ),
        ("wu2022", "equation 89: roller mode", 14081, 22700, 0.5),
    ],
)
def test_values(by_item, source, item, published, computed, tolerance):
    row = by_item[source, item]
    assert row.published == published
    assert row.computed == pytest.approx(computed, abs=tolerance)


def test_table_5_is_reproduced_to_the_printed_digit(by_item):
    """All 60 entries, the five with wrong digits against the corrected ones."""
    with (DATA / "wu2022_table5_misprints.csv").open(encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    corrections = {
        (int(line["n_rollers"]), line["mode"]): float(line["correct"])
        for line in csv.DictReader(lines)
    }
    assert len(corrections) == 5
    found = [row for (_, item), row in by_item.items() if item.startswith("Table 5, N = ")]
    assert len(found) == 60
    explained = 0
    for row in found:
        head, mode = row.item.removeprefix("Table 5, N = ").split(": ")
        key = int(head), mode.split(",")[0]
        correct = corrections.get(key, float(row.published))
        assert isinstance(row.computed, float)
        assert abs(row.computed - correct) <= 0.5
        corrected = correct != row.published
        assert row.verdict == ("misprint explained" if corrected else "fault reproduced")
        explained += corrected
        # The frequency of the structure with its springs' own signs is another one.
        assert row.own is not None
        assert abs(row.own - row.published) > 0.5
    assert explained == 5


@pytest.mark.parametrize("count", [7, 9, 12])
def test_the_published_matrix_is_indefinite(count):
    """t1 and t2 twice each, f3 and f5: six eigenvalues below zero, whatever N is."""
    stage = load("wu2022").stages[0]
    matrix, mass = published_matrices(stage, count)
    assert np.array_equal(matrix, matrix.T)
    weight = 1 / np.sqrt(mass)
    values = np.linalg.eigvalsh(matrix * np.outer(weight, weight))
    assert len(values) == count + 10
    assert int((values < 0).sum()) == 6
    negative = {name for name, mode in published_modes(stage, count).items() if mode.negative}
    assert negative == {"t1", "t2", "f3", "f5"}


def test_stable_frequencies_are_those_of_modal():
    """What the notes call the stable model is the public modal analysis, all N + 10 of it."""
    modes = prsm.modal(load("wu2022"))
    stable = stable_frequencies()[7]
    repeat = {"f": 1, "t": 2, "r": 4}
    expected = sorted(value for mode, value in stable.items() for _ in range(repeat[mode[0]]))
    np.testing.assert_allclose(np.sort(np.asarray(modes.frequencies)), expected, rtol=1e-9)
    # Wu et al. 2022, Table 4, in the positive model, from an independent implementation.
    rounded = [round(value, 1) for value in sorted(stable.values())]
    others = [2262.2, 3604.0, 4847.5, 13856.5, 21761.9, 22838.8, 27273.8, 34523.4]
    assert rounded == [293.3, 839.1, *others]


def test_one_source_at_a_time(rows):
    only = validate(source="closed_forms")
    assert only == tuple(row for row in rows if row.source == "closed_forms")
    with pytest.raises(prsm.UnknownNameError, match=r"li202[01]"):
        validate(source="li2022")


def test_summary_counts_every_row(rows):
    counts = summary(rows)
    assert set(counts) == {*sources(), "all"}
    assert sum(counts["all"].values()) == len(rows)
    assert counts["all"]["not reproduced"] == len(KNOWN)
    assert counts["wu2022"]["fault reproduced"] >= 55
    # Of the misprints nine are corrected: five in Table 5, two in Table 6, two counts.
    assert counts["wu2022"]["misprint explained"] == 9
    assert counts["all"]["misprint explained"] == 12


def test_plain_table_fits_and_says_everything(rows):
    text = table(rows)
    assert max(map(len, text.splitlines())) <= 120
    squeezed = " ".join(text.split())
    for row in rows:
        assert row.verdict in squeezed
        assert " ".join(row.note.split()) in squeezed
    assert all(name + ":" in text for name in sources())


def test_markdown_has_one_line_per_row(rows):
    lines = markdown(rows).splitlines()
    assert len(lines) == len(rows) + 2
    assert all(line.replace(r"\|", "").count("|") == 8 for line in lines)


def test_half_unit_of_printed_digits():
    assert half_unit("999") == 0.5
    assert half_unit("0.60") == pytest.approx(0.005)
    assert half_unit("2.078e8") == pytest.approx(5e4)
    assert half_unit("-8.3") == pytest.approx(0.05)
    with pytest.raises(ValueError, match="nan"):
        half_unit("nan")


def test_verdicts_change_with_the_numbers():
    """A regression in the physics turns every favourable verdict into "not reproduced"."""
    assert number("x", "1.00", 1.004).verdict == "reproduced"
    assert number("x", "1.00", 1.006).verdict == "not reproduced"
    assert number("x", "1.00", math.nan).verdict == "not reproduced"
    assert misprint("x", "12", 21.2, correct="21", note="n").verdict == "misprint explained"
    assert misprint("x", "12", 12.0, correct="21", note="n").verdict == "not reproduced"
    assert at_most("x", "0.45", 0.44).verdict == "reproduced"
    assert at_most("x", "0.45", 0.46).verdict == "not reproduced"
    assert at_most("x", "0.45", 0.30).verdict == "not reproduced"
    assert trend("x", "rises", "falls", False).verdict == "not reproduced"
    assert trend("x", "rises", "rises", bool(jnp.asarray(True))).verdict == "trend reproduced"


def _different(computed=2.0, evidence=3.0):
    return differs(
        "x",
        "1.00",
        computed,
        between=(1.9, 2.1),
        because="b",
        evidence=evidence,
        evidence_between=(2.9, 3.1),
    )


def test_differences_are_bounded_and_their_reasons_computed():
    """A number that leaves its bounds, or a reason that the numbers stop to bear out, fails."""
    assert _different().verdict == "differs because"
    assert _different(computed=2.2).verdict == "not reproduced"
    assert _different(computed=1.8).verdict == "not reproduced"
    assert _different(computed=math.nan).verdict == "not reproduced"
    assert _different(evidence=3.2).verdict == "not reproduced"
    assert _different(evidence=math.nan).verdict == "not reproduced"
    between = (1.9, 2.1)
    for build, verdict, words in (
        (unexplained, "unexplained", {"note": "n"}),
        (not_comparable, "not comparable", {"missing": "m"}),
        (inconsistent, "paper inconsistent", {"note": "n"}),
    ):
        assert build("x", "1", 2.0, between=between, **words).verdict == verdict
        assert build("x", "1", 2.2, between=between, **words).verdict == "not reproduced"
        assert build("x", "in words", 2.0, between=between, **words).relative_difference is None
    with pytest.raises(ValueError, match="lower one first"):
        unexplained("x", "1", 2.0, between=(2.1, 1.9), note="n")


def test_faults_formulas_and_papers_are_no_reproductions():
    assert fault("x", "12", 12.2, own=21.0, note="n").verdict == "fault reproduced"
    assert fault("x", "12", 12.6, own=21.0, note="n").verdict == "not reproduced"
    with pytest.raises(ValueError, match="not a fault"):
        fault("x", "12", 12.2, own=12.1, note="n")
    with pytest.raises(ValueError, match="does not correct"):
        misprint("x", "12", 12.0, correct="12", note="n")
    assert formula("x", "1.25", 1.254, note="n").verdict == "formula agrees"
    assert formula("x", "1.25", 1.256, note="n").verdict == "not reproduced"
    assert consistent("x", "0.5", 0.54, note="n").verdict == "paper consistent"
    assert consistent("x", "0.5", 0.56, note="n").verdict == "not reproduced"


def test_every_difference_carries_its_bound_and_its_reason_a_number(rows):
    """No row that departs from a printed number rests on words alone."""
    bounded = ("differs because", "unexplained", "not comparable", "paper inconsistent")
    found = [row for row in rows if row.verdict in bounded]
    assert len(found) > 50
    for row in found:
        assert isinstance(row.computed, float), row.item
        assert row.bounds is not None, row.item
        low, high = row.bounds
        assert low * (1 - 1e-12 * np.sign(low)) <= row.computed <= high + 1e-12 * abs(high), row
        # A bound that a printed number fits in as well would not tell the two apart.
        if isinstance(row.published, float):
            assert not low <= row.published <= high, row
        if high > low:
            # A per cent or two of what it bounds, or a percentage's tenth.
            wide = (high - low) / max(abs(low), abs(high), 1.0)
            assert wide < 0.1 or row.item in WIDE, row
        if row.verdict == "differs because":
            assert row.evidence is not None, row.item
            assert row.evidence_bounds is not None
            below, above = row.evidence_bounds
            assert below * (1 - 1e-12 * np.sign(below)) <= row.evidence <= above + 1e-12, row
            assert "evidence" in row.note, row


def test_the_reason_put_in_gives_the_printed_number(by_item):
    """Where a reason can be computed with, the result is nearer to the printed number by far."""
    for (source, item), share in PUT_IN.items():
        row = by_item[source, item]
        correct = CORRECTED.get(item, row.published)
        away = abs(row.evidence / correct - 1)
        assert away <= share, row
        assert away < 0.3 * abs(row.computed / correct - 1), row


def test_comparisons_within_a_paper_are_no_reproductions(rows):
    """Notes that say so have the verdict that says so, and the other way round."""
    for row in rows:
        assert ("from the two printed" in row.note) <= row.verdict.startswith("paper "), row
        if row.source == "closed_forms" or "the formula's value" in row.note:
            assert row.verdict in ("formula agrees", "differs because"), row
        if row.verdict == "misprint explained":
            assert abs(row.computed - row.published) > row.tolerance, row


def test_lisowski_pressure_maps_hold_what_the_paper_prints(rows):
    """Both sides at three loads; where the flanks are whole they bear like exact Hertz contacts."""
    assert rows  # the rows solve the same contacts with as many cells
    maps, edge_zone = published_pressures("lisowski2014", cells=32)
    panels = [panel for row in maps.rows for panel in row]
    assert [panel.name for panel in panels] == [
        f"{side} side, {load} N" for side in ("screw", "nut") for load in (25, 50, 100)
    ]
    printed = [[one.value and one.value / 1e6 for one in panel.printed] for panel in panels]
    assert printed == [
        [608, 999],
        [1480, 1259],
        [1586, 1585],
        [None, 969],
        [879, 1221],
        [1531, 1585],
    ]
    assert [one.correct for panel in panels for one in panel.printed if one.correct] == [1540e6]
    for panel in panels:
        surface, hertz = panel.contact.surface, panel.contact.hertz
        assert surface.max_pressure == pytest.approx(float(hertz.max_pressure), rel=1e-3)
        assert panel.ellipse is not None
        # The paper's radii make the contact larger, by as much as they lower the pressure.
        area = panel.ellipse.semi_major * panel.ellipse.semi_minor
        share = float(hertz.semi_major * hertz.semi_minor) / area
        # The paper's normal force leaves out the helix.
        share *= np.sqrt(2) / float(panel.contact.normal_per_axial)
        expected = {one.name: one.correct or one.value for one in panel.printed}["Hertz"]
        # What the interpolated Hertz coefficients of the paper leave open.
        assert share * hertz.max_pressure == pytest.approx(expected, rel=2e-3)
    # The screw and the roller are both convex: the longer axis lies along the profile, where the
    # paper has the shorter one; in the concave nut both lie along the thread.
    turned = [abs(np.cos(panel.ellipse.angle)) for panel in panels]
    assert max(turned[:3]) < 0.1
    assert min(turned[3:]) > 0.9
    whole, *cut = edge_zone.rows[0]
    assert edge_zone.file_name == "lisowski2014-edge-zone"
    for panel in cut:
        edge = panel.contact.flanks.body_edge
        assert float(jnp.min(present(edge))) < 0 < float(jnp.max(present(edge)))
        peak = panel.contact.surface.max_pressure
        assert peak > 1.1 * whole.contact.surface.max_pressure
    assert published_pressures("wu2022") == ()
    with pytest.raises(prsm.UnknownNameError, match="lisowski2014"):
        published_pressures("lisowski2015")
