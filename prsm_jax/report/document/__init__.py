"""The report: its sections, and how they are written."""

from ._contact_pictures import (
    contact_pictures as contact_pictures,
    save_contact_pictures as save_contact_pictures,
)
from ._mechanism_section import stage_rows as stage_rows
from ._section import Picture as Picture, Section as Section, Table as Table
from ._sections import report_section as report_section, report_sections as report_sections
from ._status_section import (
    LIMITS as LIMITS,
    MARGINS_IN_WORDS as MARGINS_IN_WORDS,
    checks_table as checks_table,
    limit_cells as limit_cells,
    limits_in_words as limits_in_words,
    limits_table as limits_table,
    point_words as point_words,
)
from ._study_sections import study_sections as study_sections, write_study as write_study
from ._transient_pictures import save_transient_pictures as save_transient_pictures
from ._write import write_document as write_document, write_report as write_report
