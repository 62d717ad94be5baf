"""The optimised or calibrated mechanism as a file: the original file with new numbers."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ..mechanism import Mechanism, set_parameters
from ..quantities import catalogue
from ._common import Common
from ._progress import clear

if TYPE_CHECKING:
    from ..calibration import Calibration
    from ..optimisation import Optimum


def optimised_text(source: str, best: "Optimum") -> str:
    """The file that was optimised, with the new numbers; a comment above says which they are.

    Variables have six digits, or more if rounding changes an objective or constraint by over 1e-6.

    **Arguments:**

    - `source`: the file or example that was optimised.
    - `best`: the optimum.
    """
    from ..file import edit, round_in_unit, source_text
    from ..optimisation import rounded_variables

    values = rounded_variables(best.mechanism, best, round_in_unit)
    written = set_parameters(best.mechanism, values)
    units = {quantity.name: quantity.unit for quantity in catalogue()}
    return edit(source_text(source), written, units, by="prsm optimise")


#: Significant digits of fitted numbers: rounding is far below any scatter.
_DIGITS = 6


def calibrated_text(source: str, mechanism: Mechanism, fit: "Calibration") -> str:
    """The file that was calibrated, with fitted numbers of six digits, named in a comment above.

    **Arguments:**

    - `source`: the file or example that `mechanism` came from.
    - `mechanism`: what was calibrated, settings included.
    - `fit`: the calibration.
    """
    from ..file import edit, round_in_unit, source_text

    values = {
        # A number on its bound stays there.
        one.name: one.value if one.active_bound else round_in_unit(one.value, one.unit, _DIGITS)
        for one in fit.parameters
    }
    written = set_parameters(mechanism, values)
    units = {quantity.name: quantity.unit for quantity in catalogue()}
    return edit(source_text(source), written, units, by="prsm calibrate")


def nothing_written(path: Path, reason: str, common: Common) -> str:
    """Why a file was not written, and that one of an earlier run is still there.

    With `--json` the text is not shown; the file of the earlier run is then named on stderr.

    **Arguments:**

    - `path`: the file that the verb would have written.
    - `reason`: why it was not.
    - `common`: the options of the verb.
    """
    words = f"no file written: {reason}"
    if not path.exists():
        return words
    earlier = f"{path} is of an earlier run"
    if common.json is not None:
        clear()
        print(f"prsm: {words}; {earlier}", file=sys.stderr)
    return f"{words}\n{earlier}"
