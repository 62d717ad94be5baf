"""What the verb modal prints and draws with --spatial: vibration in space, with the axis."""

from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from ...mechanism import Mechanism, set_parameter
from ...quantities import available_quantities, compute
from ...response import axis_compliance
from ...vibration import SpatialModes, spatial_modal as run_spatial_modal
from .._tables import in_units, table

_modes = eqx.filter_jit(run_spatial_modal)
#: Quantities of the axis: labels of the table, and names of the JSON without their unit.
AXIS_QUANTITIES = {
    "first_axial_frequency": ("first axial frequency", "Hz"),
    "first_torsional_frequency": ("first torsional frequency", "Hz"),
    "first_transverse_frequency": ("first transverse frequency", "Hz"),
    "antiresonance_frequency": ("anti-resonance, motor held", "Hz"),
    "position_loop_frequency": ("position loop", "Hz"),
    "servo_stiffness": ("servo stiffness at the load", "N/m"),
    "held_motor_stiffness": ("stiffness with the motor held", "N/m"),
}
_KEYS = {"Hz": "hz", "N/m": "n_per_m"}
#: Positions of the nut, and frequencies of the compliance, in pictures.
_POSITIONS, _FREQUENCIES = 41, 1200
#: Modes, and springs of each, in the table of energies; smaller shares are left out.
_MODES, _SPRINGS, _LEAST = 5, 4, 0.01
_POSITION = "axis.shaft.nut_distance"


class Spatial:
    """Modes in space of a mechanism, and numbers of its axis."""

    def __init__(self, mechanism: Mechanism, stage: int):
        self.mechanism, self.stage = mechanism, stage
        self.modes: SpatialModes = _modes(mechanism, stage=stage, shapes=True)
        self.elastic = self.modes.elastic_modes()
        self.held: SpatialModes | None = None
        axis = mechanism.axis
        if axis is not None and axis.motor is not None:
            self.held = _modes(mechanism, stage=stage, shapes=True, motor_held=True)
        self.axis: dict[str, float] = {}
        if axis is not None:
            names = available_quantities(mechanism, tuple(AXIS_QUANTITIES))
            values = eqx.filter_jit(lambda m: compute(m, names))(mechanism)
            self.axis = {name: float(values[name]) for name in names}


def spatial_results(found: Spatial, shapes: bool) -> dict[str, Any]:
    """Modes in space by the names of the JSON."""
    modes = found.modes
    results: dict[str, Any] = {
        "stage": found.stage,
        "spatial": True,
        "frequencies_hz": np.asarray(modes.frequencies).tolist(),
        "families": modes.families,
        "multiplicities": modes.multiplicities,
        # The elastic axial–torsional modes, ascending.
        "axial_torsional": [
            {
                "number": mode.number,
                "family": mode.family,
                "frequency_hz": mode.frequency,
                "kinetic_energy_shares": mode.kinetic,
                "strain_energy_shares": mode.strain,
            }
            for mode in found.elastic
        ],
    }
    if found.held is not None:
        held = [mode.frequency for mode in found.held.elastic_modes()]
        results["antiresonances_hz"] = held
    if found.axis:
        results["axis"] = {
            f"{name}_{_KEYS[AXIS_QUANTITIES[name][1]]}": value for name, value in found.axis.items()
        }
    if shapes:
        results["coordinates"] = [str(coordinate) for coordinate in modes.coordinates]
        # A row for each mode; rotations as u = r θ.
        results["shapes_per_sqrt_kg"] = modes.shapes.T
        results["kinetic_energy_shares"] = modes.kinetic_energy_shares()
        results["strain_energy_shares"] = modes.strain_energy_shares()
    return results


def spatial_text(found: Spatial, file: str) -> str:
    """Tables of frequencies, of the axis, and of the energies that say what to stiffen."""
    modes = found.modes
    values = modes.frequencies.tolist()
    rows = [
        (modes.families[at], 0.0 if modes.families[at] == "rigid" else values[at], times)
        for at, times in ((at, modes.multiplicities[at]) for at in modes.distinct)
    ]
    title = f"Natural frequencies in space: {file}, stage {found.stage}"
    lines = table(title, ["family", "f Hz", "times"], rows)
    if found.axis:
        listed = [(*AXIS_QUANTITIES[n], v) for n, v in found.axis.items()]
        converted = in_units((words, value, unit) for words, unit, value in listed)
        lines += "\n" + table("Axis", ["", "value", "unit"], converted)
    shares = [
        (f"{mode.number} {mode.family}", mode.frequency, name.replace("_", " "), 100 * share)
        for mode in found.elastic[:_MODES]
        for name, share in list(mode.strain.items())[:_SPRINGS]
        if share >= _LEAST
    ]
    title = "Strain energy of axial–torsional modes: which springs to stiffen"
    return lines + "\n" + table(title, ["mode", "f Hz", "spring", "share %"], shares)


@eqx.filter_jit
def _at_positions(mechanism: Mechanism, names: tuple[str, ...], distances):
    def at(distance):
        return compute(set_parameter(mechanism, _POSITION, distance, checked=False), names)

    return jax.vmap(at)(distances)


def _positions(mechanism: Mechanism) -> np.ndarray:
    """Places of the nut from one end of the screw to the other, or to the far bearing [m]."""
    stage, axis = mechanism.stages[0], mechanism.axis
    assert axis is not None
    assert axis.shaft is not None
    assert stage.screw.length is not None
    end = float(stage.screw.length)
    if axis.shaft.far_bearing is not None:
        end = float(axis.shaft.far_bearing.distance)
    half = 0.05 * end if stage.nut.length is None else float(stage.nut.length) / 2
    return np.linspace(half, end - half, _POSITIONS)


def spatial_pictures(folder: Path, found: Spatial) -> tuple[Path, ...]:
    """Mode shapes of the axis; with an axis its compliance, and numbers against the nut's place."""
    from ...report import (
        NUT_POSITION_QUANTITIES,
        axis_compliance_chart,
        axis_mode_shapes,
        nut_position_chart,
        save_figures,
    )

    mechanism = found.mechanism
    drawn = {}
    if found.elastic:
        drawn["axis-mode-shapes"] = axis_mode_shapes(mechanism, found.modes)
    axis = mechanism.axis
    if axis is not None:
        largest = max((mode.frequency for mode in found.elastic[:5]), default=1e3)
        first = min((mode.frequency for mode in found.elastic), default=10.0)
        hertz = np.geomspace(first / 20, 1.5 * largest, _FREQUENCIES)
        compliance = eqx.filter_jit(axis_compliance)(mechanism, jnp.asarray(hertz))
        drawn["axis-compliance"] = axis_compliance_chart(compliance, found.modes, found.held)
    if axis is not None and axis.shaft is not None:
        names = tuple(name for name in found.axis if name in NUT_POSITION_QUANTITIES)
        distances = _positions(mechanism)
        values = _at_positions(mechanism, names, jnp.asarray(distances))
        given = float(axis.shaft.nut_distance)
        drawn["axis-against-nut-position"] = nut_position_chart(distances, values, given)
    return save_figures(folder, drawn)
