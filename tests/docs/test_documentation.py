"""Blocks of README and documentation: Python runs, TOML loads, and what is printed is the text."""

from pathlib import Path

import jax
import pytest

import prsm_jax as prsm
from tests.compilation_cache import cache_folder
from tests.docs.printed import blocks, differences, session

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def _blocks(page: Path, language: str):
    return blocks(page.read_text(encoding="utf-8"), language)


def _pages_with(language, *, printed=False):
    return [
        pytest.param(page, id=page.stem)
        for page in PAGES
        if any(one.printed or not printed for one in _blocks(page, language))
    ]


def _run(page, language, capsys):
    """Run the blocks of a page, compare what they print, and give all of it."""
    run, everything = session(page, language), ""
    for block in _blocks(page, language):
        run(block.code)
        printed = capsys.readouterr().out
        everything += printed
        if block.printed is not None:
            wrong = differences(block.printed, printed)
            assert not wrong, f"{page.name}: python -m tests.docs.printed {page.name}\n{wrong}"
    return everything


@pytest.mark.usefixtures("memory_for_large_programs")
@pytest.mark.parametrize("page", _pages_with("python"))
def test_python_blocks_run(page, capsys, monkeypatch, tmp_path):
    # One page is one session: later blocks use what earlier ones made. Files go to an empty folder.
    from prsm_jax.findings import _margin
    from prsm_jax.quantities import _catalogue

    monkeypatch.chdir(tmp_path)
    known, sources = dict(_catalogue._CATALOGUE), list(_margin._SOURCES)
    try:
        printed = _run(page, "python", capsys)
    finally:
        _catalogue._CATALOGUE.clear()
        _catalogue._CATALOGUE.update(known)
        _margin._SOURCES[:] = sources
    assert printed


@pytest.mark.usefixtures("memory_for_large_programs")
@pytest.mark.parametrize("page", _pages_with("console", printed=True))
def test_commands_print_what_the_page_shows(page, capsys, monkeypatch, tmp_path):
    shared = cache_folder()
    monkeypatch.setenv("PRSM_JAX_CACHE", shared)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(tmp_path)
    try:
        assert _run(page, "console", capsys)
    finally:
        jax.config.update("jax_compilation_cache_dir", shared)


def test_printed_text_is_compared_number_by_number():
    assert not differences("η 0.859\n…\nlast 3", "η  0.8591\nany\nline\nlast 3\n")
    assert not differences("0.859 %", "0.860 %")
    assert "expected: '0.859 %'" in differences("0.859 %", "0.861 %")
    assert "expected: 'efficiency 1'" in differences("efficiency 1", "torque 1")
    assert "expected: 'b'" in differences("a\n…\nb", "a\nc")
    assert "printed, too: 'b'" in differences("a", "a\nb")


@pytest.mark.parametrize("page", _pages_with("toml"))
def test_toml_blocks_load(page):
    for block in _blocks(page, "toml"):
        assert prsm.loads(block.code).stages


def test_readme_names_every_verb():
    from prsm_jax.cli._verbs import app

    verbs = {name for name in app if not name.startswith("-")}
    text = (ROOT / "README.md").read_text()
    table = (ROOT / "docs/command_line.md").read_text()
    for verb in verbs:
        assert f"`{verb}`" in text
        assert f"`{verb}`" in table
