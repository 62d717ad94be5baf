"""Covariance of fitted parameters, their 95 % limits, and repetitions with new noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..quantities import quantity_of
from ._losses import influence
from ._optimum import NO_INFLUENCE
from ._problem import CalibrationProblem, solve_many

PROBABILITY = 0.95


@dataclass(frozen=True)
class Statistics:
    """Uncertainty of the free parameters, each over its magnitude.

    - `singular_values`, `directions`: of the Jacobian; a row of `directions` is a combination.
    - `known`: which directions have an influence on the measured quantities.
    - `scatter`: standard deviation s of a residual of unit weight.
    - `covariance`: s² (JᵀJ)⁻¹; infinite on the diagonal of each parameter that has a part in a
      direction without influence.
    - `freedom`: degrees of freedom n − k: values less directions with an influence.
    - `student`: quantile of |t| at 95 %.
    """

    singular_values: np.ndarray
    directions: np.ndarray
    known: np.ndarray
    scatter: float
    covariance: np.ndarray
    freedom: int
    student: float

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviation of each free parameter."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def direction_deviations(self) -> np.ndarray:
        """Standard deviation along each direction."""
        sizes = np.where(self.known, self.singular_values, 1.0)
        return np.where(self.known, self.scatter / sizes, np.inf)


def statistics_of(jacobian: np.ndarray, residuals: np.ndarray, loss: str) -> Statistics:
    """Statistics of a fit.

    **Arguments:**

    - `jacobian`: derivatives of the scaled values by the free parameters, rows × parameters.
    - `residuals`: scaled residuals.
    - `loss`: name of the loss. For a robust one s² is Huber's: Σψ²/(n − k) over the square of
      the mean of ψ′ (Huber, Robust Statistics, 1981, equation 7.6.3).
    """
    from scipy.special import stdtrit

    first, second = influence(residuals, loss)
    slope = second.mean()
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
    known = singular > NO_INFLUENCE * singular.max(initial=0.0)
    # A direction without influence fits no value, like a parameter that is fixed.
    freedom = len(residuals) - int(known.sum())
    scatter = float(np.sqrt(np.sum(first**2) / freedom) / abs(slope)) if slope else np.inf
    inverse = np.where(known, 1.0 / np.where(known, singular, 1.0) ** 2, 0.0)
    covariance = scatter**2 * (directions.T * inverse) @ directions
    # A parameter with a part in a direction without influence can have any value.
    lost = (np.abs(directions[~known]) > 1e-6).any(axis=0)
    covariance[lost, lost] = np.inf
    student = float(stdtrit(freedom, (1 + PROBABILITY) / 2))
    return Statistics(singular, directions, known, scatter, covariance, freedom, student)


@dataclass(frozen=True)
class Repetitions:
    """Fits to repeated measurements [SI], repetition × parameter; NaN where a fit failed.

    `lower` and `upper` are the 95 % limits.
    """

    parameters: tuple[str, ...]
    values: np.ndarray
    standard_deviations: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    converged: np.ndarray

    def coverage(self, truth: Sequence[float | int] | np.ndarray | Array) -> np.ndarray:
        """Share of fits whose limits contain the truth, for each parameter.

        Of those that converged; NaN if there is none.
        """
        if not self.converged.any():
            return np.full(len(self.parameters), np.nan)
        within = (self.lower <= np.asarray(truth)) & (np.asarray(truth) <= self.upper)
        return within[self.converged].mean(axis=0)


_computed = eqx.filter_jit(CalibrationProblem.computed)


def repeat_fits(
    problem: CalibrationProblem,
    values: Sequence[float | int] | np.ndarray | Array,
    standard_deviation: float,
    repetitions: int = 1000,
    seed: int = 0,
) -> Repetitions:
    """Fit simulated measurements many times in one mapped program, to plan a test rig.

    Unlike those of `calibrate`, limits are not cut at the bounds.

    **Arguments:**

    - `problem`: from `calibration_problem`; its measured values are not used, so they are not
      paired with components: give a column per component, such as `natural_frequencies[2]`.
    - `values`: true values of the parameters [SI].
    - `standard_deviation`: of the normal noise, over the scale of each row.
    - `repetitions`, `seed`: number of repetitions, and seed of the noise.

    **Returns:** values and limits of each repetition.

    **Raises:** `ValueError` unless `values` has one number for each parameter, and for a column of
    several components without the number of one.
    """
    if problem.unnumbered:
        name = problem.unnumbered[0]
        known = [one for one in problem.components if quantity_of(one).name == name]
        raise ValueError(
            f"{name} has {len(known)} components, and repeated fits do not pair values with them; "
            f"give a column per component, from {known[0]} to {known[-1]}"
        )
    true = jnp.asarray(values, problem.start.dtype)
    if true.shape != problem.start.shape:
        raise ValueError(
            f"values has the shape {true.shape}; give one number for each of "
            f"{', '.join(problem.parameters)}"
        )
    exact = _computed(problem, true)
    noise = jax.random.normal(jax.random.key(seed), (repetitions, *exact.shape), exact.dtype)
    measured = exact[None] + standard_deviation * noise * problem.scale[None]
    free = jnp.ones(true.shape, bool)
    solved = solve_many(problem, measured, free, true, problem.start)
    magnitude = np.asarray(problem.magnitude)
    jacobians, residuals = np.asarray(solved.jacobian), np.asarray(solved.residuals)
    good = np.asarray(solved.converged & solved.finite)
    fitted = np.where(good[:, None], np.asarray(solved.values), np.nan)
    deviations, student = np.full_like(fitted, np.nan), np.ones((len(fitted), 1))
    for i in np.flatnonzero(good):
        one = statistics_of(jacobians[i], residuals[i], problem.loss)
        # Fits may differ in the number of directions that the data determine.
        deviations[i], student[i] = one.deviations * magnitude, one.student
    return Repetitions(
        problem.parameters,
        fitted,
        deviations,
        fitted - student * deviations,
        fitted + student * deviations,
        good,
    )
