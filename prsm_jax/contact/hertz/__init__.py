"""Elliptic contacts by Hertz, exact and approximated."""

from ._approximations import (
    APPROXIMATIONS as APPROXIMATIONS,
    lisowski_coefficients as lisowski_coefficients,
)
from ._hertz import (
    HertzContact as HertzContact,
    HertzMethod as HertzMethod,
    anisotropy_of as anisotropy_of,
    contact_modulus as contact_modulus,
    hertz_contact as hertz_contact,
)
from ._methods import axis_ratio_of as axis_ratio_of
