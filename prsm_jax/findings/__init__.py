"""Findings on a mechanism, and the margins that `check` and the optimiser share.

Do the parts fit, can they be made, do they last, and are the given numbers plausible?
"""

from ..geometry import Finding as Finding
from ._check import (
    CheckNumbers as CheckNumbers,
    check as check,
    check_from as check_from,
    check_numbers as check_numbers,
    margin_numbers as margin_numbers,
    prepare_check as prepare_check,
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
from ._strength_checks import (
    CHECK_VALUES as CHECK_VALUES,
    Status as Status,
    StrengthCheck as StrengthCheck,
    Verdict as Verdict,
    check_values as check_values,
    status_of as status_of,
    strength_checks as strength_checks,
    strength_checks_from as strength_checks_from,
)
