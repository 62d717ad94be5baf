"""How programs are compiled: one for each structure, batches, labels of physics, precision."""

from ._batches import (
    AbstractResult as AbstractResult,
    each as each,
    listed as listed,
    mapped as mapped,
)
from ._folder import CACHE_VARIABLE as CACHE_VARIABLE, usual_folder as usual_folder
from ._one_program import (
    bind_program as bind_program,
    is_known as is_known,
    one_program as one_program,
    one_program_where_possible as one_program_where_possible,
    prepare_program as prepare_program,
    repeated_program as repeated_program,
    traceable as traceable,
)
from ._one_verb import (
    beside as beside,
    run_one_verb as run_one_verb,
    runs_one_verb as runs_one_verb,
    while_compiling as while_compiling,
    works_beside as works_beside,
)
from ._origin import origin_of as origin_of
from ._physics import physics as physics, traced_physics as traced_physics
from ._precision import to_precision as to_precision
from ._read_ahead import keep_list as keep_list
from ._stored import (
    has_stored as has_stored,
    run_stored as run_stored,
    stored_facts as stored_facts,
)
