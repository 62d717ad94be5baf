"""What grows: the tasks, their sizes, and for each size a check against something known."""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import prsm_jax as prsm
from prsm_jax.mechanism import set_parameters
from prsm_jax.sweeps import map_in_chunks

from ..method_options import taken as options_taken
from ..references.transients.designs_of_two_stages import base
from .sharing import sharing


@dataclass(frozen=True)
class Work:
    """One size of a task.

    - `function`: what does it, compiled by `eqx.filter_jit`, and its `arguments`.
    - `error`: the largest relative error of what the function gave, by an independent way.
    - `steps`: how many steps that took, where there are steps.
    """

    function: Any
    arguments: tuple[Any, ...]
    error: Callable[[Any], float]
    steps: Callable[[Any], int] | None = None


@dataclass(frozen=True)
class Task:
    """Something that is asked in several sizes.

    - `unit`: what is counted.
    - `build`: the work of one size.
    - `sizes`: from small to large; those of `--quick` and `--smoke` are the first of them.
    - `check`: what the error is measured against.
    - `expected`: power of the size with which the number of operations grows.
    - `why`: where that power comes from.
    """

    title: str
    unit: str
    build: Callable[[int], Work]
    sizes: tuple[int, ...]
    check: str
    expected: float
    why: str


#: Up, a plateau, down, and a dwell: 0.36 s, and in it samples that no bend of the speed hits.
_CYCLE = prsm.scenario.TrapezoidalProfile(*map(jnp.asarray, (200.0, 0.03, 0.24, 0.03, 0.06)))
_PERIOD, _SAMPLES = 0.36, 13
#: A pattern of speeds and loads, one point a second, that a recorded day repeats [s].
_PATTERN = 600


def _apart(found: Any, period: np.ndarray, count: int) -> float:
    """Largest difference between every period and one alone, over the largest value.

    The first sample of a stroke stands where the speed bends, on either side of it.
    """
    rows = np.asarray(found)[: count * len(period)].reshape(count, len(period))
    between = np.arange(len(period)) % _SAMPLES != 0
    return float(np.max(np.abs(rows - period)[:, between]) / np.max(np.abs(period)))


def _reversals(method: Any, steps: int, width: float) -> Callable[[int], Work]:
    """Periods of a reversing stroke; each takes at most `steps`, friction reverses over `width`."""

    def build(size: int) -> Work:
        two = base(width)

        def scenario(strokes: int) -> prsm.Scenario:
            profile = prsm.scenario.SequenceProfile((_CYCLE,), repeats=strokes, reversing=True)
            duration = jnp.asarray(strokes * _PERIOD)
            return prsm.Scenario(
                profile, jnp.asarray(7e3), duration, samples=strokes * _SAMPLES + 1
            )

        def run(given: prsm.Scenario, allowed: int):
            found = prsm.simulate(
                two,
                given,
                method=method,
                gradient="forward",
                throw=False,
                **options_taken(method, max_steps=allowed),
            )
            return found.drive_torque, found.solver.code, found.solver.steps

        solve: Any = eqx.filter_jit(run)
        long = scenario(size)

        def error(found) -> float:
            # Forth and back once, and once more: the first begins at rest.
            short, code, _ = solve(scenario(4), 4 * steps)
            pair = np.asarray(short)[2 * _SAMPLES : 4 * _SAMPLES]
            if int(code) or int(found[1]):
                return np.nan
            return _apart(found[0][2 * _SAMPLES :], pair, size // 2 - 1)

        taken = (lambda found: int(found[2])) if method == "rosenbrock" else None
        return Work(solve, (long, size * steps), error, taken)

    return build


def _day(hours: int) -> Work:
    """A recorded mission: tables of speed and load with a point every second."""
    two = prsm.load("li2020_two_stage")
    random = np.random.default_rng(24)
    patterns = 6 * hours
    speed = random.uniform(-150.0, 150.0, _PATTERN)
    load = random.uniform(2e3, 8e3, _PATTERN)

    def scenario(times: int) -> prsm.Scenario:
        seconds = jnp.arange(times * _PATTERN + 1.0)

        def repeated(values: np.ndarray) -> prsm.scenario.TableProfile:
            closed = np.append(np.tile(values, times), values[0])
            return prsm.scenario.TableProfile(seconds, jnp.asarray(closed), "linear")

        duration = jnp.asarray(float(times * _PATTERN))
        samples = 3 * times * _PATTERN + 1
        return prsm.Scenario(repeated(speed), repeated(load), duration, samples=samples)

    def run(given: prsm.Scenario):
        found = prsm.simulate(two, given, method="quasi_steady", throw=False)
        return found.drive_torque, found.solver.code

    solve: Any = eqx.filter_jit(run)
    long = scenario(patterns)

    def error(found) -> float:
        short, code = solve(scenario(1))
        period = np.asarray(short)[:-1].reshape(_PATTERN, 3)
        if int(code) or int(found[1]):
            return np.nan
        rows = np.asarray(found[0])[:-1].reshape(patterns, _PATTERN, 3)
        # Every third sample stands where the tables bend.
        difference = np.abs(rows - period)[:, :, 1:]
        return float(np.max(difference) / np.max(np.abs(period)))

    return Work(solve, (long,), error)


_VARIABLES = ("lead", "contact_angle", "roller_radius")
_QUANTITIES = ("efficiency", "max_pressure", "mass")


def _gradients(derivative: Callable[..., Any], size: int) -> Work:
    """Three quantities of many designs and their derivatives by three dimensions."""
    actuator = prsm.load("actuator")
    start = np.array([float(np.ravel(prsm.get_parameter(actuator, n))[0]) for n in _VARIABLES])
    factors = np.random.default_rng(5).uniform(0.95, 1.05, (3, size))
    columns = [jnp.asarray(column) for column in start[:, None] * factors]

    def values(numbers):
        moved = set_parameters(actuator, dict(zip(_VARIABLES, numbers, strict=True)))
        found = prsm.compute(moved, list(_QUANTITIES))
        return [jnp.ravel(found[name])[0] for name in _QUANTITIES]

    def slopes(numbers):
        return values(numbers), derivative(values)(numbers)

    solve: Any = eqx.filter_jit(lambda designs: map_in_chunks(slopes, designs, chunk=1000))
    checked = min(size, 20)
    plain: Any = jax.jit(jax.vmap(values))

    def error(found) -> float:
        few = [column[:checked] for column in columns]
        worst = 0.0
        for index, column in enumerate(few):
            ends = []
            for part in (1e-3, -1e-3, 2e-3, -2e-3):
                moved = [*few[:index], column * (1 + part), *few[index + 1 :]]
                ends.append(np.asarray(plain(moved)))
            by_difference = (8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / 12e-3
            ours = np.asarray([row[index][:checked] * column for row in found[1]])
            scale = np.abs(np.asarray(plain(few)))
            worst = max(worst, float(np.max(np.abs(ours - by_difference) / scale)))
        return worst

    return Work(solve, (columns,), error)


def _sharing(threads: int, rollers: int) -> Work:
    solve, arguments, error = sharing(threads, rollers)
    return Work(solve, arguments, error, lambda found: int(found[3]))


_SAMPLES_ALONE = "each sample is balanced by itself, 1,024 at a time"
_IN_CHUNKS = "each design is computed by itself, 1,000 at a time"
_BY_DIFFERENCES = "extrapolated central differences, 20 designs"
_BALANCE = "balance and compatibility of all threads in NumPy"


TASKS = {
    "reversals_balance": Task(
        "reversals, quasi-steady balance",
        "reversal",
        _reversals("quasi_steady", 1, 0.0),
        (100, 1000, 10_000),
        "one period computed alone",
        1.0,
        f"{_SAMPLES_ALONE}; a repeated sequence is found by one division",
    ),
    "reversals_integrated": Task(
        "reversals, RODASP, friction regularised over 1 mm/s",
        "reversal",
        _reversals("rosenbrock", 500, 1e-3),
        (100, 1000, 10_000),
        "one period computed alone",
        1.0,
        "a reversal takes as many steps as the one before; a step looks at two breaks. Operations "
        "are counted with one step, so they are those of the samples",
    ),
    "mission": Task(
        "recorded mission, a point every second",
        "hour",
        _day,
        (1, 3, 8, 24),
        "its pattern of ten minutes by itself",
        1.0,
        f"{_SAMPLES_ALONE}; a sample looks for its place in the tables by halving, log size",
    ),
    "gradients_forward": Task(
        "designs with nine derivatives each, forward",
        "design",
        functools.partial(_gradients, jax.jacfwd),
        (1000, 10_000, 100_000),
        _BY_DIFFERENCES,
        1.0,
        _IN_CHUNKS,
    ),
    "gradients_reverse": Task(
        "designs with nine derivatives each, reverse",
        "design",
        functools.partial(_gradients, jax.jacrev),
        (10_000, 100_000),
        _BY_DIFFERENCES,
        1.0,
        f"{_IN_CHUNKS}; what reverse mode keeps is that of one thousand",
    ),
    "sharing_threads": Task(
        "load sharing, threads of 6 unlike rollers",
        "thread",
        lambda threads: _sharing(threads, 6),
        (10, 30, 100, 300),
        _BALANCE,
        1.0,
        "the equations of neighbouring threads alone are coupled, so elimination is one pass; "
        "Newton takes a few steps more where the load is less even",
    ),
    "sharing_rollers": Task(
        "load sharing, unlike rollers on 100 threads",
        "roller",
        lambda rollers: _sharing(100, rollers),
        (7, 15, 30, 60),
        _BALANCE,
        3.0,
        "screw and nut couple all rollers of a thread, so each thread is the elimination of a "
        "full matrix of as many rows as rollers, and one; few rollers are below the cube",
    ),
}
