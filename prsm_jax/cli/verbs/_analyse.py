"""Verbs that analyse one mechanism: check, strength, steady."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...dynamics import STEADY_RESULTS, SteadyState, steady_meaning, steady_state
from ...findings import check_from, check_values, status_of, strength_checks_from
from ...mechanism import Mechanism, OperatingPoint
from ...programs import beside
from ...quantities import assumptions
from .._app import app
from .._common import STEADY, Common, Saved, checked, checked_numbers, emit, plain
from .._programs import run_stored
from .._progress import doing, expect_programs
from .._tables import Line, TextTable, in_units, prose, terminal_width

if TYPE_CHECKING:
    from ...optimisation import LimitReading

_DEFAULT = Common()


@app.command
def check(file: str, *, common: Common = _DEFAULT) -> int:
    """Do the parts fit together, and are the numbers plausible? Exit status 1 on an error."""
    mechanism = common.load(file)
    findings, rests_on = checked(mechanism), assumptions(mechanism)
    rows = [(f.name, f.severity, f.stage, f.message) for f in findings]
    table = TextTable("Findings", ("name", "severity", "stage", "what"), rows)

    def text() -> str:
        return table.text(terminal_width()) if rows else "no findings"

    keys = ("name", "severity", "stage", "value", "limit", "message")
    results = {
        "findings": [{k: getattr(f, k) for k in keys} for f in findings],
        "errors": sum(f.severity == "error" for f in findings),
    }
    emit(common, results, text, rests_on, saved=Saved("findings", [table]))
    return int(any(f.severity == "error" for f in findings))


def _limits(mechanism: Mechanism) -> "tuple[LimitReading, ...]":
    """Limits of the design problem; the optimiser is imported only where there are some."""
    if mechanism.design_problem is None:
        return ()
    from ...optimisation import limit_readings

    return limit_readings(mechanism)


#: What a file without limits lacks.
_NO_CHECKS = (
    "No checks: the file gives no limit. Give permissible_pressure, required_life or a shaft in "
    "[stage.strength], or a friction law in [stage.friction]."
)


@app.command
def strength(file: str, *, common: Common = _DEFAULT) -> int:
    """Safety, life, buckling, speed, play: value, limit, margin and verdict of each.

    Exit status 1 if a check fails or `prsm check` finds an error: the status is the worst of both.
    --out writes the table as strength.json and strength.md. The status is "no checks" where the
    file gives no limit and check finds nothing. Limits of [optimise] are not part of it; broken
    ones are listed.
    """
    mechanism = common.load(file)
    limits = beside(_limits, mechanism)
    numbers = checked_numbers(mechanism)
    expect_programs("_values")
    doing("computing capacities and life")
    from ...report import MARGINS_IN_WORDS, checks_table, limits_in_words, limits_table

    values = check_values(mechanism)
    checks = strength_checks_from(mechanism, numbers, values)
    findings, rests_on = check_from(mechanism, numbers), assumptions(mechanism, tuple(values))
    status = status_of(checks, findings)
    limited = limits()
    results = {
        "checks": [one.to_dict() for one in checks],
        "status": status,
        "limits": [one.to_dict() for one in limited],
    }
    headline = f"Strength of {file}: {status}"
    shown = checks_table(headline, checks, len(mechanism.stages))
    table = TextTable(shown.caption, shown.head, shown.rows)
    unkept = [one for one in limited if one.verdict != "pass"]
    others: list[TextTable] = []
    if unkept:
        words = f"{limits_in_words(limited)} The status above does not include them"
        shown = limits_table(words, unkept)
        others = [TextTable(shown.caption, shown.head, shown.rows)]
    tables = [table] if table.rows else []
    sentences = [] if table.rows or status == "no checks" else [headline]
    if any(one.margin is not None for one in checks):
        sentences.append(MARGINS_IN_WORDS)
    if status_of(checks, ()) == "no checks":
        sentences.append(_NO_CHECKS)

    def text() -> str:
        words = "".join(one.text(terminal_width()) for one in tables)
        words += "".join(map(prose, sentences))
        return words + "".join("\n" + one.text(terminal_width()) for one in others)

    saved = Saved("strength", [*tables, *others], sentences)
    valid = emit(common, results, text, rests_on, findings, saved)
    return int(not valid or status == "fail")


def steady_results(state: SteadyState, point: OperatingPoint | None) -> dict[str, Any]:
    """A steady state by the names of the JSON."""
    results = {
        "efficiency": state.efficiency,
        "carrier_ratio": state.carrier_ratio,
        "drive_torque_nm": state.drive_torque,
        "contact_force_n": state.contact_force,
        "screw_roller_axial_force_n": state.screw_roller_axial_force,
        "ring_gear_force_n": state.ring_gear_force,
        "carrier_force_n": state.carrier_force,
        "slip_speed_m_per_s": state.slip_speed,
        "losses_w": state.losses,
        "input_power_w": state.input_power,
        "output_power_w": state.output_power,
        "power_balance_residual": state.power_balance_residual,
        "valid": state.valid,
        "result": 0 if state.code is None else state.code,
    }
    if point is not None:
        results |= {"speed_rad_per_s": point.speed, "load_n": point.load}
    return results


def with_result_name(results: dict[str, Any]) -> dict[str, Any]:
    """A steady state with the name of its result, without efficiency where there is none.

    The computed efficiency then has no meaning, such as -0.34 for a thread that locks.
    """
    name = STEADY_RESULTS[int(results["result"])]
    changed: dict[str, Any] = {"result": name, "result_message": steady_meaning(name)}
    if name not in ("successful", "overlapping_rollers"):
        changed["efficiency"] = None
    return {**results, **changed}


def _at_standstill(mechanism: Mechanism) -> tuple[str, ...]:
    """What the results of an operating point without speed are those of."""
    point = mechanism.operating_point
    if point is None or float(point.speed) != 0 or float(point.load) == 0:
        return ()
    body = mechanism.stages[0].thread.family.turning
    back = "negative" if float(point.load) > 0 else "positive"
    return (
        "At speed 0, efficiency, torque and forces are those of the start of motion, with the "
        f"{body} driving: the limit of slow turning. At rest, any torque between this one and that "
        f"of back-driving (a {back} speed) holds the load.",
    )


def _steady(mechanism: Mechanism) -> dict[str, Any]:
    return steady_results(steady_state(mechanism), mechanism.operating_point)


@app.command
def steady(file: str, *, common: Common = _DEFAULT) -> int:
    """Steady state: efficiency, torque, forces, every loss by name, power balance.

    --out writes them as steady.json and steady.md, with pictures of the losses and of the power.
    """
    mechanism = common.load(file)
    rests_on = (*_at_standstill(mechanism), *assumptions(mechanism, STEADY))
    pictures: tuple[Path, ...] = ()
    if common.out is None:
        results = with_result_name(plain(run_stored("steady", _steady, mechanism)))
        tables = _steady_tables(file, mechanism, results)
    else:
        expect_programs("steady_state")
        state = steady_state(mechanism)
        results = with_result_name(plain(steady_results(state, mechanism.operating_point)))
        tables = _steady_tables(file, mechanism, results)
        pictures = _steady_pictures(common.out, state) if results["valid"] else ()
        results["pictures"] = plain(pictures)
    sentences: list[str] = []
    if results["result"] != "successful":
        sentences.append(("" if results["valid"] else "Not valid: ") + results["result_message"])

    def text() -> str:
        words = "".join(table.text(terminal_width()) for table in tables)
        words += "".join(map(prose, sentences))
        if common.out is not None:
            words += f"{len(pictures)} pictures, steady.json and steady.md in {common.out}\n"
        return words

    saved = Saved("steady", tables, sentences)
    return int(not emit(common, results, text, rests_on, checked(mechanism), saved))


def _steady_pictures(folder: Path, state: SteadyState) -> tuple[Path, ...]:
    from ...report import loss_chart, power_flow_chart, save_figures, steady_flow

    doing("drawing")
    figures = {"losses": loss_chart({"operating point": state})}
    flow = steady_flow(state)
    if flow.total > 0:
        figures["power-flow"] = power_flow_chart(flow)
    return save_figures(folder, figures)


#: Labels of the efficiency where there is none.
_EFFICIENCY = {
    name: f"efficiency: none, {name.replace('_', ' ')}"
    for name in STEADY_RESULTS
    if name not in ("successful", "overlapping_rollers")
}


#: Results with numbers of forces and powers; others are of a state that does not exist.
_WITH_NUMBERS = ("successful", "self_locking", "overlapping_rollers", "sinking_load")


def _steady_tables(file: str, mechanism: Mechanism, results: dict[str, Any]) -> list[TextTable]:
    efficiency = _EFFICIENCY.get(results["result"], "efficiency")

    def known(value: float | None) -> float | None:
        return value if results["result"] in _WITH_NUMBERS else None

    lines: list[Line] = [
        (efficiency, known(results["efficiency"]), "1", "efficiency"),
        ("drive torque", known(results["drive_torque_nm"]), "N·m"),
        ("input power", known(results["input_power_w"]), "W"),
        ("output power", known(results["output_power_w"]), "W"),
        *((f"loss: {name}", known(power), "W") for name, power in results["losses_w"].items()),
        ("power balance residual", known(results["power_balance_residual"]), "1"),
    ]
    for number, (stage, ratio, force) in enumerate(
        zip(mechanism.stages, results["carrier_ratio"], results["contact_force_n"], strict=True),
        start=1,
    ):
        body = stage.thread.family.turning
        lines.append((f"stage {number}: carrier ratio", ratio, "1"))
        lines.append((f"stage {number}: normal force of {body} on one roller", known(force), "N"))
    return [TextTable(f"Steady state: {file}", ("", "", ""), in_units(lines))]
