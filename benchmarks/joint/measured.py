"""Values, Jacobians and Hessians of quantities of one example, for a batch of its designs."""

import random
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm
from prsm_jax.mechanism import get_parameter, set_parameters

VARIABLES = ("lead", "contact_angle", "roller_radius")
#: Those of Hessians.
FOUR = (*VARIABLES, "roller_profile_radius")
#: Steps of central differences, relative to each number; the error of the values is 1e-13 or so.
_STEP = 1e-5
#: Steps of the reference, of sixth order by extrapolation.
_WIDE = 4e-3


class Sample(NamedTuple):
    """A compiled program and what it took."""

    compile_seconds: float
    compile_processor_seconds: float
    #: Of the compiled program; the same on every machine with the same XLA.
    instructions: int
    #: Best time of a design [s].
    seconds: float
    found: Any


def quantity_names(example: str) -> tuple[str, ...]:
    """Names of the quantities that an example has, without those that are not real numbers."""
    mechanism = prsm.load(example)
    found = prsm.compute(mechanism, prsm.quantities.available_quantities(mechanism))
    real = [name for name, value in found.items() if jnp.issubdtype(value.dtype, jnp.floating)]
    return tuple(sorted(real))


def random_subsets(names: Sequence[str], count: int, seed: int) -> list[tuple[str, ...]]:
    """Different subsets of two to six names."""
    generator = random.Random(seed)
    found: dict[tuple[str, ...], None] = {}
    while len(found) < count:
        found[tuple(sorted(generator.sample(names, generator.randint(2, 6))))] = None
    return list(found)


def of_numbers(
    example: str, names: Sequence[str], variables: Sequence[str] = VARIABLES
) -> tuple[Callable[[jax.Array], dict[str, jax.Array]], np.ndarray]:
    """Quantities as a function of the variables, and the variables of the example."""
    mechanism = prsm.load(example)

    def evaluate(numbers):
        moved = set_parameters(mechanism, dict(zip(variables, numbers, strict=True)))
        return prsm.compute(moved, list(names))

    return evaluate, np.array([float(get_parameter(mechanism, name)) for name in variables])


def results_of_verbs(example: str) -> tuple[Callable[[jax.Array], jax.Array], np.ndarray]:
    """Efficiency, contact pressures and frequencies from three verbs, concatenated; and where."""
    mechanism = prsm.load(example)

    def evaluate(numbers):
        moved = set_parameters(mechanism, dict(zip(VARIABLES, numbers, strict=True)))
        contacts = prsm.thread_contacts(moved)
        sides = [side for stage in contacts for side in (stage.screw, stage.nut)]
        return jnp.concatenate([
            prsm.steady_state(moved).efficiency[None],
            jnp.stack([side.hertz.max_pressure for side in sides]),
            prsm.modal(moved).frequencies,
        ])  # fmt: skip

    return evaluate, np.array([float(get_parameter(mechanism, name)) for name in VARIABLES])


def designs_around(centre: np.ndarray, count: int) -> jax.Array:
    """Designs within a thousandth of the example."""
    generator = np.random.default_rng(15)
    return jnp.asarray(centre * (1 + 1e-3 * generator.uniform(-1, 1, (count, centre.size))))


def as_one(evaluate: Callable[[jax.Array], Mapping[str, jax.Array]]):
    """The quantities as one array, which is what a user who concatenates has."""
    return lambda numbers: jnp.concatenate([jnp.ravel(v) for v in evaluate(numbers).values()])


def with_value(function: Callable[[jax.Array], Any]) -> Callable[[jax.Array], tuple[Any, Any]]:
    """Jacobian in forward mode, and the value, which a user wants as well."""

    def both(numbers):
        value = function(numbers)
        return value, value

    return jax.jacfwd(both, has_aux=True)


def central_differences(function: Callable[[jax.Array], jax.Array], size: int):
    """Jacobian by differences of the values at two points for each number, in one batch."""

    def jacobian(numbers):
        steps = _STEP * jnp.diag(numbers)
        values = jax.vmap(function)(jnp.concatenate([numbers[None] + steps, numbers[None] - steps]))
        return (values[:size] - values[size:]).T / (2 * _STEP * numbers)[None]

    return jacobian


def reference_jacobian(function: Callable[[jax.Array], jax.Array], centre: jax.Array) -> np.ndarray:
    """Jacobian at one design by differences of sixth order, in one compiled program."""
    size = centre.size
    factors = _WIDE * np.array([1.0, 0.5, 0.25])
    steps = jnp.concatenate([factor * jnp.diag(centre) for factor in factors])
    points = jnp.concatenate([centre[None] + steps, centre[None] - steps])
    values = np.asarray(jax.jit(jax.vmap(function))(points))
    differences = (values[: 3 * size] - values[3 * size :]).reshape(3, size, -1)
    slopes = differences / (2 * factors[:, None, None] * np.asarray(centre)[None, :, None])
    first = slopes[1:] + (slopes[1:] - slopes[:-1]) / 3
    return (first[1] + (first[1] - first[0]) / 15).T


def timed(
    functions: Mapping[str, Callable[..., Any]], designs: jax.Array, seconds: float
) -> dict[str, Sample]:
    """Compile each function for a batch and sample them in turn; times are those of a design."""
    compiled, compiling, instructions = {}, {}, {}
    for name, function in functions.items():
        lowered = jax.jit(jax.vmap(function)).lower(designs)
        wall, processor = time.perf_counter(), time.process_time()
        compiled[name] = lowered.compile()
        compiling[name] = time.perf_counter() - wall, time.process_time() - processor
        instructions[name] = compiled[name].as_text().count(" = ")
    found = {name: jax.block_until_ready(run(designs)) for name, run in compiled.items()}
    best = dict.fromkeys(compiled, np.inf)
    begin = time.perf_counter()
    while True:
        for name, run in compiled.items():
            start = time.perf_counter()
            jax.block_until_ready(run(designs))
            best[name] = min(best[name], time.perf_counter() - start)
        if time.perf_counter() - begin > seconds:
            break
    return {
        name: Sample(wall, processor, instructions[name], best[name] / len(designs), found[name])
        for name, (wall, processor) in compiling.items()
    }


def error_of(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest error, each row relative to its largest entry as an elasticity."""
    scale = np.max(np.abs(expected), axis=-1, keepdims=True)
    return float(np.max(np.abs(found - expected) / np.where(scale > 0, scale, 1.0)))
