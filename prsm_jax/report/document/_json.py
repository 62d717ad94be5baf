"""A document as JSON: the content of the page, with the curves of its charts."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..interactive import Chart
from ._section import Picture, Section


def document_json(
    title: str,
    kind: str,
    sections: Sequence[Section],
    charts: Mapping[str, Chart],
    attachments: Iterable[str],
    faults: Sequence[str],
) -> str:
    """A document as JSON text: tables as they are printed, curves as numbers with units.

    **Arguments:**

    - `title`, `kind`, `sections`, `faults`: as for `write_document`.
    - `charts`: curves of pictures by the name of the picture.
    - `attachments`: names of further files.
    """
    content = {
        "title": title,
        "kind": kind,
        "status": next((one.status for one in sections if one.status), None),
        "faults": list(faults),
        "sections": [_section(one, charts) for one in sections],
        "attachments": list(attachments),
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _section(section: Section, charts: Mapping[str, Chart]) -> dict[str, Any]:
    return {
        "anchor": section.anchor,
        "title": section.title,
        "status": section.status or None,
        "paragraphs": list(section.paragraphs),
        "tables": [
            {"caption": one.caption, "head": list(one.head), "rows": [list(r) for r in one.rows]}
            for one in section.tables
        ],
        "assumptions": list(section.assumptions),
        "faults": list(section.faults),
        "pictures": [_picture(one, charts) for one in section.pictures],
    }


def _picture(picture: Picture, charts: Mapping[str, Chart]) -> dict[str, Any]:
    chart = charts.get(picture.name)
    return {
        "name": picture.name,
        "caption": picture.caption,
        "file": f"figures/{picture.name}.png",
        "chart": None if chart is None else chart.to_dict(),
    }
