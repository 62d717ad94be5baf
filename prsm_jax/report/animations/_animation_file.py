"""Animated GIFs: frames with one palette, written completely or not at all."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...process import whole_file


def save_frames(target: Path, frames: Sequence[Any], seconds: float) -> Path:
    """Write indexed pictures as a GIF that repeats.

    **Arguments:**

    - `target`: where to write.
    - `frames`: Pillow pictures, one after the other.
    - `seconds`: duration of all frames [s].
    """
    with whole_file(target) as partial:
        frames[0].save(
            partial,
            format="GIF",
            save_all=True,
            append_images=list(frames[1:]),
            # GIF counts hundredths of a second; browsers replace fewer than two by ten.
            duration=10 * max(round(100 * seconds / len(frames)), 2),
            loop=0,
            optimize=False,
        )
    return target


def indexed(pixels: np.ndarray, palette: np.ndarray) -> Any:
    """A picture in the nearest colours of a palette; Pillow's own search is not exact."""
    from PIL import Image

    packed = pixels.astype(np.int64) @ (1 << 16, 1 << 8, 1)
    colours, inverse = np.unique(packed, return_inverse=True)
    single = np.stack([colours >> 16, (colours >> 8) & 255, colours & 255], axis=1)
    nearest = np.argmin(np.sum((single[:, None] - palette[None]) ** 2, axis=2), axis=1)
    picture = Image.fromarray(nearest[inverse].reshape(packed.shape).astype(np.uint8))
    picture.putpalette(palette.astype(np.uint8).tobytes())
    return picture
