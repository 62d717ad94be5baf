"""The search method from a word or an object."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from ...fields import refuse_options
from ._constrained import Slsqp, TrustConstr
from ._lbfgs import Lbfgs
from ._method import SearchMethod
from ._multi_start import MultiStart
from ._optax import Adam

_BY_WORD: dict[str, Any] = {cls.word: cls for cls in (Adam, Lbfgs, Slsqp, TrustConstr, MultiStart)}


def _numbers_of(cls: Any) -> dict[str, type]:
    """Options of a method that are numbers, with their types."""
    return {
        one.name: type(one.default)
        for one in dataclasses.fields(cls)
        if isinstance(one.default, int | float)
    }


def _with_options(word: str, options: Mapping[str, float | int]) -> SearchMethod:
    """The method of a word; `multi-start` also takes the options of the SLSQP that finishes it."""
    cls = _BY_WORD[word]
    own = _numbers_of(cls)
    finishing = _numbers_of(Slsqp) if cls is MultiStart else {}
    refuse_options(f"method {word!r}", options, [*own, *finishing])

    def taken(types: dict[str, type]) -> dict[str, Any]:
        # A file may write a learning rate of 1 as a whole number.
        return {
            name: float(value) if types[name] is float else value
            for name, value in options.items()
            if name in types
        }

    if finishing:
        return MultiStart(**taken(own), finish=Slsqp(**taken(finishing)))
    return cls(**taken(own))


def search_of(
    method: SearchMethod | str,
    constrained: bool,
    max_iterations: int | None = None,
    options: Iterable[tuple[str, float | int]] = (),
) -> SearchMethod:
    """The search method of an object or a word; `"auto"` is SLSQP with constraints, else L-BFGS.

    **Arguments:**

    - `method`: the object or its word.
    - `constrained`: whether there are constraints.
    - `max_iterations`: an option for the word, in place of that of `options`; `None` if it was not
      passed.
    - `options`: names and values of options for the word.

    **Raises:** `ValueError` for an unknown word, a method that does not accept constraints, an
    option that the method does not take, or one in addition to an object.
    """
    if isinstance(method, SearchMethod):
        if max_iterations is not None:
            name = type(method).__name__
            advice = "leave it out"
            if hasattr(method, "max_iterations"):
                advice = f"write {name}(…, max_iterations=…)"
            raise ValueError(
                f"method is {name}(…), which carries its own options, but max_iterations is passed "
                f"as well; {advice}"
            )
        search = method
    else:
        word = method
        if word == "auto":
            word = Slsqp.word if constrained else Lbfgs.word
        if not isinstance(word, str) or word not in _BY_WORD:
            raise ValueError(
                f"method is {method!r}; choose one of auto, {', '.join(_BY_WORD)}, or give an "
                "object such as prsm_jax.optimisation.Slsqp(max_iterations=100)"
            )
        given = dict(options)
        if max_iterations is not None:
            given["max_iterations"] = max_iterations
        search = _with_options(word, given)
    if constrained and not search.accepts_constraints:
        others = " or ".join(word for word, cls in _BY_WORD.items() if cls.accepts_constraints)
        raise ValueError(
            f"method {search.name!r} accepts bounds only; with constraints or worst cases choose "
            f"{others}"
        )
    return search
