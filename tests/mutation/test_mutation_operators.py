"""The faults that a mutation run puts in: each changes one thing, none changes words."""

import ast
import json
from pathlib import Path

from tests.mutation.operators import faults
from tests.mutation.rooms import TESTS, core_files, quick_tests

_SOURCE = '''"""A text with 3 numbers + a sum."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    SIZE = 3


def area(width: "float | int", height, scale=2.0):
    """Width times height, 1 * 2."""
    if not width > 0:
        raise ValueError(f"width is {width + 1}")
    # 4 - 2
    whole = scale * width ** 2 - height[1]
    return -whole if width <= height else jnp.sqrt(whole)
'''


def test_each_fault_changes_one_thing_and_leaves_a_program():
    found = {(one.old, one.new, one.line) for one in faults("one.py", _SOURCE)}
    assert found == {
        ("2.0", "2.2", 9),
        ("not ", "", 11),
        (">", "<", 11),
        ("0", "1", 11),
        ("*", "/", 14),
        ("**", "*", 14),
        ("2", "3", 14),
        ("-", "+", 14),
        ("-", "", 15),
        ("<=", "<", 15),
        ("sqrt", "cbrt", 15),
    }
    for one in faults("one.py", _SOURCE):
        changed = one.applied(_SOURCE)
        assert changed != _SOURCE
        ast.parse(changed)


def test_every_core_file_has_tests_that_exist():
    root = Path(__file__).parents[2]
    for path in core_files(root / "prsm_jax"):
        assert quick_tests(str(path.relative_to(root / "prsm_jax")))
    for _, names in TESTS:
        for name in names:
            assert (root / "tests" / name).exists(), name


def test_every_reason_is_of_a_fault_that_there_is():
    """Remove a reason from `reasons.json` together with the line that it was about."""
    package = Path(__file__).parents[2] / "prsm_jax"
    reasons = json.loads((Path(__file__).parent / "reasons.json").read_text())
    for name, reason in reasons.items():
        path = name.partition(":")[0]
        known = {fault.name for fault in faults(path, (package / path).read_text())}
        assert name in known, f"no such fault any more: {name}"
        assert reason
    page = (Path(__file__).parent / "README.md").read_text()
    for name, reason in reasons.items():
        assert name.partition(":")[0] in page
        assert reason in page


def test_a_fault_keeps_its_name_when_other_lines_change():
    before = [one.name for one in faults("one.py", _SOURCE)]
    after = [one.name for one in faults("one.py", "WIDTH = other\n\n" + _SOURCE)]
    assert before == after
    assert len(set(before)) == len(before)
    twice = [
        one.name
        for one in faults("two.py", "area = side * side * side\narea = side * side * side\n")
    ]
    assert [name.rpartition("` ")[2] or "" for name in twice][1:] == [
        "(number 2)",
        "(number 3)",
        "(number 4)",
    ]
