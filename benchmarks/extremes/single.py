"""A row in single precision, against the same program in double precision on the same numbers."""

import copy
import time

import jax.numpy as jnp
import numpy as np

from .cells import Cell
from .numbers import changed

#: Relative error of values and derivatives that counts as agreement.
_TOLERANCE = {"value": 1e-3, "slope": 1e-2}
#: What a change of all numbers by this does to a result, this many times, is no error either.
_EPSILON, _TIMES = 1.2e-7, 100.0


def _spread(function, leaves, random) -> dict[str, np.ndarray]:
    """How far a change of all numbers by a rounding of single precision moves results."""
    middle, worst = function(leaves), {}
    for _ in range(2):
        moved = [x * (1 + _EPSILON * random.choice([-1.0, 1.0], x.shape)) for x in leaves]
        for name, value in function(moved).items():
            with np.errstate(all="ignore"):
                change = np.nan_to_num(abs(value - middle[name]))
            worst[name] = np.maximum(worst.get(name, 0.0), change)
    return worst


def _compared(found, exact, spread, tolerance: float, floor) -> float:
    """Largest error over what is allowed of it."""
    allowed = tolerance * np.max(abs(exact), initial=0.0) + _TIMES * spread + floor
    with np.errstate(all="ignore"):
        return float(np.max(np.where(found == exact, 0.0, abs(found - exact) / allowed)))


def _value(one, name, value, code, exact, exact_code, spread) -> Cell:
    if code != 0:
        return Cell("refused", None, f"code {code}")
    if not np.isfinite(value).all():
        if name in one.infinite and not np.isnan(value).any():
            return Cell("agrees", 0.0, "documented to be ∞")
        return Cell("not_finite", None, "in float32")
    if exact_code != 0 or not np.isfinite(exact).all():
        return Cell("finite", None, "no number in float64")
    error = _compared(value, exact, spread, _TOLERANCE["value"], 0.0)
    return Cell("agrees" if error <= 1 else "wrong_value", error * _TOLERANCE["value"])


def judge_single(compiled, row, seed: int) -> tuple[dict[str, tuple[Cell, ...]], float]:
    """Cells of a row whose numbers are rounded to float32: value, forward, reverse."""
    begin = time.perf_counter()
    random = np.random.default_rng([seed, 32])
    leaves, _ = changed(compiled.leaves, compiled.numbers, row.changes)
    leaves = [np.float64(np.float32(x)) for x in leaves]
    short = copy.copy(compiled)
    short._dtype = jnp.float32
    exact, exact_codes = compiled.values(leaves)
    found, codes = short.values(leaves)
    direction = [x * random.choice([-1.0, 1.0], x.shape) for x in leaves]
    spread = _spread(lambda x: compiled.values(x)[0], leaves, random)
    slopes, slope = compiled.forward(leaves, direction), short.forward(leaves, direction)
    slope_spread = _spread(lambda x: compiled.forward(x, direction), leaves, random)
    cells = {}
    for name, value in found.items():
        own = _value(
            compiled.structure, name, value, codes[name], exact[name], exact_codes[name],
            spread[name],
        )  # fmt: skip
        forward = reverse = Cell("absent")
        if own.status == "agrees" and np.isfinite(value).all():
            # Below a thousandth of the value per relative change there is only rounding.
            floor = 1e-3 * np.max(abs(value), initial=0.0)
            error = _compared(
                slope[name], slopes[name], slope_spread[name], _TOLERANCE["slope"], floor
            )
            forward = Cell("agrees" if error <= 1 else "wrong_gradient", error)
            if not np.isfinite(slope[name]).all():
                forward = Cell("not_finite", None, "in float32")
            weights = {n: np.ones_like(v) if n == name else 0 * slope[n] for n, v in found.items()}
            gradient = short.reverse(leaves, weights)
            rounding = floor + _TIMES * float(np.sum(slope_spread[name]))
            reverse = _transposed(gradient, direction, slope[name], rounding)
        cells[name] = own, forward, reverse
    return cells, time.perf_counter() - begin


def _transposed(gradient, direction, slope, rounding: float) -> Cell:
    if not all(np.isfinite(g).all() for g in gradient):
        return Cell("not_finite", None, "in float32")
    terms = [g * d for g, d in zip(gradient, direction, strict=True)]
    size = sum(float(np.sum(abs(term))) for term in terms)
    missing = abs(sum(float(np.sum(term)) for term in terms) - float(np.sum(slope)))
    agrees = missing <= _TOLERANCE["slope"] * size + rounding
    error = missing / (size + rounding) if missing > 0 else 0.0
    return Cell("agrees" if agrees else "wrong_gradient", error, "reverse differs from forward")
