"""`python -m tests.layers.architecture`: writes docs/architecture.md and its picture.

Both follow from the imports; the layer tests compare the page with what would be written.
"""

import ast
from pathlib import Path

from tests.layers.room_order import GROUND, LAYERS, WAY, order
from tests.layers.walks import WALKS, in_words

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "prsm_jax"
PAGE, PICTURE = ROOT / "docs" / "architecture.md", ROOT / "docs" / "images" / "architecture.svg"

#: Rooms that stand beside the others in the picture: many arrows would cross it to them.
_ASIDE = ("file", "validation", "explanation")

_HEAD = """\
# Architecture

This page and its picture are written by `python -m tests.layers.architecture` from the imports of
the package, and a test compares them. `tests/layers/room_order.py` says which room may use which.

Data flows one way, and the folders are named after it: {order}.
A mechanism holds laws of `friction` and a `scenario`. `validation`, `explanation` and `cli` use the
rooms below them. The rooms at the ground are `fields`, `numerics`, `programs`, `text` and
`process`: they contain nothing about screws, and all other rooms use them.

![Rooms of the package, and which room imports which](images/architecture.svg)

An arrow points from a room to a room that imports it. Arrows that follow from other arrows, and
arrows from the ground, are left out.

* Other rooms import a room only by its `__init__.py` (its door), which only re-exports. The names
  of its other modules begin with `_`.
* A room does not import from a room that lies above it or beside it, not even inside a function.
* A room with more than about a dozen files has rooms within, in an order of their own.
* No room has the name of a verb: `prsm_jax.vibration` is a room, `prsm_jax.modal` a function.
* Heavy packages (diffrax, SciPy's optimisers, matplotlib, pint, xarray) are imported inside the
  functions that use them.

| room | what it is about | files | rooms within | imports |
| --- | --- | --- | --- | --- |
"""

_WALKS = """
## The way of a number

The lists show the main functions through which a number passes, in the order in which they return.
A test traces the derivative and compares the lists. No number goes back to an earlier room: a room
calls rooms below it and passes their results on. The first mechanism has no losses of spin and
rolling; with them, the contacts come between `geometry` and `dynamics`.

"""


def _doc(door: Path) -> str:
    text = ast.get_docstring(ast.parse(door.read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())


def used_rooms(room: str) -> list[str]:
    """Rooms that a room imports from, in their order."""
    found = set()
    for path in (PACKAGE / room).rglob("*.py"):
        depth = len(path.relative_to(PACKAGE).parts) - 1
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == depth + 1:
                named = [node.module] if node.module else [one.name for one in node.names]
                found |= {name.split(".")[0] for name in named}
    return [name for name in LAYERS if name in found and name != room]


def page() -> str:
    """The text of the page."""
    rows = []
    for room in LAYERS:
        folder = PACKAGE / room
        inner = sorted(p.parent.name for p in folder.glob("*/__init__.py"))
        files = sum(1 for p in folder.rglob("*.py") if p.name != "__init__.py")
        cells = [f"`{room}`", _doc(folder / "__init__.py"), str(files), ", ".join(inner) or "–"]
        rows.append("| " + " | ".join([*cells, ", ".join(used_rooms(room)) or "–"]) + " |")
    walks = "\n".join(map(in_words, WALKS))
    return _HEAD.format(order=order()) + "\n".join(rows) + "\n" + _WALKS + walks


def direct() -> dict[str, set[str]]:
    """For each room those that it imports and that none of its other imports imports."""
    uses = {room: set(used_rooms(room)) - set(GROUND) for room in LAYERS if room not in GROUND}
    below: dict[str, set[str]] = {}
    for room in uses:
        below[room] = uses[room].union(*(below[one] for one in uses[room]))
    return {
        room: {one for one in used if not any(one in below[other] for other in used - {one})}
        for room, used in uses.items()
    }


def draw(path: Path) -> None:
    """The picture: rooms from the ground up, and arrows from each to those that import it."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "architecture"
    from matplotlib import pyplot

    links = direct()
    level: dict[str, int] = {}
    for room in links:
        level[room] = 1 + max((level[one] for one in links[room]), default=-1)
    rows: dict[int, list[str]] = {}
    for room, height in level.items():
        rows.setdefault(height, []).append(room)
    places = {}
    for height, row in rows.items():
        middle = [room for room in row if room not in _ASIDE]
        for k, room in enumerate(middle):
            places[room] = (2.2 * (k - (len(middle) - 1) / 2), height)
        places |= {room: (6.6, height) for room in row if room in _ASIDE}
    figure, axes = pyplot.subplots(figsize=(9, 0.75 * len(rows) + 0.5), layout="constrained")
    for room, (x, y) in places.items():
        for below in sorted(links[room]):
            x0, y0 = places[below]
            axes.annotate(
                "",
                (x, y - 0.22),
                (x0, y0 + 0.22),
                arrowprops={"arrowstyle": "-|>", "color": "0.55", "lw": 0.9, "shrinkA": 0},
                zorder=1,
            )
        on_way = any(room in group for group in WAY)
        axes.text(
            x,
            y,
            room,
            ha="center",
            va="center",
            fontsize=10,
            bbox={
                "boxstyle": "round,pad=0.35",
                "facecolor": "#dce9f5" if on_way else "#f2f2f2",
                "edgecolor": "#356a9c" if on_way else "0.5",
            },
        )
    across = [x for x, _ in places.values()]
    axes.set_xlim(min(across) - 1.2, max(across) + 1.2)
    axes.set_ylim(-0.6, max(level.values()) + 0.6)
    axes.axis("off")
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)


def main() -> int:
    """Write both."""
    PAGE.write_text(page(), encoding="utf-8")
    draw(PICTURE)
    print(f"{PAGE.relative_to(ROOT)}, {PICTURE.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
