"""Types of numbers shared by all packages."""

from typing import TypeAlias

from jaxtyping import Array, Float

#: One number, in SI units.
Scalar: TypeAlias = Float[Array, ""]
