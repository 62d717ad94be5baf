"""Every number of a mechanism as one vector, and what quantities make of many such vectors.

One compiled program evaluates all of them: a batch of mechanisms, each with one number changed.
"""

import functools
import itertools

import jax
import jax.numpy as jnp
import numpy as np
from scenes import example

import prsm_jax as prsm
from prsm_jax.quantities import compute_coded

#: Of the axis around a mechanism; the example that has one shares all else with the actuator.
OF_AN_AXIS = (
    "first_axial_frequency",
    "first_torsional_frequency",
    "first_transverse_frequency",
    "antiresonance_frequency",
    "position_loop_frequency",
    "servo_stiffness",
    "held_motor_stiffness",
)
#: Mechanisms in a batch.
_BATCH = 64


def numbers_of(mechanism):
    """Names of all numbers, their values, and the function that builds a mechanism from values."""
    leaves, structure = jax.tree_util.tree_flatten_with_path(mechanism)
    names = [
        jax.tree_util.keystr(path) + (f"[{k}]" if leaf.ndim else "")
        for path, leaf in leaves
        for k in range(leaf.size)
    ]
    shapes = [leaf.shape for _, leaf in leaves]

    def build(vector):
        built, at = [], 0
        for shape in shapes:
            size = int(np.prod(shape))
            built.append(jnp.reshape(vector[at : at + size], shape))
            at += size
        return jax.tree_util.tree_unflatten(structure, built)

    values = np.concatenate([np.ravel(np.asarray(leaf)) for _, leaf in leaves])
    return names, values, build


class Quantities:
    """Quantities of a mechanism as a function of all its numbers.

    **Attributes:** `names`, `values`: of the numbers; `labels`: of the components of quantities.
    """

    def __init__(self, mechanism, quantities=None):
        self.names, self.values, build = numbers_of(mechanism)
        wanted = (
            prsm.quantities.available_quantities(mechanism) if quantities is None else quantities
        )

        def evaluate(vector):
            found, code = compute_coded(build(vector), wanted)
            return jnp.concatenate([jnp.ravel(found[name]) for name in wanted]), code

        shapes = jax.eval_shape(lambda v: compute_coded(build(v), wanted)[0], self.values)
        self.labels = [
            label
            for name in wanted
            for label in prsm.quantities.component_names(name, shapes[name].shape)
        ]
        #: Values alone, of one vector of numbers.
        self.evaluate = lambda vector: evaluate(vector)[0]
        self._run = jax.jit(jax.vmap(evaluate))
        self._push = jax.jit(
            jax.vmap(lambda x, t: jax.jvp(self.evaluate, (x,), (t,))[1], (None, 0))
        )

    def __call__(self, rows):
        """Values and result codes of many vectors of numbers."""
        parts = [self._run(part) for part in _batches(rows)]
        values, codes = (np.concatenate([np.asarray(p[k]) for p in parts]) for k in (0, 1))
        return values[: len(rows)], codes[: len(rows)]

    def derivatives(self):
        """Forward derivatives of every label, a row for each number, per relative change of it."""
        scales = sizes(self.names, self.values)
        parts = [self._push(self.values, part) for part in _batches(np.diag(scales))]
        return np.concatenate([np.asarray(part) for part in parts])[: len(scales)]

    def differences(self):
        """The same by differences, and an estimate of their own error; see `extrapolated`."""
        shifts = np.concatenate([_STEPS, -_STEPS])
        rows = self.values + shifts[:, None, None] * np.diag(sizes(self.names, self.values))[None]
        found, _ = self(rows.reshape(-1, len(self.values)))
        return _differences(found.reshape(2, len(_STEPS), len(self.values), -1))

    def second_derivative(self, direction):
        """Forward over forward, of every label along a direction."""
        slope = lambda v: jax.jvp(self.evaluate, (v,), (direction,))[1]  # noqa: E731
        return np.asarray(jax.jit(lambda v: jax.jvp(slope, (v,), (direction,))[1])(self.values))

    def second_difference(self, direction):
        """The same by differences of first derivatives, and an estimate of their own error."""
        slope = jax.vmap(lambda v: jax.jvp(self.evaluate, (v,), (direction,))[1])
        shifts = np.concatenate([_STEPS, -_STEPS])
        found = np.asarray(jax.jit(slope)(self.values + shifts[:, None] * direction))
        return _differences(found.reshape(2, len(_STEPS), -1))


def _differences(found):
    """Limit and error from values at all steps (second axis) ahead (first axis) and back."""
    steps = _STEPS.reshape(-1, *(1,) * (found.ndim - 2))
    rounding = _ROUNDING * np.max(np.abs(found), axis=(0, 1)) / steps
    # Infinite values have no difference.
    with np.errstate(invalid="ignore"):
        return extrapolated((found[0] - found[1]) / (2 * steps), rounding)


#: Relative changes of a number, halved from one to the next.
_STEPS = 2e-2 * 0.5 ** np.arange(16)
#: Relative, of the values that differences are of.
_ROUNDING = 1e-14


def sizes(names, values):
    """By what a relative change is relative.

    The magnitude of a number; where it is 0 the largest of its array (errors of pitch are
    micrometres), or 1.
    """
    arrays = [name.rpartition("[")[0] if name.endswith("]") else name for name in names]
    largest = dict.fromkeys(arrays, 0.0)
    for name, value in zip(arrays, np.abs(values), strict=True):
        largest[name] = max(largest[name], value)
    others = np.asarray([largest[name] or 1.0 for name in arrays])
    return np.where(values == 0, others, np.abs(values))


def extrapolated(differences, rounding=0.0):
    """Richardson's limit of central differences over halved steps, and an estimate of its error.

    `rounding` is what rounding of the values leaves of each difference: two neighbours that agree
    to less agree by chance.

    From each column of the extrapolation the value that agrees best with those before it; where
    rounding or a kink disturbs all of them, the estimate says so.
    """
    columns = [differences]
    rounding = np.broadcast_to(rounding, differences.shape)
    for order in range(1, 4):
        last = columns[-1]
        columns.append((4.0**order * last[1:] - last[:-1]) / (4.0**order - 1))
    best = np.full(differences.shape[1:], np.nan)
    error = np.full(differences.shape[1:], np.inf)
    for before, column in itertools.pairwise(columns):
        for k in range(1, len(column)):
            moved = np.abs(column[k] - column[k - 1])
            gained = np.abs(column[k] - before[k + 1])
            estimate = np.maximum(np.maximum(moved, gained), rounding[-len(column) + k])
            better = estimate < error
            best, error = np.where(better, column[k], best), np.where(better, estimate, error)
    return best, error


def _batches(rows):
    """Rows in batches of one size, the last one filled up with its last row."""
    for first in range(0, len(rows), _BATCH):
        part = np.asarray(rows[first : first + _BATCH])
        yield np.concatenate([part, np.repeat(part[-1:], _BATCH - len(part), axis=0)])


@functools.cache
def quantities_of(name, wanted=None):
    """The `Quantities` of a shipped example, compiled once."""
    return Quantities(example(name), wanted)
