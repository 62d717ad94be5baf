"""The verb that lists the optional parts of a file: explain."""

from typing import Annotated

from cyclopts import Parameter

from .._app import app
from .._common import Common, Saved, emit, words_of
from .._progress import counted, doing
from .._tables import prose, terminal_width

_DEFAULT = Common()
_WITHOUT = "Parts have the names of their fields; --numbers lists optional numbers too.\n"


@app.command
def explain(
    file: str,
    *,
    programs: Annotated[
        str | None,
        Parameter(help="steady_state, modes, transient, quantities, separated by commas."),
    ] = None,
    numbers: Annotated[
        bool, Parameter(negative="", help="Also list optional numbers, and the cost of each.")
    ] = False,
    time: Annotated[
        bool,
        Parameter(negative="", help="Also compile and run each program; takes minutes."),
    ] = False,
    common: Common = _DEFAULT,
) -> int:
    """Optional parts that the file has, those that it leaves out and why, and the cost of each.

    The cost of a part is the difference between the program with it and without it: equations that
    JAX traces; with --time also flops and bytes, memory, compiling and run time. --out writes
    explain.json and explain.md.
    """
    mechanism = common.load(file)
    doing("counting parts")
    from ...explanation import explain as run_explain

    explanation = run_explain(
        mechanism, programs=words_of(programs), numbers=numbers, time=time, progress=counted
    )
    results = explanation.to_dict()
    tables = explanation.tables(numbers)

    def text() -> str:
        words = "\n".join(table.text(terminal_width()) for table in tables)
        return words if numbers else words + "\n" + prose(_WITHOUT)

    saved = Saved("explain", tables, () if numbers else (_WITHOUT,))
    return int(not emit(common, results, text, saved=saved))
