"""The matrix as pictures: one coloured cell per pair of row and column."""

import base64
import functools
import html
import io
import itertools
from pathlib import Path
from typing import Any

import numpy as np

from ..cells import KINDS, STATUSES, Table

#: Worst first: the colour of a pair is that of the worst of its three cells.
_RANK = ("crash", "hang", "not_finite", "wrong_value", "wrong_gradient", "accepted")
_RANK = (*_RANK, "open", "finite", "refused", "agrees", "untouched", "absent")
#: `<`, `>` and `&` as SVG writes them; quotation marks stay.
escape = functools.partial(html.escape, quote=False)
_GREY = "#f2f2f2"


def _worst(three) -> str:
    return min((cell.status for cell in three), key=_RANK.index)


def _rgb(colour: str) -> tuple[int, int, int]:
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))  # type: ignore[return-value]


def _png(pixels: np.ndarray) -> bytes:
    from PIL import Image

    written = io.BytesIO()
    Image.fromarray(pixels).save(written, format="PNG", optimize=True)
    return written.getvalue()


def _image(table: Table, rows: list[dict[str, Any]], wide: int, high: int) -> bytes:
    """Cells of so many pixels, apart from each other where they are large enough for it.

    As large as they are shown, for not every viewer leaves the edges of enlarged pixels sharp.
    """
    pixels = np.full((len(rows), len(table.columns), 3), _rgb(_GREY), np.uint8)
    for i, row in enumerate(rows):
        cells = table.cells.get(row["name"], {})
        for j, column in enumerate(table.columns):
            if column in cells:
                pixels[i, j] = _rgb(STATUSES[_worst(cells[column])].colour)
    large = np.repeat(np.repeat(pixels, high, axis=0), wide, axis=1)
    if high > 5:
        large[high - 1 :: high] = 255
    large[:, wide - 1 :: wide] = 255
    return _png(large)


#: Groups of rows, and what they are.
GROUPS = {
    "single": "extremes one by one",
    "combination": "random combinations",
    "number": "NaN, infinity, zero and its negative in every number",
}


def _labels(rows: list[dict[str, Any]], group: str) -> list[tuple[str, int, int]]:
    if group == "number":
        # Four rows to a number: one label for them.
        runs = itertools.groupby(enumerate(rows), lambda pair: pair[1]["name"].rpartition(":")[0])
        groups = [(name, list(group)) for name, group in runs]
        return [(name, group[0][0], len(group)) for name, group in groups]
    return [(row["name"], index, 1) for index, row in enumerate(rows)]


def _key(table: Table, rows: list[dict[str, Any]]) -> list[str]:
    """Colours that occur, and what they mean."""
    found = {_worst(cells) for row in rows for cells in table.cells.get(row["name"], {}).values()}
    parts = []
    for place, name in enumerate(name for name in STATUSES if name in found):
        y = 54 + 13 * place
        parts.append(
            f'<rect x="8" y="{y - 9}" width="16" height="11" fill="{STATUSES[name].colour}" '
            f'stroke="#888888"/>'
        )
        text = f"{name.replace('_', ' ')}: {STATUSES[name].meaning}"
        parts.append(f'<text x="30" y="{y}">{escape(text)}</text>')
    return parts


def svg(table: Table, title: str, group: str) -> str:
    """Rows of one group of a structure, with the names of rows and columns."""
    rows = [row for row in table.rows if row["group"] == group]
    labelled = group != "combination"
    step = {"single": 11, "number": 3, "combination": 3}[group]
    wide, left, top = 11, 330, 230
    # Wide enough for slanted names of the last columns, and for the key.
    width = max(left + wide * len(table.columns) + 110, 620)
    height = top + step * len(rows) + 20
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}" font-family="sans-serif" font-size="9">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        f'<text x="8" y="18" font-size="13">{escape(title)}</text>',
        f'<text x="8" y="34">{len(rows)} {GROUPS[group]}, {len(table.columns)} columns</text>',
    ]
    for j, column in enumerate(table.columns):
        x = left + wide * j + 8
        parts.append(
            f'<text transform="translate({x},{top - 5}) rotate(-60)">{escape(column)}</text>'
        )
    parts += _key(table, rows)
    data = base64.b64encode(_image(table, rows, wide, step)).decode()
    parts.append(
        f'<image x="{left}" y="{top}" width="{wide * len(table.columns)}" '
        f'height="{step * len(rows)}" preserveAspectRatio="none" image-rendering="pixelated" '
        f'href="data:image/png;base64,{data}"/>'
    )
    if labelled:
        for name, first, count in _labels(rows, group):
            y = top + step * (first + count / 2) + 3
            parts.append(
                f'<text x="{left - 6}" y="{y:.1f}" text-anchor="end">{escape(name)}</text>'
            )
    else:
        y = top + step * len(rows) / 2
        parts.append(
            f'<text x="{left - 6}" y="{y:.1f}" text-anchor="end">one row for each, in the order '
            f"of the seed</text>"
        )
    parts.append("</svg>")
    return "\n".join(parts) + "\n"


def write_pictures(tables: list[tuple[Table, str]], folder: Path) -> list[tuple[str, str, Path]]:
    """One picture per structure and group of rows; structure, group and path of each."""
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    for table, title in tables:
        for group in GROUPS:
            if any(row["group"] == group for row in table.rows):
                path = folder / f"extremes-{table.structure}-{group}.svg"
                path.write_text(svg(table, title, group), encoding="utf-8")
                found.append((table.structure, group, path))
    return found


__all__ = ["GROUPS", "KINDS", "svg", "write_pictures"]
