"""Transients whose driving torque is prescribed."""

from ._smooth_torque import (
    has_smooth_threads as has_smooth_threads,
    smooth_torque_history as smooth_torque_history,
)
from ._torque_transient import torque_history as torque_history
