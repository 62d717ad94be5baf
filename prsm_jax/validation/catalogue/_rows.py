"""The catalogue as a source of `validate`: errors of the half not fitted, and trends."""

from collections.abc import Iterator

import numpy as np

from .._difference import differs, unexplained
from .._registry import rows_of
from .._row import Row, trend
from ._comparison import CatalogueComparison, compare_catalogue
from ._fit import CapacityModel, fitted_rules
from ._predicted import PREDICTED

#: Goal for the 90th percentile of capacities; that of the median is the column's.
_MOST = 0.35
_CAPACITIES = ("static_capacity_kn", "dynamic_capacity_kn")
_BODIES = (
    "nut_mass_kg",
    "nut_inertia_kg_mm2",
    "rollers_inertia_at_screw_kg_mm2",
    "shaft_mass_kg_per_m",
    "shaft_inertia_kg_mm2_per_m",
)
#: Allowed difference of the ratio of coarse to fine pitches.
_STEP = 0.05
#: Pitch up to which the capacities follow one law [mm]; the next printed pitch is 4 mm.
_FINE = 3.5


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _families(comparison: CatalogueComparison, fine: bool = True) -> Iterator[np.ndarray]:
    """Sizes of one diameter and number of starts, with fine or coarse pitches."""
    keys = [(row["nominal_diameter_mm"], row["starts"]) for row in comparison.rows]
    pitch = np.array([row["lead_mm"] / row["starts"] for row in comparison.rows])
    for key in dict.fromkeys(keys):
        yield np.array([one == key for one in keys]) & ((pitch < _FINE) == fine)


def lead_exponent(comparison: CatalogueComparison, values: np.ndarray) -> float:
    """Exponent of the lead at one diameter and number of starts, for pitches up to 3 mm.

    **Arguments:**

    - `comparison`: the sizes.
    - `values`: of all sizes.
    """
    lead = np.log([row["lead_mm"] for row in comparison.rows])
    product = square = 0.0
    for family in _families(comparison):
        if family.any():
            from_mean = lead[family] - lead[family].mean()
            product += float(np.sum(from_mean * np.log(values[family])))
            square += float(np.sum(from_mean**2))
    return product / square


def coarse_step(comparison: CatalogueComparison, values: np.ndarray) -> float:
    """Ratio of the mean of coarse to that of fine pitches at one diameter, over all diameters.

    **Arguments:** as `lead_exponent`.
    """
    pairs = zip(_families(comparison), _families(comparison, fine=False), strict=True)
    steps = [
        values[coarse].mean() / values[fine].mean()
        for fine, coarse in pairs
        if fine.any() and coarse.any()
    ]
    return float(np.mean(steps))


def _within(words: str, median: float, most: float, goal: tuple[float, float]) -> Row:
    return trend(
        words,
        f"within {100 * goal[0]:g} % in the median, {100 * goal[1]:g} % at the 90th percentile",
        f"{_percent(median)} in the median, {_percent(most)} at the 90th percentile",
        median <= goal[0] and most <= goal[1],
    )


@rows_of(
    "catalogue", "A maker's public catalogue of planetary roller screws, 90 sizes, 8 to 120 mm"
)
def errors_of_the_predicted_half() -> Iterator[Row]:
    """Capacities, masses and inertias of the diameters that the rules were not fitted to."""
    comparison = compare_catalogue()
    half = comparison.predicted_half
    for name in _CAPACITIES:
        found = comparison.summary(name, half)
        assert found is not None
        words = f"{PREDICTED[name].name}, {found.sizes} sizes that were not fitted"
        yield _within(words, found.median, found.percentile_90, (PREDICTED[name].goal, _MOST))
    for name in _BODIES:
        found = comparison.summary(name)
        assert found is not None
        words = f"{PREDICTED[name].name}, {found.sizes} sizes; 90th percentile beyond rounding"
        goal = PREDICTED[name].goal
        yield _within(words, found.median, found.beyond_rounding_90, (goal, goal))


@rows_of("catalogue")
def halves_exchanged() -> Iterator[Row]:
    """Capacities of the first half, predicted by rules that are fitted to the second."""
    comparison = compare_catalogue()
    half = comparison.predicted_half
    rules = fitted_rules(comparison, half)
    model = CapacityModel(comparison, rules.fatigue_rule)
    for name, computed in zip(_CAPACITIES, model.capacities(rules), strict=True):
        errors = np.abs(computed / comparison.printed[name] - 1)[~half]
        words = f"{PREDICTED[name].name}, {errors.size} sizes, fitted to the other half"
        median, most = float(np.median(errors)), float(np.percentile(errors, 90))
        yield _within(words, median, most, (PREDICTED[name].goal, _MOST))


@rows_of("catalogue")
def trends_of_capacities() -> Iterator[Row]:
    """How capacities vary with the lead at one diameter and number of starts."""
    comparison = compare_catalogue()
    allowed = dict(zip(_CAPACITIES, (0.06, 0.03), strict=True))
    for name in _CAPACITIES:
        printed, computed = comparison.printed[name], comparison.computed[name]
        exponents = lead_exponent(comparison, printed), lead_exponent(comparison, computed)
        yield trend(
            f"{PREDICTED[name].name} against the lead, pitches up to 3 mm",
            f"exponent of the lead {exponents[0]:.2f}",
            f"{exponents[1]:.2f}",
            abs(exponents[1] - exponents[0]) < allowed[name],
            note=f"{allowed[name]:g} is allowed, by which capacities change by "
            f"{100 * (7.5 ** allowed[name] - 1):.0f} % over leads of 1 to 7.5. With a profile "
            "radius in proportion to the pitch, the load of all threads at one pressure is "
            "constant but for the shape of the ellipses; the formula of ball screws gives "
            "0.9 - 2/3 for the dynamic capacity.",
        )
        lead = np.array([row["lead_mm"] for row in comparison.rows])
        by_lead = lead ** exponents[0]
        published, own = (coarse_step(comparison, x / by_lead) for x in (printed, computed))
        yield trend(
            f"{PREDICTED[name].name} at pitches from 4 mm on over finer ones, trend removed",
            f"{published:.2f}",
            f"{own:.2f}",
            abs(own - published) < _STEP,
            note="All diameters step up between pitches of 3 and 4 mm, by the same factor in both "
            "capacities; no other column of the table changes there. A larger ratio of profile "
            "radius and pitch is fitted to it, which gives both; its reason is not known.",
        )


@rows_of("catalogue")
def trends_of_losses() -> Iterator[Row]:
    """How efficiency and no-load torque vary with lead and starts."""
    comparison = compare_catalogue()
    name = "efficiency_screw_drives"
    printed, computed = comparison.printed[name], comparison.computed[name]
    spread = max(float(np.ptp(computed[family])) for family in _families(comparison))
    known = max(float(np.ptp(printed[family])) for family in _families(comparison))
    yield trend(
        "efficiency nearly independent of the lead",
        f"within {known:.2f} at one diameter and number of starts",
        f"within {spread:.4f}",
        spread <= known + 0.005,
        note="Per turn, the flanks slide by the lead over sin α, and the useful work is the load "
        "times the lead.",
    )
    starts = np.array([row["starts"] for row in comparison.rows])
    implied = {
        which: [float(np.mean((1 - x[starts == n]) / (1 + x[starts == n]))) for n in (4, 6)]
        for which, x in (("printed", printed), ("computed", computed))
    }
    # The rules take coefficients of friction in proportion to the starts less one.
    own = implied["computed"][1] / implied["computed"][0] * (4 - 1) / (6 - 1)
    yield unexplained(
        "friction (1 - η)/(1 + η) that efficiencies imply, 6 starts over 4 starts",
        f"{implied['printed'][1] / implied['printed'][0]:.2f}",
        own,
        between=(0.98, 1.02),
        note="One coefficient of friction gives one efficiency for all starts. The printed losses "
        "are nearly in proportion to the starts less one, and so to the number of rollers; the "
        "rules take the coefficient of friction in that proportion, without a reason.",
    )
    yield _torque(comparison)


def _torque(comparison: CatalogueComparison) -> Row:
    """The printed torque without load, by a constant part and one in proportion to the lead."""
    torque = np.array([row["preload_torque_nm"] for row in comparison.rows])
    lead = np.array([row["lead_mm"] for row in comparison.rows])
    worst = 0.0
    for family in _families(comparison):
        if family.sum() > 2:
            columns = np.stack([np.ones(family.sum()), lead[family]], axis=-1)
            solved = np.linalg.lstsq(columns, torque[family], rcond=None)[0]
            # Half a unit of the last printed digit is 0.005 N·m.
            beyond = np.maximum(np.abs(columns @ solved - torque[family]) - 0.005, 0)
            worst = max(worst, float(np.max(beyond / torque[family])))
    return differs(
        "exponent of the lead in the torque without load, pitches up to 3 mm",
        f"{lead_exponent(comparison, torque):.2f}",
        lead_exponent(comparison, lead),
        between=(1 - 1e-9, 1 + 1e-9),
        because="preload_torque is in proportion to the lead. At every diameter the printed torque "
        "is such a part and a constant one, of seals and rolling, which is left out here; "
        "evidence: largest relative difference from their sum beyond rounding.",
        evidence=worst,
        evidence_between=(0.0, 0.03),
    )
