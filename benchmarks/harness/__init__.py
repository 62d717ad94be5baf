"""The one harness that every benchmark case plugs into."""

from ._atomic import written_whole as written_whole
from .case import (
    Case as Case,
    Kind as Kind,
    Method as Method,
    Prepared as Prepared,
    Problem as Problem,
    Reference as Reference,
)
from .chart import draw as draw
from .measure import (
    FULL as FULL,
    QUICK as QUICK,
    SMOKE as SMOKE,
    Budget as Budget,
    ErrorSummary as ErrorSummary,
    Measurement as Measurement,
    measure as measure,
    summarise as summarise,
    survivors as survivors,
)
from .report import (
    SCHEMA as SCHEMA,
    document as document,
    table as table,
    write as write,
)
