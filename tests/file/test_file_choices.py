"""`--set` of words: the curvature convention."""

import pytest

from prsm_jax import file
from prsm_jax._errors import FileError


def test_a_convention_is_set_in_all_stages_or_in_one():
    mechanism = file.load("li2020_two_stage")
    both = file.apply_settings(mechanism, ["curvature=wu2022"])
    assert [stage.curvature for stage in both.stages] == ["wu2022", "wu2022"]
    second = file.apply_settings(mechanism, ["stage.2.curvature=wu2022"])
    assert [stage.curvature for stage in second.stages] == ["exact", "wu2022"]
    assert file.dumps(second) != file.dumps(mechanism)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("curvature=hertz", "is not one of exact, lisowski2014, wu2022"),
        ("stage.3.curvature=exact", "has 2 stage"),
        ("thread.curvature=exact", "did you mean curvature"),
    ],
)
def test_a_wrong_convention_is_one_line(setting, message):
    with pytest.raises(FileError, match=message):
        file.apply_settings(file.load("li2020_two_stage"), [setting])
