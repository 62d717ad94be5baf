"""One row of one structure: values, forward and reverse derivatives, and a verdict on each."""

import functools
import time

import jax
import jax.numpy as jnp
import numpy as np

from .cells import Cell
from .differences import STEPS, Slope, slopes
from .expected import references
from .numbers import changed, numbers_of, split
from .rows import Row, admitted
from .single import judge_single
from .slopes import STATE_TOLERANCE, first_of, slope_cell, with_choice_of_steps
from .structures import Structure

#: Forward and reverse derivatives are the same sums in another order.
_TRANSPOSE_TOLERANCE = 1e-8
_EPSILON = 2.3e-16
#: Columns that are 0 where parts cancel: power in and lost, forces of both threads.
_DIFFERENCES = frozenset(("efficiency", "ring_gear_force", "carrier_ratio"))
#: Where differences disagree they are taken again, closer by these factors: rigid threads part
#: within a femtometre, and wider steps see nothing of what holds at the point itself.
_CLOSER = (4.0**-6, 4.0**-9, 4.0**-12, 4.0**-14, 4.0**-16)
#: How well closer differences have to agree, relative; rounding leaves them so much.
_CLOSE_AGREEMENT = 1e-3


class Programs:
    """The compiled programs of a structure; every row goes through them."""

    def __init__(self, structure: Structure):
        self.structure = structure
        self.leaves, build = split(structure.base)
        self.numbers = numbers_of(structure.base)
        dtype = jnp.result_type(float)

        def outputs(values):
            found, codes = structure.outputs(build(values))
            return {name: jnp.asarray(v) for name, v in found.items()}, codes

        def only_values(values):
            return outputs(values)[0]

        @jax.jit
        def forward(values, tangents):
            return jax.jvp(only_values, (values,), (tangents,))[1]

        @jax.jit
        def reverse(values, weights):
            return jax.vjp(only_values, values)[1](weights)[0]

        self._values, self._forward, self._reverse = jax.jit(outputs), forward, reverse
        self._dtype = dtype

    def _given(self, leaves):
        return [jnp.asarray(leaf, self._dtype) for leaf in leaves]

    def values(self, leaves):
        """Values and codes."""
        found, codes = jax.device_get(self._values(self._given(leaves)))
        return (
            {name: np.asarray(v, float) for name, v in found.items()},
            {name: int(code) for name, code in codes.items()},
        )

    def forward(self, leaves, direction):
        """Derivatives of all values along a direction."""
        found = jax.device_get(self._forward(self._given(leaves), self._given(direction)))
        return {name: np.asarray(v, float) for name, v in found.items()}

    def reverse(self, leaves, weights):
        """Derivatives of a weighted sum of values by all numbers."""
        given = {name: jnp.asarray(w, self._dtype) for name, w in weights.items()}
        found = jax.device_get(self._reverse(self._given(leaves), given))
        return [np.asarray(v, float) for v in found]


@functools.cache
def programs(name: str) -> Programs:
    """The programs of a structure, compiled once per process."""
    from .structures import structure

    return Programs(structure(name))


def _relative(found: np.ndarray, expected: np.ndarray, least: float) -> float:
    """Error relative to each entry; a share `least` of the largest one is as good as nothing."""
    largest, difference = np.max(np.abs(expected), initial=0.0), np.abs(found - expected)
    if least == 1.0:
        scale = np.full_like(difference, largest)
    else:
        scale, difference = np.abs(expected), np.where(difference <= least * largest, 0, difference)
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(difference == 0, 0.0, difference / scale)
    return float(np.max(error, initial=0.0))


class Verdicts:
    """The cells of one row, column by column."""

    def __init__(self, compiled: Programs, row: Row, base: dict[str, np.ndarray]):
        self.compiled, self.row, self.base = compiled, row, base
        self.structure = compiled.structure
        self.leaves, self.places = changed(compiled.leaves, compiled.numbers, row.changes)
        self.found, self.codes = compiled.values(self.leaves)
        self.usable: dict[str, bool] = {}
        #: What rounding does to forward derivatives, where that was looked at.
        self.slope_wobble: dict[str, np.ndarray] = {}
        #: Entries below this share of the largest are measured by that share of it.
        self.least = 1.0 if self.structure.histories else 1e-14

    def _impossible(self) -> bool:
        """Whether one of the changed numbers is none that a file may have."""
        return any(
            not all(admitted(self.compiled.numbers[k], x) for x in np.ravel(self.leaves[k]))
            for k in self.places
        )

    def value_cells(self) -> dict[str, Cell]:
        """Verdicts on values."""
        impossible = self._impossible()
        expected = {} if impossible else self._expected()
        cells = {}
        for name, value in self.found.items():
            cell = self._value(name, value, expected.get(name), impossible)
            cells[name] = cell
            self.usable[name] = cell.status in ("agrees", "finite", "wrong_value")
            if cell.status == "agrees" and not np.isfinite(value).all():
                self.usable[name] = False
        return cells

    def _expected(self):
        if not self.structure.reference:
            return {}
        given = dict(zip([n.name for n in self.compiled.numbers], self.leaves, strict=True))
        try:
            return getattr(references, self.structure.reference)(self.structure, given)
        except references.NoReference:
            return {}

    def _value(self, name, value, expected, impossible) -> Cell:
        if self.codes[name] != 0:
            return Cell("refused", None, f"code {self.codes[name]}")
        if self.row.group == "number" and np.array_equal(value, self.base[name], equal_nan=True):
            return Cell("untouched")
        if not np.isfinite(value).all():
            documented = name in self.structure.infinite and not np.isnan(value).any()
            if not documented or impossible:
                return Cell("not_finite", None, f"{first_of(value)}")
            return Cell("agrees", 0.0, "documented to be ∞")
        if impossible:
            return Cell(
                "accepted", None, f"{first_of(value)}, ordinarily {first_of(self.base[name])}"
            )
        if expected is None:
            return Cell("finite")
        reference, own = expected
        if np.shape(reference) != np.shape(value):
            return Cell("wrong_value", None, f"shape {np.shape(value)} for {np.shape(reference)}")
        error = _relative(value, np.asarray(reference, float), self.least)
        if error <= max(self.structure.tolerance, own):
            return Cell("agrees", error)
        return Cell("wrong_value", error, f"{first_of(value)} for {first_of(reference)}")

    # Derivatives -------------------------------------------------------------------------------

    def _direction(self, random, geometry: bool) -> list[np.ndarray]:
        return [
            leaf * random.uniform(0.5, 1.0, leaf.shape) * random.choice([-1.0, 1.0], leaf.shape)
            if not geometry or ".thread." in number.name
            else np.zeros_like(leaf)
            for leaf, number in zip(self.leaves, self.compiled.numbers, strict=True)
        ]

    def _slope_wobble(self, direction, tangents) -> dict[str, np.ndarray]:
        """How far a relative change of all numbers by an epsilon moves forward derivatives."""
        random = np.random.default_rng(16)
        worst = {name: np.zeros_like(tangent) for name, tangent in tangents.items()}
        for _ in range(2):
            for name, slope in self.compiled.forward(self._rounded(random), direction).items():
                change = np.abs(slope - tangents[name])
                worst[name] = np.fmax(worst[name], np.where(np.isfinite(change), change, 0.0))
        return worst

    def _rounded(self, random) -> list[np.ndarray]:
        """All numbers, each an epsilon larger or smaller."""
        return [
            leaf * (1 + _EPSILON * random.choice([-1.0, 1.0], leaf.shape)) for leaf in self.leaves
        ]

    def _wobble(self, random) -> dict[str, np.ndarray]:
        """How far a relative change of all numbers by an epsilon moves the values."""
        worst = {name: np.zeros_like(value) for name, value in self.found.items()}
        for _ in range(2):
            values, _ = self.compiled.values(self._rounded(random))
            for name, value in values.items():
                change = np.abs(value - self.found[name])
                worst[name] = np.fmax(worst[name], np.where(np.isfinite(change), change, 0.0))
        return worst

    def gradient_cells(self, seed: int) -> tuple[dict[str, Cell], dict[str, Cell]]:
        """Verdicts on forward and on reverse derivatives."""
        random = np.random.default_rng([seed, *self.row.name.encode()])
        if not any(self.usable.values()):
            return {}, {}
        wobble = self.wobble = self._wobble(random)
        forward: dict[str, Cell] = {}
        # In combinations one direction has to do.
        alone = self.row.group == "single" and not self.structure.slow
        kinds = (False, True) if alone else (False,)
        tangents: dict[str, np.ndarray] = {}
        direction: list[np.ndarray] = []
        for geometry in kinds:
            own = self._direction(random, geometry)
            if not any(np.any(part) for part in own):
                continue
            given = self.compiled.forward(self.leaves, own)
            if not tangents:
                tangents, direction = given, own
            measured = self._measured(own, wobble)
            closer: dict[float, dict[str, Slope | None]] = {}
            for name in self.found:
                if self.usable[name]:
                    cell = self._slope(name, given[name], measured[name])
                    if cell.status == "wrong_gradient" and not self.structure.stepping:
                        for factor in _CLOSER:
                            if factor not in closer:
                                closer[factor] = self._measured(own, wobble, factor)
                            again = self._slope(name, given[name], closer[factor][name])
                            error = np.inf if again.error is None else again.error
                            if again.status == "agrees" and error < _CLOSE_AGREEMENT:
                                cell = again
                                break
                    forward[name] = _worse(forward.get(name), cell)
        self._at_zero(forward)
        return forward, self._reverse_cells(forward, tangents, direction, random)

    def _measured(self, direction, wobble, shrink=1.0):
        wanted = {name: value for name, value in self.found.items() if self.usable[name]}

        def at(step: float):
            values, codes = self.compiled.values(
                [leaf + step * part for leaf, part in zip(self.leaves, direction, strict=True)]
            )
            return values, {name: code == 0 for name, code in codes.items()}

        steps = STEPS[:6] if self.structure.slow else STEPS
        steps = steps if shrink == 1.0 else STEPS[:3]
        with np.errstate(all="ignore"):
            found = slopes(at, wanted, wobble, tuple(shrink * step for step in steps))
        if self.structure.stepping:
            found = {name: with_choice_of_steps(slope) for name, slope in found.items()}
        return found | self._exactly(direction)

    def _exactly(self, direction) -> dict[str, Slope | None]:
        """Derivatives of the same values found without steps, where they are."""
        if not self.structure.twin:
            return {}
        twin = Verdicts(programs(self.structure.twin), self.row, self.base)
        twin.usable = {name: code == 0 and self.usable[name] for name, code in twin.codes.items()}
        measured = twin._measured(direction, twin._wobble(np.random.default_rng(15)))
        return {name: slope for name, slope in measured.items() if slope is not None}

    def _at_zero(self, cells: dict[str, Cell]) -> None:
        """Derivatives by numbers that are 0 have to be finite too."""
        direction = [
            np.where(leaf == 0, np.where(base == 0, 1e-6, np.abs(base)), 0.0)
            for leaf, base in zip(self.leaves, self.compiled.leaves, strict=True)
        ]
        if not any(np.any(part) for part in direction):
            return
        for name, slope in self.compiled.forward(self.leaves, direction).items():
            if self.usable[name] and not np.isfinite(slope).all():
                cells[name] = Cell("not_finite", None, f"by a number that is 0: {first_of(slope)}")

    def _slope(self, name: str, given: np.ndarray, measured: Slope | None) -> Cell:
        one = self.structure
        tolerance = 10 * one.tolerance * one.slow
        if one.slope_tolerance is not None:
            tolerance = one.slope_tolerance
        spectrum = name.endswith("frequencies")
        state = one.stepping and name == "carrier_ratio"
        return slope_cell(
            self.found[name],
            given,
            measured,
            tolerance,
            one.histories,
            spectrum,
            one.stepping,
            max(STATE_TOLERANCE if state else 0.0, 10 * np.max(self._ordinary(name), initial=0.0)),
        )

    def _ordinary(self, name: str) -> np.ndarray:
        """Rounding of the ordinary value, where a small one is a difference of parts as large."""
        size = np.abs(np.nan_to_num(self.base[name], posinf=0.0, neginf=0.0))
        return _EPSILON * size if name in _DIFFERENCES else np.zeros_like(size)

    def _reverse_cells(self, forward, tangents, direction, random) -> dict[str, Cell]:
        if not tangents:
            return {}
        good = [name for name in forward if forward[name].status != "not_finite"]
        weights = {
            name: np.where(np.isfinite(t) & (name in good), self._weight(t, random), 0.0)
            for name, t in tangents.items()
        }
        cells: dict[str, Cell] = {}
        together = self._transposed(weights, tangents, direction, good)
        if together is not None and len(good) == len(forward):
            return {name: Cell(forward[name].status, together) for name in good}
        # One at a time: whose derivative it is, and whether rounding can have done it.
        self.slope_wobble = self._slope_wobble(direction, tangents)
        for name in forward:
            alone = {
                other: w if other == name else np.zeros_like(w) for other, w in weights.items()
            }
            if name not in good:
                alone[name] = np.ones_like(weights[name])
            gradient = self.compiled.reverse(self.leaves, alone)
            if not all(np.isfinite(g).all() for g in gradient):
                where = next(
                    n.name
                    for n, g in zip(self.compiled.numbers, gradient, strict=True)
                    if not np.isfinite(g).all()
                )
                cells[name] = Cell("not_finite", None, f"by {where}")
                continue
            error = self._mismatch(gradient, alone, tangents, direction, [name])
            if name not in good or error is None or error <= _TRANSPOSE_TOLERANCE:
                status = "open" if name not in good else forward[name].status
                cells[name] = Cell(status, error)
            elif self.structure.slow and error <= 1e-4:
                # Methods that choose their steps by tolerance agree to that only.
                cells[name] = Cell("open", error)
            else:
                cells[name] = Cell("wrong_gradient", error, "reverse differs from forward")
        return cells

    def _weight(self, tangent, random):
        size = np.where(np.abs(tangent) > 0, np.abs(tangent), 1.0)
        with np.errstate(over="ignore", invalid="ignore"):
            signs = random.uniform(0.5, 1.0, tangent.shape) * random.choice([-1, 1], tangent.shape)
            return np.nan_to_num(signs / size, posinf=0.0, neginf=0.0)

    def _mismatch(self, gradient, weights, tangents, direction, names) -> float | None:
        left = sum(float(np.sum(g * d)) for g, d in zip(gradient, direction, strict=True))
        right = sum(float(np.sum(weights[n] * tangents[n])) for n in names)
        scale = sum(float(np.sum(np.abs(weights[n] * tangents[n]))) for n in names)
        # Terms of the sum over all numbers may cancel.
        terms = sum(float(np.sum(np.abs(g * d))) for g, d in zip(gradient, direction, strict=True))
        scale += 1e-6 * terms
        # Nor does a derivative count that is next to nothing beside its value.
        scale += 1e-4 * sum(float(np.sum(np.abs(weights[n] * self.found[n]))) for n in names)
        # And both rest on numbers that are rounded.
        scale += 1e10 * sum(float(np.sum(np.abs(weights[n] * self._rounding(n)))) for n in names)
        return abs(left - right) / scale if scale > 0 else None

    def _rounding(self, name: str) -> np.ndarray:
        """What rounding does to a value, and to its derivatives where that was looked at.

        Of a difference that is at least what it does to the ordinary value. All columns together
        are not given that, or a derivative that is nothing would hide others.
        """
        if not self.slope_wobble:
            return self.wobble[name]
        least = np.maximum(self.wobble[name], self._ordinary(name))
        return np.maximum(least, self.slope_wobble[name])

    def _transposed(self, weights, tangents, direction, names) -> float | None:
        """How far reverse is from forward, all columns at once; `None` where it has to be told."""
        gradient = self.compiled.reverse(self.leaves, weights)
        if not all(np.isfinite(g).all() for g in gradient):
            return None
        error = self._mismatch(gradient, weights, tangents, direction, names)
        if error is None or error <= _TRANSPOSE_TOLERANCE:
            return error or 0.0
        return None


_ORDER = ("agrees", "untouched", "finite", "open", "wrong_gradient", "not_finite")


def _worse(one: Cell | None, other: Cell) -> Cell:
    if one is None:
        return other
    return max((one, other), key=lambda cell: _ORDER.index(cell.status))


def judge(
    compiled: Programs, row: Row, base: dict[str, np.ndarray], seed: int
) -> tuple[dict[str, tuple[Cell, ...]], float]:
    """The cells of a row, value, forward and reverse for each column, and the seconds it took."""
    if row.precision == "float32":
        return judge_single(compiled, row, seed)
    begin = time.perf_counter()
    verdicts = Verdicts(compiled, row, base)
    absent = Cell("absent")
    if row.changes and not verdicts.places:
        return {}, 0.0
    values = verdicts.value_cells()
    forward: dict[str, Cell] = {}
    reverse: dict[str, Cell] = {}
    if not (row.group == "number" and verdicts._impossible()):
        forward, reverse = verdicts.gradient_cells(seed)
    cells = {
        name: (value, forward.get(name, absent), reverse.get(name, absent))
        for name, value in values.items()
    }
    return cells, time.perf_counter() - begin


def crashed(columns: tuple[str, ...], error: BaseException) -> dict[str, tuple[Cell, ...]]:
    """What is said of a row that ended in an exception."""
    cell = Cell("crash", None, f"{type(error).__name__}: {error}"[:200])
    return {name: (cell, Cell("absent"), Cell("absent")) for name in columns}


__all__ = ["Programs", "Verdicts", "crashed", "judge", "programs"]
