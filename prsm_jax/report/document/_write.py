"""Write a report: one self-contained HTML file, a Markdown version, and the pictures."""

import base64
import dataclasses
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from urllib.parse import quote

from ..._errors import missing_extra
from ...process import placing_in, put_file, real_path, temporary_folder
from ...text import markdown, printable
from .._style import save_figure
from ..interactive import Chart, plotly_figure, plotly_library, script_text
from ..results import ReportData, words_of_fault
from ._json import document_json
from ._section import Section
from ._sections import report_sections


def write_report(
    directory: str | Path,
    data: ReportData,
    *,
    attachments: Mapping[str, str] | None = None,
    dpi: int = 200,
    on_fault: Callable[[str], None] = warnings.warn,
) -> Path:
    """Write the report on one design, or on two, into a directory, as `write_document` does.

    **Arguments:**

    - `directory`: where to write; made if it is not there.
    - `data`: what to report, from `analyse`.
    - `attachments`, `dpi`, `on_fault`: as for `write_document`.

    **Returns:** the path of `report.html`.

    **Raises:** as `write_document`.
    """
    kind = "analysis and optimisation" if data.optimisation is not None else "analysis"
    return write_document(
        directory,
        data.title,
        kind,
        lambda: report_sections(data),
        attachments=attachments,
        dpi=dpi,
        on_fault=on_fault,
        faults=[f"The analysis of the {part} failed: {words}" for part, words in data.faults],
    )


def write_document(
    directory: str | Path,
    title: str,
    kind: str,
    sections: Callable[[], Sequence[Section]],
    *,
    attachments: Mapping[str, str] | None = None,
    dpi: int = 200,
    on_fault: Callable[[str], None] = warnings.warn,
    faults: Sequence[str] = (),
) -> Path:
    """Write a document of sections into a directory.

    `report.html` holds everything and can be sent alone, with interactive charts if plotly is
    installed; `report.md` and `report.json` have the same content and refer to `figures/`, where
    each picture lies as PNG and SVG. Everything is made beside the directory and moved in when it
    is complete, so a full disk or a signal leaves no partial report; other files in the directory
    stay. A section or picture that cannot be made is missing, and the report says so at its top.

    **Arguments:**

    - `directory`: where to write; made if it is not there.
    - `title`: its heading; `kind`: what it is on, such as `analysis`.
    - `sections`: makes its sections, in the order of reading, once the directory can be written.
    - `attachments`: text of further files that belong to the report (JSON, the optimised
      mechanism), by file name; written with it and linked from it.
    - `dpi`: resolution of the PNG pictures.
    - `on_fault`: called for each part that is missing because of a fault; default a warning.
    - `faults`: sentences on parts that are missing already.

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
        if not plain or name in ("report.html", "report.md", "report.json", "figures"):
            raise ValueError(
                f"attachment {name!r}: give a plain file name that is not the report's"
            )
    environment = _environment()
    place = real_path(target)
    place.parent.mkdir(parents=True, exist_ok=True)
    with temporary_folder(place.parent, f".{place.name}-") as building:
        content = _Content(title, kind, tuple(sections()), files, tuple(faults))
        told = _build(building, content, environment, dpi)
        with placing_in(place.parent):
            _move_in(building, place)
    for fault in told:
        on_fault(fault)
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
    environment.filters["md"] = lambda text: markdown(str(text))
    # Paths are quoted as links in Markdown and in HTML.
    environment.filters["link"] = lambda path: quote(path, safe="/")
    return environment


@dataclasses.dataclass(frozen=True)
class _Content:
    """All that a document holds, before pictures are drawn."""

    title: str
    kind: str
    sections: tuple[Section, ...]
    files: dict[str, str]
    faults: tuple[str, ...]


def _build(folder: Path, content: _Content, environment, dpi: int) -> tuple[str, ...]:
    """Write everything; return what is missing because of a fault, as sentences."""
    from markupsafe import Markup

    sections = content.sections
    figures = folder / "figures"
    figures.mkdir()
    lost: dict[str, tuple[str, ...]] = {}
    embedded = _draw(sections, figures, dpi, lost)
    charts = _charts(sections, embedded, lost)
    sections = tuple(
        dataclasses.replace(
            section,
            faults=section.faults + lost.get(section.anchor, ()),
            pictures=tuple(one for one in section.pictures if one.name in embedded),
        )
        for section in sections
    )
    faults = (
        *content.faults,
        *(f"{section.title}: {words}" for section in sections for words in section.faults),
    )
    library = plotly_library() if charts else None
    pages = {
        name: Markup(script_text(plotly_figure(chart)))
        for name, chart in charts.items()
        if library is not None
    }
    values = {
        "library": None if library is None else Markup(library),
        "charts": pages,
        "title": printable(content.title),
        "kind": content.kind,
        "sections": sections,
        "embedded": embedded,
        "numbers": {name: number for number, name in enumerate(embedded, start=1)},
        "attachments": list(content.files),
        "faults": faults,
    }
    for name in ("report.html", "report.md"):
        text = environment.get_template(f"{name}.jinja").render(values)
        # A lone surrogate, which only Python strings can hold, must not lose the rest.
        (folder / name).write_text(text, encoding="utf-8", errors="replace")
    words = document_json(content.title, content.kind, sections, charts, content.files, faults)
    (folder / "report.json").write_text(words, encoding="utf-8", errors="replace")
    for name, text in content.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return faults


def _charts(
    sections: tuple[Section, ...], embedded: dict[str, str], lost: dict[str, tuple[str, ...]]
) -> dict[str, Chart]:
    """The curves of every picture that has them, by its name; a fault is kept as in `_draw`."""
    charts: dict[str, Chart] = {}
    for section in sections:
        for picture in section.pictures:
            if picture.chart is None or picture.name not in embedded:
                continue
            try:
                charts[picture.name] = picture.chart()
            except Exception as error:
                words = f"The chart {picture.name} is not interactive: {words_of_fault(error)}"
                lost[section.anchor] = (*lost.get(section.anchor, ()), words)
    return charts


def _draw(
    sections: tuple[Section, ...], folder: Path, dpi: int, lost: dict[str, tuple[str, ...]]
) -> dict[str, str]:
    """Draw every picture; return the SVG of each as text to be embedded.

    A picture that cannot be drawn adds a sentence to `lost`, by the anchor of its section.
    """
    embedded = {}
    for section in sections:
        for picture in section.pictures:
            try:
                _, svg = save_figure(picture.draw(), folder / picture.name, ("png", "svg"), dpi)
            except (OSError, ImportError):
                raise
            except Exception as error:
                for path in folder.glob(f"{picture.name}.*"):
                    path.unlink()
                words = f"The picture {picture.name} is missing: {words_of_fault(error)}"
                lost[section.anchor] = (*lost.get(section.anchor, ()), words)
                continue
            coded = base64.b64encode(svg.read_bytes()).decode("ascii")
            embedded[picture.name] = f"data:image/svg+xml;base64,{coded}"
    return embedded


def _move_in(building: Path, target: Path) -> None:
    # A temporary directory is private; a report gets the usual permissions of its user.
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
        put_file(path, target / path.relative_to(building))
