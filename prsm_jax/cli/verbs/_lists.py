"""Verbs that list: quantities, example, validate."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..._errors import PrsmError
from ...process import make_folder
from ...quantities import catalogue
from .._app import app
from .._common import Output, emit, save_tables, write_text
from .._progress import doing
from .._tables import TextTable, terminal_width

_DEFAULT = Output()


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
    if output.out is not None:
        save_tables(output.out, "quantities", {"quantities": known}, [table])
    emit(output, {"quantities": known}, lambda: table.text(terminal_width()))
    return 0


@app.command
def example(
    name: Annotated[str | None, Parameter(help="Name of an example; default: list all.")] = None,
    *,
    output: Output = _DEFAULT,
) -> int:
    """List the shipped examples, or print one as a file to start from; --out writes the file."""
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
    output: Output = _DEFAULT,
) -> int:
    """Published numbers beside the computed ones, with verdicts; --out draws the figures."""
    from ...validation import markdown, table as validation_table, validate as run

    output.check_targets()
    doing("computing published numbers")
    rows = run(source) if source is not None else run()
    results: dict[str, Any] = {"rows": [row.to_dict() for row in rows]}
    if output.out is not None:
        results["pictures"] = _published_pictures(output.out, source)
        write_text(output.out / f"{source or 'all'}.md", markdown(rows) + "\n")

    def text() -> str:
        lines = validation_table(rows, max(terminal_width(), 70))
        if output.out is not None:
            lines += f"\n\n{len(results['pictures'])} pictures and the table in {output.out}"
        return lines

    emit(output, results, text)
    return 0


def _published_pictures(folder: Path, source: str | None) -> tuple[Path, ...]:
    """Draw the figures of the papers."""
    from ...report import published_figure, published_pressure, save_figures
    from ...validation import published_figures, published_pressures

    # Everything that can fail is done before the folder is made.
    drawn = {figure.file_name: published_figure(figure) for figure in published_figures(source)}
    drawn |= {one.file_name: published_pressure(one) for one in published_pressures(source)}
    return save_figures(folder, drawn)
