"""Options that every verb shares, and how results leave the program."""

import json
import math
import sys
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import jax
import numpy as np
from cyclopts import Parameter

from .._errors import PrsmError
from .._files import whole_file
from ..mechanism import Mechanism, get_parameter
from ._tables import terminal_width


@Parameter(name="*")
@dataclass(frozen=True)
class Output:
    """Where results go."""

    json: Annotated[
        str | None,
        Parameter(
            name="--json",
            allow_leading_hyphen=True,
            help="Write the results as one JSON object to this file, or to stdout for '-'.",
        ),
    ] = None
    out: Annotated[Path | None, Parameter(name="--out", help="Folder for pictures and files.")] = (
        None
    )


@Parameter(name="*")
@dataclass(frozen=True)
class Common(Output):
    """Options of the verbs that read a mechanism."""

    settings: Annotated[
        list[str],
        Parameter(
            name="--set",
            negative="",
            help="Set a number by its name, with a unit: --set 'lead=12 mm'. May be repeated.",
        ),
    ] = field(default_factory=list)

    def load(self, source: str) -> Mechanism:
        """Read the mechanism and apply the settings."""
        from ..file import apply_settings, load

        mechanism = load(source)
        return apply_settings(mechanism, self.settings) if self.settings else mechanism


def plain(value: Any) -> Any:
    """Arrays and containers as what JSON knows; numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, jax.Array | np.ndarray | np.generic):
        return plain(np.asarray(value).tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    return value


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def emit(
    output: Output,
    results: Mapping[str, Any],
    text: Callable[[], str],
    assumptions: Sequence[str] | None = None,
) -> None:
    """Send results where they were asked for: JSON to a file or stdout, else text to stdout.

    The text is made only if it is shown, because tables take time to import. What the results
    rest on (`prsm_jax.assumptions`) is a key of the JSON and stands beneath the text.
    """
    if output.json is None:
        print(text().rstrip())
        if assumptions:
            print("\n" + assumed(assumptions))
        return
    if assumptions is not None:
        results = {**results, "assumptions": list(assumptions)}
    encoded = json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    if output.json == "-":
        sys.stdout.write(encoded)
    else:
        write_text(Path(output.json), encoded)


def assumed(assumptions: Sequence[str]) -> str:
    """Assumptions as lines for a terminal."""
    lines = [
        textwrap.fill(sentence, terminal_width(), initial_indent="  - ", subsequent_indent="    ")
        for sentence in assumptions
    ]
    return "\n".join(["Assumptions", *lines])


def value_of(mechanism: Mechanism, name: str, text: str, option: str | None = None) -> float:
    """A value of a named number [SI], written with its unit as in `--set`.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `name`: the number.
    - `text`: its value.
    - `option`: where the value was given, if not with `--set`.
    """
    from ..file import apply_settings

    setting = f"{name}={text.strip()}"
    try:
        return float(get_parameter(apply_settings(mechanism, [setting]), name))
    except PrsmError as error:
        if option is None:
            raise
        raise PrsmError(str(error).replace(f"--set {setting}", f"{option} {text}")) from error


def words_of(text: str | None) -> list[str] | None:
    """A comma-separated option as a list."""
    if text is None:
        return None
    return [word.strip() for word in text.split(",") if word.strip()]
