"""Data of what matplotlib has drawn, as arrays; its own types leave open what they are."""

from typing import Any

import numpy as np
from matplotlib.patches import Rectangle


def x_data(line: Any) -> np.ndarray:
    """Numbers of a line along the first axis."""
    return np.asarray(line.get_xdata())


def y_data(line: Any) -> np.ndarray:
    """Numbers of a line along the second axis."""
    return np.asarray(line.get_ydata())


def vertices_of(path: Any) -> np.ndarray:
    """Corners of a path, of the shape (corners, 2)."""
    return np.asarray(path.vertices)


def levels_of(contours: Any) -> np.ndarray:
    """Levels of drawn contours."""
    return np.asarray(contours.levels)


def box_of(patch: Any) -> Rectangle:
    """A bar or a frame, with the methods of a rectangle."""
    return patch
