"""Mode shapes and motion, drawn and moving."""

from ._mode_animation import (
    save_mode_animation as save_mode_animation,
    save_mode_animations as save_mode_animations,
)
from ._mode_shapes import mode_shapes as mode_shapes
from ._stage_animation import save_motion_animation as save_motion_animation
