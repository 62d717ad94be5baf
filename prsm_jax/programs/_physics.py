"""Labels that make the physics visible in a trace.

Every law is decorated with `physics("its_name")`. The name travels with the equations into the
jaxpr, where `traced_physics` finds it: with it the tests show that physics that a scene does not
mention is not traced; profiles show the same names.
"""

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import jax

_P = ParamSpec("_P")
_R = TypeVar("_R")
_PREFIX = "physics:"


def physics(name: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Label everything that the decorated function traces with `name`."""

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        @functools.wraps(function)
        def labelled(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            with jax.named_scope(_PREFIX + name):
                return function(*args, **kwargs)

        return labelled

    return decorate


def traced_physics(function: Callable[..., Any], *args: Any) -> set[str]:
    """The names of the physical laws that `function(*args)` traces.

    **Arguments:**

    - `function`: any function of arrays and pytrees.
    - `args`: its arguments; Equinox modules may hold static fields.

    **Returns:** the names given to `physics` that appear in the jaxpr, nested calls included.
    """
    import equinox as eqx

    jaxpr, _, _ = eqx.filter_make_jaxpr(function)(*args)
    return _scopes(jaxpr.jaxpr)


def _scopes(jaxpr) -> set[str]:
    names: set[str] = set()
    for equation in jaxpr.eqns:
        for part in str(equation.source_info.name_stack).split("/"):
            # Transformations wrap the name: "jvp(physics:hertz)".
            if _PREFIX in part:
                names.add(part.split(_PREFIX, 1)[1].rstrip(")"))
        for inner in jax.tree.leaves(
            list(equation.params.values()),
            is_leaf=lambda x: hasattr(x, "eqns") or hasattr(x, "jaxpr"),
        ):
            inner = getattr(inner, "jaxpr", inner)
            if hasattr(inner, "eqns"):
                names |= _scopes(inner)
    return names
