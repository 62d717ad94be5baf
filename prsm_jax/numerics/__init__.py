"""Numerical methods on plain arrays: roots, small linear algebra, short sums, NaN guards.

Nothing here calls LAPACK, whose batched calls deadlock between threads of one process.
"""

from ._elimination import (
    Factors as Factors,
    factorise as factorise,
    solve as solve,
    solver as solver,
    substitute as substitute,
    substitute_transposed as substitute_transposed,
)
from ._extremes import largest as largest, smallest as smallest
from ._few import (
    all_few as all_few,
    any_few as any_few,
    dot_few as dot_few,
    length_few as length_few,
    max_few as max_few,
    min_few as min_few,
    sum_few as sum_few,
)
from ._guards import (
    above_or_nan as above_or_nan,
    below_or_nan as below_or_nan,
    cube_root_or_zero as cube_root_or_zero,
    root_or_zero as root_or_zero,
)
from ._jacobi import (
    hermitian_eigenvalues as hermitian_eigenvalues,
    singular_values as singular_values,
)
from ._polynomials import (
    horner as horner,
    polynomial as polynomial,
    root_above_one as root_above_one,
)
from ._quotient import (
    inverse as inverse,
    inverse_root as inverse_root,
    quotient as quotient,
)
from ._root import (
    FirstEvaluation as FirstEvaluation,
    find_root as find_root,
    find_root_by_secants as find_root_by_secants,
    find_root_of as find_root_of,
)
from ._small_solve import solve_small as solve_small
from ._stretches import over_samples as over_samples
from ._transposed import with_transpose as with_transpose
from ._trigonometry import (
    sine_and_cosine as sine_and_cosine,
    with_batched_trigonometry as with_batched_trigonometry,
)
from ._types import Scalar as Scalar
from .compilation import apart as apart, in_pieces as in_pieces, merged as merged
from .sampling import latin_hypercube as latin_hypercube, sobol_points as sobol_points
