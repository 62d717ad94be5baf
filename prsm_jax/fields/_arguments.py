"""Arguments that many functions share."""

from collections.abc import Iterable
from typing import TypeVar

_Name = TypeVar("_Name")


def listed_names(names: Iterable[_Name], argument: str) -> list[_Name]:
    """Names as a list.

    **Arguments:**

    - `names`: the names; a text alone, whose letters would be taken for names, is refused.
    - `argument`: what they are called in the message.

    **Raises:** `ValueError` for a text.
    """
    if isinstance(names, str):
        raise ValueError(f"{argument} is the text {names!r}; give a list of names")
    return list(names)


def refuse_options(of: str, options: Iterable[str], takes: Iterable[str], where: str = "") -> None:
    """Refuse an option that a method does not take.

    **Arguments:**

    - `of`: what the method is called in the message.
    - `options`: names of the options that were given.
    - `takes`: names of those that it takes.
    - `where`: under which condition, such as `" at a prescribed speed"`.

    **Raises:** `ValueError` for an option that is not in `takes`.
    """
    known = tuple(takes)
    for name in options:
        if name not in known:
            raise ValueError(
                f"{of} takes {', '.join(known) or 'no options'}{where}, but not {name}; "
                "leave it out"
            )
