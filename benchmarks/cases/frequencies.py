"""Natural frequencies: reduced by symmetry against dense eigensolvers, values and derivatives."""

import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.numerics import singular_values
from prsm_jax.vibration import VibrationSystem, spring_network, symmetric_modes

from ..harness import Case, Method, Prepared, Problem, Reference, rival
from ..references.stages import NumPyStage, dense_solver, random_systems, unflattened
from ..references.vibration import DIGITS, NUMBERS, frequencies

_FREQUENCIES = "all frequencies"
_ELASTICITIES = "elasticities of all frequencies"


def _arrowhead(system: VibrationSystem, support: str, mass: str, share: float) -> jax.Array:
    """One block of the symmetry, scaled by its masses: diagonal K_j + c² k_j, couplings ± c k_j,
    corner Σ k_j, where c² is the number of rollers that take part."""
    factor, bodies = (share * system.roller_count) ** 0.5, system.bodies
    springs = jnp.stack([body.mesh_stiffness for body in bodies])
    supports = jnp.stack([getattr(body, support) for body in bodies])
    signs = jnp.array([float(body.roller_sign) for body in bodies])
    masses = jnp.stack([*(getattr(b, mass) for b in bodies), system.roller_equivalent_mass])
    coupling = (factor * signs * springs)[:, None]
    matrix = jnp.block(
        [
            [jnp.diag(supports + factor**2 * springs), coupling],
            [coupling.T, jnp.sum(springs)[None, None]],
        ]
    )
    weight = 1 / jnp.sqrt(masses)
    return matrix * weight[:, None] * weight[None, :]


def _blocks_by_lapack(system: VibrationSystem):
    """The two small blocks of the symmetry, but solved by LAPACK."""
    values = []
    for matrix, repeats in (
        (_arrowhead(system, "torsional_support", "equivalent_mass", 1.0), 1),
        (_arrowhead(system, "radial_support", "mass", 0.5), 2),
    ):
        found = jnp.maximum(jnp.linalg.eigvalsh(matrix), 1e-300)
        values.append(jnp.repeat(found, repeats))
    roller = sum(body.mesh_stiffness for body in system.bodies) / system.roller_equivalent_mass
    values.append(jnp.repeat(roller, system.roller_count - 3))
    assert system.carrier is not None
    values.append(jnp.atleast_1d(system.carrier.torsional_support / system.carrier.equivalent_mass))
    return jnp.sqrt(jnp.sort(jnp.concatenate(values))) / (2 * jnp.pi)


def _reduced(system: VibrationSystem):
    return symmetric_modes(system).frequencies


def _rooted(unflatten, row):
    """√k G M^{-1/2} of one design, without any use of symmetry; its singular values are ω."""
    network = spring_network(unflatten(row))
    return jnp.sqrt(network.stiffness)[:, None] * network.rows / jnp.sqrt(network.mass)[None, :]


def _without_symmetry(count: int, spread: float, quick: bool) -> Problem:
    """What a stage with unequal rollers takes: all degrees of freedom at once."""
    batches = (1, 100) if quick else (1, 100, 10_000)
    numbers = random_systems(count, batches[-1], spread)
    unflatten, stage = unflattened(count), NumPyStage(count)
    compared = 2 if quick else 8

    def jacobi(row):
        return jnp.sort(singular_values(_rooted(unflatten, row))[0]) / (2 * jnp.pi)

    def lapack(row):
        # Vectors too, as the derivatives of modes need them.
        values, vectors = jnp.linalg.svd(_rooted(unflatten, row), full_matrices=False)[1:]
        return values[::-1] / (2 * jnp.pi) + 0 * vectors[0]

    decades = "" if spread < 1 else f", numbers spread over ±{spread:g} decades"
    return Problem(
        name=f"dense_{count}" + ("" if spread < 1 else "_extreme"),
        title=f"Natural frequencies without symmetry, N = {count}{decades}",
        instance="design",
        methods=[
            _vmapped("Jacobi", _FREQUENCIES, jacobi, numbers, batches),
            _vmapped("LAPACK, singular values", _FREQUENCIES, lapack, numbers, batches),
            _vmapped("LAPACK, eigenvalues", _FREQUENCIES, dense_solver(count), numbers, batches),
            _rival("NumPy eigvalsh, batched", _FREQUENCIES, stage.by_numpy, numbers[:1_000]),
        ],
        reference=lambda: _reference(numbers[:compared], count),
        reference_note=f"mpmath eigsy of the full matrix at {DIGITS} digits, {compared} designs",
        baseline="LAPACK, singular values",
    )


def _reference(numbers: np.ndarray, count: int):
    rows = [frequencies(row, count)[0] for row in numbers]
    return {_FREQUENCIES: Reference(np.array(rows))}


def _vmapped(name, quantity, solve, numbers: np.ndarray, batches, dtype=jnp.float64) -> Method:
    """`solve` of one design's numbers, vmapped over batches of several sizes."""
    jitted = jax.jit(jax.vmap(solve))

    def prepare(batch):
        inputs = jnp.asarray(numbers[:batch], dtype)
        return Prepared(lambda: jitted(inputs), batch, lambda out: {quantity: out})

    return Method(name, prepare, batches, "designs at once")


def _chunked(name, quantity, solve, numbers: np.ndarray, chunks) -> Method:
    """The same over all designs, in chunks that stay in the cache."""

    def prepare(chunk):
        inputs = jnp.asarray(numbers)
        jitted = jax.jit(lambda rows: jax.lax.map(solve, rows, batch_size=chunk))
        return Prepared(lambda: jitted(inputs), len(numbers), lambda out: {quantity: out})

    return Method(name, prepare, chunks, f"{len(numbers)} designs in chunks of")


def _rival(name, quantity, solve, numbers: np.ndarray) -> Method:
    return rival(name, lambda: solve(numbers), len(numbers), lambda out: {quantity: out})


def _values_problem(
    name: str, title: str, count: int, spread: float, quick: bool, *, largest: int
) -> Problem:
    numbers = random_systems(count, largest, spread)
    unflatten, stage = unflattened(count), NumPyStage(count)
    compared = 2 if quick else 8
    dense_batch = 200 if quick else 1_000
    batches = [size for size in (1_000, 10_000, 100_000) if size <= largest]

    def reduced(row):
        return _reduced(unflatten(row))

    def lapack(row):
        return _blocks_by_lapack(unflatten(row))

    def of_all(name: str, solve, batches, dtype=jnp.float64) -> Method:
        return _vmapped(name, _FREQUENCIES, solve, numbers, batches, dtype)

    chunks = (500,) if quick else (1_000, 4_000)
    return Problem(
        name=name,
        title=title,
        instance="design",
        methods=[
            of_all("reduced", reduced, batches[-1:] if quick else batches),
            _chunked("reduced, lax.map", _FREQUENCIES, reduced, numbers, chunks),
            of_all("reduced, float32", reduced, batches[-1:], jnp.float32),
            of_all("reduced, LAPACK", lapack, [dense_batch]),
            of_all("dense, jax eigvalsh", dense_solver(count), [dense_batch]),
            _rival("SciPy eigh(K, M)", _FREQUENCIES, stage.by_scipy, numbers[: dense_batch // 4]),
            _rival("NumPy eigvalsh, batched", _FREQUENCIES, stage.by_numpy, numbers[:dense_batch]),
        ],
        reference=lambda: _reference(numbers[:compared], count),
        reference_note=f"mpmath eigsy of the full matrix at {DIGITS} digits, {compared} designs",
        baseline="SciPy eigh(K, M)",
    )


def _gradient_problem(count: int, quick: bool) -> Problem:
    numbers = random_systems(count, 2_000 if quick else 10_000, 0.1)
    unflatten, stage = unflattened(count), NumPyStage(count)
    dense_batch, compared = (100, 2) if quick else (500, 8)

    def reference():
        rows = [frequencies(row, count, elasticities=True)[1] for row in numbers[:compared]]
        # Elasticities are shares of one (of a half, for stiffnesses): judged absolutely.
        return {_ELASTICITIES: Reference(np.array(rows), scale=1.0)}

    def elasticities(solver):
        def logarithms(logs):
            return jnp.log(solver(jnp.exp(logs)))

        return lambda row: jax.jacfwd(logarithms)(jnp.log(row))

    def reduced(numbers):
        return _reduced(unflatten(numbers))

    return Problem(
        name="derivatives",
        title=f"Derivatives of all frequencies by all {NUMBERS} numbers, N = {count}",
        instance="design",
        methods=[
            _vmapped("reduced", _ELASTICITIES, elasticities(reduced), numbers, [len(numbers)]),
            _chunked("reduced, lax.map", _ELASTICITIES, elasticities(reduced), numbers, (1_000,)),
            _vmapped(
                "dense, jax eigvalsh",
                _ELASTICITIES,
                elasticities(dense_solver(count)),
                numbers,
                [dense_batch],
            ),
            _rival(
                "SciPy eigh, analytic", _ELASTICITIES, stage.elasticities, numbers[:dense_batch]
            ),
            _rival(
                "SciPy eigh, central differences",
                _ELASTICITIES,
                stage.differences,
                numbers[: dense_batch // 10],
            ),
        ],
        reference=reference,
        reference_note=f"mpmath eigenvectors at {DIGITS} digits, {compared} designs",
        baseline="SciPy eigh, analytic",
    )


def case(quick: bool) -> Case:
    """The case of this module; most of a quick run is compilation, so it has fewer problems."""
    largest = 2_000 if quick else 100_000
    problems = [
        _values_problem(
            f"rollers_{count}",
            f"Natural frequencies, N = {count}",
            count,
            0.1,
            quick,
            largest=largest,
        )
        for count in ((7,) if quick else (3, 7, 12, 30))
    ]
    if not quick:
        title = "Natural frequencies, N = 7, numbers spread over ±6 decades"
        problems.append(_values_problem("extreme", title, 7, 6.0, quick, largest=10_000))
        problems += [_without_symmetry(n, 0.1, quick) for n in (3, 7, 12, 20)]
        problems.append(_without_symmetry(7, 3.0, quick))
    else:
        problems.append(_without_symmetry(7, 0.1, quick))
    problems.append(_gradient_problem(7, quick))
    return Case(
        "frequencies",
        "Natural frequencies by symmetry against dense eigensolvers, and their derivatives",
        problems,
    )
