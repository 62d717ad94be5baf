"""Margins of preferred numbers: usual leads, and modules for which cutters exist."""

import bisect
import math
from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np

from ..fields import Scalar
from ..mechanism import Mechanism
from ..quantities import Analysis
from ._margin import Margin, Reading, margin_source

#: Nominal leads of ISO 3408-2 (ball screws), and those that makers of roller screws add [mm].
LEADS = (1, 2, 2.5, 3, 4, 5, 6, 8, 9, 10, 12, 15, 16, 18, 20, 24, 25, 30, 32, 35, 36, 40, 42, 50)
#: Modules of both series of DIN 780-1, which include those of ISO 54 from 1 mm on [mm].
MODULES = (
    *(0.05, 0.055, 0.06, 0.07, 0.08, 0.09, 0.1, 0.11, 0.12, 0.14, 0.16, 0.18, 0.2, 0.22, 0.25),
    *(0.28, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95),
    *(1, 1.125, 1.25, 1.375, 1.5, 1.75, 2, 2.25, 2.5, 2.75, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8, 9, 10),
)
#: A lead or module closer than this is taken as that of the series [relative].
_SAME = 1e-3


def _off(value: Scalar, series: tuple[float | int, ...]) -> Scalar:
    """Relative distance of a number from the nearest one of a series."""
    known = jnp.asarray(np.asarray(series) * 1e-3, value.dtype)
    return jnp.min(jnp.abs(jnp.log(jnp.maximum(value, 1e-12)) - jnp.log(known)))


def neighbours(value: float, series: tuple[float | int, ...]) -> str:
    """The numbers of a series on either side of a value, in mm."""
    place = bisect.bisect(series, value * 1e3)
    near = series[max(place - 1, 0) : place + 1]
    return " or ".join(f"{number:g}" for number in near) + " mm"


@margin_source
def _lead(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    def lead(analysis: Analysis) -> Scalar:
        return analysis.mechanism.stages[index].thread.lead

    def message(r: Reading) -> str:
        value = r.details["lead"]
        return (
            f"the lead of {value * 1e3:.5g} mm is not a preferred lead of ISO 3408-2 or of "
            f"roller screw catalogues: it needs special thread gauges and tools; nearest: "
            f"{neighbours(value, LEADS)}"
        )

    yield Margin(
        "unusual_lead",
        index + 1,
        lambda analysis: -_off(lead(analysis), LEADS),
        (("note", -_SAME),),
        message,
        details=lambda analysis: {"lead": lead(analysis)},
        shown=lambda r: (r.details["lead"], _nearest(r.details["lead"], LEADS)),
    )


@margin_source
def _module(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    gear = mechanism.stages[index].gear
    if gear is None or gear.roller_teeth is None:
        return

    def module(analysis: Analysis) -> Scalar:
        stage = analysis.mechanism.stages[index]
        assert stage.gear is not None
        assert stage.gear.roller_teeth is not None
        return 2 * stage.thread.roller_radius / stage.gear.roller_teeth

    def message(r: Reading) -> str:
        value = r.details["module"]
        return (
            f"the module of the roller gear, 2 r_R / z_R = {value * 1e3:.4g} mm, is not in "
            f"DIN 780 or ISO 54: it needs a special cutter; nearest: {neighbours(value, MODULES)} "
            "(change stage.thread.roller_radius or stage.gear.roller_teeth)"
        )

    yield Margin(
        "unusual_module",
        index + 1,
        lambda analysis: -_off(module(analysis), MODULES),
        (("note", -_SAME),),
        message,
        details=lambda analysis: {"module": module(analysis)},
        shown=lambda r: (r.details["module"], _nearest(r.details["module"], MODULES)),
    )


def _nearest(value: float, series: tuple[float | int, ...]) -> float:
    if not value > 0:
        return series[0] * 1e-3
    return min(series, key=lambda known: abs(math.log(known * 1e-3 / value))) * 1e-3
