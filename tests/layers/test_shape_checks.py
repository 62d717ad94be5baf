"""While tests run, the package's functions refuse shapes and classes that they do not name."""

import ast
from collections.abc import Callable
from typing import Any, Literal

import jax.numpy as jnp
import jaxtyping
import pytest
from jaxtyping import Array, Float, PyTree
from jaxtyping._import_hook import Typechecker

from prsm_jax.contact.hertz import _approximations
from prsm_jax.friction import CoulombFriction
from tests.shape_checks import _has_named_size, _OncePerFunction, checked


def _one_number(x: Float[Array, ""], name: str = "x") -> Float[Array, ""]:
    return x


def _products(x: Float[Array, " n"], y: Float[Array, " n"]) -> Float[Array, "n n"]:
    return x[:, None] * y[None, :] if x.shape[0] < 5 else x


def test_a_wrong_class_shape_or_size_is_refused():
    one, two = checked(_one_number), checked(_products)
    assert one(jnp.zeros(()), name="y") == 0.0
    assert two(jnp.ones(3), jnp.ones(3)).shape == (3, 3)
    for call in (
        lambda: one(1.0),
        lambda: one(jnp.zeros(2)),
        lambda: one(jnp.zeros(()), name=3),
        lambda: two(jnp.ones(3), jnp.ones(4)),
        lambda: two(jnp.ones(5), jnp.ones(5)),
    ):
        with pytest.raises(jaxtyping.TypeCheckError):
            call()


@pytest.mark.parametrize(
    ("annotation", "named"),
    [
        (float, False),
        (Float[Array, ""], False),
        (tuple[Float[Array, "3 3"], str] | None, False),
        (Literal["n"], False),
        (Callable[[Float[Array, " n"]], float], True),
        (dict[str, Float[Array, "#n"]] | None, True),
        (Float[Array, "*batch"], True),
        (Float[Array, "n+1"], True),
        (PyTree[Float[Array, ""]], True),
        ("Stage", True),
    ],
)
def test_which_functions_need_the_wrapper_of_jaxtyping(annotation, named):
    assert _has_named_size(annotation) is named


_WRONG: Any = "a word"


@pytest.mark.parametrize(
    "call",
    [
        lambda: _approximations.power(jnp.zeros(3)),
        lambda: CoulombFriction(_WRONG),
        lambda: CoulombFriction(jnp.asarray(0.1)).friction_coefficient(_WRONG),
    ],
    ids=["function", "class", "method"],
)
def test_the_package_is_checked(call):
    with pytest.raises(jaxtyping.TypeCheckError):
        call()


def test_checks_can_be_switched_off(unchecked):
    assert checked(_one_number)(1.0) == 1.0


def test_functions_within_functions_are_left_alone_but_wrappers_are_not():
    source = """
class A:
    def method(self): ...
def outer():
    def inner(): ...
    class Local: ...
    @functools.wraps(inner)
    def wrapper(): ...
"""
    tree = _OncePerFunction(typechecker=Typechecker(None)).visit(ast.parse(source))
    decorators = {
        node.name: [ast.unparse(one) for one in node.decorator_list]
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
    }
    assert all(name.endswith(".checked") for name in decorators["method"] + decorators["outer"])
    assert len(decorators["method"]) == len(decorators["outer"]) == 1
    assert decorators["inner"] == decorators["Local"] == []
    assert "jaxtyped" in decorators["A"][0]
    assert "jaxtyped" in decorators["wrapper"][1]
