"""Tolerances of single numbers of a mechanism, as static data."""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from ...fields import POSITIVE, check_fields, check_number, choice

Distribution: TypeAlias = Literal["normal", "uniform", "triangular"]
DISTRIBUTIONS: tuple[Distribution, ...] = get_args(Distribution)
#: Standard deviations from the middle to a limit of a normal distribution, unless stated.
_SIGMAS = 3.0


@dataclass(frozen=True)
class Tolerance:
    """Permissible deviations of one number [SI], and how they are distributed.

    All distributions are symmetric about the middle of the tolerance zone. A normal one is not cut
    off at the limits: they lie `sigmas` standard deviations from the middle. A uniform and a
    triangular one end at the limits.

    **Raises:** `ValueError` for limits in the wrong order or not finite, an unknown distribution,
    and `sigmas` of a distribution that is not normal.
    """

    name: str = choice("name of a number")
    lower: float = choice("lower deviation from the nominal value")
    upper: float = choice("upper deviation from the nominal value")
    distribution: Literal["normal", "uniform", "triangular"] = choice(
        "distribution within the limits", default="normal"
    )
    sigmas: float = choice(
        "standard deviations from the middle to a limit, of a normal distribution",
        default=_SIGMAS,
        limit=POSITIVE,
    )
    #: In any currency: at half the tolerance the cost is twice as high.
    cost: float = choice("cost of keeping this tolerance", default=1.0, limit=POSITIVE)

    def __post_init__(self) -> None:
        check_fields(self)
        owner = f"tolerance {self.name!r}: "
        for name in ("sigmas", "cost"):
            check_number(owner, name, "1", getattr(self, name), POSITIVE, to_come=False)
        if not (math.isfinite(self.lower) and math.isfinite(self.upper)):
            raise ValueError(f"{owner}deviations {self.lower} and {self.upper} must be finite")
        if not self.lower < self.upper:
            raise ValueError(
                f"{owner}lower deviation {self.lower} is not below upper deviation {self.upper}; "
                "swap or widen them"
            )
        if self.distribution != "normal" and self.sigmas != _SIGMAS:
            raise ValueError(
                f"{owner}sigmas is {self.sigmas:g}, but a {self.distribution} distribution ends at "
                "its limits; remove sigmas, or make the distribution normal"
            )

    @property
    def middle(self) -> float:
        """Mean deviation from the nominal value [SI]."""
        return 0.5 * (self.lower + self.upper)

    @property
    def half_width(self) -> float:
        """Half of the tolerance zone [SI]."""
        return 0.5 * (self.upper - self.lower)

    @property
    def standard_deviation(self) -> float:
        """Standard deviation [SI]."""
        shares = {"normal": 1 / self.sigmas, "uniform": 3**-0.5, "triangular": 6**-0.5}
        return self.half_width * shares[self.distribution]

    @property
    def kurtosis(self) -> float:
        """Fourth central moment over the squared variance."""
        return {"normal": 3.0, "uniform": 1.8, "triangular": 2.4}[self.distribution]
