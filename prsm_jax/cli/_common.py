"""Options that every verb shares, and how results leave the program."""

import collections
import json
import math
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import jax
import numpy as np
from cyclopts import Parameter

from .._errors import PrsmError, UnknownNameError
from ..findings import CheckNumbers, check_from, margin_numbers, prepare_check
from ..geometry import Finding
from ..mechanism import Mechanism, find_parameters, get_parameter
from ..process import make_folder, whole_file
from ..programs import while_compiling
from ..text import markdown
from ._progress import clear, doing, expect_programs
from ._tables import TextTable, terminal_width
from ._targets import check_folder, check_json

#: Quantities in the tables of some verbs; their assumptions are printed below the tables.
CONTACT = ("max_pressure", "approach_screw", "approach_nut", "max_von_mises_screw")
VIBRATION = ("natural_frequencies",)
CRITICAL_SPEEDS = ("natural_frequencies", "carrier_ratio")
STEADY = ("efficiency", "carrier_ratio", "drive_torque", "contact_force", "loss_power")
TRANSIENT = ("efficiency", "carrier_ratio", "drive_torque", "contact_force")


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

    def check_targets(self, default: str | None = None) -> None:
        """Refuse outputs that cannot be written, before anything is computed.

        **Arguments:**

        - `default`: the folder for results without `--out`, if there is one.
        """
        check_json(self.json)
        check_folder(self.out, "--out")
        if self.out is None and default is not None:
            check_folder(Path(default), "the folder")


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

    def load(self, source: str, *, is_checked: bool = True) -> Mechanism:
        """Check the outputs, read the mechanism and apply the settings.

        **Arguments:**

        - `source`: name of an example, or path of a file.
        - `is_checked`: whether the verb ends with the findings of this mechanism, and not with
          those of another one.
        """
        from ..file import apply_settings, load

        self.check_targets()
        mechanism = load(source)
        if self.settings:
            mechanism = apply_settings(mechanism, self.settings)
        # Every verb that analyses a mechanism ends with findings.
        expect_programs("_numbers_by")
        if is_checked:
            while_compiling(lambda: prepare_check(mechanism))
        return mechanism


def checked(mechanism: Mechanism) -> tuple[Finding, ...]:
    """Findings of `check`; the terminal announces it because its program compiles slowly."""
    return check_from(mechanism, checked_numbers(mechanism))


def checked_numbers(mechanism: Mechanism) -> CheckNumbers:
    """Values of the margins, as `check_numbers`; announced as `checked` says."""
    doing("checking the design")
    return margin_numbers(mechanism)


def plain(value: Any) -> Any:
    """Convert arrays and containers to JSON types; numbers that are not finite become null."""
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
    """Write a file completely or not at all."""
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


@dataclass(frozen=True)
class Saved:
    """What a verb saves in the folder of `--out`: its results as NAME.json, tables as NAME.md."""

    #: Name of the two files, without ending.
    name: str
    tables: Iterable[TextTable]
    #: Sentences below the tables.
    sentences: Sequence[str] = ()


def _encoded(results: Mapping[str, Any]) -> str:
    return json.dumps(plain(results), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def emit(
    output: Output,
    results: Mapping[str, Any],
    text: Callable[[], str],
    assumptions: Sequence[str] | None = None,
    findings: Sequence[Finding] | None = None,
    saved: Saved | None = None,
) -> bool:
    """Write results as JSON to a file or stdout (`--json`), or else as text to stdout.

    The text is made only if it is shown, because tables take time to import. The assumptions
    (`prsm_jax.assumptions`) are a key of the JSON and stand below the text. Each error of `check`
    is a line on stderr; a finding that makes the mechanism impossible makes the results invalid.
    With `--out`, `saved` is written to that folder too: the JSON has the same keys as that of
    `--json`, and the page says the same of findings and assumptions as the text.

    **Returns:** whether the results are valid: their own `valid` (default true), and no finding
    makes the mechanism impossible.
    """
    valid = bool(results.get("valid", True))
    if findings is not None:
        valid = valid and not any(finding.impossible for finding in findings)
        names = list(dict.fromkeys(f.name for f in findings if f.severity != "note"))
        results = {**results, "findings": names, "valid": valid}
        clear()
        for finding in findings:
            if finding.severity == "error":
                where = f"{finding.name}, stage {finding.stage}"
                print(f"prsm: error found by check: {where}: {finding.message}", file=sys.stderr)
    if assumptions is not None:
        results = {**results, "assumptions": list(assumptions)}
    if saved is not None and output.out is not None:
        page = output.out / f"{saved.name}.md"
        written = page.with_suffix(".json"), page
        results = {**results, "files": written}
        make_folder(output.out)
        write_text(written[0], _encoded(results))
        write_text(page, _page(saved, assumptions or (), findings or ()))
    if output.json is None:
        words = text().rstrip()
        if findings:
            words += "\n" + _findings_text(findings).rstrip()
        if assumptions:
            words += "\n\n" + assumed(assumptions)
        clear()
        print(words)
        return valid
    encoded = _encoded(results)
    clear()
    if output.json == "-":
        sys.stdout.write(encoded)
    else:
        write_text(Path(output.json), encoded)
    return valid


def _page(saved: Saved, assumptions: Sequence[str], findings: Sequence[Finding]) -> str:
    """The saved tables as Markdown, with what the terminal says below them."""
    parts = [table.markdown() for table in saved.tables]
    parts += [markdown(sentence) + "\n" for sentence in (*saved.sentences, *_in_words(findings))]
    if assumptions:
        lines = [f"* {markdown(sentence)}\n" for sentence in assumptions]
        parts.append("Assumptions\n\n" + "".join(lines))
    return "\n".join(parts)


def _in_words(findings: Sequence[Finding]) -> list[str]:
    """Names of errors and warnings, and whether the mechanism is impossible, as sentences."""
    sentences = []
    for severity in ("error", "warning"):
        names = collections.Counter(f.name for f in findings if f.severity == severity)
        if names:
            listed = ", ".join(f"{n} ({k})" if k > 1 else n for n, k in names.items())
            sentences.append(f"prsm check finds {severity}s: {listed}")
    if any(finding.impossible for finding in findings):
        sentences.append("Not valid: the mechanism cannot be built as drawn.")
    return sentences


def _findings_text(findings: Sequence[Finding]) -> str:
    """Names of errors and warnings as lines for a terminal."""
    lines: list[str] = []
    for sentence in _in_words(findings):
        lines += textwrap.wrap(sentence, 78, subsequent_indent="  ")
    return "\n" + "\n".join(lines) + "\n" if lines else ""


def assumed(assumptions: Sequence[str]) -> str:
    """Assumptions as lines for a terminal."""
    lines = [
        textwrap.fill(sentence, terminal_width(), initial_indent="  - ", subsequent_indent="    ")
        for sentence in assumptions
    ]
    return "\n".join(["Assumptions", *lines])


def value_of(mechanism: Mechanism, name: str, text: str, option: str) -> float:
    """A value of a named number [SI], written with its unit as in `--set`.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `name`: the number.
    - `text`: its value.
    - `option`: what the user wrote, for messages, such as `--from 1 mm`.
    """
    from ..file import apply_settings

    setting = f"{name}={text.strip()}"
    return float(get_parameter(apply_settings(mechanism, [setting], option=option), name))


def words_of(text: str | None) -> list[str] | None:
    """A comma-separated option as a list."""
    if text is None:
        return None
    return [word.strip() for word in text.split(",") if word.strip()]


def parameters_of(
    mechanism: Mechanism, text: str | None, option: str, *, differentiated: bool = False
) -> list[str] | None:
    """A comma-separated option of names of numbers, as a list.

    **Arguments:**

    - `mechanism`: the mechanism that has the numbers.
    - `text`: what the user wrote; `None` gives `None`.
    - `option`: the option, for messages.
    - `differentiated`: whether whole numbers, which have no derivative, are refused.

    **Raises:** `PrsmError` for a name that is unknown or ambiguous.
    """
    names = words_of(text)
    for name in names or ():
        try:
            static = find_parameters(mechanism, name)[0].static
        except UnknownNameError as error:
            raise PrsmError(f"{option}: {error}") from error
        if static and differentiated:
            raise PrsmError(f"{option}: {name} is a whole number, which has no derivative")
    return names
