"""Linear functions whose transpose is given as well.

JAX transposes a function operation by operation, and cannot transpose a loop whose number of steps
is known only when it runs. Such a loop needs a second one, in the opposite order.
"""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

#: Function of (parameters, inputs), both lists of arrays, to a list of arrays.
Linear = Callable[[Sequence[Any], Sequence[Any]], Sequence[Any]]

_linear = Primitive("linear_with_transpose")
_linear.multiple_results = True


def with_transpose(
    function: Linear, transpose: Linear, parameters: Sequence[Any], inputs: Sequence[Any]
) -> list[jax.Array]:
    """The results of a linear function, which reverse mode transposes by another function.

    Forward mode differentiates both functions by their parameters, too, and reverse mode does not
    where they contain a loop that JAX cannot transpose.

    **Arguments:**

    - `function`: of (parameters, inputs), linear in the inputs.
    - `transpose`: of (parameters, cotangents of the results) to the cotangents of the inputs. Both
      functions use no traced values other than their arguments.
    - `parameters`, `inputs`: lists of arrays.
    """
    parameters, inputs = ([jnp.asarray(x) for x in given] for given in (parameters, inputs))
    shapes = jax.eval_shape(function, parameters, inputs)
    results = tuple(ShapedArray(shape.shape, shape.dtype) for shape in shapes)
    return _bind(parameters, inputs, function, transpose, results)


def _bind(parameters, inputs, function, transpose, results) -> list[jax.Array]:
    return _linear.bind(
        *parameters,
        *inputs,
        function=function,
        transpose=transpose,
        count=len(parameters),
        results=results,
    )


def _evaluated(*values, function, count, **_):
    return function(list(values[:count]), list(values[count:]))


def _shapes(*_, results, **__):
    return list(results)


def _derivative(primals, tangents, *, function, transpose, count, results):
    parameters, inputs = list(primals[:count]), list(primals[count:])

    def of(inputs):
        return _bind(parameters, inputs, function, transpose, results)

    values = of(inputs)
    slopes: list[Any] = [jnp.zeros_like(value) for value in values]
    if not all(isinstance(t, ad.Zero) for t in tangents[count:]):
        slopes = of([ad.instantiate_zeros(t) for t in tangents[count:]])
    moving = [k for k in range(count) if not isinstance(tangents[k], ad.Zero)]
    if moving:

        def by_parameters(*moved):
            changed = list(parameters)
            for k, value in zip(moving, moved, strict=True):
                changed[k] = value
            return function(changed, inputs)

        _, others = jax.jvp(
            by_parameters, [parameters[k] for k in moving], [tangents[k] for k in moving]
        )
        slopes = [slope + other for slope, other in zip(slopes, others, strict=True)]
    return values, slopes


def _transposed(cotangents, *values, function, transpose, count, results):
    parameters, inputs = list(values[:count]), values[count:]
    given = [
        jnp.zeros(shape.shape, shape.dtype) if isinstance(cotangent, ad.Zero) else cotangent
        for cotangent, shape in zip(cotangents, results, strict=True)
    ]
    shapes = tuple(x.aval if ad.is_undefined_primal(x) else jax.typeof(x) for x in inputs)
    found = _bind(parameters, given, transpose, function, shapes)
    # An input that is known, as a zero, has no cotangent.
    return [None] * count + [
        one if ad.is_undefined_primal(x) else None for one, x in zip(found, inputs, strict=True)
    ]


def _batched(values, axes, *, function, transpose, count, results):
    size = next(
        value.shape[axis] for value, axis in zip(values, axes, strict=True) if axis is not None
    )
    parameters, inputs = list(values[:count]), values[count:]
    inputs = [
        batching.bdim_at_front(value, axis, size)
        for value, axis in zip(inputs, axes[count:], strict=True)
    ]

    def of_batch(one: Linear) -> Linear:
        return jax.vmap(one, in_axes=(list(axes[:count]), 0))

    shapes = tuple(ShapedArray((size, *result.shape), result.dtype) for result in results)
    found = _bind(parameters, inputs, of_batch(function), of_batch(transpose), shapes)
    return found, [0] * len(found)


_linear.def_impl(_evaluated)
_linear.def_abstract_eval(_shapes)
ad.primitive_jvps[_linear] = _derivative
ad.primitive_transposes[_linear] = _transposed
batching.primitive_batchers[_linear] = _batched
mlir.register_lowering(_linear, mlir.lower_fun(_evaluated, multiple_results=True))

__all__ = ["with_transpose"]
