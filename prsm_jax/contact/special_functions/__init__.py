"""Elliptic integrals and functions."""

from ._carlson import carlson_rf_and_rd as carlson_rf_and_rd
from ._elliptic import (
    associated_elliptic_integrals as associated_elliptic_integrals,
    complete_elliptic_integrals as complete_elliptic_integrals,
    integrals_of_square as integrals_of_square,
)
from ._incomplete import incomplete_elliptic_integrals as incomplete_elliptic_integrals
from ._jacobi import (
    Jacobi as Jacobi,
    jacobi_complex as jacobi_complex,
    jacobi_of_direction as jacobi_of_direction,
    jacobi_of_fraction as jacobi_of_fraction,
    jacobi_sum as jacobi_sum,
)
