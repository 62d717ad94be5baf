"""Blocks of a page, and what they print: `python -m tests.docs.printed PAGE…` writes it anew.

A block of Python, or of `prsm` commands, that is followed by a block of text prints this text. A
line `…` of the text stands for any number of lines. Blocks of text without such a line are written
anew by the command; the tests compare all.
"""

import contextlib
import dataclasses
import io
import itertools
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.docs.claims import value_of

_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", flags=re.M | re.S)
_NUMBER = re.compile(r"[-−+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-−+]?\d+)?")
_ANY_LINES = "…"
_ROUNDING = 1e-12
#: Columns of a terminal that is none.
_COLUMNS = "80"


@dataclasses.dataclass(frozen=True)
class Block:
    """A block of code of a page, and the text that it should print, if the page has one."""

    code: str
    printed: str | None
    #: Where that text stands in the page.
    span: tuple[int, int] | None


def blocks(text: str, language: str) -> list[Block]:
    """The blocks of a language, in order."""
    found = list(_BLOCK.finditer(text))
    result = []
    for block, after in itertools.zip_longest(found, found[1:]):
        if block[1] != language:
            continue
        follows = after and after[1] == "text" and not text[block.end() : after.start()].strip()
        printed, span = (after[2], after.span(2)) if after and follows else (None, None)
        result.append(Block(block[2], printed, span))
    return result


def differences(expected: str, printed: str) -> str:
    """Why a printed text is not the expected one; empty if it is.

    Words must be equal, white space counts alike. A number may differ by one unit of its last
    digit: half of it is rounding, and programs that are compiled otherwise round otherwise. Numbers
    below 1e-12, such as the residual of a balance, are rounding alone.
    """
    lines = [" ".join(line.split()) for line in printed.rstrip().splitlines()]
    at, anywhere = 0, False
    for line in (" ".join(line.split()) for line in expected.rstrip().splitlines()):
        if line == _ANY_LINES:
            anywhere = True
            continue
        while at < len(lines) and anywhere and not _alike(line, lines[at]):
            at += 1
        if at == len(lines) or not _alike(line, lines[at]):
            return f"expected: {line!r}\nprinted:  {lines[at] if at < len(lines) else ''!r}"
        at, anywhere = at + 1, False
    return "" if anywhere or at == len(lines) else f"printed, too: {lines[at]!r}"


def _alike(expected: str, printed: str) -> bool:
    if _NUMBER.split(expected) != _NUMBER.split(printed):
        return False
    for first, second in zip(_NUMBER.findall(expected), _NUMBER.findall(printed), strict=True):
        value, half = value_of(first.replace("e+", "e"))
        other, _ = value_of(second.replace("e+", "e"))
        if abs(value - other) > max(2 * half * (1 + 1e-9), _ROUNDING):
            return False
    return True


def run_command(line: str) -> None:
    """Run one `prsm` command in this process; `> FILE` writes what it prints into a file."""
    from prsm_jax.cli import main

    words = shlex.split(line, comments=True)
    if not words or words[0] != "prsm":
        raise ValueError(f"not a command of prsm: {line!r}")
    words, target = (words[1:-2], words[-1]) if words[-2:-1] == [">"] else (words[1:], None)
    kept = io.StringIO()
    with contextlib.redirect_stdout(kept) if target else contextlib.nullcontext():
        status = main(words)
    if status not in (0, 1):
        raise RuntimeError(f"{line}: exit status {status}")
    if target:
        Path(target).write_text(kept.getvalue(), encoding="utf-8")


def run_commands(code: str) -> None:
    """Run the commands of a block, one in each line; a backslash continues a line."""
    for line in code.replace("\\\n", " ").splitlines():
        if line.strip():
            run_command(line)


def session(page: Path, language: str) -> Callable[[str], None]:
    """What runs the blocks of a page: Python blocks share their names."""
    if language == "console":
        return run_commands
    namespace: dict[str, object] = {"__name__": "documentation", "__package__": None}
    return lambda code: exec(compile(code, str(page), "exec"), namespace)


def _written_anew(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    changes: list[tuple[tuple[int, int], str]] = []
    for language in ("python", "console"):
        found = blocks(text, language)
        if all(block.printed is None for block in found):
            continue
        run = session(page, language)
        for block in found:
            kept = io.StringIO()
            with contextlib.redirect_stdout(kept):
                run(block.code)
            if block.printed is None or block.span is None:
                continue
            if _ANY_LINES in block.printed.splitlines():
                print(f"{page.name}: {differences(block.printed, kept.getvalue()) or 'as before'}")
            else:
                changes.append((block.span, kept.getvalue().rstrip() + "\n"))
    for (start, end), printed in sorted(changes, reverse=True):
        lines = [line.rstrip() for line in printed.splitlines()]
        text = text[:start] + "\n".join(lines) + "\n" + text[end:]
    return text


def main() -> int:
    """Write the texts of the pages that are named."""
    os.environ["COLUMNS"] = _COLUMNS
    pages = [Path(name).resolve() for name in sys.argv[1:]]
    for page in pages:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            page.write_text(_written_anew(page), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
