"""Annotations of the package's functions are checked while tests run: shapes, dtypes, classes."""

import ast
import functools
import hashlib
import typing
from collections.abc import Callable
from pathlib import Path

import beartype
import jaxtyping
from beartype import roar
from jaxtyping import _import_hook


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
    if isinstance(annotation, list | tuple):
        return any(map(_has_named_size, annotation))
    if typing.get_origin(annotation) is typing.Literal:
        return False
    # What a string names, and the leaves of a tree, are not looked at.
    if isinstance(annotation, str) or hasattr(annotation, "leaftype"):
        return True
    if hasattr(annotation, "dims"):
        return any(not isinstance(size, _FIXED) for size in getattr(annotation, "dims"))  # noqa: B009
    return _has_named_size(typing.get_args(annotation))


_FIXED = type(getattr(jaxtyping.Float[jaxtyping.Array, "3"], "dims")[0])  # noqa: B009


class _OncePerFunction(_import_hook.JaxtypingTransformer):
    """Checks functions of modules and classes, but none that another function defines.

    That one would be made anew, at some milliseconds, each time the other is called: a third of
    all processor time of the tests.
    """

    def visit_FunctionDef(self, node: ast.FunctionDef):
        if not self._inside_a_function():
            name = "__import__('tests.shape_checks').shape_checks.checked"
            decorator = ast.parse(name, mode="eval").body
            node.decorator_list.append(ast.copy_location(decorator, node))
        elif any("functools.wraps" in ast.unparse(one) for one in node.decorator_list):
            # jaxtyping checks `__init__` of a dataclass against the arguments of what it wraps,
            # which lack the old names that the wrapper accepts, unless the wrapper is jaxtyping's.
            return super().visit_FunctionDef(node)
        self._parents.append(node)
        self.generic_visit(node)
        self._parents.pop()
        return node

    def visit_ClassDef(self, node: ast.ClassDef):
        return node if self._inside_a_function() else super().visit_ClassDef(node)

    def _inside_a_function(self) -> bool:
        return any(isinstance(parent, ast.FunctionDef) for parent in self._parents)


def checker_of(source: str) -> Callable:
    """beartype. Bytecode is stored by the text of this call: another source, other bytecode.

    **Arguments:**

    - `source`: a digest of this file.
    """
    return beartype.beartype


def install() -> None:
    """Check what is imported from the package from now on."""
    _import_hook.JaxtypingTransformer = _OncePerFunction
    digest = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    jaxtyping.install_import_hook("prsm_jax", f"tests.shape_checks.checker_of('{digest}')")
