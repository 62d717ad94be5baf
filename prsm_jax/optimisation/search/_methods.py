"""The search method from a word or an object."""

from typing import Any

from ._constrained import Slsqp, TrustConstr
from ._lbfgs import Lbfgs
from ._method import SearchMethod
from ._multi_start import MultiStart
from ._optax import Adam

_BY_WORD: dict[str, Any] = {cls.word: cls for cls in (Adam, Lbfgs, Slsqp, TrustConstr, MultiStart)}


def search_of(
    method: SearchMethod | str, constrained: bool, max_iterations: int | None = None
) -> SearchMethod:
    """The search method of an object or a word; `"auto"` is SLSQP with constraints, else L-BFGS.

    **Arguments:**

    - `method`: the object or its word.
    - `constrained`: whether there are constraints.
    - `max_iterations`: an option for the word; `None` if it was not passed.

    **Raises:** `ValueError` for an unknown word, a method that does not accept constraints, or an
    option in addition to an object.
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
        options = {} if max_iterations is None else {"max_iterations": max_iterations}
        if word == MultiStart.word:
            search = MultiStart(finish=Slsqp(**options))
        else:
            search = _BY_WORD[word](**options)
    if constrained and not search.accepts_constraints:
        others = " or ".join(word for word, cls in _BY_WORD.items() if cls.accepts_constraints)
        raise ValueError(
            f"method {search.name!r} accepts bounds only; with constraints or worst cases choose "
            f"{others}"
        )
    return search
