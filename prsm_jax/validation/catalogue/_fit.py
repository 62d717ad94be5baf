"""The five numbers of the rules that no row gives, fitted to one half of the diameters."""

import dataclasses
from collections.abc import Callable, Sequence

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool

from ...catalogue_sizes import FITTED, SizeRules
from ...mechanism import FatigueRule, Mechanism
from ._comparison import CatalogueComparison
from ._predicted import batch_of, evaluated, mechanism_of

_STATIC, _DYNAMIC = "static_capacity_kn", "dynamic_capacity_kn"
_ROLLERS = "rollers_inertia_at_screw_kg_mm2"
#: Largest rounding of a printed inertia from which a length is fitted, relative.
_ROUNDING = 0.05


class CapacityModel:
    """Capacities of all sizes of a comparison as functions of the rules' numbers."""

    def __init__(self, comparison: CatalogueComparison, fatigue_rule: FatigueRule):
        self.comparison = comparison
        mechanisms = [mechanism_of(row) for row in comparison.rows]
        self._batch = batch_of([_rated(one, fatigue_rule) for one in mechanisms])
        self._pitch = np.array([row["lead_mm"] / row["starts"] * 1e-3 for row in comparison.rows])
        self._length = [row["nut_length_mm"] * 1e-3 for row in comparison.rows]
        threads = [one.stages[0].thread for one in mechanisms]
        #: Profile radii that are centred on the axes of the rollers [m].
        self.centred = np.array(
            [float(one.roller_radius / jnp.sin(one.flank_angle)) for one in threads]
        )

    def capacities(self, rules: SizeRules) -> tuple[np.ndarray, np.ndarray]:
        """Static and dynamic capacities of all sizes [kN].

        **Arguments:**

        - `rules`: their profile ratio, lengths of thread and material factor.
        """
        by_pitch = [rules.profile_radius(float(one)) for one in self._pitch]
        radii = np.array(
            [c if one is None else one for one, c in zip(by_pitch, self.centred, strict=True)]
        )
        threads = np.array([rules.threaded_length(one) for one in self._length]) / self._pitch
        # The program of all columns is compiled already; their evaluation takes milliseconds.
        batch = eqx.tree_at(
            lambda m: (m.stages[0].thread.roller_profile_radius, m.stages[0].engaged_threads),
            self._batch,
            (jnp.asarray(radii), jnp.asarray(threads)),
        )
        values = evaluated(batch)
        return np.asarray(values[_STATIC]), np.asarray(values[_DYNAMIC]) * rules.material_factor

    def fitted(
        self,
        where: Bool[np.ndarray, " sizes"],
        rules_of: Callable[[np.ndarray], SizeRules],
        start: Sequence[float],
    ) -> SizeRules:
        """Rules fitted to some sizes: numbers to the static, material factor to the dynamic ones.

        **Arguments:**

        - `where`: the sizes that count.
        - `rules_of`: rules from the numbers, all above 0, that are fitted.
        - `start`: the numbers to start from.
        """
        static, dynamic = (np.log(self.comparison.printed[name]) for name in (_STATIC, _DYNAMIC))

        def residuals(logarithms: np.ndarray) -> np.ndarray:
            computed, _ = self.capacities(rules_of(np.exp(logarithms)))
            return (np.log(computed) - static)[where]

        rules = dataclasses.replace(rules_of(fit_numbers(residuals, start)), material_factor=1.0)
        missing = dynamic - np.log(self.capacities(rules)[1])
        return dataclasses.replace(rules, material_factor=float(np.exp(missing[where].mean())))


def _rated(mechanism: Mechanism, fatigue_rule: FatigueRule) -> Mechanism:
    """The mechanism with a fatigue rule and a material factor of 1."""
    (stage,) = mechanism.stages
    assert stage.strength is not None
    strength = dataclasses.replace(
        stage.strength, fatigue_rule=fatigue_rule, material_factor=jnp.asarray(1.0)
    )
    return dataclasses.replace(mechanism, stages=(dataclasses.replace(stage, strength=strength),))


def fit_numbers(
    residuals: Callable[[np.ndarray], np.ndarray], start: Sequence[float]
) -> np.ndarray:
    """Numbers with the least squares of differences of logarithms.

    Relative errors of both signs weigh the same, and the numbers stay above 0.

    **Arguments:**

    - `residuals`: as a function of the logarithms of the numbers.
    - `start`: the numbers to start from.
    """
    from scipy.optimize import least_squares

    found = least_squares(residuals, np.log(np.asarray(start)), diff_step=1e-4)
    return np.exp(found.x)


def fitted_rules(comparison: CatalogueComparison, where: Bool[np.ndarray, " sizes"]) -> SizeRules:
    """The rules with their six numbers fitted to some sizes.

    Profile ratios and ends of the thread are fitted to the static capacity, the material factor to
    the dynamic one; the ends of the roller to the rollers' inertia, which is in proportion to their
    length; the friction to both efficiencies, by (1 − η)/(1 + η) at 45°.

    **Arguments:**

    - `comparison`: of sizes that have all columns.
    - `where`: the sizes that count.
    """

    def rules_of(numbers: np.ndarray) -> SizeRules:
        fine, coarse, ends = map(float, numbers)
        return dataclasses.replace(
            FITTED,
            profile_ratio=fine,
            coarse_profile_ratio=coarse,
            thread_ends=1e-3 * ends,
        )

    model = CapacityModel(comparison, FITTED.fatigue_rule)
    return dataclasses.replace(
        model.fitted(where, rules_of, (4.0, 5.0, 22.0)),
        roller_ends=_roller_ends(comparison, where),
        friction_by_starts=_friction_by_starts(comparison, where),
    )


def _roller_ends(comparison: CatalogueComparison, where: np.ndarray) -> float:
    lengths = [row["nut_length_mm"] * 1e-3 for row in comparison.rows]
    own = np.array([FITTED.roller_length(one) for one in lengths])
    # A printed 0.2 says too little about a length.
    exact = comparison.half_units[_ROLLERS] < _ROUNDING * comparison.printed[_ROLLERS]
    where = where & exact
    unit = (comparison.computed[_ROLLERS] / own)[where]
    printed = comparison.printed[_ROLLERS][where]

    def residuals(logarithms: np.ndarray) -> np.ndarray:
        rules = dataclasses.replace(FITTED, roller_ends=1e-3 * float(np.exp(logarithms[0])))
        rolled = np.array([rules.roller_length(one) for one in lengths])[where]
        return np.log(unit * rolled / printed)

    return 1e-3 * float(fit_numbers(residuals, (13.0,))[0])


def _friction_by_starts(comparison: CatalogueComparison, where: np.ndarray) -> float:
    starts = np.array([row["starts"] for row in comparison.rows])[where]
    efficiency = np.mean(
        [
            comparison.printed[name][where]
            for name in ("efficiency_screw_drives", "efficiency_load_drives")
        ],
        axis=0,
    )
    friction = (1 - efficiency) / (1 + efficiency)
    return float(np.sum(friction * (starts - 1)) / np.sum((starts - 1) ** 2))
