"""The picture of the stress below a contact."""

import pytest
from report_checks import outside, overlaps
from scenes import array, example, stage_contact

from prsm_jax.contact import hertz_contact
from prsm_jax.report import subsurface_chart


def test_section_has_its_numbers_and_no_words_on_words():
    hertz = stage_contact(example("lisowski2014").stages[0], array(1000.0)).screw.hertz
    figure = subsurface_chart(hertz, 0.3, 0.1)
    assert not overlaps(figure)
    assert not outside(figure)
    still, sliding, bar = figure.axes
    assert still.get_title(loc="left") == "without friction"
    assert "0.1" in sliding.get_title(loc="left")
    assert "MPa" in bar.get_ylabel()
    assert "mm" in sliding.get_xlabel()
    # The numbers drawn are those of the peak: 0.61 to 0.62 p₀ for any ellipse like this.
    drawn = float(still.texts[0].get_text().split()[0])
    assert drawn == pytest.approx(0.615e-6 * float(hertz.max_pressure), rel=0.01)
    assert float(sliding.texts[0].get_text().split()[0]) > drawn


@pytest.mark.usefixtures("unchecked")
def test_nothing_to_show_is_said():
    empty = hertz_contact(array(0.0), array(100.0), array(0.0), array(1e11))
    with pytest.raises(ValueError, match="no load"):
        subsurface_chart(empty, 0.3)
    with pytest.raises(ValueError, match="choose major or minor"):
        subsurface_chart(empty, 0.3, along="middle")  # pyright: ignore[reportArgumentType]
