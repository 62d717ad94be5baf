"""Text in pictures: plain characters, also those that the font lacks."""

import contextlib
import re
import warnings
from collections.abc import Generator
from typing import Any

from ..text import MINUS

_POWER = re.compile(r"\$\\mathdefault\{(-?)(?:([\d.]+)\\times)?(\d+)\^\{(-?\d+)\}\}\$")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@contextlib.contextmanager
def any_letter() -> Generator[None, None, None]:
    """Draw characters that the font lacks as boxes, without warnings."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from", UserWarning)
        warnings.filterwarnings("ignore", "Matplotlib currently does not support", UserWarning)
        yield


def write_powers_out(figure: Any) -> None:
    """Write powers of ten on logarithmic axes as plain characters, not as formulas."""
    from matplotlib.ticker import LogFormatterMathtext, LogFormatterSciNotation

    class Powers(LogFormatterSciNotation):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return _POWER.sub(_power, super().__call__(x, pos))

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if isinstance(axis.get_major_formatter(), LogFormatterMathtext):
                axis.set_major_formatter(Powers())
            minor = axis.get_minor_formatter()
            if isinstance(minor, LogFormatterMathtext):
                axis.set_minor_formatter(Powers(minor_thresholds=minor.minor_thresholds))


def _power(match: re.Match[str]) -> str:
    sign, times, base, power = match.groups()
    return f"{sign and MINUS}{times + '·' if times else ''}{base}{power.translate(_RAISED)}"
