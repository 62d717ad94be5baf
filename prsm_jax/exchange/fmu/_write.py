"""The unit as a file."""

import os
import shutil
import tempfile
from pathlib import Path

from ..._errors import missing_extra
from ...file import dump
from ...mechanism import Mechanism, require_type
from ...process import temporary_folder, whole_file
from ...quantities import catalogue
from ._motion import check_exchangeable

_SCRIPT = Path(__file__).parent / "_model.py"
#: Name of the script in the unit; its module has this name in the Python that runs it.
_NAME = "prsm_jax_roller_screw.py"


def write_fmu(path: str | os.PathLike[str], mechanism: Mechanism) -> Path:
    """Write a mechanism as an FMU: FMI 3.0, co-simulation, driven by a torque.

    Inputs are `torque` at the first screw and `load` on the last nut (of an inverted roller screw,
    at the nut and on the screw), constant during each step; parameters are `initial_speed` and
    `initial_position`; outputs are the motion of screw, nut, carriers and rollers, contact forces,
    the torque of friction and the power of losses. All have units in the model description, which
    also names the body of each. Numbers of the mechanism are fixed: they are in a file within the
    unit. The carriers are in balance at every instant (`simulate(..., method="quasi_steady")`).

    The importing program needs a Python that has prsm_jax; the unit runs the code of that version.

    **Arguments:**

    - `path`: the file, which ends in `.fmu`; it is complete or, if anything fails, as before.
    - `mechanism`: the mechanism, with masses and thread friction.

    **Returns:** the path.

    **Raises:** `ValueError` for another ending; `PrsmError` for a mechanism that
    `check_exchangeable` refuses; `MissingDataError` for types without transients;
    `MissingExtraError` without pythonfmu3 or pint.
    """
    target = Path(path)
    if target.suffix.lower() != ".fmu":
        raise ValueError(f"FMU {target}: the ending must be .fmu")
    try:
        from pythonfmu3.builder import FmuBuilder
    except ImportError as error:
        raise missing_extra("fmu", "an FMU", error) from error
    require_type(mechanism.stages, "an exchange as FMU is", ("standard", "inverted"))
    check_exchangeable(mechanism)
    units = {quantity.name: quantity.unit for quantity in catalogue()}
    with temporary_folder(Path(tempfile.gettempdir()), "prsm-jax-fmu-") as folder:
        dump(mechanism, folder / "mechanism.toml", units)
        script = shutil.copyfile(_SCRIPT, folder / _NAME)
        built = FmuBuilder.build_FMU(
            script, dest=folder / "built", project_files=[folder / "mechanism.toml"]
        )
        with whole_file(target) as partial:
            shutil.copyfile(built, partial)
    return target
