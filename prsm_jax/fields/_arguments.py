"""Arguments that many functions share."""

from collections.abc import Iterable


def listed_names(names: Iterable[str], argument: str) -> list[str]:
    """Names as a list.

    **Arguments:**

    - `names`: the names; a text alone, whose letters would be taken for names, is refused.
    - `argument`: what they are called in the message.

    **Raises:** `ValueError` for a text.
    """
    if isinstance(names, str):
        raise ValueError(f"{argument} is the text {names!r}; give a list of names")
    return list(names)
