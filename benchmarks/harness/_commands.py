"""What the commands of several folders share: options, processes of their own, dates."""

import argparse
import datetime
import importlib.util
import subprocess
import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from .report import machine, versions


def parser_of(name: str, about: str | None, *, several: bool = False) -> argparse.ArgumentParser:
    """A parser with `--out`, `--docs` and `--page`.

    **Arguments:**

    - `name`: of the command.
    - `about`: what it does.
    - `several`: whether the page may join several files.
    """
    parser = argparse.ArgumentParser(prog=f"python -m benchmarks {name}", description=about)
    parser.add_argument(
        "--out", type=Path, default=Path("out/benchmarks"), help="folder for the results"
    )
    parser.add_argument("--docs", type=Path, help="folder for the page and its pictures")
    pages: dict[str, Any] = {"nargs": "+"} if several else {}
    words = "only the page, from these files" if several else "only the page, from this file"
    parser.add_argument("--page", type=Path, metavar="JSON", help=words, **pages)
    return parser


def refuse_unknown(
    parser: argparse.ArgumentParser, what: str, given: Collection[str], known: Collection[str]
) -> None:
    """End with one line that names what is not known, if there is such a name."""
    unknown = sorted(set(given) - set(known))
    if unknown:
        parser.error(f"unknown {what} {', '.join(unknown)}; choose from {', '.join(known)}")


def of_this_run(schema: int) -> dict[str, Any]:
    """The first keys of a document: what is true of the whole run."""
    return {
        "schema": schema,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": versions(),
    }


def where_and_when(document: Mapping[str, Any]) -> str:
    """Cores, processor and day of a run, without a full stop."""
    machine = document["machine"]
    cores = {1: "one core", 2: "two cores"}.get(machine["cores"], f"{machine['cores']} cores")
    return f"On a busy machine of {cores} ({machine['processor']}), {document['date'][:10]}"


def why_left_out(package: str) -> str | None:
    """Why a rival of this package is not measured: it is not installed; `None` if it is."""
    return None if importlib.util.find_spec(package) else f"not installed: {package}"


def run_worker(
    module: str, words: Sequence[str], limit: float
) -> subprocess.CompletedProcess[str] | None:
    """Run a module of this package in a process of its own; `None` past the time limit [s]."""
    try:
        return subprocess.run(
            [sys.executable, "-m", f"benchmarks.{module}", *words],
            capture_output=True,
            text=True,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None
