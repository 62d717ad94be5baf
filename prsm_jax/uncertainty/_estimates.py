"""Mean, standard deviation, quantiles, yield and contributions of one quantity, by each method."""

import dataclasses

import numpy as np

from ._sampling import standard_error

#: Probabilities of the quantiles: the outer ones are those of ±3 standard deviations.
PROBABILITIES = (0.00135, 0.05, 0.5, 0.95, 0.99865)
#: Standard deviation over the mean below which a scatter is rounding: some thousand units of the
#: last digit, far below any tolerance.
ROUNDING = 1e-12


@dataclasses.dataclass(frozen=True)
class Estimate:
    """One quantity by one method [SI]; errors are standard errors of sampled numbers, else 0.

    `contributions` are shares of the variance, one for each tolerance; the rest of the variance
    belongs to no single tolerance. `yield_share` is `None` without limits.
    """

    mean: float
    standard_deviation: float
    quantiles: tuple[float, ...]
    yield_share: float | None
    contributions: tuple[float, ...]
    mean_error: float = 0.0
    standard_deviation_error: float = 0.0
    quantile_errors: tuple[float, ...] = (0.0,) * len(PROBABILITIES)
    yield_error: float | None = None
    contribution_errors: tuple[float, ...] = ()

    @property
    def scatters(self) -> bool:
        """Whether there is a scatter, and not only rounding of one and the same number."""
        return _above_rounding(self.standard_deviation, self.mean)


def _above_rounding(deviation: float, mean: float) -> bool:
    return deviation > ROUNDING * abs(mean)


def _shares(parts: np.ndarray, variance: float) -> tuple[float, ...]:
    whole = variance if variance > 0 else 1.0
    return tuple((parts / whole).tolist())


def first_order(
    value: float,
    slopes: np.ndarray,
    normal: np.ndarray,
    deviations: np.ndarray,
    limits: tuple[float, float] | None,
) -> Estimate:
    r"""The linear expansion about the value, with the variance $\sum_i (g_i \sigma_i)^2$.

    Its distribution is normal if each tolerance that changes the quantity is. Otherwise quantiles
    and yield are those of its samples: a uniform zone has no tails.

    **Arguments:**

    - `value`: at the middle of all tolerances.
    - `slopes`: derivative by each standardised deviation, $g_i \sigma_i$.
    - `normal`: whether the distribution of each tolerance is normal.
    - `deviations`: scramblings × points × tolerances, where quantiles and yield are sampled.
    - `limits`: lower and upper limit, or `None`.
    """
    variance = float(slopes @ slopes)
    if (normal | (slopes == 0)).all():
        return _normal(value, variance, _shares(slopes**2, variance), limits)
    sampled = monte_carlo(value + deviations @ slopes, deviations, limits)
    return _with_moments(sampled, value, variance, _shares(slopes**2, variance))


def _normal(
    value: float,
    variance: float,
    contributions: tuple[float, ...],
    limits: tuple[float, float] | None,
) -> Estimate:
    from scipy.special import ndtr, ndtri

    deviation = variance**0.5
    quantiles = value + deviation * ndtri(np.array(PROBABILITIES))
    share = None
    if limits is not None:
        low, high = limits
        if deviation > 0:
            above, below = (np.array([high, low]) - value) / deviation
            share = float(ndtr(above) - ndtr(below))
        else:
            share = float(low <= value <= high)
    return Estimate(value, deviation, tuple(quantiles.tolist()), share, contributions)


def _with_moments(
    sampled: Estimate, mean: float, variance: float, contributions: tuple[float, ...]
) -> Estimate:
    """Quantiles and yield of samples, with moments and contributions in closed form."""
    return dataclasses.replace(
        sampled,
        mean=mean,
        standard_deviation=variance**0.5,
        contributions=contributions,
        mean_error=0.0,
        standard_deviation_error=0.0,
        contribution_errors=(),
    )


def second_order(
    value: float,
    slopes: np.ndarray,
    curvatures: np.ndarray,
    kurtosis: np.ndarray,
    deviations: np.ndarray,
    limits: tuple[float, float] | None,
) -> Estimate:
    r"""Mean and variance of the quadratic expansion in closed form; the rest from its samples.

    With standardised slopes $a_i$ and curvatures $b_{ij}$ the mean is $q + \frac12 \sum_i b_{ii}$
    and the variance $\sum_i a_i^2 + \frac14 \sum_i b_{ii}^2 (\kappa_i - 1) + \sum_{i<j} b_{ij}^2$
    for any symmetric distributions with kurtosis $\kappa_i$.

    **Arguments:**

    - `value`, `slopes`, `deviations`, `limits`: as for `first_order`.
    - `curvatures`: second derivatives by the standardised deviations, tolerances × tolerances.
    - `kurtosis`: of each tolerance.
    """
    own = np.diag(curvatures)
    single = slopes**2 + 0.25 * own**2 * (kurtosis - 1)
    together = np.sum(np.triu(curvatures, 1) ** 2)
    variance = float(np.sum(single) + together)
    values = quadratic(value, slopes, curvatures, deviations)
    sampled = monte_carlo(values, deviations, limits)
    mean = value + 0.5 * float(np.sum(own))
    return _with_moments(sampled, mean, variance, _shares(single, variance))


def quadratic(
    value: float, slopes: np.ndarray, curvatures: np.ndarray, deviations: np.ndarray
) -> np.ndarray:
    """The quadratic expansion at standardised deviations (… × tolerances)."""
    curved = np.einsum("...i,ij,...j->...", deviations, curvatures, deviations)
    return value + deviations @ slopes + 0.5 * curved


def within(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Which values lie within limits; NaN, a design that failed, does not."""
    return (values >= limits[0]) & (values <= limits[1])


def share_with_error(inside: np.ndarray) -> tuple[float, float]:
    """Share of true entries (scramblings × points) and its standard error, at least 1/N."""
    error = standard_error(inside.mean(axis=1))
    return float(inside.mean()), max(float(error), 1 / inside.size)


def _contributions(values: np.ndarray, deviations: np.ndarray) -> np.ndarray:
    """Shares of the variance: covariance of q with its regression on z and z² − 1 of each z.

    Their sum is the coefficient of determination, at most 1.
    """
    good = np.isfinite(values)
    z = deviations[good]
    count = z.shape[1]
    if len(z) <= 2 * count + 1:
        return np.full(count, np.nan)
    columns = np.concatenate([np.ones((len(z), 1)), z, z**2 - 1], axis=1)
    centre, spread = np.mean(values[good]), np.std(values[good])
    if not _above_rounding(float(spread), float(centre)):
        return np.zeros(count)
    standardised = (values[good] - centre) / spread
    fit = np.linalg.lstsq(columns, standardised, rcond=None)[0]
    covariances = fit[1:] * (columns[:, 1:].T @ standardised) / len(standardised)
    return np.maximum(covariances[:count] + covariances[count:], 0.0)


def monte_carlo(
    values: np.ndarray,
    deviations: np.ndarray,
    limits: tuple[float, float] | None,
) -> Estimate:
    """Moments and quantiles of the samples that did not fail. A failed one is outside of limits.

    **Arguments:**

    - `values`: of the quantity, scramblings × points, NaN for designs that failed.
    - `deviations`: standardised deviations, scramblings × points × tolerances.
    - `limits`: lower and upper limit, or `None`.
    """
    count = deviations.shape[-1]
    if (np.isfinite(values).sum(axis=1) < 2).any():
        nothing = (np.nan,) * len(PROBABILITIES)
        share = (None, None) if limits is None else share_with_error(within(values, limits))
        return Estimate(np.nan, np.nan, nothing, share[0], (np.nan,) * count, yield_error=share[1])
    of_each = np.array(
        [
            [np.nanmean(row), np.nanstd(row), *np.nanquantile(row, PROBABILITIES)]
            for row in (*values, values.ravel())
        ]
    )
    errors = standard_error(of_each[:-1])
    mean, deviation, *quantiles = of_each[-1].tolist()
    inside = (None, None) if limits is None else share_with_error(within(values, limits))
    shares = np.array([_contributions(v, z) for v, z in zip(values, deviations, strict=True)])
    pooled = _contributions(values.ravel(), deviations.reshape(-1, count))
    return Estimate(
        mean,
        deviation,
        tuple(quantiles),
        inside[0],
        tuple(pooled.tolist()),
        float(errors[0]),
        float(errors[1]),
        tuple(errors[2:].tolist()),
        inside[1],
        tuple(standard_error(shares).tolist()),
    )
