"""Results of integrations, and quantities derived from them."""

from ._integration import Settings as Settings, integrated as integrated
from ._known_efficiency import known_efficiency as known_efficiency
from ._power_entries import power_entries as power_entries, relative as relative
from ._transient_quantities import (
    energy as energy,
    integral as integral,
    mean_efficiency as mean_efficiency,
    peak as peak,
    settling_time as settling_time,
)
from ._transient_result import (
    CANNOT_BE_BUILT as CANNOT_BE_BUILT,
    MEANS_NOTHING as MEANS_NOTHING,
    CarrierHistory as CarrierHistory,
    Phase as Phase,
    SolverReport as SolverReport,
    Transient as Transient,
    code_of_finite as code_of_finite,
    finite_row as finite_row,
    histories as histories,
    judged_by_input as judged_by_input,
    prescribed as prescribed,
    rows_of as rows_of,
    transient_of as transient_of,
)
from ._uncertainty import (
    coarse_samples as coarse_samples,
    error_in_words as error_in_words,
    neglected_inertia as neglected_inertia,
)
