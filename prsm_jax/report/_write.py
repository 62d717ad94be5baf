"""Write a report: one self-contained HTML file, a Markdown version, and the pictures."""

import base64
import os
from collections.abc import Mapping
from pathlib import Path

from .._errors import missing_extra
from .._files import taking_place, temporary_folder
from ._data import ReportData
from ._section import Section
from ._sections import report_sections
from ._style import save_figure


def write_report(
    directory: str | Path,
    data: ReportData,
    *,
    attachments: Mapping[str, str] | None = None,
    dpi: int = 200,
) -> Path:
    """Write a report into a directory.

    `report.html` holds everything and can be sent alone; `report.md` refers to `figures/`, where
    each picture lies as PNG and SVG. Everything is made beside the directory and moved in when it
    is complete, so a failure writes nothing; other files in the directory stay.

    **Arguments:**

    - `directory`: where to write; made if it is not there.
    - `data`: what to report, from `analyse`.
    - `attachments`: text of further files that belong to the report (JSON, the optimised
      mechanism), by file name; written with it and linked from it.
    - `dpi`: resolution of the PNG pictures.

    **Returns:** the path of `report.html`.

    **Raises:** `MissingExtraError` without matplotlib or jinja2; `ValueError` if the directory is
    a file, or an attachment's name is not a plain file name of its own; `OSError` if it cannot be
    written.
    """
    target = Path(directory)
    if target.exists() and not target.is_dir():
        raise ValueError(f"{target} is a file; give a directory for the report")
    files = dict(attachments or {})
    for name in files:
        plain = name == Path(name).name and name not in ("", ".", "..")
        if not plain or name in ("report.html", "report.md", "figures"):
            raise ValueError(
                f"attachment {name!r}: give a plain file name that is not the report's"
            )
    environment = _environment()
    target.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(target.parent, f".{target.name}-") as building:
        _build(building, data, files, environment, dpi)
        with taking_place():
            _move_in(building, target)
    return target / "report.html"


def _environment():
    try:
        import jinja2
    except ImportError as error:
        raise missing_extra("report", "writing a report", error) from error
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("prsm_jax.report", "templates"),
        autoescape=lambda name: name is not None and ".html" in name,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["cell"] = lambda text: str(text).replace("|", "\\|").replace("\n", " ")
    return environment


def _build(folder: Path, data: ReportData, files: dict[str, str], environment, dpi: int) -> None:
    sections = report_sections(data)
    figures = folder / "figures"
    figures.mkdir()
    embedded = _draw(sections, figures, dpi)
    values = {
        "title": data.title,
        "improved": data.optimisation is not None,
        "sections": sections,
        "embedded": embedded,
        "numbers": {name: number for number, name in enumerate(embedded, start=1)},
        "attachments": list(files),
    }
    for name in ("report.html", "report.md"):
        text = environment.get_template(f"{name}.jinja").render(values)
        (folder / name).write_text(text, encoding="utf-8")
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def _draw(sections: tuple[Section, ...], folder: Path, dpi: int) -> dict[str, str]:
    """Draw every picture; the SVG of each as text to be embedded."""
    embedded = {}
    for section in sections:
        for picture in section.pictures:
            _, svg = save_figure(picture.draw(), folder / picture.name, ("png", "svg"), dpi)
            coded = base64.b64encode(svg.read_bytes()).decode("ascii")
            embedded[picture.name] = f"data:image/svg+xml;base64,{coded}"
    return embedded


def _move_in(building: Path, target: Path) -> None:
    # A temporary directory is private; a report is as readable as what its maker usually makes.
    mask = os.umask(0)
    os.umask(mask)
    building.chmod(0o777 & ~mask)
    if not target.exists():
        os.rename(building, target)
        return
    (target / "figures").mkdir(exist_ok=True)
    # The report itself last, so that it never refers to pictures that are not there yet.
    made = sorted(p for p in building.rglob("*") if p.is_file())
    for path in sorted(made, key=lambda p: p.name == "report.html"):
        os.replace(path, target / path.relative_to(building))
