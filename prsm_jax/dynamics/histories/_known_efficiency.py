"""Where the ratio of powers of a transient is an efficiency."""

import numpy as np
from jaxtyping import Float

from ._transient_result import Transient

#: Below this share of the largest power, as while the motion reverses, acceleration and not
#: friction decides the ratio of powers.
_IDLE = 0.02
#: Rounding of an efficiency of 0 or 1.
_ROUNDING = 1e-9


def known_efficiency(run: Transient) -> Float[np.ndarray, " times"]:
    """The efficiency over time, with gaps where the ratio of powers is none.

    While masses are accelerated or return energy, this ratio leaves the range from 0 to 1, and at
    and close to standstill (below 2 % of the largest power) it is a quotient of two small powers.

    **Arguments:**

    - `run`: a transient outside a trace, of one design.

    **Returns:** the ratio of powers [1] at each sample; NaN in the gaps.
    """
    share = np.asarray(run.efficiency)
    power = np.abs(np.asarray(run.drive_torque * run.screw_speed))
    if run.load_power is not None:
        power = np.maximum(power, np.abs(np.asarray(run.load_power)))
    # A run that failed has NaN at its end, which hides no sample before.
    largest = np.max(power, where=np.isfinite(power), initial=0.0)
    known = (power > _IDLE * largest) & (share >= -_ROUNDING) & (share <= 1 + _ROUNDING)
    exact = np.where(share <= _ROUNDING, 0.0, np.minimum(share, 1.0))
    return np.where(known, exact, np.nan)
