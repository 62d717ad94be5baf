"""Options that are counts or shares, and what is said of options that cannot be used."""

import contextlib
import itertools
from collections.abc import Sequence
from typing import Any

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    Parameter,
    Token,
    ValidationError,
)

#: Designs of one run, which are in memory at once.
MOST_DESIGNS = 100_000_000
#: Values along one curve, as many as samples of a transient.
MOST_VALUES = 1_000_000


def count(least: int, most: int | None = None, *, help: str) -> Parameter:
    """A whole number in a range; the message for another one names the option.

    **Arguments:**

    - `least`: the smallest that is allowed.
    - `most`: the largest that is allowed; no limit if it is not given.
    - `help`: what `--help` prints.
    """
    allowed = f"of {least} or more" if most is None else f"from {least} to {most}"

    def validate(_: Any, value: int | None) -> None:
        if value is not None and not (least <= value and (most is None or value <= most)):
            raise ValueError(f"must be a whole number {allowed}")

    def whole(_: Any, tokens: Sequence[Token]) -> int:
        # The parser itself would round 2.5. An integer may be too long for a float.
        text = tokens[0].value
        with contextlib.suppress(ValueError):
            return int(text)
        with contextlib.suppress(ValueError):
            if (number := float(text)).is_integer():
                return int(number)
        raise ValueError(f"must be a whole number {allowed}")

    return Parameter(help=help, validator=validate, converter=whole)


def share(help: str) -> Parameter:
    """A number between 0 and 1, ends excluded; the message for another one names the option.

    **Arguments:**

    - `help`: what `--help` prints.
    """

    def validate(_: Any, value: float | None) -> None:
        if value is not None and not 0 < value < 1:
            raise ValueError("must be between 0 and 1, such as 0.99")

    return Parameter(help=help, validator=validate)


def error_text(error: CycloptsError, words: Sequence[str]) -> str:
    """What is wrong with the words after `prsm`, in the form of the package's own messages."""
    argument = error.argument
    if isinstance(error, ValidationError) and argument is not None and argument.tokens:
        option = argument.tokens[0].keyword or argument.name
        return f"{option} {argument.value}: {error.exception_message}"
    if isinstance(error, CoercionError) and error.token is not None and error.msg:
        # Only counts have a message of their own here.
        return f"{error.token.keyword} {error.token.value}: {error.msg}"
    if isinstance(error, MissingArgumentError):
        for option, value in itertools.pairwise(words):
            if option == error.keyword and value.startswith("-") and not value.startswith("--"):
                return (
                    f"{option} {value}: a value that begins with a minus is taken for an option; "
                    f"write {option}='{value}'"
                )
    return str(error)
