"""Verbs of forced vibration: response, campbell."""

from typing import Annotated, Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from cyclopts import Parameter

from ..._errors import PrsmError
from ...fields import as_scalar
from ...mechanism import Mechanism, ModalDamping
from ...programs import one_program_where_possible
from ...quantities import assumptions
from ...response import (
    Campbell,
    Crossing,
    FrequencyResponse,
    Kind,
    campbell as run_campbell,
    frequency_response,
)
from ...vibration import Modes, modal as run_modal
from .._app import app
from .._common import CRITICAL_SPEEDS, VIBRATION, Common, checked, emit, words_of
from .._counts import MOST_VALUES, count
from .._progress import expect_programs
from .._tables import prose, table

_DEFAULT = Common()
_Stage = Annotated[int, count(1, help="Which stage, counted from 1.")]
_frequency_response = one_program_where_possible(frequency_response)
_modes = one_program_where_possible(run_modal)
_campbell = one_program_where_possible(run_campbell)


def _range(modes: Modes, fmin: float | None, fmax: float | None, points: int) -> np.ndarray:
    """Frequencies on a logarithmic axis, from below the first elastic mode to above the last."""
    natural = np.asarray(modes.frequencies)
    elastic = natural[np.asarray(modes.families) != "rigid"]
    first = elastic.min() / 3 if fmin is None else fmin
    last = elastic.max() * 2 if fmax is None else fmax
    if not 0 <= first < last < np.inf:
        raise PrsmError(
            f"--fmin {first:.6g} --fmax {last:.6g}: must be 0 Hz or more, and fmin below fmax"
        )
    # A logarithmic axis cannot start at 0.
    return np.geomspace(first, last, points) if first > 0 else np.linspace(first, last, points)


def response_results(
    response: FrequencyResponse, modes: Modes, law: str | None, stage: int
) -> dict[str, Any]:
    """A frequency response by the names of the JSON."""
    return {
        "stage": stage,
        "from": response.excitation,
        "to": response.response,
        "kind": response.kind,
        "unit": response.unit,
        "damping": law,
        "frequency_hz": response.frequency,
        "real": response.value.real,
        "imaginary": response.value.imag,
        "magnitude_db": response.decibel,
        "phase_rad": response.phase,
        "at_pole": response.at_pole,
        "natural_frequencies_hz": modes.frequencies,
        "families": modes.families,
        "multiplicities": modes.multiplicities,
    }


def _damped(mechanism: Mechanism, stage: int, ratio: float | None) -> Any:
    if not 1 <= stage <= len(mechanism.stages):
        raise PrsmError(f"--stage {stage}: the mechanism has {len(mechanism.stages)} stage(s)")
    if ratio is None:
        return mechanism.stages[stage - 1].damping
    if not 0 <= ratio < 1:
        raise PrsmError(f"--ratio {ratio:g}: must be 0 or more and less than 1")
    return ModalDamping(as_scalar(ratio))


def _undamped(infinite: np.ndarray) -> str:
    """What the table of a response without damping shows."""
    words = "no damping, so infinite at resonance; give [stage.damping] or --ratio"
    if infinite.all():
        return words
    finite = "the modes of this frequency do not connect the two places; the others give the value"
    return f"{words}. Finite: {finite}"


@app.command
def response(
    file: str,
    *,
    source: Annotated[
        str,
        Parameter(name="--from", help="Where the force acts: 'screw u', 'nut x', 'roller 3 u', …"),
    ] = "screw u",
    target: Annotated[
        str, Parameter(name="--to", help="Where the motion is measured, written as --from.")
    ] = "nut u",
    fmin: Annotated[float | None, Parameter(help="Lowest frequency in Hz.")] = None,
    fmax: Annotated[float | None, Parameter(help="Highest frequency in Hz.")] = None,
    points: Annotated[
        int, count(2, MOST_VALUES, help="Number of frequencies, spaced in equal ratios.")
    ] = 2001,
    kind: Annotated[Kind, Parameter(help="Displacement, velocity or acceleration.")] = "receptance",
    ratio: Annotated[
        float | None,
        Parameter(help="Damping ratio of every mode, instead of the file's [stage.damping]."),
    ] = None,
    stage: _Stage = 1,
    common: Common = _DEFAULT,
) -> int:
    """Frequency response of one degree of freedom to a force at another; x, y and u = r θ."""
    mechanism = common.load(file)
    damping = _damped(mechanism, stage, ratio)
    expect_programs("modal", "frequency_response")
    modes = _modes(mechanism, stage=stage, shapes=True)
    hertz = _range(modes, fmin, fmax, points)
    natural = np.asarray(modes.frequencies)
    at_modes = np.array([natural[k] for k in modes.distinct])
    both = _frequency_response(
        mechanism,
        source,
        target,
        jnp.asarray(np.concatenate([hertz, at_modes])),
        stage=stage,
        damping=damping,
        kind=kind,
    )

    def part(where: slice) -> FrequencyResponse:
        return eqx.tree_at(
            lambda f: (f.frequency, f.value, f.at_pole),
            both,
            (both.frequency[where], both.value[where], both.at_pole[where]),
        )

    curve, peaks = part(slice(None, points)), part(slice(points, None))
    law = None if damping is None else damping.law
    picture = None
    if common.out is not None and np.asarray(curve.value).any():
        from ...report import response_chart, save_figures

        figure = response_chart({law or "undamped": curve}, modes)
        picture = save_figures(common.out, {"response": figure})[0]

    def text() -> str:
        unit = f"|H| dB re 1 {curve.unit}"
        rows = [
            (modes.families[k], at_modes[index], modes.multiplicities[k], size, angle)
            for index, (k, size, angle) in enumerate(
                zip(
                    modes.distinct,
                    np.asarray(peaks.decibel).tolist(),
                    np.degrees(np.asarray(peaks.phase)).tolist(),
                    strict=True,
                )
            )
        ]
        title = f"{kind.capitalize()} of {target} per force at {source}: {file}, stage {stage}"
        lines = table(title, ["family", "f Hz", "times", unit, "phase deg"], rows)
        if law is None and np.asarray(peaks.at_pole).any():
            lines += prose(_undamped(np.asarray(peaks.at_pole)))
        if not np.asarray(both.value).any():
            lines += prose(f"by symmetry a force at {source} does not move {target}")
        return lines + ("" if picture is None else f"picture: {picture}")

    results = response_results(curve, modes, law, stage)
    valid = emit(common, results, text, assumptions(mechanism, VIBRATION), checked(mechanism))
    return int(not valid)


def campbell_results(diagram: Campbell, max_speed: float, stage: int) -> dict[str, Any]:
    """A Campbell diagram by the names of the JSON."""
    return {
        "stage": stage,
        "carrier_ratio": diagram.carrier_ratio,
        "max_speed_rpm": max_speed * 30 / np.pi,
        "orders": [
            {
                "name": order.name,
                "order": order.order,
                "lobes": order.lobes,
                "description": order.description,
            }
            for order in diagram.orders
        ],
        "frequencies_hz": diagram.modes.frequencies,
        "families": diagram.modes.families,
        "multiplicities": diagram.modes.multiplicities,
        "crossings": [
            {
                "speed_rpm": crossing.speed_rpm,
                "speed_rad_per_s": crossing.speed,
                "order": crossing.order,
                "harmonic": crossing.harmonic,
                "frequency_hz": crossing.frequency,
                "family": crossing.family,
                "multiplicity": crossing.multiplicity,
                "excited": crossing.excited,
            }
            for crossing in diagram.crossings(max_speed)
        ],
    }


def _max_speed(mechanism: Mechanism, rpm: float | None) -> float:
    """The end of the speed range [rad/s]: given, or 1.5 times the operating speed, or 3000 rpm."""
    point = mechanism.operating_point
    if rpm is None:
        speed = 0.0 if point is None else 1.5 * abs(float(point.speed))
        return speed or 3000 * np.pi / 30
    if not 0 < rpm < np.inf:
        raise PrsmError(f"--max-rpm {rpm:g}: must be more than 0")
    return rpm * np.pi / 30


def _speeds_of_operation(mechanism: Mechanism) -> tuple[float, float] | None:
    """Lowest and highest speed of operating point and duty cycle, standstill apart [rad/s]."""
    point, cycle = mechanism.operating_point, mechanism.duty_cycle
    given = [] if point is None else [np.abs(np.ravel(point.speed))]
    given += [] if cycle is None else [np.abs(np.ravel(cycle.speed))]
    speeds = np.concatenate(given) if given else np.zeros(0)
    speeds = speeds[speeds > 0]
    return (float(speeds.min()), float(speeds.max())) if speeds.size else None


def _in_words(crossing: Crossing) -> str:
    """Speed of a crossing, and what meets there."""
    return (
        f"{crossing.speed_rpm:.6g} rpm, where harmonic {crossing.harmonic} of {crossing.order} "
        f"meets {crossing.frequency:.6g} Hz ({crossing.family})"
    )


@app.command
def campbell(
    file: str,
    *,
    max_rpm: Annotated[
        float | None,
        Parameter(help="Highest screw speed in rpm; default 1.5 times the operating speed."),
    ] = None,
    harmonics: Annotated[int, count(1, 1000, help="Number of harmonics of each order.")] = 3,
    orders: Annotated[
        str | None, Parameter(help="Names of orders, separated by commas; default all.")
    ] = None,
    every: Annotated[
        bool,
        Parameter(negative="", help="Also list crossings that the phases of the rollers cancel."),
    ] = False,
    stage: _Stage = 1,
    common: Common = _DEFAULT,
) -> int:
    """Screw speeds at which excitations from the kinematics meet natural frequencies."""
    mechanism = common.load(file)
    speed = _max_speed(mechanism, max_rpm)
    names = words_of(orders)
    expect_programs("campbell")
    diagram = _campbell(
        mechanism, stage=stage, harmonics=harmonics, orders=None if names is None else tuple(names)
    )
    picture = None
    if common.out is not None and diagram.crossings(speed):
        from ...report import campbell_chart, save_figures

        chart = campbell_chart(diagram, speed, _speeds_of_operation(mechanism))
        picture = save_figures(common.out, {"campbell": chart})[0]

    def text() -> str:
        rows = [
            (
                one.speed_rpm,
                one.order,
                one.harmonic,
                one.frequency,
                one.family,
                one.multiplicity,
                "yes" if one.excited else "no",
            )
            for one in diagram.crossings(speed, excited_only=not every)
        ]
        columns = ["rpm", "order", "harmonic", "f Hz", "family", "times", "excited"]
        title = f"Critical speeds up to {speed * 30 / np.pi:.6g} rpm: {file}, stage {stage}"
        lines = table(title, columns, rows) if rows else f"{title}\nnone\n"
        beyond = diagram.crossings(excited_only=not every)
        if not rows and beyond:
            lines += prose(f"The lowest is {_in_words(beyond[0])}.")
        if common.out is not None and picture is None:
            lines += prose(
                f"No picture: no order meets a natural frequency up to {speed * 30 / np.pi:.6g} "
                "rpm; give a higher --max-rpm or more --harmonics."
            )
        orders = ", ".join(f"{one.name} {float(one.order):.5g}" for one in diagram.orders)
        ratio = f"carrier ratio {float(diagram.carrier_ratio):.6g}"
        turning = mechanism.stages[stage - 1].thread.family.turning
        lines += prose(f"{ratio}; orders per turn of the {turning}: {orders}")
        return lines + ("" if picture is None else f"picture: {picture}")

    results = campbell_results(diagram, speed, stage)
    valid = emit(common, results, text, assumptions(mechanism, CRITICAL_SPEEDS), checked(mechanism))
    return int(not valid)
