"""Checks of numbers at construction; traced numbers are not known and pass."""

from collections.abc import Mapping

import jax.core
import numpy as np
from jaxtyping import ArrayLike


def _known(values: Mapping[str, ArrayLike | None]) -> dict[str, np.ndarray]:
    return {
        name: np.asarray(value)
        for name, value in values.items()
        if value is not None and not isinstance(value, jax.core.Tracer)
    }


def check_finite(owner: str, remedy: str, **values: ArrayLike | None) -> None:
    """**Raises:** `ValueError` if one of the named numbers is known and NaN or infinite."""
    for name, value in _known(values).items():
        if not np.all(np.isfinite(value)):
            raise ValueError(f"{owner}: {name} is {value}; it must be finite; {remedy}")


def check_positive(owner: str, **values: ArrayLike | None) -> None:
    """**Raises:** `ValueError` if one of the named numbers is known and not above 0."""
    for name, value in _known(values).items():
        if not np.all(value > 0):
            raise ValueError(f"{owner}: {name} is {value}; it must be more than 0")


def check_not_negative(owner: str, **values: ArrayLike | None) -> None:
    """**Raises:** `ValueError` if one of the named numbers is known and below 0."""
    for name, value in _known(values).items():
        if not np.all(value >= 0):
            raise ValueError(f"{owner}: {name} is {value}; it must be 0 or more")


def check_not_zero(owner: str, **values: ArrayLike | None) -> None:
    """**Raises:** `ValueError` if one of the named numbers is known and 0 or not finite."""
    for name, value in _known(values).items():
        if not np.all(np.isfinite(value) & (value != 0)):
            raise ValueError(f"{owner}: {name} is {value}; it must be finite and not 0")


def check_increasing(owner: str, **values: ArrayLike | None) -> None:
    """**Raises:** `ValueError` if a named array is known and not strictly increasing."""
    for name, value in _known(values).items():
        if value.shape[-1] < 2 or not np.all(np.diff(value, axis=-1) > 0):
            raise ValueError(
                f"{owner}: {name} is {value}; it must be two or more values that increase"
            )
