"""Units of the fields of results, as annotations."""

import functools
import typing
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class In:
    """The SI unit of a field of a result: `torque: Annotated[Scalar, In("N·m")]`.

    The field is a number, an array, or a dictionary of them. Results print fields of this kind.
    An annotation, because a value in its place would be taken for a default.
    """

    unit: str


@functools.cache
def units_of(cls: type) -> Mapping[str, str]:
    """SI units of the fields of a class that state one.

    **Arguments:**

    - `cls`: the class.
    """
    hints = typing.get_type_hints(cls, include_extras=True)
    marks = {name: getattr(hint, "__metadata__", ()) for name, hint in hints.items()}
    return {name: mark.unit for name, row in marks.items() for mark in row if isinstance(mark, In)}
