"""NSGA-II of pymoo on the same problem: same variables, bounds, objective and limits."""

import time
from importlib import import_module
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from .problem import (
    FEWEST_ROLLERS,
    LIMITED,
    LOWER,
    OBJECTIVES,
    UPPER,
    Size,
    dimensioned,
    gains,
)
from .search import FEASIBLE
from .tasks import FAILED, measured_together, stacked

#: Designs in a generation.
POPULATION = 100
#: Efficiencies vary by a hundredth where other measures vary by their own size.
_WEIGHTS = np.array([100.0 if name.startswith("efficiency") else 1.0 for name in LIMITED])


class Rival(NamedTuple):
    """The best feasible design of NSGA-II."""

    objective: float
    #: Number of starts, and the variables of the problem.
    starts: int
    variables: np.ndarray
    evaluations: int
    seconds: float


def decoded(size: Size, rollers: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places among the numbers of starts, and variables with whole rollers, from the unit box."""
    index = np.minimum((x[:, 4] * len(size.choices)).astype(int), len(size.choices) - 1)
    lower, upper = np.array(LOWER), np.array(UPPER)
    most = rollers[index]
    count = FEWEST_ROLLERS + np.floor(x[:, 3] * (most - FEWEST_ROLLERS + 1))
    count = np.minimum(count, most)
    return index, np.column_stack([lower + (upper - lower) * x[:, :3], count])


def encoded_start() -> np.ndarray:
    """The size's own design: its own starts, and as many rollers as fit."""
    own = np.array([np.pi / 4, 1.0, 1.0])
    return np.append((own - np.array(LOWER)) / (np.array(UPPER) - np.array(LOWER)), [1.0, 0.0])


def nsga2(size: Size, limits: np.ndarray, evaluations: int, seed: int, *, several: bool) -> Rival:
    """The best feasible design that NSGA-II finds, with pymoo's default operators.

    Numbers of starts and rollers are rounded. The size's own design is in the first generation;
    the others of it are random.

    **Arguments:**

    - `size`: the size.
    - `limits`: `limits_of` its own design.
    - `evaluations`: about so many designs.
    - `seed`: of the random numbers.
    - `several`: whether the three gains are three objectives; otherwise the smallest is the only
      one.
    """
    # By name, so that types are checked where pymoo is not installed.
    algorithm: Any = import_module("pymoo.algorithms.moo.nsga2").NSGA2
    problem_class: Any = import_module("pymoo.core.problem").Problem
    minimize = import_module("pymoo.optimize").minimize

    mechanisms = [dimensioned(size, n) for n in size.choices]
    rollers = np.array([float(one.stages[0].roller_count) for one in mechanisms])
    # As many for each size, so that one program serves all.
    batch = stacked([*mechanisms, *mechanisms[:1] * (5 - len(mechanisms))])
    best: dict[str, Any] = {"objective": -np.inf}
    counted = [0]

    class Design(problem_class):
        def __init__(self) -> None:
            super().__init__(
                n_var=5,
                n_obj=len(OBJECTIVES) if several else 1,
                n_ieq_constr=len(LIMITED),
                xl=np.zeros(5),
                xu=np.ones(5),
            )

        def _evaluate(self, x: Any, out: Any, *_args: Any, **_kwargs: Any) -> None:
            filled = np.concatenate([x, np.full((POPULATION - len(x), x.shape[1]), 0.5)])
            index, variables = decoded(size, rollers, filled)
            values, good = measured_together(batch, jnp.asarray(index), jnp.asarray(variables))
            values, good = np.asarray(values)[: len(x)], np.asarray(good)[: len(x)]
            counted[0] += len(x)
            # A truncation load of 0 has no logarithm.
            good = good & (np.isfinite(values) & (values > 0)).all(axis=1)
            gain = np.full(values.shape, FAILED)
            gain[good] = gains(values[good], limits)
            least = np.min(gain[:, : len(OBJECTIVES)], axis=1)
            slack = gain[:, len(OBJECTIVES) :] + FEASIBLE
            kept = np.where(np.min(slack, axis=1) >= 0, least, -np.inf)
            place = int(np.argmax(kept))
            if kept[place] > best["objective"]:
                best.update(
                    objective=float(kept[place]),
                    starts=size.choices[index[place]],
                    variables=variables[place],
                )
            out["F"] = -gain[:, : len(OBJECTIVES)] if several else -least[:, None]
            out["G"] = -slack * _WEIGHTS

    first = np.random.default_rng(seed).random((POPULATION, 5))
    first[0] = encoded_start()
    begin = time.perf_counter()
    generations = max(1, round(evaluations / POPULATION))
    minimize(
        Design(), algorithm(pop_size=POPULATION, sampling=first), ("n_gen", generations), seed=seed
    )
    seconds = time.perf_counter() - begin
    if "starts" not in best:
        return Rival(-np.inf, 0, np.full(4, np.nan), counted[0], seconds)
    return Rival(best["objective"], best["starts"], best["variables"], counted[0], seconds)
