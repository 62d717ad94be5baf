"""House style of all pictures: sizes in millimetres on A4, colours for any colour vision.

Pictures are built on `matplotlib.figure.Figure` itself; pyplot is not used, and the
style applies only while a picture is drawn.
"""

import functools
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, ParamSpec

from .._errors import missing_extra
from ..process import make_folder, whole_file
from ._letters import any_letter, write_powers_out

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure as Figure
else:
    # matplotlib is optional: its names exist for the type checker only.
    Axes = Figure = Any

#: Width of the text on a page of A4 with the usual margins [mm].
PAGE_WIDTH = 180.0
#: Sizes of text [points].
TITLE, TEXT, SMALL = 9.0, 8.0, 7.0
INK, MUTED, FAINT = "#1a1a1a", "#5f6368", "#d5d8dc"

# Palette of Okabe and Ito, distinguishable with any colour vision.
_ORANGE, _SKY, _GREEN, _YELLOW = "#e69f00", "#56b4e9", "#009e73", "#f0e442"
_BLUE, _VERMILION, _PURPLE, _GREY = "#0072b2", "#d55e00", "#cc79a7", "#8a8f94"
#: Colours for items without a fixed colour, in this order, each with a hatch for print without
#: colour and for more items than colours.
SERIES = (_BLUE, _ORANGE, _GREEN, _VERMILION, _PURPLE, _SKY, _YELLOW, _GREY)
HATCHES = ("", "////", "....", "\\\\\\\\", "xxxx", "----", "oooo", "++++")
FAMILY_COLOURS = {
    "rigid": _GREY,
    "carrier": _PURPLE,
    "axial": _VERMILION,
    "torsional": _BLUE,
    "transverse": _ORANGE,
    "roller": _GREEN,
}
LOSS_COLOURS = {
    "thread_sliding": _VERMILION,
    "spin": _ORANGE,
    "rolling_hysteresis": _YELLOW,
    "spline": _PURPLE,
    "thrust_bearing": _BLUE,
    "drag": _GREY,
}
BODY_COLOURS = {
    "screw": "#b9cfe4",
    "roller": "#f5dfb0",
    "nut": "#c9d6cf",
    "ring_gear": "#d9c2d3",
    "carrier": "#dddddd",
}
ACTIVE, FREE = _VERMILION, _SKY

_RC: Any = {
    "font.family": ["DejaVu Sans"],
    "font.size": TEXT,
    "axes.titlesize": TITLE,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": TEXT,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.unicode_minus": True,
    "axes.axisbelow": True,
    # Whole numbers at the ticks, no small addend at the end of the axis.
    "axes.formatter.useoffset": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "grid.color": FAINT,
    "grid.linewidth": 0.5,
    "hatch.linewidth": 0.4,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    # Text from users is not a formula: a dollar sign in a title stays a dollar sign.
    "text.parse_math": False,
    "text.usetex": False,
    # The same picture gives the same file.
    "svg.hashsalt": "prsm_jax",
}

_P = ParamSpec("_P")


def drawn(picture: Callable[_P, Any]) -> Callable[_P, Any]:
    """Draw a picture and lay it out in the house style, since the layout creates the ticks."""

    @functools.wraps(picture)
    def styled(*args: _P.args, **kwargs: _P.kwargs) -> Any:
        try:
            import matplotlib
            import matplotlib.figure
        except ImportError as error:
            raise missing_extra("report", "drawing pictures", error) from error
        with matplotlib.rc_context(_RC), any_letter():
            figure = picture(*args, **kwargs)
            write_powers_out(figure)
            figure.draw_without_rendering()
        return figure

    return styled


def page_figure(
    height: float | int,
    width: float | int = PAGE_WIDTH,
    layout: Literal["constrained"] | None = "constrained",
) -> Figure:
    """An empty figure of a size in millimetres."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width / 25.4, height / 25.4), layout=layout)
    if layout == "constrained":
        engine: Any = figure.get_layout_engine()
        engine.set(w_pad=0.06, h_pad=0.06)
    return figure


def place_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a position in millimetres from the lower left corner of the figure."""
    full_width, full_height = figure.get_size_inches() * 25.4
    return figure.add_axes(
        (left / full_width, bottom / full_height, width / full_width, height / full_height)
    )


def series_style(index: int) -> dict[str, Any]:
    """Colour and hatch of the n-th of several items without a fixed colour."""
    turn = index // len(SERIES)
    return {
        "facecolor": SERIES[index % len(SERIES)],
        "hatch": HATCHES[(index + 3 * turn) % len(HATCHES)] if turn else "",
        "edgecolor": "white",
    }


def readable(name: str) -> str:
    """A name of the code as words: `thread_sliding` → "thread sliding"."""
    return name.replace("_", " ")


def save_figures(folder: str | Path, figures: Mapping[str, Figure]) -> tuple[Path, ...]:
    """Write pictures by name into a folder, which is made if it is not there; their paths."""
    place = Path(folder)
    make_folder(place)
    return tuple(path for name, one in figures.items() for path in save_figure(one, place / name))


def save_figure(
    figure: Figure, path: str | Path, formats: Iterable[str] = ("png", "svg"), dpi: int = 200
) -> tuple[Path, ...]:
    """Write a picture in each format, `path` with its suffix replaced.

    **Arguments:**

    - `figure`: the picture.
    - `path`: where to write, without or with a suffix.
    - `formats`: `"png"`, `"svg"`, `"pdf"`.
    - `dpi`: resolution of PNG.

    **Returns:** the paths written. Each file is written completely or not at all.
    """
    import matplotlib

    written = []
    for format_ in formats:
        target = Path(path).with_suffix(f".{format_}")
        # A date in the file would make every report differ from the one before.
        metadata = {"Date": None} if format_ == "svg" else None
        if format_ == "pdf":
            metadata = {"CreationDate": None}
        with matplotlib.rc_context(_RC), any_letter(), whole_file(target) as partial:
            figure.savefig(partial, format=format_, dpi=dpi, metadata=metadata)
        written.append(target)
    return tuple(written)
