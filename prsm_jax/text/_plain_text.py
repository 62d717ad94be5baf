"""Text from users: shown literally, never interpreted by a terminal, a browser or Markdown."""

import re

_LONGEST_HEADING, _LONGEST_LABEL = 200, 60
_LINE_BREAKS = re.compile(r"[\t-\r\x1c-\x1f\x85\u2028\u2029]+")
#: Control characters, marks that turn the direction of writing, and halves of characters.
_NOT_SHOWN = re.compile(r"[\x00-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")
#: Characters with a meaning in Markdown: CommonMark, and GitHub's tables, strike-through and
#: formulas. An underscore between letters or digits has none.
_MARKS = re.compile(r"[\\`*\[\]<>|$~]|&(?=[#\w])|(?<![^\W_])_|_(?![^\W_])")
_LIST_OR_HEADING = re.compile(r"^(\d*)([#+\-=.)])(?=[\s#\-=]|$)")


def printable(text: str) -> str:
    """The text in one line, with a substitute for each character that cannot be shown."""
    return _NOT_SHOWN.sub("\ufffd", _LINE_BREAKS.sub(" ", text))


def short_heading(text: str) -> str:
    """The text as a heading: printable, and cut if it is too long."""
    return _cut(text, _LONGEST_HEADING)


def short_label(text: str) -> str:
    """The text as a label in a picture: printable, and cut if it is too long."""
    return _cut(text, _LONGEST_LABEL)


def _cut(text: str, longest: int) -> str:
    line = printable(text[: 4 * longest]).strip()
    return line if len(line) <= longest else line[: longest - 1] + "…"


def markdown(text: str) -> str:
    """The text in one line, escaped so that Markdown shows it literally."""
    line = _MARKS.sub(lambda match: "\\" + match[0], printable(text).strip())
    return _LIST_OR_HEADING.sub(r"\1\\\2", line)
