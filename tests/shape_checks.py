"""Annotations of the package's functions are checked while tests run: shapes, dtypes, classes."""

import ast
import functools
import typing
from collections.abc import Callable

import beartype
import jaxtyping
from beartype import roar
from jaxtyping import _import_hook

checker_of_types = beartype.beartype


def checked(function: Callable) -> Callable:
    """A function that checks what it takes and gives.

    Sizes that must agree with each other, as two `n` of one function, need jaxtyping's wrapper. It
    is made of two wrappers of beartype and looks up names at every call, so the many functions
    without such sizes have one of beartype.
    """
    if any(map(_has_named_size, function.__annotations__.values())):
        return jaxtyping.jaxtyped(typechecker=beartype.beartype)(function)
    of_beartype = beartype.beartype(function)

    @functools.wraps(function)
    def checks(*args, **kwargs):
        # As in jaxtyping's: see the fixture `unchecked`.
        call = function if jaxtyping.config.jaxtyping_disable else of_beartype
        try:
            return call(*args, **kwargs)
        except roar.BeartypeCallHintViolation as error:
            raise jaxtyping.TypeCheckError(str(error)) from error

    return checks


def _has_named_size(annotation: object) -> bool:
    if isinstance(annotation, str | typing.TypeVar) or hasattr(annotation, "leaftype"):
        return True
    sizes = getattr(annotation, "dims", None)
    if sizes is not None:
        return sizes is not ... and any(not isinstance(s, _FIXED) for s in sizes)
    inner = (*typing.get_args(annotation), getattr(annotation, "__value__", ()))
    return any(
        any(map(_has_named_size, part)) if isinstance(part, list | tuple) else _has_named_size(part)
        for part in inner
        if not isinstance(part, str) or typing.get_origin(annotation) is not typing.Literal
    )


_FIXED = type(getattr(jaxtyping.Float[jaxtyping.Array, "3"], "dims")[0])  # noqa: B009


class _OncePerFunction(_import_hook.JaxtypingTransformer):
    """Checks functions of modules and classes, but none that another function defines.

    That one would be made anew, at some milliseconds, each time the other is called: a third of
    all processor time of the tests.
    """

    def visit_FunctionDef(self, node: ast.FunctionDef):
        if (
            self._parents
            and getattr(self._parents[0], "body", [])[-1:]
            and any(
                isinstance(one, ast.FunctionDef) and one.name == "renamed_arguments"
                for one in getattr(self._parents[0], "body", [])
            )
        ):
            return super().visit_FunctionDef(node)
        if self._inside_a_function():
            # Wrappers of `__init__`, by which jaxtyping knows that a class is checked already.
            return super().visit_FunctionDef(node) if node.decorator_list else node
        name = "__import__('tests.shape_checks').shape_checks.checked"
        decorator = ast.parse(name, mode="eval").body
        node.decorator_list.append(ast.copy_location(decorator, node))
        self._parents.append(node)
        self.generic_visit(node)
        self._parents.pop()
        return node

    def visit_ClassDef(self, node: ast.ClassDef):
        return node if self._inside_a_function() else super().visit_ClassDef(node)

    def _inside_a_function(self) -> bool:
        return any(isinstance(parent, ast.FunctionDef) for parent in self._parents)


def install() -> None:
    """Check what is imported from the package from now on."""
    _import_hook.JaxtypingTransformer = _OncePerFunction
    # Bytecode is stored under this name.
    jaxtyping.install_import_hook("prsm_jax", "tests.shape_checks.checker_of_types")
