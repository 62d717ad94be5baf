"""Verbs that list: quantities, example, validate."""

from typing import Annotated

from cyclopts import Parameter

from ..quantities import catalogue
from ._app import app
from ._common import Output, emit, table

_DEFAULT = Output()


@app.command
def quantities(*, output: Output = _DEFAULT) -> int:
    """The catalogue of quantities that can be computed, differentiated, optimised and swept."""
    known = [
        {"name": q.name, "symbol": q.symbol, "unit": q.unit, "description": q.description}
        for q in catalogue()
    ]
    rows = [tuple(entry.values()) for entry in known]
    columns = ["name", "symbol", "unit", "description"]
    emit(output, {"quantities": known}, lambda: table("Quantities", columns, rows))
    return 0


@app.command
def example(
    name: Annotated[str | None, Parameter(help="Which example; none lists them.")] = None,
    *,
    output: Output = _DEFAULT,
) -> int:
    """Print a shipped example as a file to start from."""
    from ..file import example_names, example_text

    if name is None:
        emit(output, {"examples": example_names()}, lambda: "\n".join(example_names()))
    else:
        emit(output, {"name": name, "text": example_text(name)}, lambda: example_text(name))
    return 0


@app.command
def validate(
    source: Annotated[str | None, Parameter(help="Only rows of this source.")] = None,
    *,
    output: Output = _DEFAULT,
) -> int:
    """Published numbers beside the computed ones, with verdicts."""
    from ..validation import table as validation_table, validate as run

    rows = run(source) if source is not None else run()
    emit(output, {"rows": [row.to_dict() for row in rows]}, lambda: validation_table(rows))
    return 0
