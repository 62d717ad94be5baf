"""Contact, vibration, steady state and transient as sections of a report."""

import math
from collections.abc import Mapping
from typing import Any, SupportsFloat

import numpy as np

from ...dynamics import error_in_words
from ...quantities import AXIS_QUANTITIES
from ...text import fixed, number, show
from .._style import readable
from ..animations import mode_shapes
from ..contact_charts import FlankLine, contact_ellipses
from ..interactive import (
    frequency_bars,
    history_curves,
    loss_bars,
    power_curves,
    transient_curves,
)
from ..motion_charts import (
    efficiency_text,
    energy_flow,
    history_chart,
    loss_chart,
    power_flow_chart,
    power_history_chart,
    settles,
    settling_words,
    share_text,
    steady_flow,
    transient_chart,
)
from ..results import SIDES, ReportData, any_cut, largest_pressures
from ..vibration_charts import elastic_modes, frequency_chart
from ._section import Picture, Section, Table


def _designs(data: ReportData, part: str, index: int | None = None) -> dict[str, Any]:
    """A part of the analysis by label: of the design alone, or before and after."""
    own, other = getattr(data, part), getattr(data.improved, part, None)
    pick = (lambda value: value) if index is None else (lambda value: value[index])
    if other is None:
        return {data.label: pick(own)}
    before, after = data.ends
    return {before: pick(own), after: pick(other)}


def _pressures(data: ReportData, index: int) -> dict[str, tuple[float, float]]:
    """Largest pressures of one stage, by label as in `_designs`."""
    designs = (data, data.improved)
    known = [one for one in designs if one is not None and one.contacts is not None]
    labels = _designs(data, "contacts", index)
    return {label: largest_pressures(one, index) for label, one in zip(labels, known, strict=True)}


def _ends(data: ReportData, index: int) -> dict[str, tuple[FlankLine, ...]]:
    """Crests and roots beside the ellipses of one stage, by label as in `_pressures`."""
    designs = (data, data.improved)
    known = [one for one in designs if one is not None and one.contacts is not None]
    labels = _designs(data, "contacts", index)
    return {
        label: one.flank_lines[index] if one.flank_lines else ()
        for label, one in zip(labels, known, strict=True)
    }


def contact_section(data: ReportData) -> Section | None:
    """Pressures, sizes and stiffnesses of the thread contacts."""
    if data.contacts is None or data.meshings is None:
        return None
    many, cut = len(data.contacts) > 1, any_cut(data)
    rows = []
    for index, (contact, meshing) in enumerate(zip(data.contacts, data.meshings, strict=True)):
        for side, pressure in zip(SIDES, largest_pressures(data, index), strict=True):
            point, part = getattr(meshing, side), getattr(contact, side)
            hertz = part.hertz
            rows.append(
                (
                    (f"stage {index + 1}, " if many else "") + side,
                    number(1e3 * float(point.contact_radius)),
                    number(math.degrees(float(point.contact_angle_position)), 3),
                    number(float(part.normal_force)),
                    number(1e6 * float(hertz.semi_major)),
                    number(1e6 * float(hertz.semi_minor)),
                    number(1e-6 * pressure),
                    number(1e6 * float(hertz.approach)),
                    number(1e-6 * float(hertz.stiffness)),
                    number(1e-6 * float(hertz.stiffness_tangent)),
                    *((number(1e-6 * float(hertz.max_pressure)),) if cut else ()),
                )
            )
    head = (
        "side",
        "contact radius in mm",
        "position in deg",
        "normal force in N",
        "semi-axis a in µm",
        "semi-axis b in µm",
        "p₀ in MPa",
        "approach in µm",
        "stiffness F/δ in N/µm",
        "dF/dδ in N/µm",
        *(("p₀ of the whole ellipse in MPa",) if cut else ()),
    )
    pictures = tuple(
        Picture(
            f"contact_ellipses{data.of_stage(i)[0]}",
            f"Contact ellipses of one thread{data.of_stage(i)[1]}, to the same scale, and the "
            "crests and roots in their reach.",
            lambda i=i: contact_ellipses(
                _designs(data, "contacts", i), _pressures(data, i), _ends(data, i)
            ),
        )
        for i in range(len(data.contacts))
    )
    words = ("One thread contact on each side of a roller, all engaged threads equally loaded.",)
    if cut:
        words += (
            "Ends of flanks cut ellipses here: p₀ is the largest pressure of the remaining part; "
            "semi-axes, approach and stiffnesses are those of whole ellipses.",
        )
    table = Table("Thread contacts", head, tuple(rows))
    return Section("contact", "Thread contact", words, (table,), pictures)


def vibration_section(data: ReportData) -> Section | None:
    """Natural frequencies by family, and those of the axis around the stage."""
    if data.modes is None and not data.axis:
        return None
    tables, pictures, paragraphs = [], [], ()
    for index, modes in enumerate(data.modes or ()):
        suffix, words = data.of_stage(index)
        designs = [elastic_modes(m) for m in _designs(data, "modes", index).values()]
        frequencies, rigid = designs[0]
        rows = []
        for (family, count), (value, multiplicity) in frequencies.items():
            share = _mesh_share(modes, family, value)
            cells = [f"{family} {count}", number(value, 5), str(multiplicity), fixed(share, 0)]
            if len(designs) > 1:
                after = designs[1][0].get((family, count))
                cells.append(number(after[0], 5) if after else "")
            rows.append(tuple(cells))
        if rigid:
            blank = ("",) * (len(designs) - 1)
            rows.append(("rigid", "0", str(rigid), "0", *blank))
        head = ("mode", "frequency in Hz", "multiplicity", "energy in the contacts in %")
        head += (f"{data.later} in Hz",) if len(designs) > 1 else ()
        tables.append(Table(f"Natural frequencies{words}", head, tuple(rows)))
        pictures.append(
            Picture(
                f"frequencies{suffix}",
                f"Natural frequencies by family{words}; ×2 marks a repeated frequency.",
                lambda index=index: frequency_chart(_designs(data, "modes", index)),
                lambda index=index: frequency_bars(_designs(data, "modes", index)),
            )
        )
        if modes.system is not None:
            pictures.append(
                Picture(
                    f"mode_shapes{suffix}",
                    f"Mode shapes{words}: the mechanism at the extreme of each motion, seen along "
                    "its axis.",
                    lambda index=index, modes=modes: mode_shapes(
                        data.mechanism, modes, stage=index + 1
                    ),
                )
            )
    if data.axis:
        paragraphs = (_WITH_AXIS,)
        tables.append(_axis_table(data, data.axis))
    return Section("vibration", "Vibration", paragraphs, tuple(tables), tuple(pictures))


_WITH_AXIS = (
    "Natural frequencies by family are those of the stage alone, whose bodies do not move along "
    "the axis. The table of the axis is that of prsm modal --spatial: all bodies move in space on "
    "the tangent stiffnesses of the contacts, with the motor, the elastic screw and the load of "
    "[axis], as far as the file has them."
)


def _axis_table(data: ReportData, axis: Mapping[str, Any]) -> Table:
    """Frequencies and stiffnesses of the axis, and those of the improved design."""
    after = None if data.improved is None else data.improved.axis
    rows = []
    for name in axis:
        words, unit = AXIS_QUANTITIES[name]
        values = [float(one[name]) for one in (axis, after) if one is not None]
        # Without a mode of this kind the frequency is infinite.
        cells = ["none" if math.isinf(one) else show(one, unit) for one in values]
        rows.append((words, *cells))
    return Table("Axis", ("", "value", *((data.later,) if after is not None else ())), tuple(rows))


def _mesh_share(modes, family: str, value: float) -> float:
    # Without symmetry all modes except the carrier's are in one group.
    group = modes.group(family) or modes.group("coupled")
    frequencies = np.asarray(group.frequencies)
    return 100 * float(np.asarray(group.mesh_energy_share)[np.abs(frequencies - value).argmin()])


def steady_section(data: ReportData) -> Section | None:
    """Efficiency, torque, forces and losses."""
    if data.steady is None or data.forward is None or data.backward is None:
        return None
    state, turning = data.steady, data.mechanism.stages[0].thread.family.turning
    # Of a state that does not exist there are motions, but no forces and powers.
    is_known = state.has_efficiency or state.result_name in ("self_locking", "sinking_load")

    def known(value: SupportsFloat, unit: str) -> str:
        return show(value, unit) if is_known else "–"

    paragraphs = []
    if not bool(state.valid):
        words = "Do not use these numbers" if is_known else "There is no steady state"
        paragraphs.append(f"{words}: {state.result}.")
    elif state.result_name == "sinking_load":
        paragraphs.append(f"There is no efficiency: {state.result}.")
    backward = efficiency_text(data.backward)
    if backward.endswith("%"):
        paragraphs.append(f"The load can drive the {turning} back.")
    elif backward == "self-locking":
        paragraphs.append(
            f"The mechanism is self-locking: the load alone does not turn the {turning}."
        )
    rows = [
        (f"efficiency, {turning} drives", efficiency_text(data.forward)),
        ("efficiency, load drives", backward),
        ("drive torque", known(state.drive_torque, "N·m")),
        ("input power", known(state.input_power, "W")),
        ("output power", known(state.output_power, "W")),
    ]
    for index, stage in enumerate(data.mechanism.stages):
        words, body = data.of_stage(index)[1], stage.thread.family.turning
        force, slip = state.contact_force[index], float(state.slip_speed[index])
        rows += [
            (
                f"carrier speed over {body} speed{words}",
                number(float(state.carrier_ratio[index]), 5),
            ),
            (f"normal force of {body} on one roller{words}", known(force, "N")),
            (f"slip of {body} on roller{words}", show(slip, "m/s")),
        ]
    residual = number(float(state.power_balance_residual), 2)
    rows.append(("error of the power balance", residual if is_known else "–"))
    tables = [Table("Steady state at the operating point", ("", ""), tuple(rows))]
    source = float(state.input_power)
    if state.losses and source > 0 and is_known:
        lost = [(readable(n), float(v)) for n, v in state.losses.items()]
        lost.sort(key=lambda item: -item[1])
        lost.append(("total", sum(v for _, v in lost)))
        table = tuple((n, number(v), fixed(100 * v / source, 3)) for n, v in lost)
        tables.append(Table("Losses", ("loss", "power in W", "share of the input in %"), table))
    if not is_known:
        return Section("steady", "Steady state", tuple(paragraphs), tuple(tables))
    if data.improved is not None and data.improved.steady is not None:
        chart = _designs(data, "steady")
    else:
        chart = {f"{turning} drives": data.forward, "load drives": data.backward}
    pictures = [
        Picture(
            "losses",
            "Power balance and losses.",
            lambda: loss_chart(chart),
            (lambda: loss_bars(chart)) if state.losses else None,
        )
    ]
    forward = data.forward
    if steady_flow(forward).total > 0:
        pictures.append(
            Picture(
                "power_flow",
                f"Power flow from the motor to the load when the {turning} drives.",
                lambda: power_flow_chart(steady_flow(forward)),
            )
        )
    return Section("steady", "Steady state", tuple(paragraphs), tuple(tables), tuple(pictures))


def transient_section(data: ReportData) -> Section | None:
    """Run-up of the rollers, or the course of a scenario."""
    run = data.transient
    if run is None:
        return None
    settling = settles(run)
    rows = []
    if settling:
        rows += [
            ("efficiency at the start", share_text(run.efficiency[0])),
            ("efficiency at the end", share_text(run.efficiency[-1])),
            ("settling time (carriers within 1 %)", settling_words(run)),
        ]
    largest = float(np.abs(np.asarray(run.drive_torque)).max())
    rows += [
        ("largest magnitude of the drive torque", show(largest, "N·m")),
        ("drive torque at the end", show(float(run.drive_torque[-1]), "N·m")),
        ("solver", f"{run.solver.name}, {int(run.solver.steps)} steps"),
    ]
    turning = data.mechanism.stages[0].thread.family.turning
    error = error_in_words(run, turning)
    if error is not None:
        rows.append(("estimated error", error))
    paragraphs = ("Speed or torque, and load, over the time of the scenario.",)
    pictures = []
    if settling:
        paragraphs = (
            f"The {turning} runs at full speed from the start and the rollers start from rest, so "
            "the threads slide until the carriers have come up to speed.",
        )
        pictures.append(
            Picture(
                "transient",
                "Efficiency, carrier ratio and drive torque.",
                lambda: transient_chart(run),
                lambda: transient_curves(run),
            )
        )
    pictures += [
        Picture(
            "histories",
            "Motion, torque, load and forces over time.",
            lambda: history_chart(data.mechanism, run),
            lambda: history_curves(data.mechanism, run),
        ),
        Picture(
            "powers",
            "Powers over time: supply, work on the load, losses and change of kinetic energy.",
            lambda: power_history_chart(data.mechanism, run),
            lambda: power_curves(data.mechanism, run),
        ),
    ]
    flow = energy_flow(data.mechanism, run)
    if flow.total > 0:
        pictures.append(
            Picture(
                "energy_flow",
                "Energy of the whole transient.",
                lambda: power_flow_chart(flow, "Energy flow of the whole transient"),
            )
        )
    table = Table("Transient", ("", ""), tuple(rows))
    return Section("transient", "Transient", paragraphs, (table,), tuple(pictures))
