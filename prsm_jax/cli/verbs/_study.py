"""The verb on a study of a few drivers, with its report."""

import json
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..._errors import PrsmError
from ...mechanism import Mechanism
from ...process import folder_for_results
from .._app import app
from .._common import Common, checked, emit, plain, value_of, words_of
from .._counts import MOST_VALUES, count
from .._progress import Counter, counted, doing, expect_programs
from .._tables import terminal_width
from ._demo import command_of, read_with_origin, tell_faults

_DEFAULT = Common()
_POINTS, _FRONT_POINTS = 7, 11
_NAMES = "from `prsm quantities`, separated by commas."


def _drivers(mechanism: Mechanism, texts: list[str]) -> Any:
    """Ranges by name from `NAME=LOWER:UPPER`; only names where no range is given."""
    ranges: dict[str, tuple[float, float] | None] = {}
    for text in texts:
        name, equals, limits = (part.strip() for part in text.partition("="))
        ends = limits.split(":")
        if not name or (equals and len(ends) != 2):
            raise PrsmError(
                f"--driver {text}: must be NAME or NAME=LOWER:UPPER, such as 'lead=5 mm:20 mm'"
            )
        if name in ranges:
            raise PrsmError(f"--driver {text}: {name} is given twice; remove one")
        both = [value_of(mechanism, name, end, f"--driver {text}") for end in ends if equals]
        if equals and both[0] > both[1]:
            upper, lower = (end.strip() for end in ends)
            raise PrsmError(
                f"--driver {text}: the smaller end comes first; write '{name}={lower}:{upper}'"
            )
        ranges[name] = (both[0], both[1]) if equals else None
    return ranges or None


def _senses(maximise: str | None, minimise: str | None) -> dict[str, str] | None:
    """Senses by quantity; a quantity that is named twice is refused."""
    more, less = words_of(maximise) or [], words_of(minimise) or []
    both = sorted(set(more) & set(less))
    if both:
        raise PrsmError(f"--maximise and --minimise both name {', '.join(both)}; remove one")
    return (dict.fromkeys(more, "maximise") | dict.fromkeys(less, "minimise")) or None


class _Progress:
    """Shows the present computation of a study and its progress."""

    def __init__(self) -> None:
        self._map = Counter("designs of the map")

    def __call__(self, what: str, done: int, total: int) -> None:
        if what == "map":
            self._map(done, total)
        else:
            counted(done, total, f"searches, {what}")


@app.command
def study(
    file: str,
    *,
    driver: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            help="NAME=LOWER:UPPER, such as 'lead=5 mm:20 mm', or NAME alone: then the range is "
            "that of [[optimise.variable]], or else 25 % on either side of the present value. "
            "Repeat it for further drivers. Default: lead, contact angle and roller radius.",
        ),
    ] = None,
    maximise: Annotated[
        str | None, Parameter(help=f"Quantities of which more is better, {_NAMES}")
    ] = None,
    minimise: Annotated[
        str | None, Parameter(help=f"Quantities of which less is better, {_NAMES}")
    ] = None,
    objectives: Annotated[
        str | None,
        Parameter(help="Two or three quantities: objectives of the front. Default: the first two."),
    ] = None,
    points: Annotated[
        int, count(2, MOST_VALUES, help="Values of every driver in the map.")
    ] = _POINTS,
    front_points: Annotated[int, count(3, 1000, help="Points of the front.")] = _FRONT_POINTS,
    without: Annotated[
        str | None,
        Parameter(
            help="Parts of the physics to leave out, one at a time, separated by commas; names as "
            "`prsm explain` prints them, or their ends. Default: those of spin, "
            "rolling_hysteresis and load_sharing that the file has. 'none' leaves out nothing."
        ),
    ] = None,
    starts: Annotated[
        int | None, count(1, 10_000, help="Number of starts for the best of each objective.")
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """Report on a few drivers: their effect on quantities, conflicts of these, and the front.

    By default natural frequencies and efficiency against lead, contact angle and roller radius,
    under the limits of [optimise], and again without spin, rolling hysteresis and load sharing.
    All at the operating point of the file.

    Writes report.html, report.md, figures, study.json and the store of the map to --out (default
    out). A run that was stopped continues with the same command. Exit status 1 if the front has not
    converged.

    Example: prsm study actuator --out out/drivers
    """
    common.check_targets("out")
    mechanism, origin = read_with_origin(file, common)
    drivers, senses = _drivers(mechanism, driver or []), _senses(maximise, minimise)
    left_out = words_of(without)
    options = [word for one in driver or () for word in ("--driver", one)]
    for option, given, default in (
        ("--maximise", maximise, None),
        ("--minimise", minimise, None),
        ("--objectives", objectives, None),
        ("--points", points, _POINTS),
        ("--front-points", front_points, _FRONT_POINTS),
        ("--without", without, None),
        ("--starts", starts, None),
    ):
        options += [option, str(given)] if given != default else []
    from ...report import write_study
    from ...studies import study as run_study

    # Map, front and, for each part that is left out, designs and front.
    expect_programs("evaluate_chunk", "compiled_derivatives")
    folder = Path("out") if common.out is None else common.out
    store = folder / f"{Path(file).stem}-study.zarr"
    with folder_for_results(folder):
        results = run_study(
            mechanism,
            drivers,
            senses,
            words_of(objectives),
            points=points,
            front_points=front_points,
            without=[] if left_out == ["none"] else left_out,
            starts=starts,
            store=store,
            progress=_Progress(),
        )
    findings = checked(mechanism)
    if results.front.points:
        # Errors are constraints: those of the present design are not those of the front.
        findings = tuple(one for one in findings if one.severity != "error")
    doing("drawing and writing the report")
    faults: list[str] = []
    report = write_study(
        folder,
        results,
        command=command_of("study", file, folder, common, options),
        source=file,
        origin=origin,
        attachments={
            "study.json": json.dumps(plain(results.to_dict()), indent=2, ensure_ascii=False) + "\n",
        },
        on_fault=faults.append,
    )
    tell_faults(faults)
    valid = emit(
        common,
        {"report": report, "store": store, **results.to_dict()},
        lambda: results.text(terminal_width()) + f"\n\n{report}\n{store}",
        results.assumptions,
        findings,
    )
    return int(not (valid and results.front.converged) or bool(faults))
