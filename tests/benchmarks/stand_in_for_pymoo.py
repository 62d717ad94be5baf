"""A search at random under the names of pymoo that the benchmarks use, as pymoo may be absent."""

import importlib.machinery
import sys
import types
from typing import Any, NamedTuple

import numpy as np


class Generation(NamedTuple):
    """Designs of one call, their objectives and their constraints, which hold from 0 down."""

    positions: np.ndarray
    objectives: np.ndarray
    constraints: np.ndarray


class _Problem:
    def __init__(self, **given: Any):
        self.given = given


class _Algorithm:
    def __init__(self, pop_size: int, sampling: np.ndarray | None = None):
        self.size, self.first = pop_size, sampling


def install(monkeypatch: Any) -> list[Generation]:
    """Put the modules in place for one test; the list gets every generation of later searches."""
    seen: list[Generation] = []

    def minimize(problem: Any, algorithm: _Algorithm, until: tuple[str, int], seed: int) -> Any:
        random, kept = np.random.default_rng(seed), []
        lower, upper = problem.given["xl"], problem.given["xu"]
        for index in range(until[1]):
            first = algorithm.first if index == 0 else None
            share = random.random((algorithm.size, problem.given["n_var"]))
            positions = lower + (upper - lower) * share if first is None else first
            out: dict[str, np.ndarray] = {}
            problem._evaluate(positions, out)
            assert out["F"].shape == (len(positions), problem.given["n_obj"])
            assert out["G"].shape == (len(positions), problem.given["n_ieq_constr"])
            seen.append(Generation(positions, out["F"], out["G"]))
            kept.append(out["F"][out["G"].max(axis=1) <= 0])
        found = np.concatenate(kept)
        return types.SimpleNamespace(F=found if len(found) else None)

    contents = {
        "pymoo.algorithms.moo.nsga2": {"NSGA2": _Algorithm},
        "pymoo.core.problem": {"Problem": _Problem},
        "pymoo.optimize": {"minimize": minimize},
        "pymoo": {},
    }
    for name, content in contents.items():
        module = types.ModuleType(name)
        module.__spec__ = importlib.machinery.ModuleSpec(name, None)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    return seen
