"""The numbers of a mechanism that scatter, and their standardised deviations.

Each tolerance has one standardised deviation z with mean 0 and variance 1; all are independent. A
name that applies to several stages moves their numbers by the same deviation.
"""

import dataclasses
from collections.abc import Iterable

import numpy as np
from jaxtyping import Array, Float

from ..fields import Scalar
from ..mechanism import Mechanism, Tolerance, set_parameters, tolerance_zones

#: Smallest probability of a sample: the normal quantile of 0 is infinite.
_LEAST = 2.0**-53


@dataclasses.dataclass(frozen=True)
class Inputs:
    """Tolerances of a mechanism and the numbers that they move.

    - `mechanism`: without its tolerances and its design problem, which do not affect the physics.
    - `tolerances`: the tolerances.
    - `paths`: full names of the numbers.
    - `middle`: their values in the middle of the tolerance zones [SI].
    - `directions`: change of the numbers for one standard deviation of each tolerance [SI],
      tolerances × numbers.
    - `units`: SI unit of each tolerance.
    """

    mechanism: Mechanism
    tolerances: tuple[Tolerance, ...]
    paths: tuple[str, ...]
    middle: np.ndarray
    directions: np.ndarray
    units: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the tolerances."""
        return tuple(one.name for one in self.tolerances)

    @property
    def kurtosis(self) -> np.ndarray:
        """Kurtosis of each tolerance's distribution."""
        return np.array([one.kurtosis for one in self.tolerances])

    @property
    def normal(self) -> np.ndarray:
        """Whether each tolerance's distribution is normal."""
        return np.array([one.distribution == "normal" for one in self.tolerances])

    def standardised(self, uniform: np.ndarray) -> np.ndarray:
        """Standardised deviations of points of the unit cube (… × tolerances)."""
        from scipy.special import ndtri

        inside = np.clip(uniform, _LEAST, 1 - _LEAST)
        columns = []
        for index, one in enumerate(self.tolerances):
            u = inside[..., index]
            if one.distribution == "normal":
                columns.append(ndtri(u))
            elif one.distribution == "uniform":
                columns.append(np.sqrt(3.0) * (2 * u - 1))
            else:
                tail = np.sqrt(6.0) * (1 - np.sqrt(2 * np.minimum(u, 1 - u)))
                columns.append(np.sign(u - 0.5) * tail)
        return np.stack(columns, axis=-1)

    def values(self, deviations: np.ndarray) -> np.ndarray:
        """Numbers [SI] for standardised deviations (… × tolerances)."""
        return self.middle + deviations @ self.directions


def inputs_of(mechanism: Mechanism, tolerances: Iterable[Tolerance] | None) -> Inputs:
    """Check tolerances and look up their numbers.

    **Raises:** as `tolerance_zones`.
    """
    zones = tolerance_zones(mechanism, tolerances)
    physics = dataclasses.replace(mechanism, tolerances=None, design_problem=None)
    return Inputs(
        physics,
        zones.tolerances,
        zones.paths,
        zones.nominal + zones.offsets,
        zones.directions,
        zones.units,
    )


def moved(
    mechanism: Mechanism, paths: tuple[str, ...], values: Float[Array, " numbers"]
) -> Mechanism:
    """The mechanism with its numbers at given values [SI], which may be traced."""
    pairs: dict[str, Scalar] = {path: values[index] for index, path in enumerate(paths)}
    return set_parameters(mechanism, pairs, checked=False)
