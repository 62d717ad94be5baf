"""Results of a report: the analysis of a mechanism, its checks, and where it came from."""

from ._analyse import (
    STRENGTH as STRENGTH,
    analyse as analyse,
    with_optimisation as with_optimisation,
    words_of_fault as words_of_fault,
)
from ._data import ReportData as ReportData, SideOnsets as SideOnsets
from ._origin import Origin as Origin, origin_of_file as origin_of_file
from ._pressures import (
    SIDES as SIDES,
    any_cut as any_cut,
    largest_pressure as largest_pressure,
    largest_pressures as largest_pressures,
    largest_shared_pressure as largest_shared_pressure,
    truncated_pressures as truncated_pressures,
    untruncated_pressures as untruncated_pressures,
)
