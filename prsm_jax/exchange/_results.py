"""Results as files of other programs: MATLAB, netCDF and CSV."""

import csv
import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._errors import missing_extra
from .._version import __version__
from ..process import whole_file
from ..results import Result
from ._labelled import Labelled, labelled, words_of

#: Rows of a CSV file of histories run over it.
_TIME = "time"


def export_result(result: Result, path: str | os.PathLike[str], *, name: str | None = None) -> Path:
    """Write a result to a file, in the format of its ending; all numbers in SI.

    | ending | format |
    | --- | --- |
    | `.mat` | MATLAB 5: a struct with the numbers, and in it `units` and `about` with their words |
    | `.nc` | netCDF 4: variables with the attribute `units`, over `time` and `stage` |
    | `.csv` | histories: a row for each time, a column `name (stage 1) [unit]` for each number |

    Losses are `losses.spin` in MATLAB, `losses_spin` elsewhere. `load_result` reads none of these
    files: use `save_result` to read a result back into this package.

    **Arguments:**

    - `result`: a result of one design, such as that of `simulate` or `steady_state`.
    - `path`: the file; it is complete or, if anything fails, as before.
    - `name`: of the struct in a `.mat` file; default the class of the result, such as `transient`.

    **Returns:** the path.

    **Raises:** `ValueError` for another ending, a batch of designs, a result without histories in a
    CSV file, and a name that is none in MATLAB; `MissingExtraError` without the library of netCDF.
    """
    target = Path(path)
    if target.suffix.lower() not in _FORMATS:
        raise ValueError(f"export to {target}: the ending must be one of {', '.join(_FORMATS)}")
    arrays, words = labelled(result), words_of(result) | {"prsm_jax": __version__}
    if target.suffix.lower() == ".csv" and not any(_TIME in one.dimensions for one in arrays):
        # SteadyState: a steady state.
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(result).__name__).lower()
        raise ValueError(f"a {kind} has no histories for a CSV file; export it to .mat or .nc")
    with whole_file(target) as partial:
        _FORMATS[target.suffix.lower()](
            partial, arrays, words, type(result).__name__.lower() if name is None else name
        )
    return target


def _matlab(path: Path, arrays: Sequence[Labelled], words: dict[str, str], name: str) -> None:
    from scipy.io import savemat

    if not (name.isascii() and name.isidentifier() and name[0] != "_" and len(name) <= 63):
        raise ValueError(
            f"{name!r} is no name in MATLAB; give letters, digits and underscores, a letter first"
        )
    content: dict[str, Any] = {}
    units: dict[str, Any] = {}
    for one in arrays:
        numbers, named = content, units
        for part in one.path[:-1]:
            numbers, named = numbers.setdefault(part, {}), named.setdefault(part, {})
        numbers[one.path[-1]], named[one.path[-1]] = one.values, one.unit
    content |= {"units": units, "about": words}
    with path.open("wb") as file:
        # An open file, since SciPy would add its ending to another name.
        savemat(file, {name: content}, long_field_names=True, oned_as="column")


def _netcdf(path: Path, arrays: Sequence[Labelled], words: dict[str, str], name: str) -> None:
    try:
        import h5netcdf  # noqa: F401
        import xarray
    except ImportError as error:
        raise missing_extra("export", "an export to .nc", error) from error
    variables = {
        "_".join(one.path): xarray.Variable(one.dimensions, one.values, {"units": one.unit})
        for one in arrays
    }
    sizes = {d: n for v in variables.values() for d, n in zip(v.dims, v.shape, strict=True)}
    if "stage" in sizes:
        variables["stage"] = xarray.Variable("stage", np.arange(1, sizes["stage"] + 1))
    xarray.Dataset(variables, attrs=words).to_netcdf(path, engine="h5netcdf")


def _csv(path: Path, arrays: Sequence[Labelled], words: dict[str, str], name: str) -> None:
    columns: dict[str, np.ndarray] = {}
    for one in arrays:
        if _TIME not in one.dimensions:
            continue
        axis = one.dimensions.index(_TIME)
        rows = np.moveaxis(one.values, axis, 0)
        others = one.dimensions[:axis] + one.dimensions[axis + 1 :]
        for place in np.ndindex(*rows.shape[1:]):
            parts = ", ".join(f"{d} {k + 1}" for d, k in zip(others, place, strict=True))
            heading = "_".join(one.path) + (f" ({parts})" if parts else "")
            heading += f" [{one.unit}]" if one.unit != "1" else ""
            column = rows[(slice(None), *place)]
            columns[heading] = column.astype(int) if column.dtype == bool else column
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        # Python's numbers: their text reads back to the same double.
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


_FORMATS: dict[str, Callable[[Path, Sequence[Labelled], dict[str, str], str], None]] = {
    ".mat": _matlab,
    ".nc": _netcdf,
    ".csv": _csv,
}
