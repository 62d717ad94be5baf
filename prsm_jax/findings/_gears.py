"""Findings of gears: do the rollers fit between their teeth, and do they keep their places?"""

from collections.abc import Iterator

import jax.numpy as jnp

from ..dynamics import roller_migration
from ..fields import Scalar
from ..geometry import Finding
from ..mechanism import Mechanism
from ..quantities import Analysis
from ._margin import Margin, Reading, is_whole, margin_source

#: Travel per turn of the carrier that is rounding [m].
_ROUNDING = 1e-12


@margin_source
def _gear(mechanism: Mechanism, index: int) -> Iterator[Margin]:
    """Thread and gear must turn a roller by the same angle between two places.

    A roller that rolls from one place to the next, by 2π/N about the axis, turns by 2π n/N
    against the carrier, which is z_R n/N of its teeth; the ring gear has z_r/N teeth there.
    Identical rollers fit in all places if z_r = n z_R, which holds by construction, and if both
    numbers are whole.
    """
    gear = mechanism.stages[index].gear
    if gear is None or gear.roller_teeth is None:
        return

    def teeth(analysis: Analysis) -> Scalar:
        part = analysis.mechanism.stages[index].gear
        assert part is not None
        assert part.roller_teeth is not None
        return part.roller_teeth

    def ring(analysis: Analysis) -> Scalar:
        part = analysis.mechanism.stages[index].gear
        if part is not None and part.ring_teeth is not None:
            return part.ring_teeth
        return teeth(analysis) * analysis.mechanism.stages[index].thread.starts

    def message(r: Reading) -> str:
        given = gear.ring_teeth is not None
        return (
            f"the ring gear {'has' if given else 'would have n z_R ='} {r.details['ring']:.6g} "
            f"teeth for z_R = {r.details['teeth']:.6g} roller teeth; both must be whole numbers"
        )

    # With whole roller teeth and whole starts the ring gear teeth are whole too.
    yield Margin(
        "gear_assembly",
        index + 1,
        teeth,
        (("error", 1.0),),
        message,
        kind="assembly",
        details=lambda analysis: {"teeth": teeth(analysis), "ring": ring(analysis)},
        shown=lambda r: (r.details["ring"], float(round(r.details["ring"]))),
        reserve=0.0,
        integer=True,
    )


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
        # Only an exact match keeps the limit: for a search an equality with a kink.
        smooth=False,
    )


def assembly_notes(mechanism: Mechanism) -> Iterator[Finding]:
    """How to mount the rollers if the ring gear teeth are not divisible by their number."""
    for number, stage in enumerate(mechanism.stages, start=1):
        gear = stage.gear
        if gear is None or gear.roller_teeth is None:
            continue
        roller = float(gear.roller_teeth)
        ring = roller * float(stage.thread.starts)
        if gear.ring_teeth is not None:
            # Where gear and thread differ, rollers leave their phase in any case.
            continue
        if not (is_whole(roller) and is_whole(ring)):
            continue
        step = round(ring) % stage.roller_count
        if step == 0:
            continue
        yield Finding(
            "gear_assembly",
            "note",
            number,
            ring / stage.roller_count,
            float(round(ring / stage.roller_count)),
            f"{round(ring)} ring gear teeth are not divisible by {stage.roller_count} rollers: "
            f"each roller must be mounted turned by {step}/{stage.roller_count} of a tooth "
            "relative to the previous one, with thread and gear of all rollers cut in the same "
            "phase",
        )
