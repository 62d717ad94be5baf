"""What could keep the static capacity independent of the lead: hypotheses, and their errors."""

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np
from jaxtyping import Bool, Float

from ...catalogue_sizes import FITTED, SizeRules
from ...mechanism import FatigueRule
from ._comparison import CatalogueComparison
from ._fit import CapacityModel, fit_numbers


@dataclasses.dataclass(frozen=True)
class Hypothesis:
    """Capacities by one hypothesis, its numbers fitted to one half of the diameters."""

    name: str
    #: Rules with the fitted numbers; `None` where the capacities are in closed form.
    rules: SizeRules | None
    #: Capacities of all sizes [kN].
    static: Float[np.ndarray, " sizes"]
    dynamic: Float[np.ndarray, " sizes"]


def _rules(ends: float, least: float, *ratios: float) -> SizeRules:
    """Ends [mm] and least share of the thread; ratios of the profile for fine and coarse pitches.

    Without ratios the profile is centred on the roller's axis; one is for all pitches.
    """
    fine, coarse = (ratios[0], ratios[-1]) if ratios else (None, None)
    return dataclasses.replace(
        FITTED,
        thread_ends=1e-3 * ends,
        least_thread=least,
        profile_ratio=fine,
        coarse_profile_ratio=coarse,
    )


def _centred_share(numbers: np.ndarray) -> SizeRules:
    return _rules(np.inf, *map(float, numbers))


def _centred_ends(numbers: np.ndarray) -> SizeRules:
    return _rules(*map(float, numbers), FITTED.least_thread)


def _pitch_share(numbers: np.ndarray) -> SizeRules:
    return _rules(np.inf, 0.6, *map(float, numbers))


def _pitch_ends(numbers: np.ndarray) -> SizeRules:
    ends, *ratios = map(float, numbers)
    return _rules(ends, FITTED.least_thread, *ratios)


_CENTRED, _BY_PITCH = "profile centred on the roller's axis", "profile in proportion to the pitch"
_SHARE, _ENDS = "thread a share of the nut", "ends without thread"
_COARSE = "another proportion for coarse pitches"
_Rules = Callable[[np.ndarray], SizeRules]
#: Name, rules, start of the numbers that are fitted, theory of the dynamic capacity.
_BY_RULES: tuple[tuple[str, _Rules, tuple[float, ...], FatigueRule], ...] = (
    (f"{_CENTRED}, {_SHARE}", _centred_share, (0.6,), "lundberg_palmgren"),
    (f"{_CENTRED}, {_ENDS}", _centred_ends, (22.0,), "lundberg_palmgren"),
    (f"{_BY_PITCH}, {_SHARE}", _pitch_share, (4.0,), "equivalent_balls"),
    (f"{_BY_PITCH}, {_ENDS}", _pitch_ends, (22.0, 4.0), "lundberg_palmgren"),
    (f"{_BY_PITCH}, {_ENDS}", _pitch_ends, (22.0, 4.0), "equivalent_balls"),
    (f"{_BY_PITCH}, {_ENDS}, {_COARSE}", _pitch_ends, (22.0, 4.0, 5.0), "equivalent_balls"),
)


def hypotheses(
    comparison: CatalogueComparison, where: Bool[np.ndarray, " sizes"]
) -> Iterator[Hypothesis]:
    """All hypotheses, with their numbers fitted to some sizes.

    The last one is that of a flank in line contact, by the rules of roller bearings: its load is
    the flank's whole length times curvature, and no pitch is in it.

    **Arguments:**

    - `comparison`: of sizes that have both capacities.
    - `where`: the sizes that count for the fit.
    """
    theories: tuple[FatigueRule, ...] = ("lundberg_palmgren", "equivalent_balls")
    models = {theory: CapacityModel(comparison, theory) for theory in theories}
    for name, rules_of, start, theory in _BY_RULES:
        model = models[theory]
        rules = model.fitted(where, rules_of, start)
        words = theory.replace("_", " ")
        yield Hypothesis(f"{name}; {words}", rules, *model.capacities(rules))
    yield _line_contact(comparison, where)


def _line_contact(comparison: CatalogueComparison, where: np.ndarray) -> Hypothesis:
    r"""$C_{0a} \propto N l / \Sigma\kappa$, $C_a \propto N^{3/4} l^{7/9} D^{29/27}$ (ISO 281)."""
    length, diameter, starts = (
        np.array([row[name] for row in comparison.rows])
        for name in ("nut_length_mm", "nominal_diameter_mm", "starts")
    )
    roller = diameter / (starts - 2)
    # Pitch circles of 3 (n − 1) rollers fit; one is left out.
    count = 3 * (starts - 1) - 1
    printed = [comparison.printed[name] for name in ("static_capacity_kn", "dynamic_capacity_kn")]

    def scaled(values: np.ndarray, known: np.ndarray) -> np.ndarray:
        return values * np.exp(np.mean(np.log(known / values)[where]))

    def static(ends: float) -> np.ndarray:
        return scaled(count * (length - ends) / (1 / roller + 1 / diameter), printed[0])

    def residuals(logarithms: np.ndarray) -> np.ndarray:
        return np.log(static(float(np.exp(logarithms[0]))) / printed[0])[where]

    ends = float(fit_numbers(residuals, (22.0,))[0])
    dynamic = count**0.75 * (length - ends) ** (7 / 9) * roller ** (29 / 27)
    return Hypothesis(
        f"flank in line contact, {_ENDS}; roller bearings",
        None,
        static(ends),
        scaled(dynamic, printed[1]),
    )
