"""One vibrating mode as an animated GIF."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from ...mechanism import Mechanism
from ...process import make_folder
from ...vibration import Modes
from .._parts import MODE_ENERGY
from .._style import FAMILY_COLOURS, INK, SMALL, TEXT, Figure, drawn, page_figure, place_axes
from ._animation_file import indexed, save_frames
from ._body_motion import ModeMotion, mode_motions
from ._mode_shapes import check_energy, frequency_words, headline, scale_words
from ._moving_view import MovingView

_SIDE, _OVER, _UNDER, _DPI = 84.0, 11.0, 6.0, 130
_SECONDS, _COLOURS = 1.6, 64


@drawn
def _still(motion: ModeMotion, energy: float) -> Figure:
    figure = page_figure(_OVER + _SIDE + _UNDER, _SIDE, layout=None)
    height = _OVER + _SIDE + _UNDER
    axes = place_axes(figure, 0.0, _UNDER, _SIDE, _SIDE)
    axes.set_label("mechanism")
    place: dict[str, Any] = {"ha": "center", "va": "center"}
    words = f"{headline(motion)}, {frequency_words(motion)}"
    style = {"color": FAMILY_COLOURS[motion.family], "fontweight": "bold", "fontsize": TEXT + 1}
    figure.text(0.5, 1 - 5.5 / height, words, **place, **style)
    amplitude = motion.amplitude(energy)
    words = scale_words(motion, energy)
    if amplitude is not None:
        words += f"; at {1e3 * energy:g} mJ the largest is {1e6 * amplitude:.2g} µm"
    figure.text(0.5, 3.8 / height, words, **place, fontsize=SMALL, color=INK)
    return figure


def save_mode_animation(
    path: str | Path,
    mechanism: Mechanism,
    modes: Modes,
    mode: int,
    *,
    stage: int = 1,
    energy: float = MODE_ENERGY,
    frames: int = 24,
) -> Path:
    """Write one period of a mode as an animated GIF that repeats.

    Drawn as in `mode_shapes`, without arrows.

    **Arguments:**

    - `path`: where to write; the suffix becomes `.gif`.
    - `mechanism`, `modes`, `stage`, `energy`: as `mode_shapes`.
    - `mode`: number of the mode in `modes.frequencies`, from 1; members of a repeated root give
      the same picture.
    - `frames`: pictures in one period, an even number of at least 8.

    **Returns:** the path written. The file is written completely or not at all.

    **Raises:** `ValueError` for a mode or stage that does not exist, shapes that were not computed,
    or too few frames; `MissingExtraError` without matplotlib.
    """
    _check(energy, frames)
    motions = mode_motions(mechanism, modes, stage)
    motion = next((m for m in motions if m.first <= mode <= m.last), None)
    if motion is None:
        raise ValueError(f"mode is {mode}; the stage has modes 1 to {motions[-1].last}")
    return _save(Path(path).with_suffix(".gif"), motion, energy, frames)


def save_mode_animations(
    folder: str | Path,
    mechanism: Mechanism,
    modes: Modes,
    *,
    stage: int = 1,
    energy: float = MODE_ENERGY,
    frames: int = 24,
) -> tuple[Path, ...]:
    """Write every distinct mode as `mode-NN-FAMILY.gif`, NN its number in `modes.frequencies`.

    **Arguments:** as `save_mode_animation`; the folder is made if it is not there.

    **Returns:** the paths written.

    **Raises:** as `save_mode_animation`.
    """
    _check(energy, frames)
    motions = mode_motions(mechanism, modes, stage)
    place = Path(folder)
    make_folder(place)
    return tuple(
        _save(place / f"mode-{motion.first:02d}-{motion.family}.gif", motion, energy, frames)
        for motion in motions
    )


def _check(energy: float, frames: int) -> None:
    check_energy(energy)
    if frames < 8 or frames % 2:
        raise ValueError(f"frames is {frames}; give an even number of at least 8")


def _save(target: Path, motion: ModeMotion, energy: float, frames: int) -> Path:
    return save_frames(target, _pictures(motion, energy, frames), _SECONDS)


def _pictures(motion: ModeMotion, energy: float, frames: int) -> list[Any]:
    """All frames with one palette, from one extreme through rest to the other and back."""
    figure = _still(motion, energy)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    figure.set_dpi(_DPI)
    canvas = FigureCanvasAgg(figure)
    view = MovingView(figure.axes[0], motion, arrows=False, line=0.9)
    # Everything that does not move is drawn once, as the background.
    for artist in view.moving:
        artist.set_visible(False)
    canvas.draw()
    behind = canvas.copy_from_bbox(figure.bbox)
    for artist in view.moving:
        artist.set_visible(True)
    half: list[Any] = []
    # The second half of the period shows the same pictures in reverse order.
    for step in range(frames // 2 + 1):
        view.move(math.cos(2 * math.pi * step / frames))
        canvas.restore_region(behind)
        for artist in sorted(view.moving, key=lambda a: a.get_zorder()):
            figure.draw_artist(artist)
        for artist in view.resting:
            figure.draw_artist(artist)
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba()))
        half.append(picture.convert("RGB"))
    palette = np.reshape(half[0].quantize(_COLOURS).getpalette(), (-1, 3))
    half = [indexed(np.asarray(picture), palette) for picture in half]
    return half + half[-2:0:-1]
