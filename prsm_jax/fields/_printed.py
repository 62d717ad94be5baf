"""What `print` shows of a part of a mechanism: its class, and the numbers that it has."""

from typing import Any

import equinox as eqx
import jax
import jax.core
import numpy as np

#: Longest list of numbers that is shown whole; a longer one has type and shape.
_LONGEST = 12


class _Numbers:
    """A number or a list of numbers, printed without quotes."""

    def __init__(self, text: str):
        self.text = text

    def __repr__(self) -> str:
        return self.text


def _shown(leaf: Any) -> Any:
    # A traced number has no value to show.
    if isinstance(leaf, jax.core.Tracer) or not isinstance(leaf, jax.Array | np.ndarray):
        return leaf
    values = np.asarray(leaf)
    if values.dtype.kind not in "fiu" or values.ndim > 1 or values.size > _LONGEST:
        return leaf
    listed = [f"{value:.6g}" for value in np.ravel(values).tolist()]
    return _Numbers(listed[0] if values.ndim == 0 else f"[{', '.join(listed)}]")


def printed(part: eqx.Module) -> str:
    """A part as the text of a call: `Support(radial_stiffness=2e+08, torsional_stiffness=5e+07)`.

    Numbers are in SI units. Absent parts and choices at their default are left out; traced numbers
    have type and shape.
    """
    return eqx.tree_pformat(jax.tree.map(_shown, part))
