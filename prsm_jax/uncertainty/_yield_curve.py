"""The yield against a common factor of all tolerances."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..fields import Scalar
from ..mechanism import Mechanism, Tolerance, of_one_known_design
from ..results import Shown
from ..text import TextTable
from ._allocation import widened, widest_factor
from ._inputs import inputs_of
from ._sampling import Progress
from ._tolerance import tolerance

_FACTORS = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0)


@dataclasses.dataclass(frozen=True, repr=False)
class YieldCurve(Shown):
    """Share of mechanisms within all limits, for tolerances that are wider by common factors.

    - `factors`: widths of all zones relative to the given widths.
    - `yields`: shares by method, one for each factor.
    - `errors`: standard errors of the shares by method, one for each factor; 0 without samples.
    """

    factors: np.ndarray
    yields: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]

    def __str__(self) -> str:
        columns = ("width of zones", *(f"yield, {name.replace('_', ' ')}" for name in self.yields))
        rows = list(zip(self.factors.tolist(), *self.yields.values(), strict=True))
        return TextTable("Share within all limits", columns, rows).text().rstrip()


@of_one_known_design
def yield_curve(
    mechanism: Mechanism,
    factors: Iterable[float] | None = None,
    limits: Mapping[str, Any] | None = None,
    *,
    method: str = "all",
    samples: int = 4096,
    seed: int = 0,
    tolerances: Iterable[Tolerance] | None = None,
    speed: float | Scalar | None = None,
    load: float | Scalar | None = None,
    findings: bool = True,
    progress: Progress = None,
) -> YieldCurve:
    """The yield if all tolerances are wider or narrower by the same factor, about their middles.

    **Arguments:**

    - `mechanism`, `limits`, `method`, `samples`, `seed`, `tolerances`, `speed`, `load`,
      `findings`, `progress`: as for `tolerance`; the progress is that of all factors.
    - `factors`: default from 0.25 to 3, as far as the numbers stay in their ranges.

    **Returns:** a `YieldCurve`.

    **Raises:** as `tolerance`; `ValueError` without limits, or if a factor is not positive.
    """
    given = inputs_of(mechanism, tolerances).tolerances
    if factors is None:
        widest = min(widest_factor(mechanism, one) for one in given)
        factors = [factor for factor in _FACTORS if factor <= widest]
    wanted = tuple(factors)
    if not wanted or not all(factor > 0 for factor in wanted):
        raise ValueError(f"factors is {wanted}; give positive numbers")
    results = []
    for place, factor in enumerate(wanted):

        def told(done: int, total: int, place: int = place) -> None:
            if progress is not None:
                progress(place * total + done, len(wanted) * total)

        analysis = tolerance(
            mechanism,
            limits=limits,
            method=method,
            samples=samples,
            seed=seed,
            tolerances=[widened(one, factor) for one in given],
            speed=speed,
            load=load,
            findings=findings,
            progress=told,
        )
        results.append(analysis.methods)
        if not any(one is not None for one in analysis.limits):
            raise ValueError("there are no limits; give limits, or constraints in [optimise]")
    shares = {
        name: np.array([one[name].yield_share for one in results], float) for name in results[0]
    }
    errors = {
        name: np.array([one[name].yield_error or 0.0 for one in results]) for name in results[0]
    }
    return YieldCurve(np.array(wanted, float), shares, errors)
