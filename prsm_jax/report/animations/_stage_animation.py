"""A transient as an animated GIF: turning and travelling screws, nuts, orbiting rollers."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from ...dynamics import Transient, travel_per_radian
from ...mechanism import Mechanism
from ...text import DisplayUnit, display_unit, number, trimmed
from .._style import INK, SMALL, TEXT, Figure, drawn, page_figure, place_axes
from ..motion_charts import integrated, travel_of
from ._animation_file import indexed, save_frames
from ._stage_view import Pose, TelescopeView, turn_to, turning_view

_SIDE, _OVER, _ALONG, _UNDER, _DPI = 62.0, 12.0, 40.0, 9.0, 110
_SECONDS, _COLOURS = 4.0, 64
#: Drawn angle of the screw: at most between two pictures, and at least in total [rad].
_STEP, _LEAST = math.radians(20.0), math.radians(270.0)


def angle_scale(screw: np.ndarray) -> float:
    """Factor by which angles are drawn larger or smaller, so that the eye can follow them.

    **Arguments:**

    - `screw`: angle of the screw at each picture [rad].
    """
    step, span = float(np.abs(np.diff(screw)).max()), float(np.ptp(screw))
    if span == 0:
        return 1.0
    ratio = _STEP / step
    if ratio < 1:
        return 1 / math.ceil(1 / ratio)
    return float(max(1, min(math.floor(ratio), math.ceil(_LEAST / span))))


def poses(
    mechanism: Mechanism, run: Transient, frames: int
) -> tuple[np.ndarray, list[Pose], float]:
    """Times [s], the positions of all bodies at each, and the scale of the angles.

    Rollers that nothing but friction turns (recirculating) are drawn as if they rolled in the nut.
    """
    time = np.asarray(run.time)
    at = np.linspace(time[0], time[-1], frames)
    screw = np.interp(at, time, integrated(run, run.screw_speed))
    scale = angle_scale(screw)
    count = len(mechanism.stages)
    carriers = [np.interp(at, time, integrated(run, run.carrier_speed[k])) for k in range(count)]
    ratios = [float(stage.thread.rolling_ratio) for stage in mechanism.stages]
    turning = mechanism.stages[0].thread.family.turning
    last = float(travel_per_radian(mechanism.stages, count))
    nut_travel = np.interp(at, time, travel_of(mechanism, run))
    shares = [float(travel_per_radian(mechanism.stages, k + 1)) / last for k in range(count)]
    all_poses = [
        Pose(
            {turning: scale * float(screw[i])},
            tuple(scale * float(c[i]) for c in carriers),
            # In the carrier's frame a roller turns about its axis at −κ ω.
            tuple(-n * scale * float(c[i]) for n, c in zip(ratios, carriers, strict=True)),
            tuple(1e3 * share * float(nut_travel[i]) for share in shares),
        )
        for i in range(frames)
    ]
    return at, all_poses, scale


@drawn
def _still(mechanism: Mechanism, words: str) -> Figure:
    count = len(mechanism.stages)
    width, height = max(count * _SIDE, 110.0), _OVER + _SIDE + _ALONG + _UNDER
    figure = page_figure(height, width, layout=None)
    left = (width - count * _SIDE) / 2
    for stage in range(count):
        axes = place_axes(figure, left + stage * _SIDE, _UNDER + _ALONG, _SIDE, _SIDE)
        axes.set_label(f"stage {stage + 1}")
        if count > 1:
            x = (left + (stage + 0.5) * _SIDE) / width
            figure.text(
                x, 1 - 9.5 / height, f"stage {stage + 1}", ha="center", va="center", fontsize=TEXT
            )
    place_axes(figure, 2.0, _UNDER, width - 4.0, _ALONG).set_label("along the axis")
    figure.text(0.5, 4.0 / height, words, ha="center", va="center", fontsize=SMALL, color=INK)
    return figure


def scale_words(scale: float) -> str:
    """The scale of turning and travel, as text."""
    if scale == 1:
        return "turning and travel to scale"
    drawn_as = f"{scale:g} times" if scale > 1 else f"1/{round(1 / scale)}"
    return f"turning drawn {drawn_as}, travel to scale"


def save_motion_animation(
    path: str | Path, mechanism: Mechanism, run: Transient, *, frames: int = 60
) -> Path:
    """Write a transient as an animated GIF that repeats.

    Above, every stage seen along the axis: screw (or nut) and rollers turn, rollers orbit with the
    carrier. Below, all stages in half-section: each nut carries the next screw; an inverted screw
    moves through its nut. Turning that is too fast or
    too small for the eye is drawn smaller or larger, and the picture states the factor.

    **Arguments:**

    - `path`: where to write; the suffix becomes `.gif`.
    - `mechanism`, `run`: the mechanism and its transient.
    - `frames`: number of pictures, equally spaced in time; at least 8.

    **Returns:** the path written. The file is written completely or not at all.

    **Raises:** `ValueError` for too few frames; `MissingExtraError` without matplotlib.
    """
    if frames < 8:
        raise ValueError(f"frames is {frames}; give at least 8")
    pictures = _pictures(mechanism, run, frames)
    return save_frames(Path(path).with_suffix(".gif"), pictures, _SECONDS)


def _pictures(mechanism: Mechanism, run: Transient, frames: int) -> list[Any]:
    times, all_poses, scale = poses(mechanism, run, frames)
    figure = _still(mechanism, scale_words(scale))
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    figure.set_dpi(_DPI)
    canvas = FigureCanvasAgg(figure)
    *along, across = figure.axes
    views = [turning_view(axes, mechanism, k + 1) for k, axes in enumerate(along)]
    travel = np.array([pose.travel for pose in all_poses]).T
    telescope = TelescopeView(across, mechanism, travel)
    height = figure.get_size_inches()[1] * 25.4
    clock = display_unit("s", float(times[-1]))
    heading = figure.text(0.5, 1 - 4.5 / height, "", ha="center", va="center", fontsize=TEXT + 1)
    pictures: list[Any] = []
    palette = np.zeros((0, 3), int)
    speeds = np.interp(times, np.asarray(run.time), np.asarray(run.screw_speed))
    rpm, family = DisplayUnit("rpm", 30 / math.pi), mechanism.stages[0].thread.family
    for time, pose, speed in zip(times.tolist(), all_poses, speeds.tolist(), strict=True):
        for stage, view in enumerate(views, start=1):
            turn_to(view, pose, stage)
        telescope.move(pose)
        heading.set_text(
            f"{trimmed(clock(time), 3)} {clock.label}, {family.turning} {number(rpm(speed), 3)} "
            f"rpm, {family.held} {number(pose.travel[-1], 3)} mm"
        )
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        if not pictures:
            palette = np.reshape(np.asarray(picture.quantize(_COLOURS).getpalette()), (-1, 3))
        pictures.append(indexed(np.asarray(picture), palette))
    return pictures
