"""Published numbers beside the computed ones, with verdicts.

Each paper has modules that register functions of rows under the paper's name.
"""

from ._difference import (
    consistent as consistent,
    differs as differs,
    fault as fault,
    formula as formula,
    inconsistent as inconsistent,
    not_comparable as not_comparable,
    unexplained as unexplained,
)
from ._figures import (
    Curve as Curve,
    Mark as Mark,
    Panel as Panel,
    PublishedFigure as PublishedFigure,
    published_figures as published_figures,
)
from ._pressure_figures import (
    PressureFigure as PressureFigure,
    PressurePanel as PressurePanel,
    PrintedEllipse as PrintedEllipse,
    PrintedPressure as PrintedPressure,
    published_pressures as published_pressures,
)
from ._registry import rows_of as rows_of, sources as sources, validate as validate
from ._row import (
    VERDICTS as VERDICTS,
    Row as Row,
    Verdict as Verdict,
    at_most as at_most,
    misprint as misprint,
    number as number,
    trend as trend,
)
from ._table import markdown as markdown, summary as summary, table as table

# The sources, in the order of the table.
from .wu2022 import (  # isort: skip
    _wu2022 as _wu2022,
    _wu2022_parts as _wu2022_parts,
    _wu2022_frequencies as _wu2022_frequencies,
    _wu2022_shapes as _wu2022_shapes,
    _wu2022_indefinite as _wu2022_indefinite,
    _wu2022_trends as _wu2022_trends,
)
from .lin_parker1999 import _lin_parker1999 as _lin_parker1999  # isort: skip
from .li import (  # isort: skip
    _li2020 as _li2020,
    _li2020_details as _li2020_details,
    _li2021 as _li2021,
    _li2021_details as _li2021_details,
    _li_figures as _li_figures,
)
from .lisowski2014 import (  # isort: skip
    _lisowski2014 as _lisowski2014,
    _lisowski2014_surfaces as _lisowski2014_surfaces,
    _lisowski2014_maps as _lisowski2014_maps,
)
from . import (  # isort: skip
    _shape_function as _shape_function,
    _closed_forms as _closed_forms,
)
from .catalogue import (  # isort: skip
    PREDICTED as PREDICTED,
    CatalogueComparison as CatalogueComparison,
    ErrorSummary as ErrorSummary,
    compare_catalogue as compare_catalogue,
)
from .catalogue import _rows as _rows  # isort: skip
