"""Fit of any numbers of a mechanism to measurements, with their uncertainty."""

from ._calibrate import calibrate as calibrate
from ._data_file import (
    example_data_names as example_data_names,
    read_measurements as read_measurements,
)
from ._measurements import Measurements as Measurements
from ._problem import (
    CalibrationProblem as CalibrationProblem,
    calibration_problem as calibration_problem,
)
from ._result import (
    Calibration as Calibration,
    FittedParameter as FittedParameter,
    Residuals as Residuals,
    Undetermined as Undetermined,
)
from ._statistics import Repetitions as Repetitions, repeat_fits as repeat_fits
