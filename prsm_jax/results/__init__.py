"""How results print themselves, draw themselves, and are kept in files."""

from ._charts import chart_for as chart_for
from ._files import load_result as load_result, save_result as save_result
from ._result import (
    DesignResult as DesignResult,
    Result as Result,
    Shown as Shown,
    lines_of as lines_of,
    outcome as outcome,
    printed as printed,
)
