"""All pictures of the axis around a mechanism, computed and written."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

from ...mechanism import AxisShaft, Mechanism, set_parameter
from ...programs import one_program_where_possible
from ...quantities import available_quantities, compute
from ...response import axis_compliance
from ...vibration import SpatialModes
from .._style import save_figures
from ._axis_compliance_chart import axis_compliance_chart
from ._axis_mode_shapes import axis_mode_shapes
from ._nut_position_chart import NUT_POSITION_QUANTITIES, nut_position_chart

#: Positions of the nut, and frequencies of the compliance, up to beyond so many modes.
_POSITIONS, _FREQUENCIES, _MODES = 41, 1200, 5


def save_axis_pictures(
    folder: str | Path,
    mechanism: Mechanism,
    modes: SpatialModes,
    held: SpatialModes | None = None,
) -> tuple[Path, ...]:
    """Write the axial–torsional mode shapes, the compliance, and numbers against the nut's place.

    The compliance needs an axis, and the last picture an elastic screw.

    **Arguments:**

    - `folder`: made if it is not there.
    - `mechanism`: the mechanism.
    - `modes`: its modes, from `spatial_modal(mechanism, shapes=True)`.
    - `held`: those with the motor held, also with shapes; marked in the compliance.

    **Returns:** the paths written.

    **Raises:** `ValueError` if the shapes were not computed; `MissingExtraError` without
    matplotlib.
    """
    drawn, elastic = {}, modes.elastic_modes()
    if elastic:
        drawn["axis-mode-shapes"] = axis_mode_shapes(mechanism, modes)
    axis, turning = mechanism.axis, mechanism.stages[0].thread.family.turning
    if axis is not None and elastic:
        first, last = elastic[0].frequency, elastic[:_MODES][-1].frequency
        hertz = jnp.geomspace(first / 20, 1.5 * last, _FREQUENCIES)
        compliance = _axis_compliance(mechanism, hertz)
        drawn["axis-compliance"] = axis_compliance_chart(compliance, modes, held, turning=turning)
    if axis is not None and axis.shaft is not None:
        names = available_quantities(mechanism, tuple(NUT_POSITION_QUANTITIES))
        if axis.motor is None or axis.motor.controller is None:
            # Without a controller it is that with the motor held.
            names = tuple(name for name in names if name != "servo_stiffness")
        distances = _positions(mechanism, axis.shaft)
        values = _at_positions(mechanism, names, jnp.asarray(distances))
        given = float(axis.shaft.nut_distance)
        drawn["axis-against-nut-position"] = nut_position_chart(
            distances, values, given, turning=turning
        )
    return save_figures(folder, drawn)


_axis_compliance = one_program_where_possible(axis_compliance)


@one_program_where_possible
def _at_positions(mechanism: Mechanism, names: tuple[str, ...], distances):
    def at(distance):
        moved = set_parameter(mechanism, "axis.shaft.nut_distance", distance, checked=False)
        return compute(moved, names)

    return jax.vmap(at)(distances)


def _positions(mechanism: Mechanism, shaft: AxisShaft) -> np.ndarray:
    """Places of the nut from one end of the screw to the other, or to the far bearing [m]."""
    stage = mechanism.stages[0]
    given = stage.screw.length if shaft.far_bearing is None else shaft.far_bearing.distance
    assert given is not None
    end = float(given)
    half = 0.05 * end if stage.nut.length is None else float(stage.nut.length) / 2
    return np.linspace(half, end - half, _POSITIONS)
