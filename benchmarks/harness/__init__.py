"""The one harness that every benchmark case plugs into."""

from ._atomic import (
    read_json as read_json,
    save_picture as save_picture,
    write_json as write_json,
    write_text as write_text,
    written_whole as written_whole,
)
from ._commands import (
    of_this_run as of_this_run,
    parser_of as parser_of,
    refuse_unknown as refuse_unknown,
    run_worker as run_worker,
    where_and_when as where_and_when,
    why_left_out as why_left_out,
)
from ._markdown import row_of as row_of, table_of as table_of, time_text as time_text
from .case import (
    Case as Case,
    Kind as Kind,
    Method as Method,
    Prepared as Prepared,
    Problem as Problem,
    Reference as Reference,
    rival as rival,
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
    machine as machine,
    table as table,
    write as write,
)
