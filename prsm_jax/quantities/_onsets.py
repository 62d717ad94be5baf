"""Where contact ellipses reach the ends of flanks, computed once for all quantities."""

from .. import strength
from ..fields import Scalar
from ..geometry import flanks_end
from ._analysis import Analysis


def onsets_anywhere(analysis: Analysis, index: int):
    """Where the ellipses of a stage (from 0) reach the ends of their flanks; `None` if nowhere."""
    stage = analysis.mechanism.stages[index]
    if not flanks_end(stage):
        return None
    return analysis.once(
        ("side_onsets", index),
        lambda: strength.side_onsets(
            stage, analysis.meshing(index), analysis.reference_contact(index)
        ),
    )


def onsets_of(analysis: Analysis, index: int):
    """As `onsets_anywhere`, but valid only if the contact points lie on their flanks."""

    def make():
        onsets = onsets_anywhere(analysis, index)
        for side in onsets or ():
            if side is not None:
                # There is no contact point beyond the end of a flank.
                analysis.require(side.on_flank)
        return onsets

    return analysis.once(("onsets", index), make)


def _onset(analysis: Analysis, index: int, side: str):
    onsets = onsets_of(analysis, index)
    return None if onsets is None else onsets[("screw", "nut").index(side)]


def truncated_pressure(analysis: Analysis, index: int, side: str, hertz: Scalar) -> Scalar:
    """Largest pressure on the `"screw"` or `"nut"` side of a stage, from that of Hertz [Pa]."""
    return strength.truncated_pressure(_onset(analysis, index, side), hertz)


def equal_pressure(analysis: Analysis, index: int, side: str) -> Scalar:
    """As `truncated_pressure`, if all threads share the load at the operating point equally [Pa].

    Where a flank ends, from the contact under the reference load, which its ends need anyway: a
    contact under the load itself would add a sixth to the program of a second derivative.
    """
    onset = _onset(analysis, index, side)
    if onset is None:
        return getattr(analysis.contacts[index], side).hertz.max_pressure
    return strength.truncated_pressure(onset, onset.pressure(analysis.load))


def pressure_under(analysis: Analysis, index: int, side: str, load: Scalar) -> Scalar:
    """As `equal_pressure`, under another axial load than that of the operating point [Pa]."""
    hertz = getattr(analysis.reference_contact(index), side).hertz.max_pressure
    return truncated_pressure(analysis, index, side, strength.pressure_at(hertz, load))
