"""A maker's catalogue of roller screws beside the mechanisms that rules build from its rows."""

from ._comparison import (
    CatalogueComparison as CatalogueComparison,
    ErrorSummary as ErrorSummary,
    compare_catalogue as compare_catalogue,
)
from ._predicted import PREDICTED as PREDICTED, Predicted as Predicted
