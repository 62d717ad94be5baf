"""The verb `bench`: error against run time, where the benchmarks are available."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..._errors import PrsmError
from .._app import app
from .._targets import check_folder

_OUT = Path("out/bench")


def _checkout() -> Path:
    """The folder that contains the package `benchmarks`: the current one, or that of `prsm_jax`.

    **Raises:** `PrsmError` if there is none.
    """
    for folder in (Path.cwd(), Path(__file__).resolve().parents[3]):
        if (folder / "benchmarks" / "__main__.py").is_file():
            return folder
    raise PrsmError(
        "bench: the benchmarks are not part of an installation; get a checkout of prsm_jax, "
        "install it there with pip install -e '.[bench]', and run prsm bench in its top folder"
    )


@app.command
def bench(
    *cases: Annotated[str, Parameter(help="Names of cases; default all.")],
    quick: Annotated[bool, Parameter(help="Smaller problems: minutes instead of hours.")] = False,
    page: Annotated[bool, Parameter(help="Only the page, from the results in --out.")] = False,
    out: Annotated[Path, Parameter(help="Folder for the results of each case.")] = _OUT,
    docs: Annotated[
        Path | None,
        Parameter(help="Folder for the page accuracy_and_speed.md and its JSON; default --out."),
    ] = None,
) -> int:
    """Error against run time of every method: charts, one page, one JSON. Needs a checkout."""
    root = _checkout()
    check_folder(out)
    check_folder(docs, "--docs")
    if importlib.util.find_spec("mpmath") is None:
        raise PrsmError(
            "bench: mpmath, which the references need, is missing: pip install -e '.[bench]'"
        )
    arguments = [*cases, "--out", str(out.absolute()), "--docs", str((docs or out).absolute())]
    arguments += ["--quick"] * quick + ["--page"] * page
    path = os.pathsep.join(filter(None, (str(root), os.environ.get("PYTHONPATH"))))
    # A separate process, with the compiler settings that users of the library have.
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", *arguments],
        cwd=root,
        env=os.environ | {"PYTHONPATH": path},
        check=False,
    )
    return done.returncode
