"""The verb doctor: is everything there that the other verbs need?"""

import importlib.metadata
import os
import platform
import shutil
import sys
from pathlib import Path
from typing import Any

from ...._errors import missing_extra
from ...._version import __version__
from ..._app import app
from ..._common import Output, Saved, emit
from ..._progress import doing
from ..._tables import TextTable, prose, terminal_width
from ._installed import Package, extras, required

_DEFAULT = Output()
#: The extra without which the verbs themselves fail.
_NEEDED = "cli"
_OLDEST_PYTHON = (3, 11)


@app.command
def doctor(*, output: Output = _DEFAULT) -> int:
    """Look at the installation: versions, devices, precision, cache. Exit status 1 if one fails.

    Extras that are not installed are listed with the command that installs them; they are no fault.
    """
    output.check_targets()
    doing("looking at the installation")
    results: dict[str, Any] = {
        "prsm_jax": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "folder": str(Path(__file__).parents[3]),
    }
    problems: list[str] = []
    notes: list[str] = []
    if sys.version_info[:2] < _OLDEST_PYTHON:
        problems.append(f"Python {results['python']} is too old: install 3.11 or newer")
    results["packages"], results["extras"] = _packages(problems)
    results |= _devices(problems, notes)
    results["cache"] = _cache(notes)
    results |= {"notes": notes, "problems": problems, "ok": not problems}
    tables = _tables(results)
    lines = [f"note: {one}" for one in notes] + [f"PROBLEM: {one}" for one in problems]
    lines = lines or ["Everything is there."]

    def text() -> str:
        words = "\n".join(table.text(terminal_width()) for table in tables)
        return words + "\n" + prose("\n".join(lines))

    emit(output, results, text, saved=Saved("doctor", tables, lines))
    return int(bool(problems))


def _packages(problems: list[str]) -> tuple[dict[str, str | None], list[dict[str, Any]]]:
    """Versions of the packages by name, and the extras with what they lack."""
    try:
        core, groups = required(), {name: required(name) for name in extras()}
    except importlib.metadata.PackageNotFoundError:
        problems.append(
            "the package prsm-jax is not installed; in its folder run pip install -e '.[all]'"
        )
        return {}, []
    except ModuleNotFoundError as error:
        problems.append(str(missing_extra(_NEEDED, "reading requirements", error)))
        return {}, []
    problems += [_remedy(one, "") for one in core if not one.good]
    rows: list[dict[str, Any]] = []
    for name, group in groups.items():
        missing = [one for one in group if not one.good]
        command = f"pip install 'prsm-jax[{name}]'"
        rows.append(
            {
                "extra": name,
                "missing": [one.name for one in missing],
                "command": command if missing else None,
            }
        )
        if name == _NEEDED:
            problems += [_remedy(one, name) for one in missing]
    every = {one.name: one.version for group in (core, *groups.values()) for one in group}
    return dict(sorted(every.items())), rows


def _remedy(package: Package, extra: str) -> str:
    found = f"version {package.version}" if package.version else "missing"
    whole = f"prsm-jax[{extra}]" if extra else "prsm-jax"
    wanted = f" ({package.wanted} is needed)" if package.wanted else ""
    return f"{package.name}: {found}{wanted}; pip install --upgrade '{whole}'"


def _devices(problems: list[str], notes: list[str]) -> dict[str, Any]:
    """Devices of JAX, the precision, and whether a small program gives the right number."""
    import jax
    import jax.numpy as jnp

    try:
        devices = jax.devices()
        # 1 + 2⁻⁴⁰ is 1 in single precision.
        tiny = float(jax.jit(lambda x: (x + 2.0**-40) - x)(jnp.ones(())))
        # A sum that no device may get wrong.
        total = float(jax.jit(jnp.sum)(jnp.arange(1000.0)))
    except Exception as error:
        problems.append(f"JAX cannot compute: {type(error).__name__}: {error}")
        return {"devices": [], "backend": None, "precision": None}
    if tiny != 2.0**-40:
        problems.append(
            "numbers have single precision: unset JAX_ENABLE_X64=0, and import prsm_jax before "
            "anything that switches it off"
        )
    if total != 499500.0:
        problems.append(
            f"the sum of the numbers 0 to 999 on the device is {total:g} instead of 499500"
        )
    if shutil.which("nvidia-smi") and all(one.platform == "cpu" for one in devices):
        notes.append(
            "there is an NVIDIA card, but this JAX uses the processor: pip install 'jax[cuda13]'"
        )
    return {
        "devices": [{"platform": one.platform, "kind": one.device_kind} for one in devices],
        "backend": jax.default_backend(),
        "precision": "float64" if tiny == 2.0**-40 else "float32",
    }


def _cache(notes: list[str]) -> dict[str, Any]:
    """The folder of compiled programs: where, how much, and whether it can be written."""
    import jax

    named = os.environ.get("PRSM_JAX_CACHE")
    folder = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    if named == "":
        return {"folder": None, "files": 0, "size_bytes": 0}
    if not folder:
        # All verbs work without it. The command line has said why on stderr.
        notes.append(
            "compiled programs are not kept, so every run compiles; name another folder in "
            "PRSM_JAX_CACHE"
        )
        return {"folder": None, "files": 0, "size_bytes": 0}
    sizes = [path.stat().st_size for path in Path(folder).rglob("*") if path.is_file()]
    return {"folder": str(folder), "files": len(sizes), "size_bytes": sum(sizes)}


def _tables(results: dict[str, Any]) -> list[TextTable]:
    cache = results["cache"]
    devices = ", ".join(f"{one['kind']} ({one['platform']})" for one in results["devices"])
    kept = "not kept"
    if cache["folder"]:
        count = f"{cache['files']} file{'s' * (cache['files'] != 1)}"
        kept = f"{cache['folder']} ({count}, {cache['size_bytes'] / 1e6:.1f} MB)"
    rows = [
        ("prsm_jax", results["prsm_jax"]),
        ("Python", results["python"]),
        ("platform", results["platform"]),
        ("folder", results["folder"]),
        ("devices", devices or "none"),
        ("precision", results["precision"] or "not known"),
        ("compiled programs", kept),
    ]
    versions = [(name, version or "missing") for name, version in results["packages"].items()]
    groups = [
        (one["extra"], ", ".join(one["missing"]) or "complete", one["command"] or "")
        for one in results["extras"]
    ]
    tables = [
        TextTable("Installation", ("", ""), rows),
        TextTable("Packages", ("package", "version"), versions),
        TextTable("Extras", ("extra", "missing", "to install it"), groups),
    ]
    return [table for table in tables if table.rows]
