"""Load sharing among threads: chains in JAX against Newton and root searches in NumPy and SciPy.

All minimise the same convex energy: segments of screw, roller and nut, and between them Hertz
contacts in series with teeth that only press. The rivals work on displacements, as most published
codes do: a Newton method with the banded Cholesky solver of SciPy, and its general root finder.
"""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..harness import Case, Method, Prepared, Problem, Reference
from ..references.chains import HERTZ, SEGMENTS, TOOTH, flank_force, shared

_THREADS = 20
_TOLERANCES = (1e-3, 1e-6, 1e-12)
_LABEL = "thread loads"


class _Instances(NamedTuple):
    #: Load [N] and gaps of both sides [m] of each instance.
    load: np.ndarray
    gap: np.ndarray


def _instances(count: int, classes: int) -> _Instances:
    random = np.random.default_rng(20_140_601)
    gaps = random.normal(size=(count, classes, _THREADS)) * 1e-6
    return _Instances(random.uniform(2e3, 2e4, count), gaps)


def _weights(classes: int) -> np.ndarray:
    """Ten rollers, of which all but the last of the classes' are alike."""
    weights = np.ones(classes)
    weights[0] = 11.0 - classes
    return weights


def _loads(load, gap, weights, tolerance):
    chains, found = shared(load, gap, weights, tolerance)
    forward, _ = chains.screw.loads(found.state.screw_approach, 0.0)
    return forward


@functools.cache
def _program(classes: int, tolerance: float, batch: int | None):
    weights = _weights(classes)

    def one(args):
        load, gap = args
        return _loads(load, gap, weights, tolerance)

    if batch is None:
        return jax.jit(lambda load, gap: one((load[0], gap[0]))[None])
    return jax.jit(lambda load, gap: jax.lax.map(one, (load, gap), batch_size=batch))


def _ours(
    instances: _Instances, classes: int, batch: int | None, settings, dtype: Any = jnp.float64
) -> Method:
    def prepare(tolerance) -> Prepared:
        count = 1 if batch is None else len(instances.load)
        inputs = (jnp.asarray(x[:count], dtype) for x in (instances.load, instances.gap))
        inputs = tuple(inputs)
        program = _program(classes, tolerance, batch)
        return Prepared(lambda: program(*inputs), count, lambda out: {_LABEL: out})

    name = "one at a time" if batch is None else "a batch"
    if dtype == jnp.float32:
        name += ", float32"
    return Method(name, prepare, settings, "tolerance")


class _Displacements:
    """Energy, gradient and banded Hessian over displacements, thread by thread."""

    def __init__(self, load, gap, weights):
        self.load, self.gap, self.weights = load, gap, weights
        self.size = len(weights) + 2
        springs = np.concatenate([[1 / SEGMENTS[0]], weights / SEGMENTS[1], [1 / SEGMENTS[2]]])
        self.springs = springs[None, :]

    def start(self):
        """Displacements at which all threads are pressed about equally."""
        each = self.load / (10 * _THREADS)
        reach = HERTZ * each ** (2 / 3) + TOOTH * each + self.gap.max()
        start = np.zeros((_THREADS, self.size))
        start[:, 0], start[:, 1:-1] = 2 * reach, reach
        return start.ravel()

    def evaluate(self, unknown):
        # Displacements [thread, body]; the nut is held where thread 1 is.
        nodes = unknown.reshape(_THREADS, self.size)
        screw, rollers, nut = nodes[:, :1], nodes[:, 1:-1], nodes[:, -1:]
        first, k1 = flank_force(screw - rollers - self.gap.T)
        second, k2 = flank_force(rollers - nut - self.gap.T)
        first, k1, second, k2 = (self.weights * x for x in (first, k1, second, k2))
        pull = self.springs * (nodes[:-1] - nodes[1:])
        gradient = np.zeros_like(nodes)
        gradient[:-1] += pull
        gradient[1:] -= pull
        gradient[:, 0] += first.sum(1)
        gradient[:, 1:-1] += second - first
        gradient[:, -1] -= second.sum(1)
        gradient[0, 0] -= self.load
        # Held by a spring as stiff as the nut: the loads do not depend on it.
        gradient[0, -1] += self.springs[0, -1] * nodes[0, -1]
        return gradient.ravel(), first, k1, k2

    def hessian(self, k1, k2):
        m = self.size
        band = np.zeros((m + 1, _THREADS * m))
        diagonal = np.zeros((_THREADS, m))
        diagonal[:-1] += self.springs
        diagonal[1:] += self.springs
        diagonal[:, 0] += k1.sum(1)
        diagonal[:, 1:-1] += k1 + k2
        diagonal[:, -1] += k2.sum(1)
        diagonal[0, -1] += self.springs[0, -1]
        band[0] = (diagonal + 1e-9 * np.max(k1 + k2)).ravel()
        for j in range(m - 2):
            band[j + 1, 0::m] = -k1[:, j]
            band[m - 2 - j, j + 1 :: m] = -k2[:, j]
        band[m, : (_THREADS - 1) * m] = np.tile(-self.springs[0], _THREADS - 1)
        return band


def _banded(instances: _Instances, classes: int, count: int) -> Method:
    """Newton with a residual line search and SciPy's banded Cholesky factors."""
    from scipy.linalg import solveh_banded

    weights = _weights(classes)

    def solve(load, gap, tolerance):
        model = _Displacements(load, gap, weights)
        unknown = model.start()
        gradient, first, k1, k2 = model.evaluate(unknown)
        for _ in range(100):
            error = np.max(np.abs(gradient))
            if error <= tolerance * load:
                break
            step = solveh_banded(model.hessian(k1, k2), -gradient, lower=True, check_finite=False)
            share = 1.0
            while True:
                trial = model.evaluate(unknown + share * step)
                if trial[0] @ step <= 0.5 * abs(gradient @ step) or share < 1e-6:
                    break
                share /= 2
            unknown = unknown + share * step
            gradient, first, k1, k2 = trial
        return (first / weights).T

    def prepare(tolerance):
        pairs = list(zip(instances.load[:count], instances.gap[:count], strict=True))

        def call():
            return np.stack([solve(load, gap, tolerance) for load, gap in pairs])

        return Prepared(call, count, lambda out: {_LABEL: out})

    return Method("Newton, SciPy solveh_banded", prepare, _TOLERANCES, "tolerance", kind="rival")


def _root_finder(instances: _Instances, classes: int, count: int) -> Method:
    """SciPy's root finder (MINPACK hybr) on the balance of all nodes."""
    from scipy.optimize import root

    weights, length = _weights(classes), 1e-6

    def solve(load, gap, tolerance):
        model = _Displacements(load, gap, weights)
        found = root(
            lambda x: model.evaluate(x * length)[0] / load,
            model.start() / length,
            method="hybr",
            options={"xtol": tolerance, "maxfev": 20_000},
        )
        return (model.evaluate(found.x * length)[1] / weights).T

    def prepare(tolerance):
        def call():
            pairs = zip(instances.load[:count], instances.gap[:count], strict=True)
            return np.stack([solve(load, gap, tolerance) for load, gap in pairs])

        return Prepared(call, count, lambda out: {_LABEL: out})

    return Method("SciPy optimize.root (hybr)", prepare, _TOLERANCES, "tolerance", kind="rival")


def _problem(name: str, title: str, classes: int, batch: int, quick: bool) -> Problem:
    size = batch // 20 if quick else batch
    instances = _instances(size, classes)
    compared = 10 if quick else 50

    def reference():
        # Two formulations that share no line have to agree before either is a reference.
        load, gap = instances.load[:compared], instances.gap[:compared]
        ours = np.asarray(_program(classes, 1e-13, 1)(jnp.asarray(load), jnp.asarray(gap)))
        theirs: Any = _banded(instances, classes, compared).prepare(1e-13).call()
        mean = load[:, None, None] / (10 * _THREADS)
        if np.max(np.abs(ours - theirs) / mean) > 1e-8:
            raise RuntimeError(f"load sharing, {name}: the two references disagree")
        return {_LABEL: Reference(ours, np.broadcast_to(mean, ours.shape))}

    chunk = 500 if classes <= 3 else 50
    # A program for each: of all that a quick run does, most is compiling.
    settings = _TOLERANCES[::2] if quick else _TOLERANCES
    methods = [
        _ours(instances, classes, chunk, settings),
        _ours(instances, classes, None, settings[-1:] if quick else settings),
        _ours(instances, classes, chunk, (1e-5,), jnp.float32),
        _banded(instances, classes, 10 if quick else 50),
    ]
    if classes == 1:
        methods.append(_root_finder(instances, classes, 1 if quick else 3))
    return Problem(
        name=name,
        title=title,
        instance="nut",
        methods=methods,
        reference=reference,
        reference_note=(
            f"the same balance to 1e-13 by chains and by displacements, {compared} nuts; errors "
            "over the mean load of a thread"
        ),
        baseline="Newton, SciPy solveh_banded",
        target=1e-8,
    )


def case(quick: bool) -> Case:
    """The case of this module."""
    return Case(
        "load_sharing",
        "Load on 20 threads of 10 rollers with pitch errors: chains in JAX, SciPy",
        [
            _problem("equal", "Load on the threads of 10 equal rollers", 1, 10_000, quick),
            _problem(
                "one_unequal",
                "Load on the threads of 10 rollers, one unlike the others",
                2,
                10_000,
                quick,
            ),
            _problem(
                "all_unequal", "Load on the threads of 10 rollers, all unlike", 10, 400, quick
            ),
        ],
    )
