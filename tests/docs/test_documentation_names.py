"""Names on pages: every public name is on a page of the API, and every named function exists."""

import ast
import importlib
import re
from pathlib import Path

import pytest

import prsm_jax
from tests.layers.room_order import LAYERS
from tests.layers.test_layers import WITHOUT_PAGE

PACKAGE = Path(prsm_jax.__file__).parent
DOCS = PACKAGE.parent / "docs"


def _public(door: Path) -> set[str]:
    """Names that a door re-exports from its own modules."""
    return {
        alias.asname or alias.name
        for node in ast.walk(ast.parse(door.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.level
        for alias in node.names
        if not alias.name.startswith("_")
    }


def _words(page: Path) -> set[str]:
    """Names in code spans and in blocks of directives; words of sentences do not count."""
    text = page.read_text(encoding="utf-8")
    code = re.findall(r"`([^`\n]+)`", text) + re.findall(
        r"^```\{eval-rst\}$(.*?)^```$", text, flags=re.M | re.S
    )
    return set(re.findall(r"\w+", " ".join(code)))


@pytest.mark.parametrize("room", sorted(set(LAYERS) - WITHOUT_PAGE))
def test_every_name_of_a_door_is_on_its_page(room):
    """A new one: `.. autofunction:: prsm_jax.ROOM.NAME` under "Further names", or `:members:`."""
    names = _public(PACKAGE / room / "__init__.py")
    assert names
    missing = sorted(names - _words(DOCS / "api" / f"{room}.md"))
    assert not missing, f"docs/api/{room}.md lacks {', '.join(missing)}"


@pytest.mark.parametrize("room", sorted(set(LAYERS) - WITHOUT_PAGE))
def test_every_name_of_a_page_exists(room):
    """Sphinx reports others only when it builds the pages."""
    text = (DOCS / "api" / f"{room}.md").read_text(encoding="utf-8")
    module = importlib.import_module(f"prsm_jax.{room}")
    named = re.findall(rf"^\.\. auto\w+:: prsm_jax\.{room}\.(\w+)$", text, flags=re.M)
    assert not [name for name in named if not hasattr(module, name)]


def test_every_name_at_the_top_is_on_the_page_of_the_interface():
    # Rooms have links.
    names = _public(PACKAGE / "__init__.py") - set(LAYERS)
    assert len(names) > 50
    missing = sorted(names - _words(DOCS / "api.md"))
    assert not missing, f"docs/api.md lacks {', '.join(missing)}"


def _equations() -> list[str]:
    """The column of functions of all tables before the misprints."""
    tables, _, _ = (DOCS / "equations.md").read_text(encoding="utf-8").partition("## Misprints")
    rows = re.findall(r"^\| (.*) \|$", tables, flags=re.M)
    return [row.split(" | ")[1] for row in rows if not row.startswith("equation |")]


def test_every_function_of_the_equations_exists():
    columns = _equations()
    assert len(columns) > 70
    for column in columns:
        names = re.findall(r"`([\w.]+)`", column)
        assert names, column
        for name in names:
            room, *path = name.split(".")
            found = importlib.import_module(f"prsm_jax.{room}")
            assert path[0] in _public(PACKAGE / room / "__init__.py"), name
            for one in path:
                found = getattr(found, one)
            assert callable(found) or isinstance(found, property), name


def test_every_room_with_equations_has_a_table():
    """Rooms of physics: those from geometry to forced vibration, with friction."""
    named = {name for column in _equations() for name in re.findall(r"`(\w+)\.", column)}
    physics = {"mechanism", "friction", "geometry", "contact", "halfspace", "load_sharing"}
    physics |= {"strength", "stiffness", "vibration", "dynamics", "response"}
    assert physics <= named


def test_every_citation_of_the_equations_is_listed():
    """Names with a year in the column of sources are the entries of the list of sources."""
    text = (DOCS / "equations.md").read_text(encoding="utf-8")
    words = r"(?:[A-Z]\w+|de|and)"
    cited = set()
    for row in re.findall(r"^\| (.*) \|$", text.partition("## Misprints")[0], flags=re.M):
        cited |= set(re.findall(rf"{words}(?: {words})* \d{{4}}(?![-\d])", row.split(" | ")[2]))
    entries = re.findall(r"^(\S.* \d{4})\n: ", text, flags=re.M)
    assert len(entries) == len(set(entries)) > 30
    assert cited == set(entries)
