"""The verb that fits parameters to measurements."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from ..._errors import PrsmError
from ...mechanism import Mechanism, all_parameters
from ...process import make_folder
from ...quantities import assumptions, quantity_of
from ...text import is_efficiency
from .._app import app
from .._common import Common, checked, emit, parameters_of, value_of, write_text
from .._optimised import calibrated_text, nothing_written
from .._progress import expect_programs
from .._tables import terminal_width

_DEFAULT = Common()


def _friction(mechanism: Mechanism) -> list[str]:
    """Friction coefficients of the file: the parameters of a fit if none are named."""
    paths = [
        one.path
        for one in all_parameters(mechanism)
        if ".friction." in one.path and one.path.endswith("coefficient") and not one.static
    ]
    if not paths:
        raise PrsmError("the file has no friction coefficient; name numbers with --parameters")
    return paths


def _bound(mechanism: Mechanism, text: str) -> tuple[str, tuple[float | None, float | None]]:
    """`NAME=LOWER:UPPER`, values as in `--set`; one of them may be empty."""
    name, equals, limits = (part.strip() for part in text.partition("="))
    lower, colon, upper = (part.strip() for part in limits.partition(":"))
    if not (name and equals and colon and (lower or upper)):
        raise PrsmError(f"--bounds {text}: must be NAME=LOWER:UPPER, such as 'lead=9 mm:11 mm'")

    def value(word: str) -> float | None:
        return value_of(mechanism, name, word, f"--bounds {text}") if word else None

    low, high = value(lower), value(upper)
    if low is not None and high is not None and not low < high:
        # Here, since messages of the calibration are in SI.
        remedy = "; give an upper limit above the lower one"
        if low > high:
            remedy = f"; reverse them: {name}={upper}:{lower}"
        raise PrsmError(f"--bounds {text}: {lower} is not below {upper}{remedy}")
    return name, (low, high)


def _deviation(text: str) -> tuple[str, float]:
    """`QUANTITY=VALUE`, the value with a unit of the quantity or bare in SI."""
    from ...fields import POSITIVE
    from ...file.numbers import is_plain_number, read_number, refuse_shares

    name, equals, word = (part.strip() for part in text.partition("="))
    if not (name and equals and word):
        raise PrsmError(
            f"--deviations {text}: must be QUANTITY=VALUE, such as 'drive_torque=0.05 N m'"
        )
    unit = quantity_of(name).unit
    try:
        if not is_efficiency(name):
            refuse_shares(word)
        return name, read_number(float(word) if is_plain_number(word) else word, unit, POSITIVE)
    except ValueError as error:
        raise PrsmError(f"--deviations {text}: {error}") from error


@app.command
def calibrate(
    file: str,
    *,
    data: Annotated[
        str,
        Parameter(
            help="CSV file of measurements, with a header 'name [unit],…'; or shipped example data."
        ),
    ],
    parameters: Annotated[
        str | None,
        Parameter(
            help="Names of numbers in the file, separated by commas. Default: all friction "
            "coefficients of the file."
        ),
    ] = None,
    bounds: Annotated[
        list[str] | None,
        Parameter(
            negative="", help="NAME=LOWER:UPPER, such as 'lead=9 mm:11 mm'; may be repeated."
        ),
    ] = None,
    deviations: Annotated[
        list[str] | None,
        Parameter(
            negative="",
            help="Standard deviation of a measured column, such as 'drive_torque=0.05 N m'; may be "
            "repeated.",
        ),
    ] = None,
    loss: Annotated[
        str, Parameter(help="squared; or huber, soft_l1 or cauchy, which outliers affect less.")
    ] = "squared",
    common: Common = _DEFAULT,
) -> int:
    """Fit numbers of the file to measurements, with 95 % limits; name what stays undetermined.

    With --out the calibrated mechanism and a picture of the residuals are written to that folder.
    Exit status 1 if the fit did not converge.
    """
    mechanism = common.load(file)
    from ...calibration import calibrate as run_calibration, read_measurements

    measured = read_measurements(data, mechanism)
    names = parameters_of(mechanism, parameters, "--parameters")
    names = _friction(mechanism) if names is None else names
    limits = dict(_bound(mechanism, text) for text in bounds or [])
    scatter = dict(_deviation(text) for text in deviations or [])
    expect_programs("start_values", "solve_one")
    fit = run_calibration(
        mechanism, measured, names, standard_deviations=scatter, bounds=limits, loss=loss
    )
    path, where = None, ""
    if common.out is not None:
        target = common.out / f"{Path(file).stem}-calibrated.toml"
        if fit.converged:
            from ...report import calibration_chart, save_figure

            make_folder(common.out)
            save_figure(calibration_chart(fit), common.out / "calibration")
            path, where = target, f"calibrated mechanism: {target}"
            write_text(target, calibrated_text(file, mechanism, fit))
        else:
            where = nothing_written(target, "the fit did not converge", common)
    results: dict[str, Any] = fit.to_dict() | {"mechanism": path, "valid": fit.converged}

    def text() -> str:
        return f"{fit.text(terminal_width())}\n\n{where}"

    quantities = [one.quantity for one in fit.residuals]
    valid = emit(common, results, text, assumptions(mechanism, quantities), checked(fit.mechanism))
    return int(not valid)
