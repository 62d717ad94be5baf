"""Mode shapes drawn as motion of the bodies: one panel for each distinct frequency."""

import math
from typing import Any

from ...mechanism import Mechanism
from ...text import number, show
from ...vibration import Modes
from .._parts import MODE_ENERGY, body_patches, dense_legend
from .._style import (
    BODY_COLOURS,
    FAMILY_COLOURS,
    INK,
    MUTED,
    PAGE_WIDTH,
    SMALL,
    TITLE,
    Figure,
    drawn,
    page_figure,
    place_axes,
    readable,
)
from ._body_motion import ModeMotion, mode_motions
from ._moving_view import DRAWN_SHARE, MovingView

_COLUMNS, _MARGIN, _GUTTER = 4, 2.0, 3.0
#: Room for words over and under a panel, for the heading and for the legend [mm].
_OVER, _UNDER, _HEADING, _FOOT = 7.5, 10.5, 7.0, 15.5
_LINE = 31
_SPRINGS = {
    "screw_roller": "screw threads",
    "nut_roller": "nut threads",
    "ring_roller": "gear",
    "pin_radial": "pins",
    "pin_tangential": "pins",
}


@drawn
def mode_shapes(
    mechanism: Mechanism, modes: Modes, *, stage: int = 1, energy: float = MODE_ENERGY
) -> Figure:
    """Draw all mode shapes of a stage, one panel for each distinct frequency.

    Every body is displaced and turned to one scale for each mode, which is printed beside the
    frequency. The rest position is grey, and arrows show the displacement from it. Rotations are
    `θ = u / r` on the body's own nominal circle, shown by its mark. For a repeated root one shape
    is drawn. The ring gear lies beside the nut in the mechanism and inside it in the picture;
    rollers that only rotate move with the carrier.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `modes`: its modes, from `modal(mechanism, stage=stage, shapes=True)`.
    - `stage`: which stage, counted from 1.
    - `energy`: energy of the mode to which the printed magnification refers [J].

    **Returns:** a matplotlib figure, A4 wide.

    **Raises:** `ValueError` if the shapes were not computed, for a stage that does not exist, or an
    energy that is not positive; `MissingExtraError` without matplotlib.
    """
    motions = mode_motions(mechanism, modes, stage)
    check_energy(energy)
    columns = min(_COLUMNS, len(motions))
    side = (PAGE_WIDTH - 2 * _MARGIN - (_COLUMNS - 1) * _GUTTER) / _COLUMNS
    rows = math.ceil(len(motions) / columns)
    height = rows * (_OVER + side + _UNDER + _GUTTER) + _HEADING + _FOOT
    figure = page_figure(height, layout=None)
    figure.text(
        _MARGIN / PAGE_WIDTH,
        1 - 4.0 / height,
        "Mode shapes" + (f" of stage {stage}" if len(mechanism.stages) > 1 else ""),
        fontsize=TITLE,
        fontweight="bold",
        va="center",
    )
    for index, motion in enumerate(motions):
        row, column = divmod(index, columns)
        left = _MARGIN + column * (side + _GUTTER)
        top = height - _HEADING - row * (_OVER + side + _UNDER + _GUTTER)
        axes = place_axes(figure, left, top - _OVER - side, side, side)
        MovingView(axes, motion, arrows=True)
        _words(axes, motion, energy)
    _legend(figure, height, motions, energy)
    return figure


def check_energy(energy: float) -> None:
    """Check that an energy is positive and finite, so that it gives an amplitude."""
    if not 0 < energy < math.inf:
        raise ValueError(f"energy is {energy:g} J; give a positive one")


def headline(motion: ModeMotion) -> str:
    """Number, family and multiplicity of a mode."""
    numbers = str(motion.first)
    if motion.multiplicity > 1:
        numbers += f"{', ' if motion.multiplicity == 2 else '–'}{motion.last}"
    times = f" ×{motion.multiplicity}" if motion.multiplicity > 1 else ""
    return f"{numbers}  {motion.family}{times}"


def frequency_words(motion: ModeMotion) -> str:
    """The natural frequency."""
    return "0 Hz" if motion.family == "rigid" else show(motion.frequency, "Hz")


def scale_words(motion: ModeMotion, energy: float) -> str:
    """Magnification of displacements, relative to those at the given energy [J]."""
    amplitude = motion.amplitude(energy)
    if amplitude is None:
        return "displacements of any size"
    roller = next(body.radius for body in motion.bodies if body.kind == "roller")
    factor = DRAWN_SHARE * roller / (1e3 * amplitude)
    # Two digits are enough.
    power = max(math.floor(math.log10(factor)) - 1, 0)
    return f"displacements ×{number(round(factor, -power), 2)}"


def _words(axes, motion: ModeMotion, energy: float) -> None:
    over: dict[str, Any] = {"transform": axes.transAxes, "ha": "center", "va": "bottom"}
    colour = FAMILY_COLOURS[motion.family]
    axes.text(0.5, 1.085, headline(motion), color=colour, fontweight="bold", **over)
    axes.text(0.5, 1.0, frequency_words(motion), **over)
    for line, words in enumerate([scale_words(motion, energy), *_shares(motion)]):
        axes.annotate(
            words,
            (0.5, 0),
            (0, 2 - 9.5 * line),
            xycoords="axes fraction",
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=SMALL,
            color=MUTED if line else INK,
        )


def _shares(motion: ModeMotion) -> list[str]:
    """Which bodies move and which springs are strained, as many as fit in a line."""
    moving = {readable(k) + ("s" if k == "roller" else ""): v for k, v in motion.kinetic.items()}
    strained: dict[str, float] = {}
    for name, share in motion.strain.items():
        body, support, _ = name.partition("_support_")
        words = _SPRINGS.get(name, f"{readable(body)} support" if support else readable(name))
        strained[words] = strained.get(words, 0.0) + share
    return [_line("moving: ", moving), _line("strained: ", strained)]


def _line(start: str, shares: dict[str, float]) -> str:
    words = ""
    for name, share in sorted(shares.items(), key=lambda item: -item[1]):
        more = f"{words}, {name} {100 * share:.0f} %" if words else f"{name} {100 * share:.0f} %"
        if share < 0.095 or (words and len(start + more) > _LINE):
            break
        words = more
    return start + (words or "nothing")


def _legend(figure: Figure, height: float, motions: tuple[ModeMotion, ...], energy: float) -> None:
    from matplotlib.lines import Line2D

    kinds = {body.kind for body in motions[0].bodies}
    handles: list[Any] = body_patches(body for body in BODY_COLOURS if body in kinds - {"carrier"})
    if "carrier" in kinds:
        handles.append(
            Line2D([], [], color="#7a7f85", lw=1.4, marker="o", ms=3, label="carrier and pins")
        )
    handles += [
        Line2D([], [], color="#9aa0a6", lw=0.8, label="at rest"),
        Line2D([], [], color="#b3001b", lw=1.2, marker=">", ms=3, label="displacement"),
    ]
    dense_legend(figure, handles, (0.5, 8.0 / height))
    words = (
        f"Displacements are magnified as printed, relative to those at a mode energy of "
        f"{1e3 * energy:g} mJ; for a repeated root one shape is drawn.\n"
        "Percentages are shares of kinetic and of strain energy."
    )
    if "ring_gear" in kinds:
        words += " The ring gear lies beside the nut and is drawn inside it."
    figure.text(0.5, 4.2 / height, words, fontsize=SMALL, color=MUTED, ha="center", va="center")
