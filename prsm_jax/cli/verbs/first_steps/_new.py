"""The verb new: five questions, and a file with a first design."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ...._errors import PrsmError
from ....dimensioning import Dimensioning, dimension
from ....file import loads
from ....geometry import Finding
from ....process import make_folder
from ..._app import app
from ..._common import Output, checked, emit, write_text
from ..._progress import doing, expect_programs
from ..._tables import prose
from ._file_text import file_text
from ._questions import QUESTIONS, answers

_DEFAULT = Output()
#: Verbs to go on with.
_NEXT = ("check", "steady", "sensitivity")


def _quantity(help: str) -> Parameter:
    """A number with a unit; one that begins with a minus is a value, not another option."""
    return Parameter(help=help, allow_leading_hyphen=True)


@app.command
def new(
    file: Annotated[Path, Parameter(help="The new file.")] = Path("my_screw.toml"),
    *,
    load: Annotated[str | None, _quantity(help="Axial load on the nut, such as '10 kN'.")] = None,
    stroke: Annotated[str | None, _quantity(help="Travel of the nut, such as '300 mm'.")] = None,
    speed: Annotated[
        str | None, _quantity(help="Largest speed of the nut, such as '100 mm/s'.")
    ] = None,
    life: Annotated[
        str | None,
        _quantity(help="Time at this load and speed ('5000 h'), or travel in it ('500 km')."),
    ] = None,
    envelope: Annotated[
        str | None, _quantity(help="Diameter of the bore for the nut, such as '80 mm'.")
    ] = None,
    force: Annotated[
        bool, Parameter(negative="", help="Replace a file that exists already.")
    ] = False,
    output: Output = _DEFAULT,
) -> int:
    """Write a file with a first design for five requirements; asks for those that are not given.

    The design is the smallest size of the catalogue that meets them all. If there is none, the verb
    says which requirement to relax, and by how much; its exit status is then 1.
    """
    output.check_targets()
    path = file if output.out is None else output.out / file
    _check_path(path, force, made=output.out is not None)
    given = {"load": load, "stroke": stroke, "speed": speed, "life": life, "envelope": envelope}
    wanted = answers(given)
    doing("computing the strength of all sizes")
    expect_programs("capacities")
    found = dimension(**wanted)
    written, findings = None, ()
    if found.mechanism is not None:
        text = file_text(found)
        findings = checked(loads(text, name=str(path)))
        if output.out is not None:
            make_folder(path.parent)
        write_text(path, text)
        written = path
    good = not any(finding.severity == "error" for finding in findings)
    results = _results(found, written, findings)
    emit(output, results, lambda: _words(found, written), findings=findings)
    return int(written is None or not good)


def _check_path(path: Path, force: bool, made: bool) -> None:
    """Refuse a path that cannot be written; `made` if its folder will be made."""
    folder = path.absolute().parent
    if path.is_dir():
        raise PrsmError(f"{path}: is a folder; give the path of a file")
    if path.exists() and not force:
        raise PrsmError(f"{path}: exists already; give another name, or --force to replace it")
    if not made and not folder.is_dir():
        raise PrsmError(f"{path}: there is no folder {folder}; create it first")


def _results(
    found: Dimensioning, path: Path | None, findings: tuple[Finding, ...]
) -> dict[str, Any]:
    return {
        "file": None if path is None else str(path),
        "requirements": {
            f"{one.name}_{_SUFFIX[one.unit]}": getattr(found.requirements, one.name)
            for one in QUESTIONS
        },
        "size": found.size,
        "margins": found.margins,
        "relaxed": {
            f"{one.name}_{_SUFFIX[one.unit]}": found.relaxed[one.name]
            for one in QUESTIONS
            if one.name in found.relaxed
        },
        "sizes": found.sizes,
        "errors": sum(finding.severity == "error" for finding in findings),
    }


#: Units in names of keys.
_SUFFIX = {"N": "n", "m": "m", "m/s": "m_per_s", "s": "s"}


def _words(found: Dimensioning, path: Path | None) -> str:
    if path is None:
        return f"{found}\n"
    told = prose(f"{path} has the design, with a comment for each number. Try:")
    return f"{found}\n\n{told}" + "".join(f"  prsm {verb} {path}\n" for verb in _NEXT)
