"""Solids as STEP files."""

import contextlib
import os
from collections.abc import Generator
from pathlib import Path

from ..._errors import PrsmError, missing_extra
from ...mechanism import Mechanism
from ...process import whole_file
from ._bodies import StepBody, threaded_body
from ._library import opencascade
from ._solid import solid_of


def solid_volume(mechanism: Mechanism, body: StepBody, *, stage: int = 1) -> float:
    """Volume of the solid of a body, from its profile by Pappus' theorem [m³].

    The mass of the model is this volume times the density with `mass_rule = "thread_profile"`.
    Otherwise it is that of the cylinder of the nominal radius, which differs where the teeth above
    this radius have not the volume of the grooves below it (`solid_mass`).

    **Arguments:**

    - `mechanism`, `body`, `stage`: as for `write_step`.

    **Raises:** as `write_step`, but for the library.
    """
    return 1e-9 * threaded_body(mechanism, body, stage).volume


def write_step(
    path: str | os.PathLike[str], mechanism: Mechanism, body: StepBody, *, stage: int = 1
) -> Path:
    """Write a body with its thread as a solid in a STEP file, in millimetres.

    The axis is z and the middle of the body is at the origin. The thread is helical, over the whole
    length, with the exact profile: straight flanks of screw and nut, arcs of the roller, tooth
    thinnings as in the mechanism. Surfaces are B-splines of degree 5 within 5e-5 mm of the exact
    ones. Gear teeth, chamfers and shaft ends are left out.

    **Arguments:**

    - `path`: the file; it is complete or, if anything fails, as before.
    - `mechanism`: the mechanism.
    - `body`: `"screw"`, `"roller"` or `"nut"`.
    - `stage`: which stage, counted from 1.

    **Returns:** the path.

    **Raises:** `MissingDataError` without the length of the body, or the wall of a nut; `PrsmError`
    for grooves, a number of starts that is not whole, and teeth that cannot be made; `ValueError`
    for another body or stage; `MissingExtraError` without OpenCascade.
    """
    try:
        control = opencascade("STEPControl")
    except ImportError as error:
        raise missing_extra("step", "a solid as STEP", error) from error
    selection = opencascade("IFSelect")
    interface = opencascade("Interface")
    solid = solid_of(threaded_body(mechanism, body, stage))
    target = Path(path)
    with _silent(), whole_file(target) as partial:
        writer = control.STEPControl_Writer()
        interface.Interface_Static.SetCVal_s("write.step.product.name", body)
        writer.Transfer(solid, control.STEPControl_AsIs)
        if writer.Write(str(partial)) != selection.IFSelect_RetDone:
            raise PrsmError(f"{target}: the library could not write the solid")
    return target


@contextlib.contextmanager
def _silent() -> Generator[None, None, None]:
    """Without the messages that the library prints, which would stand among the results."""
    messages = opencascade("Message")
    messenger = messages.Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for one in printers:
        messenger.RemovePrinter(one)
    try:
        yield
    finally:
        for one in printers:
            messenger.AddPrinter(one)
