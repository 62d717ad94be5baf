"""The notebooks run from top to bottom, the committed ones belong to their scripts, and each asks a
question and answers it with numbers that it has printed.
"""

import importlib.util
import re
from pathlib import Path

import jupytext
import pytest

from tests.compilation_cache import cache_folder

FOLDER = Path(__file__).parents[2] / "notebooks"
_spec = importlib.util.spec_from_file_location("build_notebooks", FOLDER / "build.py")
assert _spec is not None
assert _spec.loader is not None
build = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(build)

_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]\d+)?")
#: What is no number of a result: targets of links, code, and file names.
_ASIDE = re.compile(r"\]\([^)]*\)|`[^`]*`")


def _shown(number: str) -> tuple[float, float]:
    """The value of a number, and half a unit of its last digit."""
    digits, _, power = number.partition("e")
    places = len(digits.partition(".")[2])
    return float(number), 0.5 * 10.0 ** (int(power or 0) - places)


def _printed(notebook) -> list[tuple[float, float]]:
    """Every number that the cells print or show as text."""
    texts = []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            texts.append(output.get("text", ""))
            texts.append(output.get("data", {}).get("text/plain", ""))
    return [_shown(number) for number in _NUMBER.findall("\n".join(texts))]


def _not_printed(notebook, answer: str) -> list[str]:
    """Numbers of the answer that no printed number is, rounded to the digits of the answer."""
    printed = _printed(notebook)
    return [
        number
        for number in _NUMBER.findall(_ASIDE.sub(" ", answer))
        # The printed number is rounded itself, by half a unit of its own last digit.
        if not any(
            abs(value - _shown(number)[0]) <= _shown(number)[1] + own and own <= _shown(number)[1]
            for value, own in printed
        )
    ]


@pytest.mark.timeout(900)
@pytest.mark.filterwarnings("default")  # those of the kernel's own machinery are not ours
@pytest.mark.parametrize("script", build.scripts(), ids=lambda path: path.stem)
def test_a_notebook_runs(script, monkeypatch):
    # The kernel is a process of its own; let it share what the tests have compiled.
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", cache_folder())
    monkeypatch.setenv("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")
    notebook = build.execute(script)
    pictures = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 4
    assert _not_printed(notebook, notebook.cells[-1].source) == []


@pytest.mark.parametrize("script", build.scripts(), ids=lambda path: path.stem)
def test_the_committed_notebook_is_that_of_the_script(script):
    def sources(path):
        return [(cell.cell_type, cell.source) for cell in jupytext.read(path).cells]

    assert sources(script.with_suffix(".ipynb")) == sources(script)


@pytest.mark.parametrize("script", build.scripts(), ids=lambda path: path.stem)
def test_a_notebook_asks_and_answers(script):
    committed = jupytext.read(script.with_suffix(".ipynb"))
    question, answer = committed.cells[0], committed.cells[-1]
    assert (question.cell_type, answer.cell_type) == ("markdown", "markdown")
    assert "question" in question.source
    assert "?" in question.source
    assert answer.source.startswith("## Answer\n")
    assert _NUMBER.search(_ASIDE.sub(" ", answer.source))
    assert _not_printed(committed, answer.source) == []
    following = [later for later in build.scripts() if later > script][:1]
    for later in following:
        assert f"]({later.stem}.ipynb)" in answer.source
    for target in re.findall(r"\]\(([^)]*)\)", answer.source):
        assert (FOLDER / target).is_file(), target


def test_a_wrong_number_of_an_answer_is_found():
    committed = jupytext.read(FOLDER / "07_real_mechanisms.ipynb")
    assert _not_printed(committed, "at 91.4 Hz, 98.8 Hz") == []
    assert _not_printed(committed, "at 91.3 Hz, 98.8 Hz and [this](03_x.ipynb) `4`") == ["91.3"]
