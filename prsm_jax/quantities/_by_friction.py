"""Quantities with friction apart from the others."""

from collections.abc import Iterable

from ._catalogue import find_quantity


def by_friction(names: Iterable[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the quantities that depend on friction, and of all others.

    Those with friction need the steady state, and share little else with the others.

    **Raises:** `UnknownNameError` for an unknown name.
    """
    names = tuple(names)
    friction = tuple(name for name in names if "equal_friction" in find_quantity(name).assumes)
    return friction, tuple(name for name in names if name not in friction)
