"""The house: layers point down only, doors only re-export, imports are light, files are short."""

import ast
import importlib
import inspect
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

import prsm_jax
from tests.layers.architecture import PAGE, page, used_rooms
from tests.layers.room_order import GROUND, LAYERS, order
from tests.of_room import files_of, folders_of_part

ROOT = Path(prsm_jax.__file__).parent
#: Not imported with the package, but where they are used.
HEAVY = (
    "diffrax",
    "optimistix",
    "lineax",
    "optax",
    "scipy.optimize",
    "xarray",
    "zarr",
    "matplotlib",
    "pint",
    "tomlkit",
    "jinja2",
    "plotly",
    "cyclopts",
    "rich",
    "tqdm",
    "mpmath",
    "nicegui",
    "fastapi",
    "uvicorn",
)
#: Rooms that serve the package alone: no page of the documentation names them to users.
WITHOUT_PAGE = {"text"}


def _files():
    return sorted(path for path in ROOT.rglob("*.py"))


def _room(path):
    parts = path.relative_to(ROOT).parts
    return parts[0] if len(parts) > 1 else None


def _imports(path):
    """Names of imported modules inside the package, as parts below it; inner imports included."""
    package = path.relative_to(ROOT).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            if node.level:
                base = package[: len(package) - node.level + 1]
                inner = (*base, *(node.module.split(".") if node.module else ()))
            elif (node.module or "").split(".")[0] == "prsm_jax":
                inner = tuple(node.module.split(".")[1:])
            else:
                continue
            for alias in node.names:
                # `from . import _contact` and `from .. import file` name modules, not the door.
                named = ROOT.joinpath(*inner, alias.name)
                module = named.is_dir() or named.with_suffix(".py").is_file()
                yield (*inner, alias.name) if module else inner
        elif isinstance(node, ast.Import):
            for alias in node.names:
                parts = alias.name.split(".")
                if parts[0] == "prsm_jax":
                    yield tuple(parts[1:])


def _rooms_used(path):
    """Rooms that a file imports from; the package's own door counts as all of them."""
    for inner in _imports(path):
        if not inner:
            yield "prsm_jax"
        elif (ROOT / inner[0]).is_dir():
            yield inner[0]


def test_the_page_on_the_architecture_is_that_of_the_imports():
    """Written by `python -m tests.layers.architecture`; imports are read there a second time."""
    assert PAGE.read_text(encoding="utf-8") == page()
    for room in LAYERS:
        files = [path for path in _files() if _room(path) == room]
        assert set(used_rooms(room)) == {
            used for path in files for used in _rooms_used(path) if used not in (room, "prsm_jax")
        }


def test_every_room_has_its_place():
    rooms = {path.name for path in ROOT.iterdir() if (path / "__init__.py").exists()}
    assert rooms <= set(LAYERS)
    assert {"mechanism", "geometry", "contact", "stiffness", "vibration", "dynamics"} <= rooms


def test_no_room_has_the_name_of_something_that_the_package_offers():
    """`import prsm_jax.sweeps` gives the room, `prsm_jax.sweep` the verb."""
    rooms = {path.name for path in ROOT.iterdir() if (path / "__init__.py").exists()}
    taken = {
        name for name in rooms if not isinstance(getattr(prsm_jax, name, prsm_jax), ModuleType)
    }
    assert not taken


def test_readme_and_docstring_name_the_order():
    readme = (ROOT.parent / "README.md").read_text(encoding="utf-8")
    for text in (readme, prsm_jax.__doc__):
        assert order() in " ".join(text.replace("*", "").split())


def test_the_order_itself_has_no_cycles():
    remaining = dict(LAYERS)
    while remaining:
        free = {room for room, below in remaining.items() if not below & set(remaining)}
        assert free
        remaining = {room: below for room, below in remaining.items() if room not in free}


@pytest.mark.parametrize("room", LAYERS)
def test_layers_point_down_only(room):
    """No file of a room imports from a room that is not below it, not even inside a function."""
    wrong = [
        f"{path.relative_to(ROOT)} imports {used}"
        for path in _files()
        if _room(path) == room
        for used in _rooms_used(path)
        if used != room and used not in LAYERS[room] and not (room == "cli" and used == "prsm_jax")
    ]
    assert not wrong


def test_rooms_are_entered_by_their_doors():
    """Another room's private modules are not imported: only what its `__init__` re-exports."""
    wrong = []
    for path in _files():
        for inner in _imports(path):
            if len(inner) > 1 and inner[0] != _room(path) and inner[-1].startswith("_"):
                wrong.append(f"{path.relative_to(ROOT)} imports {'.'.join(inner)}")
    assert not wrong


def test_no_cycles_between_files():
    """Neither between rooms nor inside one; imports inside functions count."""
    names = {path.relative_to(ROOT).with_suffix("").parts: path for path in _files()}
    graph = {}
    for name, path in names.items():
        targets = set()
        for inner in _imports(path):
            # A name re-exported by the own door would be a cycle by itself, so doors count.
            for candidate in (inner, (*inner, "__init__")):
                if candidate in names and candidate != name:
                    targets.add(candidate)
        if name[-1] == "__init__":
            targets = {t for t in targets if t[: len(name) - 1] == name[:-1]}
        graph[name] = targets
    finished, open_ = set(), []

    def visit(name):
        assert name not in open_, f"cycle: {[*open_[open_.index(name) :], name]}"
        if name in finished:
            return
        open_.append(name)
        for target in graph[name]:
            # The package's own door is at the top; the command line may use it.
            if target != ("__init__",):
                visit(target)
        open_.pop()
        finished.add(name)

    for name in graph:
        visit(name)


@pytest.mark.parametrize(
    "door", [path for path in _files() if path.name == "__init__.py"], ids=lambda p: p.parent.name
)
def test_doors_only_re_export(door):
    """A docstring and `from ._module import name as name`; a lazy door may say so in a function."""
    allowed = (ast.ImportFrom, ast.Expr, ast.FunctionDef, ast.Assign, ast.AnnAssign, ast.If)
    tree = ast.parse(door.read_text(encoding="utf-8"))
    for node in tree.body:
        assert isinstance(node, allowed), f"line {node.lineno}"
        if isinstance(node, ast.ImportFrom) and node.level:
            for alias in node.names:
                assert alias.asname == alias.name, f"{alias.name}: write `as {alias.name}`"
        if isinstance(node, ast.FunctionDef):
            # PEP 562: names that would pull in heavy modules are looked up on first use.
            assert node.name in ("__getattr__", "__dir__")
    assert ast.get_docstring(tree)


def _offered() -> set[str]:
    """Names at the top that are not rooms."""
    return {
        name
        for name in dir(prsm_jax)
        if not name.startswith("_")
        and name != "TYPE_CHECKING"
        and not inspect.ismodule(getattr(prsm_jax, name))
    }


def test_the_top_offers_few_names_and_the_page_has_all_of_them():
    page = (ROOT.parent / "docs" / "api.md").read_text(encoding="utf-8")
    offered = _offered()
    assert len(offered) <= 53
    assert set(re.findall(r"`(\w+)`", page)) == offered
    # No room shares its name with a verb.
    assert not offered & {path.name for path in ROOT.iterdir() if path.is_dir()}


def test_every_room_that_users_import_has_a_page():
    pages = {path.stem for path in (ROOT.parent / "docs" / "api").glob("*.md")}
    assert pages == set(LAYERS) - WITHOUT_PAGE


@pytest.mark.parametrize("room", sorted(set(LAYERS) - WITHOUT_PAGE))
def test_names_on_the_page_of_a_room_are_there(room):
    page = (ROOT.parent / "docs" / "api" / f"{room}.md").read_text(encoding="utf-8")
    members = page.split(":members:")[1].split(":imported-members:")[0]
    module = importlib.import_module(f"prsm_jax.{room}")
    missing = [name for name in re.findall(r"\w+", members) if not hasattr(module, name)]
    assert not missing
    assert f"api/{room}\n" in (ROOT.parent / "docs" / "api.md").read_text(encoding="utf-8")


def test_names_that_were_at_the_top_say_where_they_are():
    pages = {
        path.stem: set(re.findall(r"\w+", path.read_text(encoding="utf-8")))
        for path in (ROOT.parent / "docs" / "api").glob("*.md")
    }
    moved = [(room, name) for room, names in prsm_jax._MOVED.items() for name in names.split()]  # pyright: ignore[reportAttributeAccessIssue]
    assert len(moved) > 40
    for room, name in moved:
        with pytest.warns(DeprecationWarning, match=rf"prsm_jax\.{name} is now .*{room}\.{name}"):
            assert getattr(prsm_jax, name) is getattr(
                importlib.import_module(f"prsm_jax.{room}"), name
            )
        assert name in pages.get(room, {name}), f"{room}.{name} is on no page"
    with pytest.raises(AttributeError, match="no attribute 'modall'"):
        _ = prsm_jax.modall  # pyright: ignore[reportAttributeAccessIssue]


def test_import_pulls_in_none_of_the_heavy_modules():
    """In a fresh interpreter; each of them costs what a warm start of the whole package costs."""
    code = f"import sys, prsm_jax; print([m for m in {HEAVY!r} if m in sys.modules])"
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "[]"


def test_rooms_that_an_analysis_does_not_use_come_at_first_use():
    """Nor do the verbs of the command line bring them; `dir` names them all the same."""
    rooms = ("calibration", "explanation", "halfspace", "optimisation", "sensitivities")
    rooms += ("uncertainty",)
    code = (
        "import sys, prsm_jax; from prsm_jax.cli import _verbs; "
        f"print([r for r in {rooms!r} if 'prsm_jax.' + r in sys.modules]); "
        f"assert {{*{rooms!r}, 'optimise', 'sweep'}} <= set(dir(prsm_jax)); "
        f"assert all(getattr(prsm_jax, r).__name__ == 'prsm_jax.' + r for r in {rooms!r}); "
        "assert prsm_jax.tolerance is prsm_jax.uncertainty.tolerance"
    )
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "[]"


def test_import_enables_float64():
    code = "import prsm_jax, jax; print(jax.numpy.zeros(1).dtype)"
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "float64"


def test_files_are_short():
    """Past 400 lines there is a second concept in a file; the median stays near 150."""
    lengths = {
        path.relative_to(ROOT): len(path.read_text(encoding="utf-8").splitlines())
        for path in _files()
        if path.name != "__init__.py"
    }
    assert not {path: lines for path, lines in lengths.items() if lines > 400}
    assert sorted(lengths.values())[len(lengths) // 2] <= 160


def test_folders_are_small():
    """With more files than this a folder needs rooms within."""
    counts = Counter(path.parent.relative_to(ROOT) for path in _files())
    assert not {folder: count for folder, count in counts.items() if count > 15}


def test_every_module_says_what_it_is():
    missing = [
        str(path.relative_to(ROOT))
        for path in _files()
        if not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not missing


def test_solvers_know_no_mechanism():
    """The room inside dynamics uses what lies below dynamics, and its own files."""
    room = ("dynamics", "solvers")
    wrong = [
        f"{path.name} imports {'.'.join(inner)}"
        for path in (ROOT / "dynamics" / "solvers").glob("*.py")
        for inner in _imports(path)
        if inner[:2] != room
        and inner[0] not in ("mechanism", *GROUND)
        and not inner[0].startswith("_")
    ]
    assert not wrong


@pytest.mark.parametrize("room", LAYERS)
def test_every_room_has_tests_of_its_own(room):
    """What `make test ROOM=…` runs is there, and is more than the layers."""
    files = files_of(room)
    assert len(files) > 1
    assert all((ROOT.parent / name).exists() for name in files)


def test_a_room_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match="ROOM is 'attic'; choose one of numerics, "):
        files_of("attic")


@pytest.mark.parametrize("parts", [1, 3, 4])
def test_every_folder_of_tests_is_in_one_part(parts):
    tests = Path(__file__).parents[1]
    expected = sorted(
        {f"tests/{path.relative_to(tests).parts[0]}" for path in tests.rglob("test_*.py")}
    )
    found = [folders_of_part(part, parts) for part in range(1, parts + 1)]
    assert all(found)
    assert [folder for part in found for folder in part] == expected
    slow = (tests / "slow.txt").read_text(encoding="utf-8").splitlines()
    counts = [sum("/".join(one.split("/")[:2]) in part for one in slow) for part in found]
    assert sum(counts) == len(slow)
    assert max(counts) < 1.5 * len(slow) / parts
