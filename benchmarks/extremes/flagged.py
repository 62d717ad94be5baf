"""The catalogue through its public doors, each quantity with a flag of its own, in one program.

`compute_checked` speaks for all quantities that it was asked for. Here it is asked for one at a
time; what they share of an analysis is traced once, and each keeps the flags it would have alone.
"""

from functools import cached_property
from typing import Any

import jax.numpy as jnp

from prsm_jax.quantities import Analysis, evaluate_checked, find_quantity


class _Record:
    """What one part of an analysis rests on."""

    def __init__(self):
        self.names: set[str] = set()
        self.flags: list[Any] = []


class _Store:
    """Parts of an analysis that were made, and their records."""

    def __init__(self):
        self.parts: dict[Any, tuple[Any, _Record]] = {}


class _Shared(Analysis):
    """An analysis that takes its parts from a store, and remembers which it took."""

    store: _Store
    loads: tuple[Any, ...]

    def __init__(self, mechanism, speed=None, load=None):
        super().__init__(mechanism, speed, load)
        self._records: list[_Record] = []
        super().expect(self.loads)

    def expect(self, loads):
        """All loads are asked for from the start, so that they are found at once."""

    def require(self, flag):
        super().require(flag)
        for record in self._records:
            record.flags.append(flag)

    def part(self, key, name, make):
        """A part by its key; `name` as `Analysis` knows it, or `None`."""
        if key not in self.store.parts:
            record = _Record()
            self._records.append(record)
            value = make()
            self._records.remove(record)
            self.store.parts[key] = value, record
            # `require` has put the flags into this analysis and all open records.
            flags = []
        else:
            value, record = self.store.parts[key]
            flags = record.flags
        names = record.names | ({name} if name else set())
        for one in names:
            if one not in self.__dict__:
                self.__dict__[one] = self.store.parts[one][0]
        known = {id(flag) for flag in self._flags}
        self._flags += [flag for flag in flags if id(flag) not in known]
        for open_record in self._records:
            open_record.names |= names
            open_record.flags += flags
        return value

    def once(self, key, make):
        return self.part(("once", key), None, make)

    def distribution(self, index, under="operating_point"):
        return self.part(
            ("distribution", index, under),
            None,
            lambda: Analysis.distribution(self, index, under),
        )


def _sharing(name: str, function):
    # A property takes precedence over the instance's dictionary, where `valid` looks.
    return property(lambda self: self.part(name, name, lambda: function(self)))


for _name, _member in vars(Analysis).items():
    if isinstance(_member, cached_property):
        setattr(_Shared, _name, _sharing(_name, _member.func))


def flagged_quantities(mechanism, names):
    """Values of quantities by name, and for each whether `compute_checked` says it can be used."""
    wanted = [find_quantity(name) for name in names]
    scope = {
        "store": _Store(),
        "loads": tuple(dict.fromkeys(load for one in wanted for load in one.shares)),
    }
    own = type("Shared", (_Shared,), scope)
    values, flags = {}, {}
    for name in names:
        found, flag = evaluate_checked(own(mechanism), [name])
        values[name], flags[name] = found[name], flag
    return values, {name: jnp.where(flag, 0, 1) for name, flag in flags.items()}
