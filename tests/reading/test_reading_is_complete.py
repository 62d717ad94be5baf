"""A chart, section or verb that nobody reads is found here."""

import ast
import importlib
import sys
from pathlib import Path
from typing import Any

from expectations import READ

_HERE = Path(__file__).parent
_REPORT = _HERE.parents[1] / "prsm_jax" / "report"


def _read(kind):
    for path in sorted(_HERE.rglob("test_reading_*.py")):
        if str(path.parent) not in sys.path:
            sys.path.insert(0, str(path.parent))
        importlib.import_module(path.stem)
    return set(READ[kind])


def _drawn() -> set[str]:
    """Public functions of the report that draw: those in the house style, and animations."""
    found = set()
    for path in _REPORT.rglob("*.py"):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                styled = any(getattr(d, "id", "") == "drawn" for d in node.decorator_list)
                if styled or node.name.endswith("_animation"):
                    found.add(node.name)
    return found


def test_every_chart_has_a_reader():
    assert _drawn() == _read("chart")


def test_every_section_has_a_reader():
    body = next(
        node
        for node in ast.parse((_REPORT / "document" / "_sections.py").read_text()).body
        if isinstance(node, ast.FunctionDef) and node.name == "_sections"
    )
    # Rows of the table: anchor, title, and the function that makes the section.
    rows: list[Any] = [node.elts for node in ast.walk(body) if isinstance(node, ast.Tuple)]
    given = {row[2].id for row in rows if len(row) == 3 and isinstance(row[0], ast.Constant)}
    assert given == _read("section")


def test_every_verb_has_a_reader():
    found = set()
    for path in (_REPORT.parent / "cli").rglob("*.py"):
        for node in ast.parse(path.read_text()).body:
            decorators = getattr(node, "decorator_list", [])
            if isinstance(node, ast.FunctionDef) and any(
                ast.unparse(one).startswith("app.command") for one in decorators
            ):
                found.add(node.name)
    assert found == _read("verb")
