"""Points spread evenly over a unit cube."""

from ._unit_cube import latin_hypercube as latin_hypercube, sobol_points as sobol_points
