"""The verb export: drawings, workbooks, histories, FMUs and tables for other programs."""

import dataclasses
import difflib
import functools
import itertools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from ...._errors import PrsmError, UnknownNameError
from ....dynamics import default_scenario, simulate, steady_state
from ....mechanism import Mechanism
from ....process import make_folder, placing_in, put_file, temporary_folder
from ....quantities import catalogue
from ....results import Result
from ....scenario import depends_on_motion
from ....text import TextTable
from ..._app import app
from ..._common import Common, checked, emit, words_of
from ..._progress import doing, expect_programs

if TYPE_CHECKING:
    from ....exchange import SolidMass, StepBody

_DEFAULT = Common()
_FOLDER = "out/export"


@dataclasses.dataclass(frozen=True)
class _Wanted:
    """A mechanism to export: its file, the folder, and the result that is asked for."""

    mechanism: Mechanism
    file: str
    #: Temporary: files are moved to their places when all of them are complete.
    folder: Path
    result: Literal["transient", "steady"]
    #: Filled by the format `step`.
    solids: "list[SolidMass]" = dataclasses.field(default_factory=list)

    @functools.cached_property
    def computed(self) -> Result:
        """The result, computed once for all formats."""
        expect_programs("_transient" if self.result == "transient" else "steady_state")
        if self.result == "steady":
            return steady_state(self.mechanism)
        return simulate(self.mechanism, default_scenario(self.mechanism))

    def path(self, ending: str) -> Path:
        """A path named after the file, such as `…/actuator.dxf` or `…/actuator-steady.mat`."""
        return self.folder / f"{Path(self.file).stem}{ending}"


def _dxf(wanted: _Wanted) -> list[Path]:
    from ....exchange import write_dxf

    stages = range(1, len(wanted.mechanism.stages) + 1)
    names = [".dxf"] if len(stages) == 1 else [f"-stage-{stage}.dxf" for stage in stages]
    return [
        write_dxf(wanted.path(name), wanted.mechanism, stage=stage)
        for stage, name in zip(stages, names, strict=True)
    ]


def _step(wanted: _Wanted) -> list[Path]:
    from ....exchange import solid_mass, write_step

    bodies: "tuple[StepBody, ...]" = ("screw", "roller", "nut")
    written, many = [], len(wanted.mechanism.stages) > 1
    for number, stage in enumerate(wanted.mechanism.stages, start=1):
        for body in bodies:
            # The length of a screw or nut that is longer than what is modelled may be absent.
            part = getattr(stage, body)
            if part is None or part.length is None:
                continue
            name = f"-stage-{number}-{body}.step" if many else f"-{body}.step"
            doing(f"making the {body}")
            written.append(write_step(wanted.path(name), wanted.mechanism, body, stage=number))
            wanted.solids.append(solid_mass(wanted.mechanism, body, stage=number))
    if not written:
        raise PrsmError(
            f"{wanted.file}: has no length of screw, roller or nut, so there is no solid; give "
            "stage.roller.length"
        )
    return written


def _xlsx(wanted: _Wanted) -> list[Path]:
    from ....exchange import write_workbook
    from ....report import analyse, origin_of_file

    doing("analysing: contact, vibration, steady state, transient, strength")
    origin = origin_of_file(wanted.file)
    data = analyse(wanted.mechanism, source=wanted.file, origin=origin)
    return [write_workbook(wanted.path(".xlsx"), data)]


def _of_result(ending: str) -> Callable[[_Wanted], list[Path]]:
    def write(wanted: _Wanted) -> list[Path]:
        from ....exchange import export_result

        path = wanted.path(f"-{wanted.result}{ending}")
        return [export_result(wanted.computed, path)]

    return write


def _fmu(wanted: _Wanted) -> list[Path]:
    from ....exchange import write_fmu

    return [write_fmu(wanted.path(".fmu"), wanted.mechanism)]


def _tables(wanted: _Wanted) -> list[Path]:
    from ....exchange import write_duty_cycle, write_scenario

    mechanism, written = wanted.mechanism, []
    if mechanism.duty_cycle is not None:
        written.append(write_duty_cycle(wanted.path("-duty-cycle.csv"), mechanism.duty_cycle))
    scenario = mechanism.scenario
    if scenario is not None and not depends_on_motion(scenario.load):
        written.append(write_scenario(wanted.path("-scenario.csv"), scenario))
    if not written:
        raise PrsmError(
            f"{wanted.file}: has no duty cycle, and no scenario whose load is a function of time; "
            "there is no table to write"
        )
    return written


def _toml(wanted: _Wanted) -> list[Path]:
    from ....file import dump

    path = wanted.path("-export.toml")
    units = {quantity.name: quantity.unit for quantity in catalogue()}
    dump(wanted.mechanism, path, units)
    return [path]


#: By the word of `--as`: the function that writes the files.
_FORMATS: dict[str, Callable[[_Wanted], list[Path]]] = {
    "dxf": _dxf,
    "step": _step,
    "xlsx": _xlsx,
    "mat": _of_result(".mat"),
    "nc": _of_result(".nc"),
    "csv": _of_result(".csv"),
    "fmu": _fmu,
    "tables": _tables,
    "toml": _toml,
}
#: Formats that need an analysis; the others come first, since a refusal is then quick.
_ANALYSED = ("xlsx", "mat", "nc", "csv")
#: Likeness from which a format is suggested. Two of three letters, as of pdf and dxf, are less.
_ALIKE = 0.7


def _formats(text: str, result: str) -> list[str]:
    words = list(dict.fromkeys(words_of(text) or ()))
    for word in words:
        if word not in _FORMATS:
            near = difflib.get_close_matches(word, _FORMATS, n=1, cutoff=_ALIKE)
            meant = f"did you mean {near[0]}? Known: " if near else "known: "
            raise UnknownNameError(f"--as {word}: unknown format; {meant}{', '.join(_FORMATS)}")
    if not words:
        raise PrsmError(f"--as names no format; give some of {', '.join(_FORMATS)}")
    if result == "steady" and "csv" in words:
        raise PrsmError(
            "--as csv --result steady: a steady state has no histories for a CSV file; choose mat "
            "or nc, or --result transient"
        )
    return words


def _written(wanted: _Wanted, formats: list[str], folder: Path) -> dict[str, list[Path]]:
    """The files of each format in the folder: all of them, or none if one cannot be made.

    **Raises:** `PrsmError` if a folder has the name of a file.
    """
    quick_first = sorted(formats, key=lambda one: one in _ANALYSED)
    made = {one: _FORMATS[one](wanted) for one in quick_first}
    for path in itertools.chain(*made.values()):
        if (folder / path.name).is_dir():
            raise PrsmError(
                f"{folder / path.name}: is a folder; remove it, or give another one with --out"
            )
    with placing_in(folder):
        for path in itertools.chain(*made.values()):
            put_file(path, folder / path.name)
    return {one: [folder / path.name for path in made[one]] for one in formats}


def _masses_as_text(solids: "list[SolidMass]") -> str:
    """Volumes and masses of solids beside the masses of the model."""
    rows = [
        (
            f"{solid.body} of stage {solid.stage}",
            1e9 * solid.volume,
            solid.solid_mass,
            solid.model_mass,
            None if solid.difference is None else round(100 * solid.difference, 6),
            solid.rule.replace("_", " "),
        )
        for solid in solids
    ]
    columns = (
        "body",
        "volume [mm³]",
        "solid's mass [kg]",
        "model's mass [kg]",
        "difference [%]",
        "model's mass is",
    )
    return TextTable("Masses of the solids and of the model", columns, rows).text()


def _masses_as_data(solids: "list[SolidMass]") -> list[dict[str, object]]:
    return [
        {
            "body": solid.body,
            "stage": solid.stage,
            "volume_m3": solid.volume,
            "solid_mass_kg": solid.solid_mass,
            "model_mass_kg": solid.model_mass,
            "difference": solid.difference,
            "mass_rule": solid.rule,
        }
        for solid in solids
    ]


@app.command
def export(
    file: str,
    *,
    as_: Annotated[
        str,
        Parameter(
            name="--as",
            help="Formats, separated by commas: dxf (drawing), step (solids), xlsx (tables of "
            "the report); mat, nc, csv (a result); fmu (FMI 3.0, driven by a torque); "
            "tables (duty cycle and scenario as CSV); toml (the mechanism).",
        ),
    ],
    result: Annotated[
        Literal["transient", "steady"], Parameter(help="What mat and nc hold; csv holds histories.")
    ] = "transient",
    scenario: Annotated[
        Path | None,
        Parameter(
            help="CSV file 'time [s], speed [rpm], load [kN]', or with torque in place of speed, "
            "that replaces the scenario of the file."
        ),
    ] = None,
    duty_cycle: Annotated[
        Path | None,
        Parameter(
            help="CSV file 'duration [s], speed [rpm], load [kN]' that replaces the duty cycle."
        ),
    ] = None,
    common: Common = _DEFAULT,
) -> int:
    """Write files for other programs: CAD, spreadsheets, MATLAB, netCDF, simulators with FMI.

    With --scenario or --duty-cycle, recorded data take the place of those of the file; `--as toml`
    keeps them. Files are written to --out (default out/export) and named after the mechanism's.
    With `--as step`, the masses of the solids are compared with those of the model. Of a mechanism
    that cannot be built the files are written, with exit status 1.
    """
    formats = _formats(as_, result)
    common.check_targets(_FOLDER)
    mechanism = common.load(file)
    if scenario is not None or duty_cycle is not None:
        from ....exchange import read_duty_cycle, read_scenario

        if scenario is not None:
            mechanism = dataclasses.replace(mechanism, scenario=read_scenario(scenario))
        if duty_cycle is not None:
            mechanism = dataclasses.replace(mechanism, duty_cycle=read_duty_cycle(duty_cycle))
    folder = make_folder(Path(_FOLDER) if common.out is None else common.out)
    with temporary_folder(folder, ".export-") as partial:
        wanted = _Wanted(mechanism, file, partial, result)
        written = _written(wanted, formats, folder)
    listed = [path for paths in written.values() for path in paths]
    results: dict[str, object] = {"files": written}
    lines = "\n".join(map(str, listed))
    if wanted.solids:
        results["solids"] = _masses_as_data(wanted.solids)
        lines += "\n\n" + _masses_as_text(wanted.solids).rstrip()
    return int(not emit(common, results, lambda: lines, findings=checked(mechanism)))
