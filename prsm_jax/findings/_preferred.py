"""Margins of preferred numbers: usual leads, and modules for which cutters exist."""

import bisect
import math
from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np

from ..fields import Scalar
from ..mechanism import LEADS, MODULES, Mechanism
from ..quantities import Analysis
from ._margin import Margin, Reading, margin_source

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
    if mechanism.stages[index].gear_module is None:
        return

    def module(analysis: Analysis) -> Scalar:
        value = analysis.mechanism.stages[index].gear_module
        assert value is not None
        return value

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
