"""The core paths with other versions: `python -m tests.versions lowest|newest [PYTHON …]`.

`lowest` installs what `pyproject.toml` names as the lowest versions, `newest` whatever is newest,
each into an environment of its own below `out/versions`, and runs the tests of the core paths with
it. A Python that is not on this machine is named as not tested.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from .core import TESTS
from .requirements import lowest, read_project

_ROOT = Path(__file__).parents[2]
_EXTRAS = ("all", "test")
#: Of the extra `test`, what the tests of the core paths do not use.
_UNUSED = (
    "cadquery-ocp-novtk",
    "fmpy",
    "hatchling",
    "ipykernel",
    "jupytext",
    "nbclient",
    "nicegui",
    "selenium",
)

#: Warnings of other packages' old versions are not ours to mend.
_WARNINGS = ("-W", "default", "-W", "ignore::DeprecationWarning")


def _interpreter(wanted: str) -> str | None:
    """The path of a Python, named by its version (3.12) or its command."""
    is_version = wanted[0].isdigit()
    names = [f"python{wanted}", wanted] if is_version else [wanted]
    found = [path for name in names if (path := shutil.which(name))]
    if is_version:
        versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
        found += [str(path) for path in sorted(versions.glob(f"{wanted}.*/bin/python"))]
    for path in found:
        # A shim of pyenv is there and fails.
        asked = subprocess.run([path, "-V"], capture_output=True, text=True, check=False)
        if asked.returncode == 0 and asked.stdout.startswith("Python 3"):
            return path
    return None


def _requirements(kind: str) -> list[str]:
    pins = lowest(read_project(_ROOT / "pyproject.toml"), _EXTRAS)
    sign = "==" if kind == "lowest" else ">="
    return [f"{name}{sign}{version}" for name, version in pins.items() if name not in _UNUSED]


def _environment(kind: str, python: str) -> Path:
    """The interpreter of an environment that has these requirements."""
    version = subprocess.check_output(
        [python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"], text=True
    ).strip()
    folder = _ROOT / "out" / "versions" / f"{kind}-{version}"
    requirements = _requirements(kind)
    mark, state = folder / ".installed", hashlib.sha256(repr(requirements).encode()).hexdigest()
    inner = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    # What is newest changes from day to day; pip says so in seconds.
    if kind == "lowest" and mark.exists() and mark.read_text() == state:
        return inner
    if not inner.exists():
        subprocess.run([python, "-m", "venv", str(folder)], check=True)
    install = [str(inner), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*install, "--upgrade", *requirements], check=True)
    mark.write_text(state)
    return inner


def _run(kind: str, python: str) -> bool:
    began = time.monotonic()
    inner = _environment(kind, python)
    installed = time.monotonic()
    command = [str(inner), "-m", "pytest", "-q", "-p", "no:cacheprovider", *_WARNINGS]
    command += ["-o", "addopts=--strict-markers", "--disable-warnings", "--durations=8"]
    command += ["-n", os.environ.get("WORKERS", "2"), "--dist", "worksteal", *TESTS]
    environment = os.environ | {"PYTHONPATH": str(_ROOT), "PYTHONDONTWRITEBYTECODE": "1"}
    passed = subprocess.run(command, cwd=_ROOT, env=environment, check=False).returncode == 0
    print(f"({installed - began:.0f} s to install, {time.monotonic() - installed:.0f} s to test)")
    return passed


def main() -> int:
    """Exit status 0 if everything that could be run passed."""
    parser = argparse.ArgumentParser(prog="python -m tests.versions", description=__doc__)
    parser.add_argument("kind", choices=("lowest", "newest"))
    parser.add_argument("python", nargs="*", default=[sys.executable])
    given = parser.parse_args()
    told, failed = [], False
    for wanted in given.python:
        python = _interpreter(wanted)
        if python is None:
            told.append(f"NOT TESTED with Python {wanted}: there is none on this machine")
            continue
        try:
            passed = _run(given.kind, python)
        except subprocess.CalledProcessError as error:
            passed = False
            print(f"cannot install: {error}")
        failed = failed or not passed
        told.append(f"{given.kind} versions, {wanted}: {'passed' if passed else 'FAILED'}")
    print("\n".join(told))
    return int(failed)


raise SystemExit(main())
