"""Base classes of results: numbers with units on paper and in notebooks, and a chart."""

import dataclasses
import html
import math
import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import equinox as eqx
import jax
import numpy as np

from ..fields import declared, members, units_of
from ..programs import AbstractResult, is_known
from ..text import Line, aligned, html_table
from ._charts import draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Numbers in a `repr`, and its longest text.
_IN_REPR, _LONGEST_REPR = 3, 100


class Shown:
    """Mixin of everything that prints itself: notebooks show it, and `plot` draws it."""

    def __repr__(self) -> str:
        first = next(iter(str(self).splitlines()), "")
        return _short(f"<{type(self).__name__}: {first}>")

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"

    def plot(self, **options: Any) -> "Figure":
        """The chart of this result, as a matplotlib figure.

        **Arguments:**

        - `options`: of the chart in `prsm_jax.report`.

        **Raises:** `ValueError` for a batch of designs, and for a result without a chart;
        `MissingExtraError` without matplotlib.
        """
        return draw(self, options)


class Result(Shown, eqx.Module):
    """A result whose fields declare their units (`prsm_jax.fields.In`), and that prints them.

    `print` shows the numbers of one design, or the smallest and the largest of a batch of designs;
    inside a trace, where there are no numbers, names and shapes. Nothing is compiled for it.
    """

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Axes of the batch of designs in front of all arrays; empty for a single design."""
        units = units_of(type(self))
        for one in declared(type(self)):
            value = getattr(self, one.name)
            if isinstance(value, Result):
                return value.batch_shape
            if one.name in units and value is not None and not isinstance(value, dict):
                # The shape of one design is in the annotation: `Float[Array, " stages"]`.
                shapes = [hint.dim_str.split() for hint in members(one.hint) if _has_shape(hint)]
                own = len(shapes[0]) if shapes else 0
                return tuple(value.shape[: len(value.shape) - own])
        return ()

    def lines(self) -> list[Line]:
        """What `print` shows; uses the numbers as they are, by NumPy."""
        return list(lines_of(self))

    def __str__(self) -> str:
        return aligned(*printed(self))

    def __repr__(self) -> str:
        title, lines = printed(self)
        known = [f"{line.label} {line.text}" for line in lines[:_IN_REPR]] if is_known(self) else []
        head = f"{type(self).__name__}{title.removeprefix(_title(self))}"
        return _short(f"<{': '.join([head, ', '.join(known)] if known else [head])}>")

    def _repr_html_(self) -> str:
        return html_table(*printed(self))


class DesignResult(Result, AbstractResult):
    """A `Result` whose properties, too, have the axes of a batch of designs in front."""


def _short(text: str) -> str:
    return text if len(text) <= _LONGEST_REPR else f"{text[: _LONGEST_REPR - 2]}…>"


def _has_shape(hint: Any) -> bool:
    return hasattr(hint, "dim_str")


def lines_of(result: Any, prefix: str = "") -> Iterator[Line]:
    """A line for each field with a unit; those of results within it follow, after their name.

    **Arguments:**

    - `result`: the result.
    - `prefix`: in front of each label.
    """
    units = units_of(type(result))
    for field in dataclasses.fields(result):
        name, unit = field.name, units.get(field.name)
        value, label = getattr(result, name), prefix + name.replace("_", " ")
        if isinstance(value, Result):
            yield from lines_of(value, f"{label}: ")
        elif unit is None or value is None:
            continue
        elif isinstance(value, dict):
            for key, part in value.items():
                yield Line(f"{label}: {key.replace('_', ' ')}", part, unit, name)
        else:
            yield Line(label, value, unit, name)


def printed(
    result: Any, describe: Callable[[], tuple[tuple[int, ...], list[Line]]] | None = None
) -> tuple[str, list[Line]]:
    """Title and lines of a result.

    Names and shapes where numbers are not known, or do not have the shapes that they should have.

    **Arguments:**

    - `result`: the result, or another pytree of a class with fields.
    - `describe`: gives the shape of the batch of designs and the lines; default `batch_shape` and
      `lines` of the result.
    """
    title = _title(result)
    if not is_known(result):
        return f"{title} inside a trace", list(_shapes(result))
    try:
        shape, lines = describe() if describe else (result.batch_shape, result.lines())
        # Formatted here, so that what cannot be formatted is shown by its shape.
        lines = [Line(line.label, line.text) for line in lines]
    except (TypeError, ValueError, IndexError, AttributeError, KeyError, RuntimeError):
        # Printing must not fail: a tree may hold anything after `jax.tree.map`.
        return f"{title} without numbers to show", list(_shapes(result))
    if shape:
        title += f" of {' × '.join(map(str, shape))} design{'s' * (math.prod(shape) != 1)}"
    return title, lines


def outcome(code: Any, names: Sequence[str]) -> Line:
    """A line that says what a result code means, or how often each occurs in a batch.

    **Arguments:**

    - `code`: the code or codes; `None` stands for 0.
    - `names`: by code, in words or as one word.
    """
    codes, counts = np.unique(np.zeros(1, int) if code is None else code, return_counts=True)
    words = [names[int(one)].replace("_", " ") for one in codes]
    if len(words) > 1:
        words = [f"{word}: {count}" for word, count in zip(words, counts, strict=True)]
    return Line("result", ", ".join(words))


def _title(result: Any) -> str:
    """Words of the class: "Steady state"."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(result).__name__)
    return words[:1] + words[1:].lower()


def _shapes(result: Any) -> Iterator[Line]:
    for field in dataclasses.fields(result):
        if field.metadata.get("static", False):
            continue
        leaves = jax.tree.leaves(getattr(result, field.name, None))
        arrays = [leaf for leaf in leaves if hasattr(leaf, "shape") and hasattr(leaf, "dtype")]
        if len(leaves) == len(arrays) == 1:
            (leaf,) = arrays
            words = f"{leaf.dtype}[{','.join(map(str, leaf.shape))}]"
        elif leaves:
            words = f"{len(leaves)} arrays" if len(leaves) > 1 else type(leaves[0]).__name__
        else:
            continue
        yield Line(field.name.replace("_", " "), words)
