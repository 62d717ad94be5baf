"""A search of your own: differential evolution over all designs, finished by SLSQP."""

from dataclasses import dataclass

import numpy as np

from prsm_jax.optimisation import SearchMethod, SearchResult, Slsqp


@dataclass(frozen=True)
class DifferentialEvolution(SearchMethod):
    """Storn and Price 1997, with a penalty for limits; needs no derivatives and no good start."""

    accepts_constraints = True
    designs: int = 20
    generations: int = 30
    seed: int = 0

    def search(self, functions, start, tolerance, report):
        lower, upper = functions.limits

        def penalised(position):
            values = functions.constraint_values(position)
            beyond = np.maximum(np.maximum(lower - values, values - upper), 0.0)
            return functions.cost(position) + 10 * np.sum(beyond)

        random = np.random.default_rng(self.seed)
        designs = random.random((self.designs, len(start)))
        designs[0] = start
        costs = np.array([penalised(design) for design in designs])
        for _ in range(self.generations):
            for i, design in enumerate(designs):
                first, second, third = designs[random.choice(self.designs, 3, replace=False)]
                mutant = np.clip(first + 0.8 * (second - third), 0.0, 1.0)
                trial = np.where(random.random(len(start)) < 0.9, mutant, design)
                cost = penalised(trial)
                if cost < costs[i]:
                    designs[i], costs[i] = trial, cost
            report(designs[np.argmin(costs)])
        end = Slsqp().search(functions, designs[np.argmin(costs)], tolerance, report)
        return SearchResult(end.position, end.message, self.generations + end.iterations)
