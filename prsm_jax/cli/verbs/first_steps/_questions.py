"""The five questions of the verb new: options of the command, or asked on the terminal."""

import contextlib
import math
import sys
from dataclasses import dataclass

from ...._errors import PrsmError
from ....file import read_quantity
from ....text import comma_in_number
from ..._progress import clear


@dataclass(frozen=True)
class Question:
    """One question: its option, SI unit, words, and an example of an answer."""

    name: str
    unit: str
    words: str
    example: str


QUESTIONS = (
    Question("load", "N", "Axial load on the nut", "10 kN"),
    Question("stroke", "m", "Stroke", "300 mm"),
    Question("speed", "m/s", "Largest speed of the nut", "100 mm/s"),
    Question("life", "s", "Life at this load and speed, or the travel in it", "5000 h"),
    Question("envelope", "m", "Diameter of the bore for the nut", "80 mm"),
)


def answers(given: dict[str, str | None]) -> dict[str, float]:
    """The five requirements [SI]; those that are not given are asked for on a terminal.

    A life that is a length is the travel of the nut in it.

    **Arguments:**

    - `given`: the options by name; `None` where there is none.

    **Raises:** `PrsmError` for an option that cannot be used, and for a missing one where stdin is
    not a terminal.
    """
    found: dict[str, float] = {}
    # First those that are given: a mistake in them ends the verb before a question.
    for question in QUESTIONS:
        text = given[question.name]
        if text is not None and not _needs_speed(question, text, given["speed"]):
            try:
                found[question.name] = _read(question, text, given["speed"])
            except ValueError as error:
                raise PrsmError(f"--{question.name} {text}: {error}") from error
    missing = [one for one in QUESTIONS if given[one.name] is None]
    if missing and not sys.stdin.isatty():
        options = ", ".join(f"--{one.name} '{one.example}'" for one in missing)
        raise PrsmError(f"new: give {options}; or run it in a terminal, where it asks for them")
    for question in missing:
        found[question.name] = _asked(question, given)
    if "life" not in found:
        assert given["life"] is not None
        found["life"] = read_quantity(given["life"], "m") / found["speed"]
    return found


def _needs_speed(question: Question, text: str, speed: str | None) -> bool:
    """Whether a life is a travel whose speed is asked for afterwards."""
    if question.name != "life" or speed is not None:
        return False
    with contextlib.suppress(ValueError):
        return 0 < read_quantity(text, "m") < math.inf
    return False


def _asked(question: Question, given: dict[str, str | None]) -> float:
    clear()
    while True:
        # Not `input`, which writes to stdout where stderr is no terminal.
        print(f"{question.words} (such as {question.example}): ", end="", file=sys.stderr)
        sys.stderr.flush()
        text = sys.stdin.readline()
        if not text:
            raise PrsmError(f"new: no answer for {question.name}; give --{question.name}")
        try:
            value = _read(question, text.strip(), given["speed"])
        except ValueError as error:
            print(f"  {error}", file=sys.stderr)
            continue
        given[question.name] = text.strip()
        return value


def _read(question: Question, text: str, speed: str | None) -> float:
    """An answer [SI]. **Raises:** `ValueError` with what to give."""
    try:
        value = _value(question, text, speed)
    except ValueError as error:
        if comma := comma_in_number(text):
            raise ValueError(comma) from error
        # A bare number would be in SI: 300 m of stroke in place of 300 mm.
        reason = str(error).partition(";")[0]
        raise ValueError(f"{reason}; give it with its unit, such as {question.example}") from error
    if not 0 < value < math.inf:
        raise ValueError(f"must be above 0 and finite; such as {question.example}")
    return value


def _value(question: Question, text: str, speed: str | None) -> float:
    try:
        return read_quantity(text, question.unit)
    except ValueError:
        if question.name != "life" or speed is None:
            raise
        # A travel: the time in which the nut makes it at its speed.
        with contextlib.suppress(ValueError, ZeroDivisionError):
            return read_quantity(text, "m") / read_quantity(speed, "m/s")
        raise
