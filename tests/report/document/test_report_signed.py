"""A report for signature: hash, fields, escaping, print, no network, one library, same content."""

import dataclasses
import hashlib
import html
import json
import re
from html.parser import HTMLParser

import pytest
from report_scenes import make_steady, make_transient

from prsm_jax import file
from prsm_jax.findings import Finding, StrengthCheck
from prsm_jax.report import Origin, ReportData, origin_of_file, write_report
from prsm_jax.report.document import _write
from prsm_jax.report.document._foundations import provenance_section
from prsm_jax.report.interactive import plotly_library

_EVIL = "<script>alert('x')</script>\"'&<img src=http://evil.example/x.png>"
_LIBRARY = "window.Plotly = {newPlot() {}}; // stands for the library"


class _Page(HTMLParser):
    """Elements with their attributes, text outside of scripts, and texts of scripts."""

    def __init__(self, text: str):
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.scripts: list[str] = []
        self._inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside = tag
            self.scripts += [""] if tag == "script" else []

    def handle_endtag(self, tag):
        if tag == self._inside:
            self._inside = ""

    def handle_data(self, data):
        if self._inside == "script":
            self.scripts[-1] += data
        elif not self._inside:
            self.words.append(data)


@pytest.fixture(scope="module")
def given(wu2022):
    """Results made up, so that nothing is compiled, with texts of a user in every place."""
    state = make_steady(2e3, thread_sliding=300.0, drag=20.0)
    return ReportData(
        wu2022,
        _EVIL,
        findings=(Finding("buckling", "warning", 1, 1.2, 2.0, _EVIL),),
        steady=state,
        forward=state,
        backward=state,
        transient=make_transient(1),
        left_out=((_EVIL, _EVIL),),
        source=_EVIL,
        command=_EVIL,
        origin=origin_of_file("wu2022", author=_EVIL, revision="B", date="2026-11-24"),
        checks=(StrengthCheck("jamming", 1, 0.05, 0.7, "1", True, 0.6, "1", "pass", _EVIL),),
    )


@pytest.fixture(scope="module")
def written(given, tmp_path_factory):
    folder = tmp_path_factory.mktemp("signed") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_write, "plotly_library", lambda: _LIBRARY)
        return write_report(folder, given, dpi=40)


@pytest.fixture(scope="module")
def page(written):
    return _Page(written.read_text())


def test_hash_author_revision_and_date(given, page, tmp_path):
    """The hash is that of the bytes, which a byte order mark and line ends are part of."""
    shown = "\n".join(page.words)
    data = file.example_text("wu2022").encode()
    assert hashlib.sha256(data).hexdigest() in shown
    assert "2026-11-24" in shown
    assert _EVIL in shown
    odd = b"\xef\xbb\xbf" + data.replace(b"\n", b"\r\n")
    (tmp_path / "odd.toml").write_bytes(odd)
    origin = origin_of_file(str(tmp_path / "odd.toml"))
    assert origin.sha256 == hashlib.sha256(odd).hexdigest() != given.origin.sha256


def test_text_from_users_is_no_element(page):
    kinds = {tag for tag, _ in page.elements}
    assert not kinds & {"small", "b", "iframe", "object", "link"}
    # Scripts are the library, the page's own, and data of charts, which cannot end the element.
    charts = [text for text in page.scripts if text.startswith("{")]
    assert len(page.scripts) == len(charts) + 2
    assert not [text for text in page.scripts if "alert" in text and text not in charts]
    assert all("<" not in text for text in charts)
    pictures = [attributes for tag, attributes in page.elements if tag == "img"]
    assert all((one["src"] or "").startswith("data:image/svg+xml;base64,") for one in pictures)
    for tag, attributes in page.elements:
        assert not {name for name in attributes if name.startswith("on")}, (tag, attributes)


def test_nothing_is_loaded_from_elsewhere(page):
    """Neither by an address in the page nor by a script: the page forbids it to itself."""
    for _, attributes in page.elements:
        for name in ("src", "href", "srcset", "data", "poster"):
            value = attributes.get(name) or ""
            assert not re.match(r"(?:[a-z]+:)?//", value.strip(), re.I), value[:80]
            assert not value.startswith(("http", "ftp", "file:", "javascript:"))
    rules = next(
        a["content"] for _, a in page.elements if a.get("http-equiv") == "Content-Security-Policy"
    )
    assert rules is not None
    allowed = dict(one.strip().split(" ", 1) for one in rules.split(";"))
    assert allowed["default-src"] == "'none'"
    assert "connect-src" not in allowed
    assert set(allowed["img-src"].split()) == {"data:", "blob:"}
    assert allowed["script-src"] == allowed["style-src"] == "'unsafe-inline'"


def test_the_page_prints_without_split_tables(written):
    style = re.search(r"<style>(.*?)</style>", written.read_text(), re.S)
    assert style is not None
    css = " ".join(style[1].split())
    assert re.search(r"@page { size: A4;", css)
    unbroken = re.search(r"([^{}]*) { break-inside: avoid; }", css)
    assert unbroken is not None
    assert {"tr", "table", "caption"} <= {x.strip() for x in unbroken[1].split(",")}
    assert "figure { break-inside: avoid;" in css
    # A table longer than a page is broken between rows, under a head that is repeated.
    assert "table.long { break-inside: auto; }" in css
    assert "thead { display: table-header-group; }" in css
    # On paper the pictures are printed, not the charts.
    printed = css[css.index("@media print") :]
    assert ".live { display: none !important; }" in printed
    assert "max-height: 115mm" in printed


def test_the_library_is_embedded_once_and_charts_are_drawn(written, page):
    assert written.read_text().count(_LIBRARY) == 1
    charts = [json.loads(text) for text in page.scripts if text.startswith("{")]
    assert charts
    figures = [a for tag, a in page.elements if tag == "figure" and a.get("class") == "chart"]
    assert len(figures) == len(charts)
    for chart in charts:
        assert {"data", "layout"} <= set(chart)
        for trace in chart["data"]:
            assert "<extra>" in trace["hovertemplate"]
            assert len(trace["x"]) == len(trace["y"]) > 0
    # Each has its picture, for print and for browsers without scripts.
    assert sum(tag == "img" for tag, _ in page.elements) >= len(charts)


def test_plotly_itself_is_embedded_once(given, tmp_path, monkeypatch):
    plotly = pytest.importorskip("plotly.offline")
    monkeypatch.setattr(_write, "plotly_library", plotly_library)
    few = dataclasses.replace(given, transient=None)
    text = write_report(tmp_path / "out", few, dpi=40).read_text()
    library = plotly.get_plotlyjs()
    assert text.count(library) == 1
    assert len(library) < len(text) < len(library) + 3_000_000


def test_without_the_library_the_pictures_are_there(given, tmp_path):
    few = dataclasses.replace(given, transient=None)
    page = _Page(write_report(tmp_path / "out", few, dpi=40).read_text())
    assert page.scripts == []
    assert sum(tag == "img" for tag, _ in page.elements) >= 3


def _normal(text: str) -> str:
    return " ".join(html.unescape(re.sub(r"\\(.)", r"\1", text)).split())


def test_markdown_and_json_have_the_same_content(written, page):
    content = json.loads((written.parent / "report.json").read_text())
    markdown = _normal((written.parent / "report.md").read_text())
    shown = _normal(" ".join(page.words))
    assert content["status"] in ("pass", "warning", "fail")
    assert [one["anchor"] for one in content["sections"]][:4] == [
        *("status", "summary", "findings", "inputs"),
    ]
    assert [one["anchor"] for one in content["sections"]][-2:] == ["left_out", "provenance"]
    cells = 0
    for section in content["sections"]:
        said = [*section["paragraphs"], *section["assumptions"]]
        for table in section["tables"]:
            said += [table["caption"], *table["head"]]
            said += [cell for row in table["rows"] for cell in row]
            cells += sum(len(row) for row in table["rows"])
        for words in said:
            assert _normal(words) in shown
            assert _normal(words) in markdown
        for picture in section["pictures"]:
            assert (written.parent / picture["file"]).is_file()
            assert picture["file"] in markdown
    # Inputs, steady state, losses, parts left out and provenance.
    assert cells > 300


def test_author_and_revision_of_the_file(given, tmp_path):
    """They are read, written, and shown unless an option says otherwise; one program for all."""
    import jax

    text = 'author = "F. Ile"\nrevision = "7"\n' + file.example_text("wu2022")
    mechanism = file.loads(text)
    assert (mechanism.author, mechanism.revision) == ("F. Ile", "7")
    again = file.loads(file.dumps(mechanism))
    assert (again.author, again.revision) == ("F. Ile", "7")
    assert jax.tree.structure(mechanism) == jax.tree.structure(given.mechanism)
    assert "author" not in file.dumps(given.mechanism)

    def responsible(origin):
        data = ReportData(mechanism, "x", origin=origin)
        return {row[0]: row[1] for row in provenance_section(data).tables[0].rows}

    assert responsible(Origin())["author"] == "F. Ile"
    rows = responsible(Origin(author="O. Ption"))
    assert (rows["author"], rows["revision"]) == ("O. Ption", "7")


def test_a_blank_is_left_for_what_is_not_given(given, tmp_path):
    few = dataclasses.replace(given, origin=Origin(), steady=None, transient=None)
    write_report(tmp_path / "out", few, dpi=40)
    content = json.loads((tmp_path / "out" / "report.json").read_text())
    (responsible, made) = content["sections"][-1]["tables"]
    assert [row[0] for row in responsible["rows"]] == ["author", "revision", "date", "signature"]
    assert {row[1] for row in responsible["rows"]} == {"…" * 12}
    assert "SHA-256 of this file" not in {row[0] for row in made["rows"]}
