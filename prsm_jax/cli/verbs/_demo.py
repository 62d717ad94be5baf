"""Verbs that write a report: report, and demo, which differentiates and improves first."""

import datetime
import json
import shlex
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ..._errors import PrsmError
from ...mechanism import Mechanism, written_out
from ...programs import beside, one_program_where_possible
from ...quantities import assumptions, available_quantities
from .._app import app
from .._common import Common, emit, plain
from .._optimised import nothing_written, optimised_text
from .._plugins import plugin_words
from .._progress import clear, doing, expect_programs, tell
from .._tables import TextTable, terminal_width
from ._analyse import steady_results, with_result_name
from ._contact import contact_results
from ._design import told_of_search
from ._modal import modal_results
from ._simulate import transient_results

if TYPE_CHECKING:
    from ...report import Origin, ReportData

_DEFAULT = Common()
#: Programs of a report, for the line of progress.
_PROGRAMS = (
    *("_contacts", "modal", "steady_state", "_transient", "_strengths", "force_deflection"),
    "load_distribution",
)
#: Quantities of strength in the sensitivities of the demo, beside those that are the default.
_OF_STRENGTH = (
    *("dynamic_capacity", "rating_life_time", "static_safety"),
    *("buckling_safety", "critical_speed_margin"),
)
# The search for the largest stress is slow if it is not compiled.
_contact_results = one_program_where_possible(contact_results)


def _all_results(data: "ReportData") -> dict[str, Any]:
    """Results as from the verbs contact, modal, steady and simulate, as far as analysed."""
    results: dict[str, Any] = {}
    if data.meshings is not None and data.contacts is not None:
        problem = data.mechanism.design_problem
        variables = () if problem is None else (one.name for one in problem.variables)
        # As after the optimisation, so that both designs use the same program.
        stages = written_out(data.mechanism, variables).stages
        results["contact"] = _contact_results(stages, data.meshings, data.contacts)
    if data.modes is not None:
        results["modal"] = modal_results(data.modes[0])
    if data.steady is not None:
        steady = steady_results(data.steady, data.mechanism.operating_point)
        results["steady"] = with_result_name(plain(steady))
    if data.transient is not None:
        results["simulate"] = transient_results(data.transient)
    return results


@Parameter(name="*")
@dataclass(frozen=True)
class Signed:
    """Fields of a report for signature."""

    author: Annotated[str, Parameter(help="Who is responsible; default that of the file.")] = ""
    revision: Annotated[str, Parameter(help="Revision, such as B; default that of the file.")] = ""

    def origin(self, file: str, settings: Sequence[str]) -> "Origin":
        """The origin of a mechanism, with today's date."""
        from ...report import origin_of_file

        today = datetime.date.today().isoformat()
        signed = {"author": self.author, "revision": self.revision, "date": today}
        return origin_of_file(file, settings=settings, **signed)

    def words(self) -> list[str]:
        """The options that give these fields."""
        given = (("--author", self.author), ("--revision", self.revision))
        return [word for name, value in given if value for word in (name, value)]


_UNSIGNED = Signed()


def read_with_origin(
    file: str, common: Common, signed: Signed = _UNSIGNED
) -> tuple[Mechanism, "Origin"]:
    """A mechanism, read and set as `Common.load` does, and its origin for a report.

    **Raises:** `PrsmError` if the file changes while it is read, since its hash would be wrong.
    """
    origin = signed.origin(file, common.settings)
    mechanism = common.load(file)
    if signed.origin(file, common.settings).sha256 != origin.sha256:
        raise PrsmError(f"{file}: changed while it was read; run the command again")
    return mechanism, origin


def command_of(
    verb: str, file: str, folder: Path, common: Common, options: Iterable[str] = ()
) -> str:
    """The command that made a report, as it can be entered again.

    **Arguments:**

    - `verb`, `file`, `folder`, `common`: its verb, mechanism, folder of results, and `--set`;
      `--plugin` is added for each plugin that is loaded.
    - `options`: words of its other options.
    """
    words = ["prsm", verb, file, "--out", str(folder)]
    words += [word for one in common.settings for word in ("--set", one)]
    return shlex.join([*words, *options, *plugin_words()])


def tell_faults(faults: Sequence[str]) -> None:
    """Say on stderr which parts of a report are missing because of a fault."""
    for fault in faults:
        clear()
        print(f"prsm: warning: the report is not complete: {fault}", file=sys.stderr)


@app.command
def report(
    file: str,
    *,
    transient: Annotated[
        bool, Parameter(help="Simulate, where the file has a duration or a scenario.")
    ] = True,
    signed: Signed = _UNSIGNED,
    common: Common = _DEFAULT,
) -> int:
    """Write a report for signature: status, findings, inputs, drawings, results, assumptions.

    Writes report.html (everything in one file, with interactive charts), report.md, report.json
    and figures to --out (default out/report).
    """
    from ...report import LIMITS, analyse, checks_table, limits_table, write_report

    common.check_targets("out/report")
    mechanism, origin = read_with_origin(file, common, signed)
    folder = Path("out/report") if common.out is None else common.out
    expect_programs(*_PROGRAMS, "_numbers")
    doing("analysing: contact, vibration, steady state, transient, strength")
    simulated = () if transient else ("--no-transient",)
    command = command_of("report", file, folder, common, (*simulated, *signed.words()))
    data = analyse(mechanism, source=file, command=command, transient=transient, origin=origin)
    doing("drawing and writing the report")
    faults: list[str] = []
    path = write_report(folder, data, on_fault=faults.append)
    findings = data.findings or ()
    results = {
        "report": path,
        "status": data.status,
        "checks": [one.to_dict() for one in data.checks or ()],
        "limits": [one.to_dict() for one in data.limits or ()],
        "sha256": origin.sha256,
        "author": origin.author or mechanism.author,
        "revision": origin.revision or mechanism.revision,
        "date": origin.date,
        "complete": not faults,
    }

    def text() -> str:
        shown = checks_table(f"Status: {data.status}", data.checks or (), len(mechanism.stages))
        words = TextTable(shown.caption, shown.head, shown.rows).text(terminal_width())
        if data.limits:
            shown = limits_table(LIMITS, data.limits)
            words += "\n" + TextTable(shown.caption, shown.head, shown.rows).text(terminal_width())
        return f"{words}\n{path}  (everything, in one file)\n"

    valid = emit(common, results, text, assumptions(mechanism), findings)
    tell_faults(faults)
    return int(bool(faults) or not valid)


@app.command
def demo(
    file: Annotated[
        str, Parameter(help="A file or example with [operating_point] and [optimise].")
    ] = "actuator",
    *,
    signed: Signed = _UNSIGNED,
    common: Common = _DEFAULT,
) -> int:
    """Analyse, differentiate and improve a mechanism, and write a report with pictures.

    Writes report.html, report.md, report.json, figures, results.json and optimised.toml to --out
    (default out/demo).
    """
    from ...file import loads
    from ...optimisation import optimise
    from ...report import analyse, summarise_optimisation, with_optimisation, write_report
    from ...sensitivities import DEFAULT_QUANTITIES, sensitivity

    began = time.perf_counter()

    def say(what: str) -> None:
        tell(f"[{time.perf_counter() - began:5.1f} s] {what}")
        doing(what.partition(":")[0])

    common.check_targets("out/demo")
    say(f"reading {file}")
    mechanism, origin = read_with_origin(file, common, signed)
    problem = mechanism.design_problem
    if problem is None:
        raise ValueError(f"{file} has no [optimise] table; give one, or use the example actuator")

    expect_programs(
        *("_numbers", "compiled_derivatives"),
        *(*_PROGRAMS, "contact_results", "_numbers"),
    )
    folder = Path("out/demo") if common.out is None else common.out
    command = command_of("demo", file, folder, common, signed.words())
    # Most of the time goes into compiling, which two threads do at once.
    before = beside(analyse, mechanism, source=file, command=command, origin=origin)
    say("differentiating: exact sensitivities to " + ", ".join(v.name for v in problem.variables))
    table = sensitivity(
        mechanism,
        quantities=available_quantities(mechanism, (*DEFAULT_QUANTITIES, *_OF_STRENGTH)),
        parameters=[variable.name for variable in problem.variables],
    )
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
    data = with_optimisation(before(), table, summarise_optimisation(best), improved)
    results = {
        "before": _all_results(data),
        "after": {} if data.improved is None else _all_results(data.improved),
        "sensitivity": table.to_dict(),
        "optimise": best.to_dict() | {"mechanism": next(iter(files), None)},
        "assumptions": assumptions(mechanism),
        "status": {name: one.status for name, one in data.designs.items()},
        "checks": {
            name: [check.to_dict() for check in one.checks or ()]
            for name, one in data.designs.items()
        },
        "limits": {
            name: [limit.to_dict() for limit in one.limits or ()]
            for name, one in data.designs.items()
        },
        "sha256": origin.sha256,
    }
    say("drawing and writing the report")
    encoded = json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False)
    faults: list[str] = []
    path = write_report(
        folder,
        data,
        attachments={"results.json": encoded + "\n", **files},
        on_fault=faults.append,
    )
    say("done; look at")
    tell(f"  {path}  (everything, in one file)")
    for name in ("report.md", "report.json", "figures", "results.json", *files):
        tell(f"  {folder / name}")
    if not files:
        reason = "the best design found breaks limits"
        tell(nothing_written(folder / "optimised.toml", reason, common))
    tell_faults(faults)
    return int(not best.converged or bool(faults))
