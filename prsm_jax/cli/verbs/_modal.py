"""The verb modal: natural frequencies, mode shapes, and frequencies against a parameter."""

import dataclasses
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from ..._errors import MissingDataError, PrsmError
from ...mechanism import Mechanism, find_parameters, stage_at
from ...quantities import AXIS_QUANTITIES, assumptions, available_quantities, compute
from ...response import SpatialDamping, spatial_damping
from ...vibration import (
    FAMILIES,
    FrequencyLoci,
    GroupedModes,
    Modes,
    SpatialModes,
    frequency_loci,
    modal as run_modal,
    spatial_modal as run_spatial_modal,
    strain_in_words,
    tilts,
)
from .._app import app
from .._common import VIBRATION, Common, checked, emit, value_of
from .._counts import MOST_VALUES, count
from .._progress import doing, expect_programs
from .._tables import in_units, prose, table

_DEFAULT = Common()
#: Values of the parameter, unless --points says otherwise.
_POINTS = 201
#: If the largest value is at least this many times the smallest, values are spaced in equal ratios.
_WIDE = 50.0
_KEYS = {"Hz": "hz", "N/m": "n_per_m"}
#: Of the table of modes in space.
_COLUMNS = ("family", "f Hz", "times")
#: Modes, and springs of each, in the table of energies; smaller shares are left out.
_MODES, _SPRINGS, _LEAST = 5, 4, 0.01


def modal_results(modes: GroupedModes, stage: int = 1) -> dict[str, Any]:
    """Natural frequencies by the names of the JSON."""
    return {
        "stage": stage,
        "frequencies_hz": np.asarray(modes.frequencies).tolist(),
        "families": modes.families,
        "multiplicities": modes.multiplicities,
    }


def shape_results(modes: GroupedModes) -> dict[str, Any]:
    """Mode shapes and energies by the names of the JSON, in the order of the frequencies."""
    return {
        "coordinates": [str(coordinate) for coordinate in modes.coordinates],
        # A row for each mode; rotations as u = r θ.
        "shapes_per_sqrt_kg": modes.shapes.T,
        "kinetic_energy_shares": modes.kinetic_energy_shares(),
        "strain_energy_shares": modes.strain_energy_shares(),
    }


def loci_results(loci: FrequencyLoci) -> dict[str, Any]:
    """Frequencies against a parameter by the names of the JSON."""
    results: dict[str, Any] = {
        "parameter": loci.parameter,
        "unit": loci.unit,
        "values": loci.values,
        "valid": loci.valid,
        # For each family a row for each value of the parameter.
        "frequencies_hz": loci.frequencies,
        "multiplicities": loci.multiplicities,
        "veerings": [
            {"family": v.family, "value": v.value, "frequencies_hz": v.frequencies}
            for v in loci.veerings()
        ],
    }
    if loci.shares is not None:
        shares = np.moveaxis(np.asarray(loci.shares), 1, 0)
        results["family_shares"] = dict(zip(FAMILIES, shares, strict=True))
    return results


def _values(
    mechanism: Mechanism, against: str, first: str | None, last: str | None, points: int
) -> np.ndarray:
    """Values of the parameter from `--from` to `--to` [SI]; integers if the parameter is one."""
    if first is None or last is None:
        raise PrsmError(f"--against {against}: give its range with --from and --to")
    ends = [
        value_of(mechanism, against, text, f"{option} {text}")
        for text, option in ((first, "--from"), (last, "--to"))
    ]
    if ends[0] == ends[1]:
        raise PrsmError(f"--from {first} --to {last}: must differ")
    if find_parameters(mechanism, against)[0].static:
        step = 1 if ends[1] > ends[0] else -1
        return np.arange(ends[0], ends[1] + step, step)
    if min(ends) > 0 and max(ends) >= _WIDE * min(ends):
        return np.geomspace(ends[0], ends[1], points)
    return np.linspace(ends[0], ends[1], points)


def _pictures(
    folder: Path,
    mechanism: Mechanism,
    modes: Modes,
    loci: FrequencyLoci | None,
    stage: int,
    animation: bool,
) -> tuple[Path, ...]:
    from ...report import frequency_loci_chart, mode_shapes, save_figures, save_mode_animations

    # Everything that can fail is done before the folder is made.
    drawn = {"mode-shapes": mode_shapes(mechanism, modes, stage=stage)}
    if loci is not None:
        name = "frequencies-against-" + loci.parameter.replace(".", "-")
        drawn[name] = frequency_loci_chart(loci)
    written = save_figures(folder, drawn)
    if animation:
        written += save_mode_animations(folder, mechanism, modes, stage=stage)
    return written


@app.command
def modal(
    file: str,
    *,
    stage: Annotated[int, count(1, help="Which stage, counted from 1.")] = 1,
    shapes: Annotated[
        bool, Parameter(negative="", help="Mode shapes and energy shares in the JSON, too.")
    ] = False,
    animation: Annotated[
        bool, Parameter(help="With --out: one animated GIF for each distinct mode.")
    ] = True,
    against: Annotated[
        str | None, Parameter(help="Also the frequencies against this number of the file.")
    ] = None,
    first: Annotated[
        str | None,
        Parameter(
            name="--from", allow_leading_hyphen=True, help="First value of this number: '20 deg'."
        ),
    ] = None,
    last: Annotated[
        str | None, Parameter(name="--to", allow_leading_hyphen=True, help="Last value.")
    ] = None,
    points: Annotated[
        int, count(3, MOST_VALUES, help="Number of values, both ends included.")
    ] = _POINTS,
    spatial: Annotated[
        bool,
        Parameter(
            negative="",
            help="Vibration in space: bodies also move along the axis, motor and load with them.",
        ),
    ] = False,
    tilt: Annotated[
        bool, Parameter(negative="", help="With --spatial: screw, nut and rollers also tilt.")
    ] = False,
    common: Common = _DEFAULT,
) -> int:
    """Natural frequencies and families of one stage; pictures of the modes with --out."""
    mechanism = common.load(file)
    if spatial:
        unused = {
            "--from": first is not None,
            "--to": last is not None,
            "--points": points != _POINTS,
            "--no-animation": not animation,
        }
        if given := [option for option, is_given in unused.items() if is_given]:
            raise PrsmError(f"{', '.join(given)}: not with --spatial, which draws no such pictures")
        return _spatial(file, mechanism, stage, shapes, against, tilt, common)
    if tilt:
        raise PrsmError("--tilt: give --spatial too; only the model in space has tilts")
    if against is None and (first is not None or last is not None):
        raise PrsmError("--from and --to: give the name of their number with --against")
    values = None if against is None else _values(mechanism, against, first, last, points)
    expect_programs("modal")
    modes = run_modal(mechanism, stage=stage, shapes=shapes or common.out is not None)
    loci = None
    if against is not None and values is not None:
        doing(f"frequencies against {against}")
        loci = frequency_loci(mechanism, against, values, stage=stage)
    written: tuple[Path, ...] = ()
    if common.out is not None:
        doing("drawing")
        written = _pictures(common.out, mechanism, modes, loci, stage, animation)

    results = modal_results(modes, stage)
    if shapes:
        results |= shape_results(modes)
    if loci is not None:
        results["against"] = loci_results(loci)
    if written:
        results["pictures"] = written

    def text() -> str:
        frequencies = results["frequencies_hz"]
        rows = [
            (modes.families[at], frequencies[at], modes.multiplicities[at]) for at in modes.distinct
        ]
        title = f"Natural frequencies: {file}, stage {stage}"
        lines = table(title, ["family", "f Hz", "times"], rows)
        if loci is not None:
            lines += _loci_table(loci, first, last)
        if written:
            lines += f"{len(written)} pictures in {common.out}\n"
        return lines

    valid = emit(common, results, text, assumptions(mechanism, VIBRATION), checked(mechanism))
    return int(not valid)


def _spatial(
    file: str,
    mechanism: Mechanism,
    stage: int,
    shapes: bool,
    against: str | None,
    tilt: bool,
    common: Common,
) -> int:
    if against is not None:
        raise PrsmError(
            f"--against {against}: not with --spatial; use prsm sweep with --quantities "
            "first_axial_frequency,antiresonance_frequency"
        )
    expect_programs("spatial_modal")
    axis = mechanism.axis
    if tilt and axis is not None:
        # Numbers of the axis and pictures are those of the file: it says that bodies tilt.
        mechanism = dataclasses.replace(mechanism, axis=dataclasses.replace(axis, tilt=True))
    found = Spatial(mechanism, stage, tilts(mechanism, True if tilt else None))
    results = spatial_results(found, shapes)
    written: tuple[Path, ...] = ()
    if common.out is not None:
        doing("drawing")
        from ...report import save_axis_pictures

        written = save_axis_pictures(common.out, mechanism, found.modes, found.held)
        results["pictures"] = written

    def text() -> str:
        lines = spatial_text(found, file)
        return lines + (f"{len(written)} pictures in {common.out}\n" if written else "")

    assumed = assumptions(mechanism, ("first_axial_frequency",))
    valid = emit(common, results, text, assumed, checked(mechanism))
    return int(not valid)


def _loci_table(loci: FrequencyLoci, first: str | None, last: str | None) -> str:
    rows = [
        (family if family in FAMILIES else "", float(curve[0]), float(curve[-1]))
        for family, curves in loci.frequencies.items()
        for curve in np.asarray(curves).T
    ]
    columns = ["family", f"f Hz at {first}", f"f Hz at {last}"]
    return table(f"against {loci.parameter}", columns, rows)


def _damping(mechanism: Mechanism, stage: int, tilt: bool) -> SpatialDamping | None:
    """Damping by creep friction, where speed, load and friction of the threads are given."""
    try:
        return spatial_damping(mechanism, stage=stage, shapes=True, tilt=tilt)
    except MissingDataError:
        # Frequencies need less.
        return None


class Spatial:
    """Modes in space of a mechanism, and numbers of its axis."""

    def __init__(self, mechanism: Mechanism, stage: int, tilt: bool = False):
        self.mechanism, self.stage, self.tilt = mechanism, stage, tilt
        self.damping = _damping(mechanism, stage, tilt)
        self.modes: SpatialModes = (
            run_spatial_modal(mechanism, stage=stage, shapes=True, tilt=tilt)
            if self.damping is None
            else self.damping.modes
        )
        self.elastic = self.modes.elastic_modes()
        self.held: SpatialModes | None = None
        axis = mechanism.axis
        if axis is not None and axis.motor is not None:
            self.held = run_spatial_modal(
                mechanism, stage=stage, shapes=True, motor_held=True, tilt=tilt
            )
        self.axis: dict[str, float] = {}
        if axis is not None:
            names = available_quantities(mechanism, tuple(AXIS_QUANTITIES))
            values = compute(mechanism, names)
            self.axis = {name: float(values[name]) for name in names}


def spatial_results(found: Spatial, shapes: bool) -> dict[str, Any]:
    """Modes in space by the names of the JSON."""
    modes = found.modes
    results: dict[str, Any] = modal_results(modes, found.stage) | {
        "spatial": True,
        "tilt": found.tilt,
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
    if found.damping is not None:
        creep = found.damping.creep
        results["creep_friction"] = {
            "result": found.damping.result_name,
            # In the order of frequencies_hz.
            "damping_ratios": np.asarray(found.damping.damping_ratios).tolist(),
            # Where not, the ratio is that of first order.
            "vibrating": np.asarray(found.damping.vibrating).tolist(),
            "slip_speed_m_per_s": float(creep.slip_speed),
            "contact_force_n": float(creep.contact_force),
            "damping_along_slip_n_s_per_m": float(creep.damping_along_slip),
            "damping_across_slip_n_s_per_m": float(creep.damping_across_slip),
        }
    if found.held is not None:
        held = [mode.frequency for mode in found.held.elastic_modes()]
        results["antiresonances_hz"] = held
    if found.axis:
        results["axis"] = {
            f"{name}_{_KEYS[AXIS_QUANTITIES[name][1]]}": value for name, value in found.axis.items()
        }
    return results | shape_results(modes) if shapes else results


def spatial_text(found: Spatial, file: str) -> str:
    """Tables of frequencies, of the axis, and of the energies that say what to stiffen."""
    modes = found.modes
    values = modes.frequencies.tolist()
    rows: list[tuple[Any, ...]] = [
        (modes.families[at], 0.0 if modes.families[at] == "rigid" else values[at], times)
        for at, times in ((at, modes.multiplicities[at]) for at in modes.distinct)
    ]
    tilting = ", bodies tilting" if found.tilt else ""
    title = f"Natural frequencies in space{tilting}: {file}, stage {found.stage}"
    columns = _COLUMNS
    damping = found.damping
    if damping is not None:
        ratios, columns = np.asarray(damping.damping_ratios), (*_COLUMNS, "damping %")
        shown = [
            100 * float(ratio) if vibrates else f"{100 * float(ratio):.4g} (first order)"
            for ratio, vibrates in zip(ratios, np.asarray(damping.vibrating), strict=True)
        ]
        rows = [(*row, shown[at]) for row, at in zip(rows, modes.distinct, strict=True)]
    lines = table(title, list(columns), rows)
    if damping is not None:
        given = stage_at(found.mechanism, found.stage).damping is not None
        other = "[stage.damping] of the file is not included" if given else "no other"
        lines += prose(f"Damping: friction of the sliding threads at the operating point, {other}.")
        if damping.result_name != "successful":
            lines += prose(damping.result)
    if found.axis:
        listed = [(*AXIS_QUANTITIES[n], v) for n, v in found.axis.items()]
        converted = in_units((words, value, unit) for words, unit, value in listed)
        lines += "\n" + table("Axis", ["", "value", "unit"], converted)
    turning = stage_at(found.mechanism, found.stage).thread.family.turning
    shares = [
        (f"{mode.number} {mode.family}", mode.frequency, words, 100 * share)
        for mode in found.elastic[:_MODES]
        for words, share in list(strain_in_words(mode.strain, turning).items())[:_SPRINGS]
        if share >= _LEAST
    ]
    title = "Strain energy of axial–torsional modes: which springs to stiffen"
    return lines + "\n" + table(title, ["mode", "f Hz", "spring", "share %"], shares)
