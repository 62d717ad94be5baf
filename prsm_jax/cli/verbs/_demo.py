"""The main job in one command: analyse, differentiate, improve, report."""

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import equinox as eqx
from cyclopts import Parameter

from ...quantities import assumptions
from .._app import app
from .._common import Common, plain
from .._optimised import optimised_text
from .._progress import clear, doing, expect_programs, tell
from .._tables import terminal_width
from ._analyse import steady_results, told
from ._contact import contact_results
from ._design import told_of_search
from ._modal import modal_results
from ._simulate import transient_results

if TYPE_CHECKING:
    from ...report import ReportData

_DEFAULT = Common()
# The search for the largest stress is slow if it is not compiled.
_contact_results = eqx.filter_jit(contact_results)


def _all_results(data: "ReportData") -> dict[str, Any]:
    """Results as from the verbs contact, modal, steady and simulate, as far as analysed."""
    results: dict[str, Any] = {}
    if data.meshings is not None and data.contacts is not None:
        results["contact"] = _contact_results(data.mechanism.stages, data.meshings, data.contacts)
    if data.modes is not None:
        results["modal"] = modal_results(data.modes[0])
    if data.steady is not None:
        steady = steady_results(data.steady, data.mechanism.operating_point)
        results["steady"] = told(plain(steady))
    if data.transient is not None:
        results["simulate"] = transient_results(data.transient)
    return results


@app.command
def demo(
    file: Annotated[
        str, Parameter(help="A file or example with [operating_point] and [optimise].")
    ] = "actuator",
    *,
    common: Common = _DEFAULT,
) -> int:
    """Analyse, differentiate and improve a mechanism, and write a report with pictures.

    Writes report.html, report.md, figures, results.json and optimised.toml to --out (default
    out/demo).
    """
    from ...file import loads
    from ...optimisation import optimise
    from ...report import analyse, summarise_optimisation, write_report
    from ...sensitivities import sensitivity

    began = time.perf_counter()

    def say(what: str) -> None:
        tell(f"[{time.perf_counter() - began:5.1f} s] {what}")
        doing(what.partition(":")[0])

    common.check_targets("out/demo")
    say(f"reading {file}")
    mechanism = common.load(file)
    problem = mechanism.design_problem
    if problem is None:
        raise ValueError(f"{file} has no [optimise] table; give one, or use the example actuator")

    expect_programs(
        *(
            "_numbers",
            "compiled_values",
            "compiled_derivatives",
            "_contacts",
            "modal",
            "steady_state",
        ),
        *("_transient", "_strengths", "force_deflection", "load_distribution"),
        *("contact_results", "_numbers"),
    )
    say("differentiating: exact sensitivities to " + ", ".join(v.name for v in problem.variables))
    table = sensitivity(mechanism, parameters=[variable.name for variable in problem.variables])
    tell(table.text(terminal_width()))

    say(f"optimising from {problem.starts} starts")
    best = optimise(mechanism, progress=told_of_search)
    tell(best.text(terminal_width()))

    text = optimised_text(file, best)
    # The improved mechanism is read from its file, so that an analysis of the file gives the
    # numbers of the report.
    improved = loads(text, name="optimised.toml")
    # A design that breaks limits is shown in the report, but not written as a file.
    files = {"optimised.toml": text} if best.feasible else {}

    say("analysing both designs: contact, vibration, steady state, transient")
    folder = Path("out/demo") if common.out is None else common.out
    data = analyse(
        mechanism,
        source=file,
        command=f"prsm demo {file} --out {folder}",
        sensitivity=table,
        optimisation=summarise_optimisation(best),
        improved=improved,
    )
    results = {
        "before": _all_results(data),
        "after": {} if data.improved is None else _all_results(data.improved),
        "sensitivity": table.to_dict(),
        "optimise": best.to_dict() | {"mechanism": next(iter(files), None)},
        "assumptions": assumptions(mechanism),
    }
    say("drawing and writing the report")
    encoded = json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False)
    faults: list[str] = []
    report = write_report(
        folder,
        data,
        attachments={"results.json": encoded + "\n", **files},
        on_fault=faults.append,
    )
    say("done; look at")
    tell(f"  {report}  (everything, in one file)")
    for name in ("report.md", "figures", "results.json", *files):
        tell(f"  {folder / name}")
    for fault in faults:
        clear()
        print(f"prsm: warning: the report is not complete: {fault}", file=sys.stderr)
    return int(not best.converged or bool(faults))
