"""Options of the methods of `simulate`, where one loop runs through several methods."""

from typing import Any


def taken(method: str, **options: Any) -> dict[str, Any]:
    """Those of the options that a method takes at a prescribed speed."""
    return {} if method in ("closed_form", "quasi_steady") else options
