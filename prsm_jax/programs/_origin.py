"""What tells a definition that is run again from another of the same name."""

from typing import Any


def origin_of(definition: Any) -> tuple[str, str]:
    """Module and qualified name of a function or a class.

    A cell of a notebook that is run twice defines the same thing anew, which then has the same
    origin.
    """
    return definition.__module__, definition.__qualname__
