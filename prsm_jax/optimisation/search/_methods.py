"""The search methods by name."""

from ._box import adam, lbfgs
from ._constrained import slsqp, trust_constr
from ._search import Search

#: Methods that accept bounds but no constraints.
BOUNDS_ONLY = ("adam", "lbfgs")


def find_search(method: str, constrained: bool) -> tuple[str, Search]:
    """The search method of a name; `"auto"` is SLSQP with constraints and L-BFGS without.

    **Raises:** `ValueError` for an unknown method, or one that does not accept constraints.
    """
    searches: dict[str, Search] = {
        "adam": adam,
        "lbfgs": lbfgs,
        "slsqp": slsqp,
        "trust-constr": trust_constr,
    }
    if method == "auto":
        method = "slsqp" if constrained else "lbfgs"
    if method not in searches:
        raise ValueError(f"method is {method!r}; choose one of auto, {', '.join(searches)}")
    if constrained and method in BOUNDS_ONLY:
        raise ValueError(
            f"method {method!r} accepts bounds only; with constraints choose slsqp or trust-constr"
        )
    return method, searches[method]
