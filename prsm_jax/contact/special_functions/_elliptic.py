"""Complete elliptic integrals by minimax polynomials, smooth at the circular limit."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...numerics import polynomial

# B = P_B(m₁) − m₁ log(m₁) Q_B(m₁) and D = P_D(m₁) − log(m₁) Q_D(m₁), of degree 10 in m₁ = κ², with
# the smallest maximum relative error over 0 < m₁ ≤ 1: 1e-17 and 3e-17, with coefficients rounded to
# float64 2.3e-17 and 6.5e-17 (Lawson's weighted least squares in 60 digits on Chebyshev points of
# m₁^{1/3}). The form is from Cody 1965, who gives K and E; near a circle their difference is too
# inaccurate for B and D.
_B_REGULAR = (
    1.0,
    0.05685281943582388,
    0.017084413168084105,
    0.008028288657114524,
    0.004478978231886146,
    -0.00047763007914593513,
    -0.02674451274446855,
    -0.09310770731137023,
    -0.12037275905015549,
    -0.05420969517572721,
    -0.00613403173459293,
)
_B_LOGARITHMIC = (
    -0.2499999999995548,
    -0.2812499987113436,
    -0.2929682884027805,
    -0.29903156329377695,
    -0.3016081214529232,
    -0.29120590308616423,
    -0.23328952160148114,
    -0.11798364773388048,
    -0.026731139549621898,
    -0.0015643721963759841,
    1.092675261783167e-05,
)
_D_REGULAR = (
    0.3862943611198914,
    0.03972077088823366,
    0.013800782024721623,
    0.0069179739311517685,
    0.0046623135725650765,
    0.011360012690746324,
    0.05420402717221795,
    0.12485799589183257,
    0.11021737081258513,
    0.0314975254831838,
    0.0018650298103189552,
)
_D_LOGARITHMIC = (
    0.49999999999999994,
    0.3749999999945164,
    0.3515624906210739,
    0.3417945655715463,
    0.3363079512862837,
    0.32980695946253236,
    0.30138013870312935,
    0.21012635677403815,
    0.08222665678792897,
    0.012546324589792131,
    0.0003955701869981268,
)


def associated_elliptic_integrals(
    axis_ratio: Float[Array, "*batch"],
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"], Float[Array, "*batch"]]:
    """The integrals K, B and D of the complementary modulus κ = √(1 − m).

    `D = (K − E)/m` and `B = (E − (1 − m) K)/m = K − D` have no cancellation and no singularity at m
    = 0, which keeps Hertz contact regular at circles; `E = B + κ² D`. Polynomials take half the
    time of the arithmetic–geometric mean, with the same rounding.

    **Arguments:**

    - `axis_ratio`: κ in (0, 1], the ratio of minor to major semi-axis.

    **Returns:** `(K, B, D)` of the parameter m = 1 − κ².
    """
    integral_b, integral_d = integrals_of_square(axis_ratio**2, jnp.log(axis_ratio))
    return integral_b + integral_d, integral_b, integral_d


def integrals_of_square(
    square: Float[Array, "*batch"], logarithm: Float[Array, "*batch"]
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """B and D if κ² and log κ are already known.

    **Arguments:**

    - `square`: κ² in (0, 1].
    - `logarithm`: log κ.
    """
    twice = -2 * logarithm
    integral_b = polynomial(_B_LOGARITHMIC, square) * square * twice
    integral_d = polynomial(_D_LOGARITHMIC, square) * twice
    return (
        integral_b + polynomial(_B_REGULAR, square),
        integral_d + polynomial(_D_REGULAR, square),
    )


def complete_elliptic_integrals(
    axis_ratio: Float[Array, "*batch"],
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Complete elliptic integrals K(m) and E(m) with m = 1 − κ².

    **Arguments:**

    - `axis_ratio`: κ in (0, 1].
    """
    first_kind, integral_b, integral_d = associated_elliptic_integrals(axis_ratio)
    return first_kind, integral_b + axis_ratio**2 * integral_d
