"""Every Python block of README and documentation runs, page by page, and every TOML loads."""

import re
from pathlib import Path

import pytest

import prsm_jax as prsm

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), flags=re.M | re.S)


def _pages_with(language):
    return [pytest.param(p, id=p.stem) for p in PAGES if p.exists() and blocks(p, language)]


@pytest.mark.parametrize("page", _pages_with("python"))
def test_python_blocks_run(page, capsys):
    # One page is one session: later blocks use what earlier ones made.
    from prsm_jax.findings import _margin
    from prsm_jax.quantities import _catalogue

    known, sources = dict(_catalogue._CATALOGUE), list(_margin._SOURCES)
    namespace: dict = {"__name__": "documentation", "__package__": None}
    try:
        for block in blocks(page, "python"):
            exec(compile(block, str(page), "exec"), namespace)
    finally:
        _catalogue._CATALOGUE.clear()
        _catalogue._CATALOGUE.update(known)
        _margin._SOURCES[:] = sources
    assert capsys.readouterr().out


@pytest.mark.parametrize("page", _pages_with("toml"))
def test_toml_blocks_load(page):
    for block in blocks(page, "toml"):
        assert prsm.loads(block).stages


def test_readme_names_every_verb():
    from prsm_jax.cli._verbs import app

    verbs = {name for name in app if not name.startswith("-")}
    text = (ROOT / "README.md").read_text()
    table = (ROOT / "docs/command_line.md").read_text()
    for verb in verbs:
        assert f"`{verb}`" in text
        assert f"`{verb}`" in table
