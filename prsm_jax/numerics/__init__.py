"""Small dense linear algebra in plain JAX operations: eliminations, singular values, eigenvalues.

Nothing here calls LAPACK, whose batched calls deadlock between threads of one process.
"""

from ._apart import apart as apart
from ._elimination import (
    Factors as Factors,
    factorise as factorise,
    solve as solve,
    solver as solver,
    substitute as substitute,
    substitute_transposed as substitute_transposed,
)
from ._few import (
    all_few as all_few,
    any_few as any_few,
    dot_few as dot_few,
    max_few as max_few,
    min_few as min_few,
    sum_few as sum_few,
)
from ._jacobi import (
    hermitian_eigenvalues as hermitian_eigenvalues,
    singular_values as singular_values,
)
from ._small_solve import solve_small as solve_small
