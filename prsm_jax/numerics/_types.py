"""Types of numbers that all rooms share."""

from typing import TypeAlias

from jaxtyping import Array, Float

#: One number, in SI units.
Scalar: TypeAlias = Float[Array, ""]
