"""Findings on a mechanism, and the margins that `check` and the optimiser share.

Do the parts fit, can they be made, do they last, and are the given numbers plausible?
"""

from ..geometry import Finding as Finding
from ._check import (
    check as check,
    check_numbers as check_numbers,
)
from ._margin import (
    Margin as Margin,
    Reading as Reading,
    error_names as error_names,
    evaluate_margins as evaluate_margins,
    first_error as first_error,
    margin_source as margin_source,
    margins_of as margins_of,
    shared_loads as shared_loads,
    sources as sources,
)
from ._masses import mass_findings as mass_findings
