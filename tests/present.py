"""Parts and numbers that may be absent in general, and are present in the example of a test."""

from typing import TypeVar

_Value = TypeVar("_Value")


def present(value: _Value | None) -> _Value:
    """`value`, which is not `None`."""
    assert value is not None
    return value
