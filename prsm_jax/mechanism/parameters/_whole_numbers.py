"""Whole numbers that are part of a mechanism's structure."""

from typing import Any

import jax.core


def whole_number(name: str, value: Any) -> int:
    """A value of a number that is part of the structure, such as `roller_count`.

    **Raises:** `ValueError` for a traced value, whose derivative would silently be 0, and for one
    that is not whole.
    """
    if isinstance(value, jax.core.Tracer):
        raise ValueError(
            f"{name} is a whole number and part of the structure of a mechanism: it has no "
            "derivative, and jit and vmap cannot trace it; compare designs with prsm.sweep or with "
            "choices of [optimise]"
        )
    if int(value) != value:
        raise ValueError(f"{name} is {value}; it must be a whole number")
    return int(value)
