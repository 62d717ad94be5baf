"""Programs in pieces: same values and derivatives, fewer operations, cuts where it is narrow."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scenes import array

from prsm_jax.numerics import in_pieces
from prsm_jax.programs import physics, traced_physics
from tests.present import present


@jax.custom_jvp
def _cube(x):
    return x * x * x


@_cube.defjvp
def _cube_derivative(primals, tangents):
    (x,), (change,) = primals, tangents
    return _cube(x), 3 * x**2 * change


@physics("a_law")
@jax.jit
def _law(x, y):
    return jnp.where(x > y, x * y, x + y)


TABLE = np.array([0.5, -1.0, 2.0])


def _everything(x, y):
    """Calls, a loop, constants, results that are numbers, flags and arguments, unused parts."""
    unused = jnp.exp(x) * y
    del unused
    first = _law(x, y) + _cube(x) * TABLE[0]
    looped = jax.lax.fori_loop(0, 3, lambda _, value: value * x + y, first)
    row = jnp.asarray(TABLE) * looped + jnp.stack([x, y, first])
    return [looped, row, x > y, jnp.asarray(True), jnp.asarray(2.5), x, jnp.sum(row)]


def _squares(x, count):
    """A chain of two operations for each square."""
    for _ in range(count):
        x = x * x + 1.0
    return x


def _cut(function, operations, *arguments):
    return in_pieces(jax.make_jaxpr(function)(*arguments), operations)


def _pieces(jaxpr):
    """Programs of the calls that are pieces."""
    named = [e for e in jaxpr.eqns if e.params.get("name") == "piece"]
    return [e.params["jaxpr"].jaxpr for e in named]


def _traced(function, *arguments):
    return jax.make_jaxpr(function)(*arguments).jaxpr


@settings(deadline=None, max_examples=20)
@given(
    st.integers(1, 30),
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0).filter(lambda y: abs(y) > 1e-3),
)
def test_values_do_not_depend_on_the_pieces(operations, x, y):
    arguments = array(x), array(y)
    cut = _cut(_everything, operations, *arguments)
    for one, other in zip(cut(*arguments), _everything(*arguments), strict=True):
        assert one.dtype == other.dtype
        # Sums of numbers up to a hundred, which may cancel.
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("operations", [1, 4, 100])
def test_derivatives_do_not_depend_on_the_pieces(operations):
    """Both modes, twice, and a batch of designs; rounding differs."""
    arguments = array(1.25), array(0.5)
    cut = _cut(_everything, operations, *arguments)

    def plain(numbers):
        return _everything(*numbers)[-1]

    def pieces(numbers):
        return cut(*numbers)[-1]

    point = jnp.stack(arguments)
    many = jnp.stack([point, 2 * point, -point])
    for second in (
        lambda f: jax.jacfwd(jax.jacfwd(f)),
        lambda f: jax.jacfwd(jax.jacrev(f)),
        jax.grad,
    ):
        one, other = (jax.jit(jax.vmap(second(f)))(many) for f in (pieces, plain))
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13)


def _waists(numbers):
    """Twice: twelve sums of one number and another, and their product, which is one number."""
    total = numbers[0]
    for _ in range(2):
        wide = [total * (k + 1) + numbers[k % 3] for k in range(12)]
        total = wide[0]
        for one in wide[1:]:
            total = total * one
    return total


def test_a_cut_is_where_few_numbers_pass():
    """Of 70 operations in pieces of at most 40, one number passes from the first to the second."""
    numbers = [array(k + 1.0) for k in range(3)]
    cut = _cut(lambda *x: [_waists(x)], 40, *numbers)
    assert [len(piece.outvars) for piece in _pieces(_traced(cut, *numbers))] == [1, 1]


@pytest.mark.parametrize("operations", [6, 12, 24])
def test_no_piece_is_longer_than_allowed(operations):
    numbers = [array(k + 1.0) for k in range(3)]
    cut = _cut(lambda *x: [_waists(x)], operations, *numbers)
    arithmetic = {"mul", "add"}
    lengths = [
        sum(e.primitive.name in arithmetic for e in piece.eqns)
        for piece in _pieces(_traced(cut, *numbers))
    ]
    assert sum(lengths) == 2 * (24 + 11)
    # Only the last may be shorter than half.
    assert max(lengths) <= operations
    assert min(lengths[:-1]) >= operations / 2


def test_a_large_function_with_its_own_derivative_is_not_a_piece():
    """Its author cuts it."""

    @jax.custom_jvp
    def large(x):
        return _squares(x, 8)

    large.defjvp(lambda primals, tangents: (large(*primals), 2 * tangents[0]))
    cut = _cut(lambda x: [large(x + 1.0) * 2.0], 8, array(0.1))
    traced = _traced(cut, array(0.1))
    assert [e.primitive.name for e in traced.eqns].count("custom_jvp_call") == 1
    assert len(_pieces(traced)) == 2
    assert jax.grad(lambda x: cut(x)[0])(array(0.1)) == 4.0


def test_a_long_function_is_cut_once_for_all_of_its_calls():
    """JAX then differentiates it once; every mechanism calls the meshing."""

    @physics("long")
    @jax.jit
    def long(x):
        return _squares(x, 8)

    def twice(x):
        return [long(long(x) * 0.125)]

    cut = _cut(twice, 8, array(0.1))
    other = _cut(lambda x: [long(x)], 8, array(0.1))
    programs = [_traced(one, array(0.1)) for one in (cut, other)]
    calls = [e for jaxpr in programs for e in jaxpr.eqns if e.params.get("name") == "run"]
    assert len(calls) == 3
    assert len({id(call.params["jaxpr"]) for call in calls}) == 1
    assert len(_pieces(calls[0].params["jaxpr"].jaxpr)) == 2
    assert traced_physics(cut, array(0.1)) == {"long"}
    np.testing.assert_allclose(cut(array(0.1))[0], twice(array(0.1))[0], rtol=1e-14)


def test_a_long_equation_does_not_make_a_piece_longer_than_allowed():
    """A law of 30 operations after 15 others, and many after it, in pieces of at most 40."""

    law = jax.jit(functools.partial(_squares, count=15))

    def chain(x):
        for _ in range(15):
            x = jnp.sin(x)
        x = law(x * 0.1)
        for _ in range(120):
            x = jnp.sin(x)
        return [x]

    pieces = _pieces(_traced(_cut(chain, 40, array(0.1)), array(0.1)))
    lengths = [len(piece.eqns) for piece in pieces]
    assert max(lengths) <= 40
    assert len(lengths) <= 8


def test_what_is_printed_is_printed():
    """A piece without results that prints."""
    seen = []

    def chain(x):
        long = _squares(x * 0.1, 8)
        jax.debug.callback(seen.append, _squares(x, 8))
        return [long]

    jax.jit(_cut(chain, 8, array(0.5)))(array(0.5))
    jax.effects_barrier()
    np.testing.assert_allclose(seen, [_squares(0.5, 8)], rtol=1e-13)


def test_a_long_function_of_a_constant():
    table = jnp.asarray(TABLE)
    long = jax.jit(lambda x, y: _squares(x * 0.1, 8) * y)
    cut = _cut(lambda x: [long(table, x)], 8, array(0.5))
    np.testing.assert_allclose(cut(array(0.5))[0], long(table, array(0.5)), rtol=1e-13)


def test_laws_keep_their_names():
    cut = _cut(_everything, 4, array(1.0), array(2.0))
    assert traced_physics(cut, array(1.0), array(2.0)) == {"a_law"}


@pytest.mark.parametrize("second", [lambda f: f, lambda f: jax.jacfwd(jax.jacrev(f))])
def test_pieces_are_calls_in_the_compiled_program(second):
    """Those of derivatives too; small functions within a piece, here `jnp.where`, are not."""

    def chain(x):
        for _ in range(12):
            x = jnp.where(x > 1, x * 0.5, x * x + 0.1)
        return [x]

    cut = _cut(chain, 8, array(0.3))
    program = jax.jit(jax.vmap(second(lambda x: cut(x)[0])))
    text = present(program.lower(jnp.linspace(0.1, 0.9, 5)).compile().as_text())
    calls = [line for line in text.splitlines() if " call(" in line]
    assert len(calls) >= 4
    assert all("to_apply=%piece" in line for line in calls)


def test_a_hessian_has_fewer_operations():
    """A chain in which each number is used three times; XLA recomputes it for each use."""

    def chain(numbers):
        x, y = numbers[0], numbers[1]
        for _ in range(60):
            x, y = x * y + x, jnp.where(x > 1, 0.5, 0.25) * (y - x * 0.125)
        return x * y

    numbers = jnp.asarray([0.4, 0.3])
    pieces = _cut(lambda x: [chain(x)], 20, numbers)

    def counted(function):
        second = jax.jit(jax.vmap(jax.jacfwd(jax.jacfwd(function))))
        compiled = second.lower(numbers[None].repeat(100, axis=0)).compile()
        return present(compiled.as_text()).count(" = "), compiled(numbers[None].repeat(100, axis=0))

    whole, expected = counted(chain)
    fewer, found = counted(lambda x: pieces(x)[0])
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert fewer < whole / 2
