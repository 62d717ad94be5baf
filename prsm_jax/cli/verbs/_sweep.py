"""The verb `sweep`: quantities at many designs, into a store that a later run continues."""

import dataclasses
import os
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from ..._errors import PrsmError, missing_extra
from ...mechanism import Constraint, Mechanism
from ...process import folder_for_results
from ...quantities import assumptions, available_quantities, catalogue
from ...sweeps import (
    PlanName,
    check_export,
    collect as collect_blocks,
    count_codes,
    export as run_export,
    sweep as run_sweep,
)
from .._app import app
from .._common import Common, checked, emit, parameters_of, value_of, words_of
from .._counts import MOST_DESIGNS, count
from .._progress import Counter, clear, doing, expect_programs
from .._tables import prose

_DEFAULT = Common()
#: Plans between two limits on every axis.
_SAMPLED = ("lhs", "sobol")


def _axis(mechanism: Mechanism, text: str, plan: str) -> tuple[str, np.ndarray]:
    """`NAME=FIRST:LAST:COUNT`, `NAME=LOWER:UPPER` or `NAME=VALUE,VALUE,…`, as in `--set`."""
    limits = "NAME=LOWER:UPPER" if plan in _SAMPLED else "NAME=FIRST:LAST:COUNT"
    name, equals, numbers = (part.strip() for part in text.partition("="))
    if not (name and equals and numbers):
        raise PrsmError(f"--axis {text}: must be {limits} or NAME=VALUE,VALUE,…")

    def value(word: str) -> float:
        return value_of(mechanism, name, word, f"--axis {text}")

    parts = numbers.split(":")
    if len(parts) == 1:
        return name, np.asarray([value(word) for word in numbers.split(",")])
    if plan in _SAMPLED:
        if len(parts) != 2:
            raise PrsmError(
                f"--axis {text}: plan {plan} takes LOWER:UPPER, such as 'lead=5 mm:15 mm'"
            )
        return name, np.asarray([value(parts[0]), value(parts[1])])
    digits = parts[2].strip() if len(parts) == 3 else ""
    # Python converts no number of thousands of digits.
    if digits.isdigit() and (len(digits) > len(str(MOST_DESIGNS)) or int(digits) > MOST_DESIGNS):
        raise PrsmError(f"--axis {name}: the count is above {MOST_DESIGNS}; give fewer values")
    if not digits.isdigit() or int(digits) < 2:
        raise PrsmError(
            f"--axis {text}: a range is FIRST:LAST:COUNT with a count of at least 2, such as "
            "'lead=5 mm:15 mm:11'"
        )
    return name, np.linspace(value(parts[0]), value(parts[1]), int(digits))


#: Numbers of the operating point, and quantities that follow from the duty cycle in their place;
#: rating lives, which have the assumption `life_theory`, do so, too.
_OPERATING = ("load", "speed")
_OF_CYCLE = ("equivalent_load", "equivalent_speed", "duty_efficiency")
#: Quantities of a sweep if none are named.
_QUANTITIES = "efficiency,max_pressure"


def _axes(mechanism: Mechanism, texts: list[str], plan: str) -> dict[str, np.ndarray]:
    """All axes; an axis that is given twice is refused."""
    axes: dict[str, np.ndarray] = {}
    for text in texts:
        name, values = _axis(mechanism, text, plan)
        if name in axes:
            raise PrsmError(f"--axis {text}: {name} is given twice; remove one")
        axes[name] = values
    return axes


def _shard(text: str | None) -> tuple[int, int] | None:
    """`I/N`."""
    if text is None:
        return None
    first, slash, second = text.partition("/")
    if not (slash and first.strip().isdigit() and second.strip().isdigit()):
        raise PrsmError(f"--shard {text}: must be I/N with 1 ≤ I ≤ N, such as 3/16")
    return int(first), int(second)


def _exported(name: str, folder: Path | None) -> Path:
    """Where a file of `--export` is written: a bare name belongs to the folder of `--out`."""
    path = Path(name)
    return folder / path if folder is not None and os.path.basename(name) == name else path


def _counted(number: int, state: str, parts: dict[str, int]) -> str:
    """A number of designs, and how it is composed: `4 failed (no meshing 3, jammed 1)`."""
    listed = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in parts.items())
    return f"{number} {state} ({listed})" if listed else f"{number} {state}"


@app.command
def sweep(
    file: str,
    *,
    axis: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            help="NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE,…, such as 'lead=5 mm:15 mm:11'; "
            "with --plan lhs or sobol NAME=LOWER:UPPER. Repeat it for further axes.",
        ),
    ] = None,
    quantities: Annotated[
        str | None,
        Parameter(
            help="Names from `prsm quantities`, separated by commas; default "
            "efficiency,max_pressure. With --collect: those to draw; default all in the store."
        ),
    ] = None,
    gradients: Annotated[
        str | None,
        Parameter(help="Names of numbers by which every quantity is differentiated, by commas."),
    ] = None,
    plan: Annotated[
        PlanName,
        Parameter(
            help="grid: all combinations. list: the first value of every axis, then the second, "
            "and so on. lhs (Latin hypercube) and sobol: --points designs between the limits."
        ),
    ] = "grid",
    points: Annotated[
        int | None, count(1, MOST_DESIGNS, help="Number of designs of lhs and sobol.")
    ] = None,
    seed: Annotated[int, count(0, help="Seed of lhs and sobol.")] = 0,
    chunk: Annotated[
        int | None,
        count(
            1,
            MOST_DESIGNS,
            help="Largest number of designs in a block; default by number and memory.",
        ),
    ] = None,
    constraints: Annotated[
        bool,
        Parameter(
            help="Compute the quantities with limits in [optimise], too: pictures then show where "
            "the limits are. --no-constraints computes only --quantities."
        ),
    ] = True,
    resume: Annotated[
        bool,
        Parameter(
            help="Continue the store of the same sweep. --no-resume replaces the store in --out."
        ),
    ] = True,
    shard: Annotated[
        str | None,
        Parameter(
            help="I/N: compute only every N-th block of designs. N processes, on machines with a "
            "common folder, share a sweep; --collect finishes it."
        ),
    ] = None,
    collect: Annotated[
        bool,
        Parameter(
            negative="",
            help="Compute nothing; finish the store that all shards have written. It contains "
            "the axes and quantities.",
        ),
    ] = False,
    scheduler: Annotated[
        str | None,
        Parameter(help="Address of a Dask scheduler, whose workers compute and write the blocks."),
    ] = None,
    export: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            help="Write a FILE.csv, .xlsx, .parquet or .nc as well: into --out, if it is given and "
            "FILE names no folder. May be repeated.",
        ),
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """Quantities at many designs, into a zarr store in --out (default out).

    The store is written block by block. A run that was stopped continues with the same command, and
    a finished one is not computed again. With --out, each quantity has a picture beside it, which
    shows the limits of the constraints in the file's [optimise] table.

    Example: prsm sweep actuator --axis "lead=5 mm:15 mm:21" --quantities efficiency,mass
    """
    common.check_targets("out")
    part = _shard(shard)
    if collect and part is not None:
        raise PrsmError("--collect and --shard cannot be combined; run --collect after all shards")
    if scheduler is not None and (part is not None or collect):
        raise PrsmError("--scheduler computes the whole sweep; leave out --shard and --collect")
    files = [_exported(name, common.out) for name in export or []]
    if part is not None and files:
        raise PrsmError(
            "--shard and --export cannot be combined; run --collect with --export after all shards"
        )
    if not (axis or collect):
        raise PrsmError("--axis is missing; give at least one, such as --axis 'lead=5 mm:15 mm:11'")
    for name in export or []:
        check_export(name)
    mechanism = common.load(file)
    axes = _axes(mechanism, axis or [], plan)
    asked = words_of(_QUANTITIES if quantities is None else quantities) or []
    names = [*asked, *_limited(mechanism, asked)] if constraints and not collect else asked
    folder = Path("out") if common.out is None else common.out
    store = folder / f"{Path(file).stem}-sweep.zarr"
    if not collect and scheduler is None:
        # Programs with other whole numbers are announced when they are compiled.
        expect_programs("evaluate_chunk")
    options: dict[str, Any] = {
        "plan": plan,
        "points": points,
        "seed": seed,
        "gradients": parameters_of(mechanism, gradients, "--gradients", differentiated=True) or [],
        "chunk": chunk,
    }
    with folder_for_results(folder):
        if collect:
            data = collect_blocks(store)
            known = {entry.name for entry in catalogue()}
            names = [str(name) for name in data.data_vars if name in known]
            asked = names if quantities is None else asked
            if lacking := [name for name in asked if name not in names]:
                raise PrsmError(
                    f"--quantities {', '.join(lacking)}: the store has only {', '.join(names)}; "
                    "choose from these"
                )
        else:
            with _executor(scheduler) as executor:
                data = run_sweep(
                    mechanism,
                    axes,
                    names,
                    **options,
                    store=store,
                    progress=Counter("designs"),
                    resume=resume,
                    shard=part,
                    executor=executor,
                )
    total = int(data.attrs["points"])
    missing, reasons, errors = count_codes(data)
    failed = sum(reasons.values())
    rests_on = assumptions(mechanism, names)
    if unmoved := _of_duty_cycle(mechanism, data, names):
        _tell(
            f"{', '.join(unmoved)}: of the duty cycle in the file, which load and speed of the "
            "operating point do not change"
        )
    for path in files:
        doing(f"writing {path.name}")
        run_export(data, path, rests_on)

    def text() -> str:
        # No design is counted twice: errors are those of designs that did not fail.
        counts = [(failed, "failed", reasons)]
        if errors:
            counts.append((sum(errors.values()), "others with errors of prsm check", errors))
        if missing:
            counts.append((missing, "not computed yet", {}))
        words = f"{total} designs: " + ", ".join(_counted(*one) for one in counts)
        return prose(words) + "\n".join(map(str, [store, *files]))

    findings = checked(mechanism)
    limits = () if mechanism.design_problem is None else mechanism.design_problem.constraints
    drawn = [one for one in limits if one.quantity in data]
    results: dict[str, Any] = {
        "store": store,
        "points": total,
        "failed": failed,
        # Designs of other shards, or of a run that was stopped.
        "missing": missing,
        "reasons": reasons,
        # Designs that did not fail, by the first error that `check` finds in them.
        "errors": errors,
        # Limits of [optimise] whose quantities were computed.
        "constraints": [dataclasses.asdict(one) for one in drawn],
        "exports": files,
        # Findings on the mechanism in the file; each design has a code of its own.
        "findings": list(dict.fromkeys(f.name for f in findings if f.severity != "note")),
        "valid": failed < total - missing,
    }
    if common.out is not None and not missing and total > 1 and failed < total:
        # Limits that --no-constraints leaves out on purpose are not missed.
        missed = {one.quantity for one in limits} - {one.quantity for one in drawn}
        if constraints and missed:
            _tell(
                f"pictures have no limits of {', '.join(sorted(missed))}, which the sweep has not "
                "computed"
            )
        results["pictures"] = _save_pictures(common.out, mechanism, data, asked, drawn)
    emit(common, results, text, rests_on)
    return 0


def _of_duty_cycle(mechanism: Mechanism, data: Any, names: list[str]) -> list[str]:
    """Quantities that follow from the duty cycle alone, in a sweep over the operating point."""
    moved = {str(axis).removeprefix("operating_point.") for axis in data.coords}
    if mechanism.duty_cycle is None or moved.isdisjoint(_OPERATING):
        return []
    lives = {one.name for one in catalogue() if "life_theory" in one.assumes}
    # A capacity has the same assumption.
    lives.discard("dynamic_capacity")
    return [name for name in names if name in _OF_CYCLE or name in lives]


def _limited(mechanism: Mechanism, asked: list[str]) -> list[str]:
    """Further quantities with limits in [optimise] that the mechanism has the data for."""
    problem = mechanism.design_problem
    names = () if problem is None else (one.quantity for one in problem.constraints)
    further = dict.fromkeys(name for name in names if name not in asked)
    return list(available_quantities(mechanism, further)) if further else []


def _save_pictures(
    folder: Path, mechanism: Mechanism, data: Any, names: list[str], limits: list[Constraint]
) -> list[str]:
    """Write a picture of each quantity; stderr names missing pictures, and limits elsewhere."""
    from ...report import save_figure, sweep_figure

    doing("drawing")
    problem = mechanism.design_problem
    senses: dict[str, Literal["maximise", "minimise"]] = {}
    if problem is not None:
        senses = {one.quantity: one.sense for one in problem.objectives}
        if limits and (problem.nut_speed is not None or problem.operating_points):
            _tell(
                "limits are drawn at the operating point of the sweep, not at the "
                f"{'nut_speed' if problem.nut_speed is not None else 'operating points'} of "
                "[optimise]"
            )
    written: list[str] = []
    for name in names:
        sense = senses.get(name, "maximise")
        try:
            picture = sweep_figure(data, name, sense=sense, constraints=limits or None)
        except ValueError as error:
            # The store has the numbers all the same.
            _tell(f"no picture of {name}: {error}")
            continue
        written += map(str, save_figure(picture, folder / f"sweep-{name}"))
    return written


def _tell(words: str) -> None:
    clear()
    print(f"prsm: {words}", file=sys.stderr)


def _executor(scheduler: str | None) -> Any:
    """The workers of a Dask scheduler, or none."""
    import contextlib

    if scheduler is None:
        return contextlib.nullcontext()
    try:
        import distributed
    except ImportError as error:
        raise missing_extra("cluster", "--scheduler", error) from error

    @contextlib.contextmanager
    def connected():
        doing(f"connecting to {scheduler}")
        try:
            client = distributed.Client(scheduler, timeout=10)
        except (OSError, ValueError) as error:
            raise PrsmError(
                f"--scheduler {scheduler}: no Dask scheduler answers there; start one with `dask "
                "scheduler` and workers with `dask worker ADDRESS`"
            ) from error
        with client:
            yield client.get_executor()

    return connected()
