"""Millions of designs: the distinct natural frequencies, their derivatives, the whole chain."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.contact import load_of, stage_contact
from prsm_jax.file import load
from prsm_jax.mechanism import get_parameter, set_parameters
from prsm_jax.stiffness import thread_stiffness
from prsm_jax.sweeps import map_in_chunks
from prsm_jax.vibration import (
    VibrationSystem,
    dense_matrices,
    distinct_frequencies,
    vibration_system,
)

from ..harness import Case, Kind, Method, Prepared, Problem, Reference, rival
from ..references.geometry_chain import frequency_slopes
from ..references.stages import (
    NumPyStage,
    dense_solver,
    random_systems,
    scaled_frequencies,
    unflattened,
)
from ..references.vibration import DIGITS, NUMBERS, frequencies

_FREQUENCIES = "all frequencies"
_ELASTICITIES = "elasticities of all frequencies"
_GRADIENT = "derivatives by lead, contact angle, roller radius"
_VARIABLES = ("lead", "contact_angle", "roller_radius")
#: Eigenvalue problems of 4×4 matrices per second of hand-written AVX-512 code on the two cores of
#: the authors' machine, and two of them per design.
_HAND_WRITTEN = 5e7 / 2
_COUNT = 7


def _distinct(system: VibrationSystem, count) -> list[Any]:
    """Carrier, torsional, transverse, roller: one number each, to stay contiguous."""
    found = distinct_frequencies(system, roller_count=count)
    return [found.carrier, *found.torsional, *found.transverse, found.roller]


def _repeats(count: int) -> np.ndarray:
    return np.array([*[1] * 5, *[2] * 4, count - 3])


def _columns(numbers: np.ndarray, count: int):
    """One contiguous array per number, and the numbers of rollers.

    The number that the system is compiled for is the same throughout: the traced one counts.
    """
    columns = [jnp.asarray(np.ascontiguousarray(column)) for column in numbers.T]
    return unflattened(_COUNT)(columns), jnp.full(len(numbers), float(count))


def _memory(compiled) -> str:
    found = compiled.memory_analysis()
    if found is None:
        return ""
    sizes = (
        found.argument_size_in_bytes,
        found.output_size_in_bytes,
        found.temp_size_in_bytes,
    )
    inputs, outputs, between = (f"{size / 1e6:.3g} MB" for size in sizes)
    return f"on each device {inputs} in, {outputs} out, {between} between"


def _chunked(name: str, function, inputs, read, chunks, devices=None) -> Method:
    total = len(jax.tree.leaves(inputs)[0])

    def prepare(chunk):
        given = inputs
        if devices is not None:
            mesh = jax.sharding.Mesh(np.array(devices), ("designs",))
            shared = jax.sharding.NamedSharding(mesh, jax.sharding.PartitionSpec("designs"))
            given = jax.device_put(inputs, shared)
        solve = jax.jit(lambda x: map_in_chunks(function, x, chunk=chunk, devices=devices))
        memory = functools.cache(lambda: _memory(solve.lower(given).compile()))
        return Prepared(lambda: solve(given), total, read, lambda _: memory())

    return Method(name, prepare, chunks, f"{total} designs in chunks of")


def _at_once(name: str, function, inputs, read, batches, kind: Kind = "rival") -> Method:
    def prepare(batch):
        given = jax.tree.map(lambda leaf: leaf[:batch], inputs)
        solve = jax.jit(jax.vmap(function))
        return Prepared(lambda: solve(given), batch, read)

    return Method(name, prepare, batches, "designs at once", kind)


def _with_values(direction, function, **options):
    """Derivatives of a function beside its values."""

    def values_twice(*arguments):
        found = function(*arguments)
        return found, found

    return direction(values_twice, has_aux=True, **options)


def _two_devices():
    found = jax.devices()
    return found[:2] if len(found) > 1 and found[0].platform == "cpu" else None


def _repeated(found, compared: int, count: int = _COUNT) -> np.ndarray:
    """Distinct frequencies of the first designs, as all of them, ascending."""
    distinct = np.stack([np.asarray(column[:compared]) for column in found], axis=1)
    return np.sort(np.repeat(distinct, _repeats(count), axis=1), axis=1)


def _values_problem(quick: bool) -> Problem:
    total, compared = (20_000, 2) if quick else (1_000_000, 8)
    numbers = random_systems(_COUNT, total, 0.1)
    columns = _columns(numbers, _COUNT)
    dense = [2_000] if quick else [20_000, 1_000, 200]
    scipy = numbers[: 200 if quick else 1_000]
    stage = NumPyStage(_COUNT)

    def solve(design):
        return _distinct(*design)

    def read(found):
        return {_FREQUENCIES: _repeated(found, compared)}

    methods = [
        _chunked("distinct", solve, columns, read, (2_000,) if quick else (1_000, 2_000, 4_000))
    ]
    devices = _two_devices()
    if devices is not None:
        methods.append(_chunked("distinct, two devices", solve, columns, read, (2_000,), devices))
    if not quick:
        fewer = jax.tree.map(lambda column: column[: total // 10], columns)
        methods.append(_chunked("distinct, a tenth of them", solve, fewer, read, (2_000,)))
        methods.append(_at_once("distinct, vmap", solve, columns, read, [total], "method"))
    rows = jnp.asarray(numbers[: max(dense)])
    methods += [
        _at_once(
            "dense, jax eigvalsh",
            dense_solver(_COUNT),
            rows,
            lambda found: {_FREQUENCIES: found[:compared]},
            dense,
        ),
        rival(
            "SciPy eigh(K, M)",
            lambda: stage.by_scipy(scipy),
            len(scipy),
            lambda out: {_FREQUENCIES: out},
        ),
    ]

    def reference():
        exact = [frequencies(row, _COUNT)[0] for row in numbers[:compared]]
        return {_FREQUENCIES: Reference(np.array(exact))}

    return Problem(
        name="values",
        title=f"From stiffnesses, masses and N to all frequencies, N = {_COUNT}",
        instance="design",
        methods=methods,
        reference=reference,
        reference_note=f"mpmath eigsy of the full matrix at {DIGITS} digits, {compared} designs",
        baseline="dense, jax eigvalsh",
        yardstick=_HAND_WRITTEN,
    )


def _counts_problem() -> Problem:
    """One compiled program for every N: the cost must not depend on it."""
    counts, total, compared = (3, 7, 12, 30), 200_000, 4
    solve = jax.jit(lambda x: map_in_chunks(lambda design: _distinct(*design), x))

    def ratios(found, numbers, count):
        exact = np.array([frequencies(row, count)[0] for row in numbers[:compared]])
        # N + 10 numbers differ in length: the smallest and the largest deviation.
        off = found[:compared] / exact - 1
        return {_FREQUENCIES: 1 + np.stack([off.min(axis=1), off.max(axis=1)], axis=1)}

    def reduced(count):
        numbers = random_systems(count, total, 0.1)
        columns = _columns(numbers, count)
        return Prepared(
            lambda: solve(columns),
            total,
            lambda found: ratios(_repeated(found, compared, count), numbers, count),
        )

    def dense(count):
        numbers = random_systems(count, 2_000, 0.1)
        rows, jitted = jnp.asarray(numbers), jax.jit(jax.vmap(dense_solver(count)))
        return Prepared(
            lambda: jitted(rows), len(numbers), lambda found: ratios(found, numbers, count)
        )

    return Problem(
        name="counts",
        title="One program for every number of rollers",
        instance="design",
        methods=[
            Method("distinct", reduced, counts, "N ="),
            Method("dense, jax eigvalsh", dense, counts, "N =", "rival"),
        ],
        reference=lambda: {_FREQUENCIES: Reference(np.ones((compared, 2)))},
        reference_note=f"mpmath at {DIGITS} digits, {compared} designs for each N",
        baseline="dense, jax eigvalsh",
    )


def _derivatives_problem(quick: bool) -> Problem:
    total, compared = (5_000, 2) if quick else (100_000, 8)
    numbers = random_systems(_COUNT, total, 0.1)
    columns = _columns(numbers, _COUNT)
    dense_batch = 100 if quick else 500
    rows, stage = jnp.asarray(numbers[:dense_batch]), NumPyStage(_COUNT)

    def slopes(direction):
        jacobian = _with_values(direction, _distinct, argnums=(0, 1))
        return lambda design: jacobian(*design)

    def read(found):
        derivatives, values = found
        values = np.stack([np.asarray(value[:compared]) for value in values], axis=1)
        by_number = np.stack(
            [
                np.stack([np.asarray(leaf[:compared]) for leaf in jax.tree.leaves(system)], axis=1)
                for system, _ in derivatives
            ],
            axis=1,
        )
        elasticities = by_number * numbers[:compared, None] / values[:, :, None]
        repeats = _repeats(_COUNT)
        order = np.argsort(np.repeat(values, repeats, axis=1), axis=1)
        repeated = np.repeat(elasticities, repeats, axis=1)
        return {_ELASTICITIES: np.take_along_axis(repeated, order[:, :, None], axis=1)}

    def dense(direction):
        return _with_values(direction, dense_solver(_COUNT))

    def read_dense(found):
        derivatives, values = (np.asarray(part) for part in found)
        return {_ELASTICITIES: derivatives * numbers[: len(values), None] / values[:, :, None]}

    def reference():
        exact = [frequencies(row, _COUNT, elasticities=True)[1] for row in numbers[:compared]]
        return {_ELASTICITIES: Reference(np.array(exact), scale=1.0)}

    methods = [_chunked("distinct, forward", slopes(jax.jacfwd), columns, read, (1_000,))]
    if not quick:
        methods += [_chunked("distinct, reverse", slopes(jax.jacrev), columns, read, (1_000,))]
    devices = _two_devices()
    if devices is not None and not quick:
        forward = slopes(jax.jacfwd)
        name = "distinct, forward, two devices"
        methods += [_chunked(name, forward, columns, read, (1_000,), devices)]
    methods += [_at_once("dense, jax, forward", dense(jax.jacfwd), rows, read_dense, [dense_batch])]
    if not quick:
        methods += [
            _at_once("dense, jax, reverse", dense(jax.jacrev), rows, read_dense, [100, 500])
        ]
    methods += [
        rival(
            "SciPy eigh, analytic",
            lambda: stage.elasticities(numbers[:dense_batch]),
            dense_batch,
            lambda out: {_ELASTICITIES: out},
        )
    ]
    return Problem(
        name="derivatives",
        title=f"Derivatives of the ten distinct frequencies by {NUMBERS} numbers and N",
        instance="design",
        methods=methods,
        reference=reference,
        reference_note=f"mpmath eigenvectors at {DIGITS} digits, {compared} designs",
        baseline="dense, jax, forward",
    )


def _chain_problem(quick: bool) -> Problem:
    """Meshing, Hertz contacts, stiffnesses, masses from dimensions, frequencies."""
    total, compared, rivals = (500, 2, 50) if quick else (100_000, 16, 1_000)
    mechanism = load("actuator")
    base = np.array([float(get_parameter(mechanism, name)) for name in _VARIABLES])
    random = np.random.default_rng(2022)
    designs = base * random.uniform(0.95, 1.05, (total, len(base)))
    columns = tuple(jnp.asarray(np.ascontiguousarray(column)) for column in designs.T)

    def system(design) -> VibrationSystem:
        moved = set_parameters(mechanism, dict(zip(_VARIABLES, design, strict=True)))
        stage = moved.stages[0]
        threads = thread_stiffness(
            stage, lambda: stage_contact(stage, jnp.abs(load_of(moved, None)))
        )
        return vibration_system(stage, threads)

    count = mechanism.stages[0].roller_count

    def distinct(design):
        return _distinct(system(design), jnp.asarray(float(count)))

    def dense(design):
        return list(scaled_frequencies(*dense_matrices(system(design))))

    def read(found):
        slopes = np.stack(
            [np.stack([np.asarray(s[:compared]) for s in row], axis=1) for row in found], axis=1
        )
        return {_GRADIENT: slopes}

    values = jax.jit(jax.vmap(distinct))

    def reference():
        found = np.array([frequency_slopes(*design) for design in designs[:compared]])
        return {_GRADIENT: Reference(found, scale=np.abs(found).max(axis=1, keepdims=True))}

    def read_dense(found):
        """The dense frequencies that are the distinct ones: each by its place among all."""
        slopes = np.stack([np.stack(row, axis=1) for row in found], axis=1)[:compared]
        distinct_values = np.stack(values(tuple(c[:compared] for c in columns)), axis=1)
        repeats = _repeats(count)
        order = np.argsort(np.repeat(distinct_values, repeats, axis=1), axis=1)
        places = np.argsort(order, axis=1)
        first = np.concatenate([[0], np.cumsum(repeats)[:-1]])
        last = np.cumsum(repeats) - 1
        # Members of a repeated root: their mean is what does not depend on the solver.
        pairs = [np.take_along_axis(slopes, places[:, at][:, :, None], 1) for at in (first, last)]
        return {_GRADIENT: (pairs[0] + pairs[1]) / 2}

    def differences(design):
        moved = []
        for place in range(len(base)):
            ends = []
            for step in (1e-5, -1e-5):
                changed = list(design)
                changed[place] = design[place] * (1 + step)
                ends.append(distinct(tuple(changed)))
            width = 2e-5 * design[place]
            moved.append([(a - b) / width for a, b in zip(*ends, strict=True)])
        return [[row[i] for row in moved] for i in range(len(moved[0]))]

    methods = [
        _chunked(
            "distinct, forward", jax.jacfwd(distinct), columns, read, (500,) if quick else (2_000,)
        ),
        _at_once("dense, jax, forward", jax.jacfwd(dense), columns, read_dense, [rivals]),
    ]
    if not quick:
        methods.append(_chunked("distinct, central differences", differences, columns, read, [500]))
    return Problem(
        name="geometry",
        title="Derivatives of the ten frequencies through the whole chain from geometry",
        instance="design",
        methods=methods,
        reference=reference,
        reference_note=f"the chain in mpmath at {DIGITS} digits, {compared} designs",
        baseline="dense, jax, forward",
    )


def case(quick: bool) -> Case:
    """The case of this module; a quick run is values and derivatives of a few designs."""
    problems = [_values_problem(quick), _derivatives_problem(quick), _chain_problem(quick)]
    if not quick:
        problems += [_counts_problem()]
    return Case(
        "many_designs",
        "Distinct natural frequencies of very many designs, and their derivatives",
        problems,
    )
