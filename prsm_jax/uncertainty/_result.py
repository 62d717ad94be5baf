"""The result of a tolerance analysis: tables that print themselves."""

import dataclasses
import math
from typing import Any

import numpy as np

from ..mechanism import Tolerance
from ..results import Shown
from ..text import TextTable, digits_for, display_unit
from ._estimates import PROBABILITIES, ROUNDING, Estimate
from ._zone_ends import ZoneEnds

METHOD_WORDS = {
    "first_order": "first order",
    "second_order": "second order",
    "monte_carlo": "Monte Carlo",
}


@dataclasses.dataclass(frozen=True)
class MethodResult:
    """Result of one method.

    - `estimates`: of each quantity.
    - `yield_share`, `yield_error`: share of mechanisms within all limits, and its standard error;
      `None` without limits.
    - `reasons`: number of designs that failed, by reason.
    - `errors`: number of other designs, by the first error of `check`.
    - `samples`: designs that were analysed; 0 for propagation.
    - `values`: samples of each quantity [SI], NaN for designs that failed.
    - `slopes`: change of each quantity for one standard deviation of each tolerance [SI], at the
      middle of the tolerance zones; empty for Monte Carlo.
    - `ends`: each quantity with one number at an end of its zone and all others nominal: analysed
      for Monte Carlo, by the expansion for propagation.
    """

    estimates: dict[str, Estimate]
    yield_share: float | None
    yield_error: float | None
    reasons: dict[str, int] = dataclasses.field(default_factory=dict)
    errors: dict[str, int] = dataclasses.field(default_factory=dict)
    samples: int = 0
    values: dict[str, np.ndarray] = dataclasses.field(default_factory=dict, repr=False)
    slopes: dict[str, np.ndarray] = dataclasses.field(default_factory=dict, repr=False)
    ends: dict[str, ZoneEnds] = dataclasses.field(default_factory=dict, repr=False)

    @property
    def failed(self) -> int:
        """Number of designs that failed."""
        return sum(self.reasons.values())

    @property
    def not_counted(self) -> list[str]:
        """Why designs do not count as within all limits, other than by a limit, in words."""
        return [
            f"{kind}{name.replace('_', ' ')} ({n})"
            for kind, counts in (("", self.reasons), ("prsm check: ", self.errors))
            for name, n in counts.items()
        ]

    @property
    def valid(self) -> bool:
        """Whether there are numbers: propagated from a design that did not fail, or sampled."""
        return self.failed < max(self.samples, 1)


@dataclasses.dataclass(frozen=True, repr=False)
class ToleranceAnalysis(Shown):
    """Scatter of quantities due to tolerances, by one or several methods.

    - `quantities`, `units`, `limits`: single numbers with SI units and limits (`None`: no limit).
    - `tolerances`, `tolerance_units`: the tolerances with their SI units.
    - `methods`: result of each method. The last method is the most accurate; the numbers of the
      analysis are its numbers.
    """

    quantities: tuple[str, ...]
    units: tuple[str, ...]
    limits: tuple[tuple[float, float] | None, ...]
    tolerances: tuple[Tolerance, ...]
    tolerance_units: tuple[str, ...]
    methods: dict[str, MethodResult]

    @property
    def method(self) -> str:
        """The most accurate method that was used."""
        return next(reversed(self.methods))

    @property
    def best(self) -> MethodResult:
        """Result of the most accurate method."""
        return self.methods[self.method]

    @property
    def valid(self) -> bool:
        """Whether each method has numbers."""
        return all(one.valid for one in self.methods.values())

    def __getitem__(self, quantity: str) -> Estimate:
        """The estimate of a quantity by the most accurate method.

        **Raises:** `KeyError` for a quantity that is not in the analysis.
        """
        if quantity not in self.quantities:
            raise KeyError(f"{quantity}; the analysis has {', '.join(self.quantities)}")
        return self.best.estimates[quantity]

    def ranked(self, quantity: str) -> list[tuple[str, float]]:
        """Each tolerance with its share of the variance of a quantity, largest first."""
        names = [one.name for one in self.tolerances]
        pairs = zip(names, self[quantity].contributions, strict=True)
        return sorted(pairs, key=lambda pair: -pair[1] if pair[1] == pair[1] else math.inf)

    def _ends(self, name: str) -> dict[str, Any] | None:
        ends = self.best.ends.get(name)
        if ends is None:
            return None
        rows = zip(self.tolerances, ends.lower, ends.upper, strict=True)
        return {
            "nominal": _finite(ends.nominal),
            "tolerances": [
                {"tolerance": one.name, "lower": _finite(float(low)), "upper": _finite(float(high))}
                for one, low, high in rows
            ],
        }

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and lists [SI] for JSON; `None` where a number is not finite."""
        rows = zip(self.quantities, self.units, self.limits, strict=True)
        return {
            "method": self.method,
            "quantities": {
                name: {
                    "unit": unit,
                    "limits": None if limit is None else [_finite(side) for side in limit],
                    **_plain(self[name]),
                    "contributions": [
                        {"tolerance": tolerance, "share": _finite(share)}
                        for tolerance, share in self.ranked(name)
                    ],
                    "zone_ends": self._ends(name),
                    "methods": {
                        method: _plain(one.estimates[name]) for method, one in self.methods.items()
                    },
                }
                for name, unit, limit in rows
            },
            "tolerances": [
                {
                    **dataclasses.asdict(one),
                    "unit": unit,
                    "standard_deviation": one.standard_deviation,
                }
                for one, unit in zip(self.tolerances, self.tolerance_units, strict=True)
            ],
            "yield": self.best.yield_share,
            "yields": {
                name: {"yield": one.yield_share, "standard_error": one.yield_error}
                for name, one in self.methods.items()
            },
            "samples": self.best.samples,
            "failed": self.best.failed,
            "reasons": self.best.reasons,
            "errors": self.best.errors,
            "valid": self.valid,
        }

    def __str__(self) -> str:
        return self.text()

    def text(self, width: int | None = None) -> str:
        """Scatter by each method with their agreement, and the ranked contributions.

        **Arguments:**

        - `width`: number of characters in a line; default as many as the tables need.
        """
        parts = [self._scatter().text(width)]
        parts.append(self._contributions().text(width))
        return "\n".join(parts) + "\n".join(self._sentences())

    def _scatter(self) -> TextTable:
        columns = ["quantity", "method", "mean", "standard deviation"]
        columns += [f"{100 * p:.6g} %" for p in PROBABILITIES] + ["yield", "agreement"]
        rows = []
        for name, unit in zip(self.quantities, self.units, strict=True):
            shown = display_unit(unit, abs(self[name].mean), name)
            label = shown.heading(name)
            for method, one in self.methods.items():
                estimate = one.estimates[name]
                spread = estimate.standard_deviation if estimate.scatters else 0.0
                quantiles = [
                    f"{float(shown(q)):.{digits_for(q, spread, 5)}g}" for q in estimate.quantiles
                ]
                scale = float(shown.per_si)
                # Rounding is not shown as a scatter, nor as a standard error.
                size = scale if estimate.scatters or math.isnan(estimate.mean) else 0.0
                rows.append(
                    (
                        label,
                        METHOD_WORDS[method],
                        _number(
                            float(shown(estimate.mean)),
                            size * estimate.mean_error,
                            digits_for(estimate.mean, spread, 6),
                        ),
                        _number(
                            size * estimate.standard_deviation,
                            size * estimate.standard_deviation_error,
                        ),
                        *quantiles,
                        _percent(estimate.yield_share, estimate.yield_error),
                        agreement(estimate, self[name]) if method != self.method else "",
                    )
                )
        return TextTable("", columns, rows)

    def _contributions(self) -> TextTable:
        rows = []
        for name in self.quantities:
            for tolerance, share in self.ranked(name):
                rows.append((name, tolerance, f"{100 * share:.1f}" if share == share else None))
        return TextTable("", ("quantity", "tolerance", "share of variance [%]"), rows)

    def _sentences(self) -> list[str]:
        lines = []
        if self.best.yield_share is not None:
            words = _percent(self.best.yield_share, self.best.yield_error)
            lines.append(f"\nwithin all limits ({METHOD_WORDS[self.method]}): {words}")
        if self.best.samples:
            lines.append(f"\n{self.best.samples} designs, {self.best.failed} failed")
            lines += self.best.not_counted
        propagated = [one for name, one in self.methods.items() if name != "monte_carlo"]
        if not all(one.valid for one in propagated):
            lines.append("not valid: the design in the middle of the tolerances fails")
        if self.best.samples and not self.best.valid:
            lines.append(
                f"{METHOD_WORDS[self.method]} is not valid: each of the {self.best.samples} "
                "designs fails"
            )
        return lines


def agreement(one: Estimate, best: Estimate) -> str:
    """Differences from the most accurate method in words.

    The mean differs by a number of standard deviations, the standard deviation by a percentage.
    Where neither has a scatter beyond rounding, equal means are `equal`.
    """
    spread = best.standard_deviation
    if not best.scatters:
        same = math.isclose(one.mean, best.mean, rel_tol=ROUNDING)
        return "equal" if same and not one.scatters else "–"
    shift = (one.mean - best.mean) / spread
    ratio = one.standard_deviation / spread - 1
    return f"mean {shift:+.3f} σ, σ {100 * ratio:+.2f} %"


def _number(value: float, error: float, digits: int = 6) -> str:
    shown = f"{value:.{digits}g}"
    return f"{shown} ± {error:.1g}" if error > 0 else shown


def _percent(share: float | None, error: float | None) -> str | None:
    if share is None:
        return None
    text = f"{100 * share:.5g}"
    return f"{text} ± {100 * error:.1g} %" if error else f"{text} %"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _plain(one: Estimate) -> dict[str, Any]:
    quantiles = zip(PROBABILITIES, one.quantiles, strict=True)
    return {
        "mean": _finite(one.mean),
        "standard_deviation": _finite(one.standard_deviation),
        "quantiles": {f"{p:g}": _finite(q) for p, q in quantiles},
        "yield": one.yield_share,
        "contributions": [_finite(share) for share in one.contributions],
        "standard_errors": {
            "mean": _finite(one.mean_error),
            "standard_deviation": _finite(one.standard_deviation_error),
            "quantiles": [_finite(error) for error in one.quantile_errors],
            "yield": one.yield_error,
            "contributions": [_finite(error) for error in one.contribution_errors],
        },
    }
