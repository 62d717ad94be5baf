"""All inputs of a mechanism with units and meaning, and which of them were assumed."""

import dataclasses
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

import equinox as eqx
import numpy as np

from ...fields import Declared, values_of
from ...file import loads, table_choices
from ...mechanism import Mechanism, find_parameters
from ...quantities import catalogue
from ...text import NumberText, display_unit, printable, related, with_label
from .._style import readable
from ..results import ReportData
from ._section import Section, Table

_HEADS = ("input", "value", "meaning", "source")
#: Names of fields whose tables in a file are called otherwise.
_IN_FILE = {"stages": "stage"}
#: Fields that other sections show, or that are no numbers of the mechanism.
_ELSEWHERE = (
    *("title", "author", "revision", "design_problem", "tolerances", "duty_cycle", "stages"),
)
#: Longest list that is printed in full.
_LONGEST = 12
_DEFAULT = "default"


@dataclasses.dataclass(frozen=True)
class _Given:
    """A part as the file states it: its table, and the part without changed settings."""

    table: Mapping[str, Any] | None
    part: Any

    def inner(self, key: str, place: int | None = None) -> "_Given":
        table = None if self.table is None else self.table.get(_IN_FILE.get(key, key))
        part = getattr(self.part, key, None)
        if place is not None:
            table = table[place] if isinstance(table, list) and place < len(table) else None
            part = part[place] if isinstance(part, tuple) and place < len(part) else None
        return _Given(table if isinstance(table, Mapping) else None, part)

    def source(self, one: Declared, value: Any, before: Any) -> str:
        """Whether the file gives a value, a setting changed it, or it was assumed."""
        if self.part is not None and not _same(value, before):
            return "--set"
        if self.table is not None and one.name in self.table:
            return "file"
        return _DEFAULT


def _same(first: Any, second: Any) -> bool:
    if first is None or second is None:
        return first is second
    return np.array_equal(np.asarray(first), np.asarray(second))


def input_text(value: Any, unit: str | None) -> str:
    """An input as text: a number to nine digits with its unit, a word, or a list."""
    if unit is None:
        return "yes" if value is True else "no" if value is False else printable(str(value))
    numbers = np.atleast_1d(np.asarray(value, dtype=float))
    shown = display_unit(unit, [float(one) for one in numbers])
    texts = [_nine_digits(shown(float(one))) for one in numbers]
    if len(texts) > _LONGEST:
        texts = [*texts[: _LONGEST - 1], f"… ({len(texts)} numbers)"]
    if len(texts) == 1:
        return with_label(texts[0], shown.label)
    return ", ".join(texts) + (f"\N{NARROW NO-BREAK SPACE}{shown.label}" if shown.label else "")


def _nine_digits(value: float) -> NumberText:
    return NumberText(f"{value:.9g}".replace("-", "\N{MINUS SIGN}"), float(value))


def _law(hint: Any, value: Any, unit: str) -> str:
    """The word by which a file names the class of a part; empty if there is only one class."""
    choices = table_choices(hint, unit)
    return next((word for word, choice in choices.items() if choice.holds(value)), "")


def _tables(
    part: Any, name: str, given: _Given, unit: str = "1", hint: Any = None
) -> Iterator[Table]:
    """The table of a part, and those of the parts within it."""
    rows: list[tuple[str, str, str, str]] = []
    inner: list[Table] = []
    law = "" if hint is None else _law(hint, part, unit)
    if law:
        rows.append(("law", law, "", "file" if given.table is not None else _DEFAULT))
    before = {} if given.part is None else {o.name: v for o, v in values_of(given.part, unit)}
    for one, value in values_of(part, unit):
        if value is None or one.name in _ELSEWHERE:
            continue
        key, own = f"{name}.{one.name}" if name else one.name, one.unit or unit
        if isinstance(value, tuple):
            for place, row in enumerate(value):
                at = given.inner(one.name, place)
                inner += _tables(row, f"{key} {place + 1}", at, own, one.element)
        elif isinstance(value, eqx.Module):
            inner += _tables(value, key, given.inner(one.name), own, one.hint)
        elif callable(value):
            rows.append((readable(one.name), "a function", one.description, "Python"))
        else:
            text = input_text(value, None if one.unit is None else own)
            source = given.source(one, value, before.get(one.name, value))
            rows.append((readable(one.name), text, one.description, source))
    if rows:
        yield Table(f"[{name}]", _HEADS, tuple(rows))
    yield from inner


def _duty_cycle(mechanism: Mechanism) -> Iterator[Table]:
    cycle = mechanism.duty_cycle
    if cycle is None:
        return
    columns = list(values_of(cycle))
    units = {
        one.name: display_unit(one.unit or "1", np.abs(np.asarray(v)).ravel().tolist())
        for one, v in columns
    }
    lists = [[_nine_digits(units[o.name](float(x))) for x in np.ravel(v)] for o, v in columns]
    rows = tuple((str(i), *row) for i, row in enumerate(zip(*lists, strict=True), start=1))
    head = ("phase", *(f"{o.name} in {units[o.name].label}" for o, _ in columns))
    yield Table("[[duty_cycle]]", head, rows)


def _optimise(mechanism: Mechanism) -> Iterator[Table]:
    problem = mechanism.design_problem
    if problem is None:
        return
    aims = tuple(
        (one.sense, readable(one.quantity), _nine_digits(one.weight), one.over)
        for one in problem.objectives
    )
    yield Table("[optimise] objectives", ("sense", "quantity", "weight", "over points"), aims)
    variables = tuple(
        (readable(one.name), *(input_text(x, _unit(mechanism, one.name)) for x in ends))
        for one in problem.variables
        for ends in [(one.lower, one.upper)]
    )
    yield Table("[optimise] variables", ("variable", "lower bound", "upper bound"), variables)
    units = {one.name: one.unit for one in catalogue()}
    signs = {"lower": "at least", "upper": "at most", "equal": "equal to"}
    limits = tuple(
        (
            readable(one.quantity),
            # A quantity of a plugin that is not loaded has a bare number.
            related(words, input_text(limit, units.get(one.quantity.partition("[")[0], "1"))),
        )
        for one in problem.constraints
        for side, words in signs.items()
        for limit in [getattr(one, side)]
        if limit is not None
    )
    if limits:
        yield Table("[optimise] constraints", ("quantity", "limit"), limits)


def _tolerances(mechanism: Mechanism) -> Iterator[Table]:
    rows = tuple(
        (
            readable(one.name),
            *(input_text(x, _unit(mechanism, one.name)) for x in (one.lower, one.upper)),
            one.distribution,
        )
        for one in mechanism.tolerances or ()
    )
    if rows:
        head = ("number", "lower deviation", "upper deviation", "distribution")
        yield Table("[tolerances]", head, rows)


def _unit(mechanism: Mechanism, name: str) -> str:
    return find_parameters(mechanism, name)[0].unit


def _from_file(data: ReportData) -> _Given:
    text = data.origin.text
    if not text:
        return _Given(None, None)
    return _Given(tomllib.loads(text.removeprefix("\ufeff")), loads(text, name=data.source))


def inputs_section(data: ReportData) -> Section:
    """Every number and choice of the mechanism, from the fields that its classes declare."""
    mechanism, given = data.mechanism, _from_file(data)
    tables: list[Table] = []
    for index, stage in enumerate(mechanism.stages):
        name = "stage" if len(mechanism.stages) == 1 else f"stage {index + 1}"
        tables += _tables(stage, name, given.inner("stages", index))
    tables += _tables(mechanism, "", given)
    for more in (_duty_cycle, _optimise, _tolerances):
        tables += more(mechanism)
    assumed = sum(row[-1] == _DEFAULT for t in tables if t.head == _HEADS for row in t.rows)
    words = ["The tables are named as in the file."]
    if data.origin.text:
        words.append(
            f"Source: 'file', stated in the file; 'default', not in the file and assumed "
            f"({assumed} inputs); '--set', changed on the command line."
        )
    else:
        words.append(
            "The mechanism was not read from a file, so the sources of its values are not known."
        )
        tables = [_without_source(table) for table in tables]
    return Section("inputs", "Inputs", tuple(words), tuple(tables))


def _without_source(table: Table) -> Table:
    if table.head != _HEADS:
        return table
    return Table(table.caption, table.head[:-1], tuple(row[:-1] for row in table.rows))
