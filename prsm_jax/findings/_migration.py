"""Margin of gears that do not match their thread: rollers then creep along the body that holds
them.
"""

from collections.abc import Iterator

import jax.numpy as jnp

from ..dynamics import roller_migration
from ..fields import Scalar
from ..mechanism import Mechanism
from ..quantities import Analysis
from ._margin import Margin, Reading, margin_source

#: Travel per turn of the carrier that is rounding [m].
_ROUNDING = 1e-12


@margin_source
def _gear_mismatch(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Rollers keep their place only if gear and thread turn them at the same speed."""
    stage = mechanism.stages[index]
    gear, family = stage.gear, stage.thread.family
    if gear is None or gear.ring_teeth is None or gear.roller_teeth is None:
        return

    def migration(analysis: Analysis) -> Scalar:
        return roller_migration(analysis.mechanism.stages[index])

    def details(analysis: Analysis) -> dict[str, Scalar]:
        chosen = analysis.mechanism.stages[index]
        assert chosen.gear is not None
        assert chosen.gear.ring_teeth is not None
        assert chosen.gear.roller_teeth is not None
        ratio = chosen.gear.ring_teeth / chosen.gear.roller_teeth
        return {"travel": migration(analysis), "gear": ratio, "thread": chosen.thread.starts}

    def message(r: Reading) -> str:
        body = family.carrying
        return (
            f"the gear turns the rollers at the ratio {r.details['gear']:.6g}, the thread at "
            f"{r.details['thread']:.6g}: they creep {r.details['travel'] * 1e3:.4g} mm along the "
            f"{body} in every turn of the carrier, and slip there, which the losses do not "
            "include; the lead is unaffected. Change stage.gear.ring_teeth or roller_teeth, or "
            "remove ring_teeth for a gear that matches"
        )

    yield Margin(
        "gear_mismatch",
        index + 1,
        lambda analysis: -jnp.abs(migration(analysis)),
        (("warning", -_ROUNDING),),
        message,
        unit="m",
        details=details,
        shown=lambda r: (r.details["travel"], 0.0),
    )
