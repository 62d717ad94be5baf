"""Lengths, radii and stiffnesses of steel cylinders, to check printed masses."""

import numpy as np

#: Bearing steel; the paper names no material [kg/m³].
DENSITY = 7850.0


def sleeve_radius(mass: float, inner: float, length: float) -> float:
    """Outer radius of a steel sleeve [m]."""
    return float(np.sqrt(inner**2 + mass / (DENSITY * np.pi * length)))


def solid_length(mass: float, radius: float) -> float:
    """Length of a solid steel cylinder [m]."""
    return mass / (DENSITY * np.pi * radius**2)


def cantilever_length(modulus: float, radius: float, stiffness: float) -> float:
    """Length of a solid cantilever whose end has the stiffness 3 E I/l³ [m]."""
    return (3 * modulus * np.pi / 4 * radius**4 / stiffness) ** (1 / 3)


def torsional(shear: float, outer: float, inner: float, length: float, at: float) -> float:
    """G I_p/(l r²), the torsional stiffness on u = r θ [N/m]."""
    return shear * np.pi / 2 * (outer**4 - inner**4) / (length * at**2)
