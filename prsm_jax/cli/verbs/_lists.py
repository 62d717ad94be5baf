"""Verbs that list: quantities, example, validate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..._errors import PrsmError
from ...process import make_folder
from ...quantities import catalogue
from .._app import app
from .._common import Output, Saved, emit, write_text
from .._progress import doing
from .._tables import TextTable, terminal_width

if TYPE_CHECKING:
    from ...validation import CatalogueComparison

_DEFAULT = Output()
#: Head of the tables of errors of a catalogue.
_SUMMARY = ("column", "sizes", "median", "90th", "largest", "90th beyond rounding")


@app.command
def quantities(*, output: Output = _DEFAULT) -> int:
    """The catalogue of quantities that can be computed, differentiated, optimised and swept."""
    known = [
        {"name": q.name, "symbol": q.symbol, "unit": q.unit, "description": q.description}
        for q in catalogue()
    ]
    rows = [tuple(entry.values()) for entry in known]
    output.check_targets()
    table = TextTable("Quantities", ("name", "symbol", "SI unit", "description"), rows)
    saved = Saved("quantities", [table])
    emit(output, {"quantities": known}, lambda: table.text(terminal_width()), saved=saved)
    return 0


@app.command
def example(
    name: Annotated[str | None, Parameter(help="Name of an example; default: list all.")] = None,
    *,
    output: Output = _DEFAULT,
) -> int:
    """List the shipped examples, or print one as a file to start from.

    With --out FOLDER it is written to FOLDER/NAME.toml; prsm example NAME > my.toml writes it to
    any file.
    """
    from ...file import example_names, example_summary, example_text

    output.check_targets()
    if output.out is not None:
        if name is None:
            raise PrsmError(f"--out {output.out}: say which example to write there")
        text = example_text(name)
        make_folder(output.out)
        write_text(output.out / f"{name}.toml", text)
    if name is None:
        titles = {one: example_summary(one) for one in example_names()}
        table = TextTable("Examples", ("name", "what it is"), list(titles.items()))
        results = {"examples": example_names(), "titles": titles}
        emit(output, results, lambda: table.text(terminal_width()))
    else:
        emit(output, {"name": name, "text": example_text(name)}, lambda: example_text(name))
    return 0


@app.command
def validate(
    source: Annotated[str | None, Parameter(help="Only rows of this source.")] = None,
    *,
    rows: Annotated[
        Path | None,
        Parameter(help="With catalogue: sizes of a CSV file with columns of the shipped table."),
    ] = None,
    every_size: Annotated[
        bool, Parameter(name="--all", negative="", help="With catalogue: errors of every size.")
    ] = False,
    output: Output = _DEFAULT,
) -> int:
    """Published numbers beside the computed ones, with verdicts; --out draws the figures."""
    from ...validation import (
        compare_catalogue,
        markdown,
        table as validation_table,
        validate as run,
    )

    if source != "catalogue" and (rows is not None or every_size):
        option = "--rows" if rows is not None else "--all"
        given = "all sources" if source is None else source
        raise PrsmError(f"{option} belongs to prsm validate catalogue, not to {given}")
    output.check_targets()
    doing("computing published numbers")
    comparison = compare_catalogue(rows) if source == "catalogue" else None
    if comparison is not None and rows is not None:
        found = comparison.rows_of_numbers()
    else:
        found = run(source) if source is not None else run()
    results: dict[str, Any] = {"rows": [row.to_dict() for row in found]}
    tables: list[TextTable] = []
    if comparison is not None:
        every = every_size or rows is not None
        results["catalogue"], tables = _catalogue_results(comparison, rows is None, every)
    if output.out is not None:
        results["pictures"] = _published_pictures(output.out, source, comparison)
        write_text(output.out / f"{source or 'all'}.md", markdown(found) + "\n")

    def text() -> str:
        width = max(terminal_width(), 70)
        parts = [] if rows is not None else [validation_table(found, width)]
        parts += [one.text(width).rstrip() for one in tables]
        if output.out is not None:
            parts.append(f"{len(results['pictures'])} pictures and the table in {output.out}")
        return "\n\n".join(parts)

    emit(output, results, text)
    return 0


def _catalogue_results(
    comparison: "CatalogueComparison", halves: bool, every: bool
) -> tuple[dict[str, Any], list[TextTable]]:
    """Errors as JSON types and as tables.

    **Arguments:**

    - `comparison`: the sizes.
    - `halves`: whether those that were not fitted have a table of their own.
    - `every`: whether each size is listed.
    """
    results = comparison.to_dict()
    tables = [_summary(comparison, "Errors of all sizes", None)]
    if halves:
        half = comparison.predicted_half
        tables.append(_summary(comparison, "Errors of the diameters that are predicted", half))
    if every:
        tables.append(_sizes(comparison))
    else:
        del results["sizes"]
    return results, tables


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _summary(comparison: "CatalogueComparison", title: str, where: Any) -> TextTable:
    from ...validation import PREDICTED

    rows = []
    for name, column in PREDICTED.items():
        found = comparison.summary(name, where)
        if found is not None:
            errors = found.median, found.percentile_90, found.largest, found.beyond_rounding_90
            rows.append((column.name, str(found.sizes), *map(_percent, errors)))
    return TextTable(title, _SUMMARY, rows)


def _sizes(comparison: "CatalogueComparison") -> TextTable:
    """Printed and computed capacities, and the errors of all columns, by size."""
    from ...validation import PREDICTED

    rows = [
        (
            size,
            column.name,
            f"{comparison.printed[name][index]:.6g}",
            f"{comparison.computed[name][index]:.4g}",
            "" if column.unit == "1" else column.unit,
            f"{100 * comparison.errors(name)[index]:+.1f} %",
        )
        for index, size in enumerate(comparison.names)
        for name, column in PREDICTED.items()
        if np.isfinite(comparison.printed[name][index])
    ]
    return TextTable("Sizes", ("size", "column", "printed", "computed", "unit", "error"), rows)


def _published_pictures(
    folder: Path, source: str | None, comparison: "CatalogueComparison | None"
) -> tuple[Path, ...]:
    """Draw the figures of the papers, and the catalogue."""
    from ...report import catalogue_chart, published_figure, published_pressure, save_figures
    from ...validation import compare_catalogue, published_figures, published_pressures

    # Everything that can fail is done before the folder is made.
    drawn = {figure.file_name: published_figure(figure) for figure in published_figures(source)}
    drawn |= {one.file_name: published_pressure(one) for one in published_pressures(source)}
    if source is None:
        comparison = compare_catalogue()
    if comparison is not None:
        drawn["catalogue-computed-against-printed"] = catalogue_chart(comparison)
    return save_figures(folder, drawn)
