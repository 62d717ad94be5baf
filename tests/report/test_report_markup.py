"""Text from users is shown letter by letter: in pictures, HTML, Markdown and on terminals."""

import dataclasses
import html
import random
import re

import pytest
from markdown_it import MarkdownIt
from matplotlib.text import Text

from prsm_jax.report import write_report
from prsm_jax.report._style import drawn, page_figure
from prsm_jax.text._plain_text import markdown, printable
from prsm_jax.text._text_table import TextTable

TITLES = (
    "$x^2$ $\\frac{$",
    "<script>alert('x')</script> & &lt;b&gt; <img src=x onerror=alert(1)>",
    "*a* _b_ **c** __d__ `e` ~~f~~ [g](h) ![i](j) | k | {{ l }} {% m %}",
    "# 1. - + > === http",
    "\\$ \\ \\* 100 % \\n",
)


@pytest.mark.parametrize("title", TITLES)
def test_markdown_shows_every_letter(title):
    """A renderer of CommonMark with GitHub's tables gives back the text, and no element."""
    renderer = MarkdownIt("commonmark").enable(["table", "strikethrough"])
    words = markdown(title)
    table = TextTable(title, ("a", title), [(title, "b")]).markdown()
    for source, parts in (
        (words, "p"),
        (f"# {words}", "h1"),
        (f"* {words}", "ul li"),
        (f"**{words}**", "p strong"),
        (table, "p strong table thead tr th tbody td"),
    ):
        shown = renderer.render(source)
        assert set(re.findall(r"<(\w+)", shown)) == set(parts.split())
        assert " ".join(title.split()) in html.unescape(re.sub(r"<[^>]*>", "", shown))


def test_markdown_of_any_letters():
    """Seeded mixtures of the letters that mean something to Markdown."""
    renderer = MarkdownIt("commonmark").enable(["table", "strikethrough"])
    moments = random.Random(14)
    for _ in range(2000):
        title = "".join(moments.choices("\\\\`*_{}[]()<>#+-.!|$~&;=:/1 ab", k=12)).strip()
        shown = renderer.render(markdown(title))
        assert re.fullmatch(r"<p>[^<]*</p>\n", shown), title
        assert html.unescape(shown[3:-5]) == title


def test_pictures_show_dollars_as_dollars():
    for title in TITLES:

        @drawn
        def picture(title=title):
            figure = page_figure(40)
            axes = figure.subplots()
            axes.set_title(title)
            axes.plot([1, 2], [1, 2], label=title)
            axes.legend()
            axes.set_xticks([1, 2], [title, title])
            return figure

        figure = picture()
        found = [text for text in figure.findobj(Text) if text.get_text() == title]
        # Heading, legend, and two ticks with a text on each side.
        assert len(found) == 6
        for text in found:
            assert text._preprocess_math(title) == (title, False)


def test_powers_of_ten_beside_logarithmic_axes():
    @drawn
    def picture():
        figure = page_figure(60)
        axes = figure.subplots()
        axes.loglog([1e-3, 1e5], [1e2, 3e2])
        return figure

    (axes,) = picture().axes
    shown = [label.get_text() for label in axes.get_xticklabels()]
    assert {"10⁻³", "10⁰", "10⁵"} <= set(shown)
    small = [label.get_text() for label in axes.yaxis.get_ticklabels(minor=True)]
    assert "2·10²" in small
    assert "$" not in "".join(shown + small)


@pytest.mark.parametrize("titles", [TITLES, TITLES[::-1]], ids=["first", "last"])
def test_a_report_with_any_title(data, tmp_path, titles):
    """The whole report, its pictures with the title in them, and no element of the title's own.

    All of them in one line, because a report takes seconds; alone they are tested above.
    """
    title = " ".join(titles)
    given = dataclasses.replace(
        data, title=title, source=title, command=title, left_out=((title, title),), modes=None
    )
    path = write_report(tmp_path / "out", given, attachments={"a $b$ <c>.txt": title}, dpi=40)
    page = path.read_text()
    body = page.split("</style>", 1)[1]
    # Scripts of the page's own are read in test_report_signed.py.
    body = re.sub(r"<script(?: type=.application/json.)?>.*?</script>", "", body, flags=re.S)
    assert "<script" not in body
    assert not re.search(r"<img(?! alt=)", body)
    assert body.count("<h1>") == 1
    assert html.unescape(re.search(r"<h1>(.*)</h1>", body)[1]) == title
    assert 'href="a%20%24b%24%20%3Cc%3E.txt"' in body
    shown = MarkdownIt("commonmark").enable("table").render((path.parent / "report.md").read_text())
    assert "<script" not in shown
    assert html.unescape(re.search(r"<h1>(.*)</h1>", shown)[1]) == title
    assert not re.findall(r"<(?:code|del|b)>", shown)


def test_a_title_of_any_length_and_letters(data, tmp_path):
    """Cut where it is a label; a letter that the font lacks is no warning; no line of its own."""
    title = "电动作动器 \u0001\n<b>\u202e " + "long " * 10_000
    few = dataclasses.replace(data, title=title, modes=None, steady=None, meshings=None)
    assert len(few.label) <= 60
    path = write_report(tmp_path / "out", few, dpi=40)
    assert "电动作动器 \ufffd &lt;b&gt;\ufffd long" in path.read_text()


def test_control_characters_do_not_reach_a_terminal():
    assert printable("a\x1b[31mb\r\nc\x9d") == "a\ufffd[31mb c\ufffd"
    text = TextTable("\x1b[2J", ("a", "b"), [("\x1b]0;x\x07", 1.0)]).text()
    assert not re.search(r"[\x00-\x09\x0b-\x1f]", text)
