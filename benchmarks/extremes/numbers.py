"""The numbers of a pytree by name, with their units and limits, and changes of them."""

import re
from typing import Any, NamedTuple

import equinox as eqx
import jax
import numpy as np

from prsm_jax.fields import ANY, Limit, declared


class Number(NamedTuple):
    """One floating-point leaf: its path as in files, its SI unit, and what it may be."""

    name: str
    unit: str
    limit: Limit


def _name(path) -> str:
    parts = []
    for key in path:
        if isinstance(key, jax.tree_util.SequenceKey):
            parts.append(str(key.idx + 1))
        else:
            parts.append(str(getattr(key, "name", getattr(key, "key", key))))
    # The numbers of a law at a radius stand in its table.
    return ".".join(parts).replace("stages.", "stage.").replace(".law.", ".")


def _unit_and_limit(tree: Any, path) -> tuple[str, Limit]:
    node, unit, limit = tree, "1", ANY
    for key in path:
        if isinstance(key, jax.tree_util.SequenceKey):
            node = node[key.idx]
            continue
        for one in declared(type(node), unit):
            if one.name == key.name:
                unit, limit = one.unit or unit, one.traced_limit
        node = getattr(node, key.name)
    return unit, limit


def numbers_of(tree: Any) -> tuple[Number, ...]:
    """Every floating-point leaf of a pytree, in the order of its leaves."""
    found = []
    for path, _ in jax.tree_util.tree_leaves_with_path(eqx.filter(tree, eqx.is_inexact_array)):
        found.append(Number(_name(path), *_unit_and_limit(tree, path)))
    return tuple(found)


def split(tree: Any):
    """The leaves as NumPy arrays, and a function that builds the pytree from such a list."""
    numbers, rest = eqx.partition(tree, eqx.is_inexact_array)
    leaves, structure = jax.tree.flatten(numbers)

    def build(values):
        return eqx.combine(jax.tree.unflatten(structure, list(values)), rest)

    return [np.asarray(leaf, float) for leaf in leaves], build


class Change(NamedTuple):
    """A number set to a value, or multiplied by a factor; of every leaf whose name matches."""

    pattern: str
    how: str  # "set" or "times"
    value: float

    def matches(self, name: str) -> bool:
        """Whether a number is meant: the pattern ends its name, with `*` for one part of it."""
        pattern = re.escape(self.pattern).replace(r"\*", r"[^.]*")
        return re.search(rf"(^|\.){pattern}$", name) is not None


def changed(
    leaves: list[np.ndarray], numbers: tuple[Number, ...], changes: tuple[Change, ...]
) -> tuple[list[np.ndarray], set[int]]:
    """Leaves with changes made, and the places of those that were meant."""
    moved, places = [leaf.copy() for leaf in leaves], set()
    for change in changes:
        for place, number in enumerate(numbers):
            if not change.matches(number.name):
                continue
            places.add(place)
            if change.how == "set":
                moved[place] = np.full_like(moved[place], change.value)
            else:
                moved[place] = moved[place] * change.value
    return moved, places
