"""Tells a definition that is run again from another one of the same name."""

from typing import Any


def origin_of(definition: Any) -> tuple[str, str]:
    """Module and qualified name of a function or a class.

    A notebook cell that is run twice defines the same function or class again, with the same
    origin.
    """
    return definition.__module__, definition.__qualname__
