"""The light drawing shows what the drawing of the report shows, to scale."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

import prsm_jax as prsm
from prsm_jax.report import cross_section, section_svg
from prsm_jax.report._style import BODY_COLOURS

SMALL = Path(__file__).with_name("small_screw.toml")
_SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize(("source", "on_paper"), [("actuator", 1.0), (SMALL, 2.0)])
def test_views_are_to_scale_and_have_the_words_of_the_report(source, on_paper):
    mechanism = prsm.load(source)
    across, along, scale = section_svg(mechanism)
    assert scale == on_paper
    thread, count = mechanism.stages[0].thread, mechanism.stages[0].roller_count
    page = ElementTree.fromstring(across)
    circles = [one.attrib for one in page.iter(f"{_SVG}circle")]
    roller = 1e3 * float(thread.roller_radius) * scale
    rollers = [one for one in circles if one["fill"] == BODY_COLOURS["roller"]]
    # Coordinates have two decimals of a millimetre on paper.
    assert [float(one["r"]) for one in rollers] == pytest.approx([roller] * count, abs=0.006)
    assert len({(one["cx"], one["cy"]) for one in rollers}) == count
    # A standard roller screw: the screw has starts - 2 radii of the roller, the nut two more.
    nut = roller * float(thread.starts)
    assert min(abs(float(one["r"]) - nut) for one in circles) < 0.006
    middle = float(page.attrib["viewBox"].split()[2]) / 2
    across_centres = max(float(one["cx"]) for one in rollers) - middle
    assert across_centres == pytest.approx(nut - roller, abs=0.011)
    words = {"".join(one.itertext()) for view in (across, along) for one in _texts(view)}
    # The third is the enlarged detail, which the page leaves out.
    report = cross_section({"": mechanism}).axes[:2]
    told = {text.get_text().replace("\n", "") for axes in report for text in axes.texts}
    assert words == told - {""}


def _texts(view):
    return ElementTree.fromstring(view).iter(f"{_SVG}text")


def test_the_nut_is_as_long_as_its_dimension():
    _, along, scale = section_svg(prsm.load("actuator"))
    path = next(
        one.attrib["d"]
        for one in ElementTree.fromstring(along).iter(f"{_SVG}path")
        if one.attrib.get("fill") == BODY_COLOURS["nut"]
    )
    xs = [float(x) for x in re.findall(r"[ML]([\d.]+) ", path)]
    # The nut of 80 mm.
    assert max(xs) - min(xs) == pytest.approx(80 * scale, abs=0.02)


def test_the_half_section_stands_upright():
    """In SVG y grows downwards: the nut lies over the roller, the roller over the screw."""
    _, along, scale = section_svg(prsm.load("actuator"))
    middles = {}
    for body in ("nut", "roller", "screw"):
        path = next(
            one.attrib["d"]
            for one in ElementTree.fromstring(along).iter(f"{_SVG}path")
            if one.attrib.get("fill") == BODY_COLOURS[body]
        )
        ys = [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", path)]
        middles[body] = (min(ys) + max(ys)) / 2
    assert middles["nut"] < middles["roller"] < middles["screw"]
    # Roller of 8 mm and screw down to the bore of 8 mm: from 12 mm to 4 mm, in halves of teeth.
    assert middles["screw"] - middles["roller"] == pytest.approx(8 * scale, abs=0.5 * scale)


def test_a_stage_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="stage"):
        section_svg(prsm.load("wu2022"), 3)
