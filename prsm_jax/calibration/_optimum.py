"""Whether a fit stands at its optimum, judged by the step that is left."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

#: Singular values below this share of the largest count as 0: rounding errors of the derivatives
#: are as large.
NO_INFLUENCE = 1e-7
#: Share of the standard deviations below which a step is negligible: it changes no digit of the
#: limits that is printed. The sum of losses has about 14 digits, and a step of a share e changes
#: it by the share e²/(n - p), so that rounding hides the decrease from e = 1e-7 √(n - p) on.
_STEP_LEFT = 1e-5


def near_optimum(
    residuals: Float[Array, " rows"],
    jacobian: Float[Array, "rows parameters"],
    exact: Float[Array, ""],
) -> Bool[Array, ""]:
    """Whether the Gauss–Newton step that is left is negligible.

    Over the standard deviations of the fitted numbers it is the part of the residuals in the
    directions that a change of the numbers gives, over the scatter of a residual (D. M. Bates and
    D. G. Watts, A relative offset orthogonality convergence criterion for nonlinear least squares,
    Technometrics 23 (1981) 179).

    **Arguments:**

    - `residuals`, `jacobian`: of the least-squares problem; a column of zeros, or one that is
      small beside the others, is a number that is not fitted.
    - `exact`: a smaller part is 0: data that a fit meets exactly have no scatter.
    """
    sizes = jnp.linalg.norm(jacobian, axis=0)
    # A smaller column is a rounding error.
    fitted = sizes > NO_INFLUENCE * sizes.max()
    divisor = jnp.where(fitted, sizes, 1.0)[None, :]
    columns = jnp.where(fitted[None, :], jacobian / divisor, 0.0)
    left, singular, _ = jnp.linalg.svd(columns, full_matrices=False)
    known = singular > NO_INFLUENCE * singular.max()
    inside = jnp.linalg.norm(jnp.where(known, left.T @ residuals, 0.0))
    # There are more values than parameters.
    freedom = (len(residuals) - known.sum()).astype(residuals.dtype)
    scatter = jnp.linalg.norm(residuals) / jnp.sqrt(freedom)
    return inside < _STEP_LEFT * scatter + exact
