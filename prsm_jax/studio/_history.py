"""The way of a design: what was before, what is, and what was undone."""

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType

#: Values of the variables [SI] by name.
Values = Mapping[str, float]
#: Steps that can be undone; the oldest are forgotten.
_MOST = 1000


@dataclasses.dataclass(frozen=True)
class History:
    """Designs in their order; every method returns a new history.

    - `present`: the design as it is; `settled`: as it was after the last complete step. They differ
      while a slider is held.
    - `past`, `future`: designs that undo and redo return to, the nearest last.
    """

    present: Values
    settled: Values
    past: tuple[Values, ...] = ()
    future: tuple[Values, ...] = ()

    @classmethod
    def of(cls, values: Values) -> "History":
        """A history of one design."""
        kept = MappingProxyType(dict(values))
        return cls(kept, kept)

    def moved(self, values: Values) -> "History":
        """With other values, which are not a step yet."""
        present = MappingProxyType({**self.present, **values})
        return dataclasses.replace(self, present=present)

    def committed(self) -> "History":
        """With the present design as a complete step; the same if nothing has moved."""
        if self.present == self.settled:
            return self
        past = (*self.past, self.settled)[-_MOST:]
        return History(self.present, self.present, past)

    def undone(self) -> "History":
        """One step back; the same at the beginning."""
        whole = self.committed()
        if not whole.past:
            return whole
        before = whole.past[-1]
        return History(before, before, whole.past[:-1], (*whole.future, whole.settled))

    def redone(self) -> "History":
        """One step forward; the same at the end."""
        if self.present != self.settled or not self.future:
            return self
        after = self.future[-1]
        return History(after, after, (*self.past, self.settled), self.future[:-1])
