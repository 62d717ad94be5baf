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
from ._jacobi import (
    hermitian_eigenvalues as hermitian_eigenvalues,
    singular_values as singular_values,
)
from ._small_solve import solve_small as solve_small
