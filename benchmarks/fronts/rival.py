"""NSGA-II of pymoo on the same objectives, variables, constraints and margins of `check`."""

import math
import time
from importlib import import_module
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from prsm_jax.mechanism import DesignProblem, Mechanism
from prsm_jax.optimisation.front import senses
from prsm_jax.optimisation.search import Evaluator
from prsm_jax.optimisation.search._outputs import outputs_at

#: Objectives and violation of a design that fails.
_FAILED = 1e3


def _batched(evaluator: Evaluator, places: list[int]):
    """Values of many designs by one program, and which are usable; `places` of the objectives."""

    @eqx.filter_jit
    def run(given, positions):
        return jax.vmap(lambda position: outputs_at(given, position))(positions)

    def call(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        arrays, valid = run(evaluator.program_inputs, jnp.asarray(positions))
        count = len(positions)
        values = np.concatenate([np.asarray(a, float).reshape(count, -1) for a in arrays], axis=1)
        rows = evaluator.rows
        used = np.append(rows.index, places)
        return values, np.asarray(valid) & np.isfinite(values[:, used]).all(axis=1)

    return call


def nsga2(
    mechanism: Mechanism, problem: DesignProblem, population: int, evaluations: int, seed: int
) -> tuple[np.ndarray, int, float]:
    """The final feasible designs of NSGA-II with pymoo's default operators.

    **Arguments:**

    - `mechanism`, `problem`: as for `pareto`.
    - `population`: designs in a generation.
    - `evaluations`: about so many designs.
    - `seed`: of the random numbers.

    **Returns:** objectives to be minimised (designs × objectives), designs evaluated, and run time
    without compilation [s].
    """
    # By name, so that types are checked where pymoo is not installed.
    algorithm: Any = import_module("pymoo.algorithms.moo.nsga2").NSGA2
    problem_class: Any = import_module("pymoo.core.problem").Problem
    minimize = import_module("pymoo.optimize").minimize

    evaluator = Evaluator(mechanism, problem, None, None)
    rows, signs = evaluator.rows, senses(problem.objectives)
    # At one operating point an objective is one of the evaluated numbers.
    places = [int(np.argmax(rows.mean_of(one))) for one in problem.objectives]
    call = _batched(evaluator, places)
    size = np.maximum(
        np.where(np.isfinite(rows.lower), np.abs(rows.lower), 0.0),
        np.where(np.isfinite(rows.upper), np.abs(rows.upper), 0.0),
    )
    size = np.where(size > 0, size, 1.0)
    has_lower, has_upper = np.isfinite(rows.lower), np.isfinite(rows.upper)
    # Compiled before the clock starts.
    call(np.full((population, evaluator.variables), 0.5))
    counted = [0]

    class Design(problem_class):
        def __init__(self):
            super().__init__(
                n_var=evaluator.variables,
                n_obj=len(places),
                n_ieq_constr=int(has_lower.sum() + has_upper.sum()),
                xl=np.zeros(evaluator.variables),
                xu=np.ones(evaluator.variables),
            )

        def _evaluate(self, x: Any, out: Any, *_args: Any, **_kwargs: Any) -> None:
            filled = np.concatenate([x, np.full((population - len(x), x.shape[1]), 0.5)])
            values, good = call(filled)
            values, good = values[: len(x)], good[: len(x)]
            counted[0] += len(x)
            numbers = values[:, rows.index]
            broken = np.concatenate(
                [
                    ((rows.lower - numbers) / size)[:, has_lower],
                    ((numbers - rows.upper) / size)[:, has_upper],
                ],
                axis=1,
            )
            out["F"] = np.where(good[:, None], signs * values[:, places], _FAILED)
            out["G"] = np.where(good[:, None], broken, _FAILED)

    begin = time.perf_counter()
    # At least as many designs as asked for: the rival has no fewer than its share.
    generations = math.ceil(evaluations / population)
    found = minimize(Design(), algorithm(pop_size=population), ("n_gen", generations), seed=seed)
    seconds = time.perf_counter() - begin
    objectives = np.empty((0, len(places))) if found.F is None else np.atleast_2d(found.F)
    return objectives, counted[0], seconds
