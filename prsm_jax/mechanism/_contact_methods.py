"""Methods for contact ellipses by name: those of the package, and approximations of users."""

import re
from collections.abc import Callable
from typing import Any, Literal, TypeAlias, TypeVar, get_args

from ..fields import Scalar
from ..programs import origin_of

#: Words of the package; the room `contact` computes them.
ContactWord: TypeAlias = Literal[
    "exact", "antoine", "power", "hamrock_brewe", "hamrock_brewe_log", "lisowski"
]
#: A function of the anisotropy τ = (B − A)/(A + B) that returns κ = b/a, K and E.
ContactApproximation: TypeAlias = Callable[[Scalar], tuple[Scalar, Scalar, Scalar]]
#: A word, or an approximation.
ContactMethod: TypeAlias = str | ContactApproximation

_Approximation = TypeVar("_Approximation", bound=Callable[..., Any])
_APPROXIMATIONS: dict[str, ContactApproximation] = {}


def _origin(approximation: Any) -> tuple[str, str]:
    """Of a function itself, and of an object its class."""
    return origin_of(
        approximation if hasattr(approximation, "__qualname__") else type(approximation)
    )


def contact_approximation(name: str) -> Callable[[_Approximation], _Approximation]:
    """Name an approximation of the contact ellipse, for `contact_method = "name"` in files.

    An approximation takes τ = (B − A)/(A + B) of the gap A x² + B y² and returns κ = b/a and the
    complete elliptic integrals K and E of 1 − κ². It is a function, or an object that can be called
    and is hashable. The same one may be defined again, e.g. if a cell of a notebook is run twice;
    the last one is used.

    **Arguments:**

    - `name`: lower-case words joined by underscores.

    **Raises:** `TypeError` if it cannot be called; `ValueError` if the name is malformed, or stands
    for another method.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise ValueError(
            f"contact approximation {name!r}: a name is lower-case words joined by underscores"
        )

    def register(approximation: _Approximation) -> _Approximation:
        if not callable(approximation):
            raise TypeError(
                f"contact approximation {name!r}: {approximation!r} must be a function of the "
                "anisotropy"
            )
        before = _APPROXIMATIONS.get(name)
        other = before is not None and _origin(before) != _origin(approximation)
        if name in get_args(ContactWord) or other:
            owner = "the package" if before is None else ".".join(_origin(before))
            raise ValueError(
                f"contact approximation {name!r}: {owner} has a method of this name; choose another"
            )
        _APPROXIMATIONS[name] = approximation
        return approximation

    return register


def contact_methods() -> dict[str, ContactMethod]:
    """What each word for a contact method stands for: itself, or the approximation of a user."""
    words: tuple[str, ...] = get_args(ContactWord)
    return dict(zip(words, words, strict=True)) | dict(sorted(_APPROXIMATIONS.items()))
