"""The process and its files: signals, forks, and files that are complete or absent.

Importing it sets up this process and those forked from it later. It comes before JAX.
"""

from . import (
    _forked as _forked,  # processes forked later cannot calculate
    _own_process as _own_process,  # before JAX, whose import takes seconds
)
from ._collection import collect_as_before as collect_as_before
from ._files import (
    folder_for_results as folder_for_results,
    make_folder as make_folder,
    real_path as real_path,
    remove_empty_folders as remove_empty_folders,
    temporary_folder as temporary_folder,
    whole_file as whole_file,
)
from ._interrupt import (
    clear_first as clear_first,
    end_on_signals as end_on_signals,
    keep_result as keep_result,
)
from ._own_process import own_command as own_command
from ._placing import (
    placing_in as placing_in,
    put_file as put_file,
    put_folder as put_folder,
)
from ._private import others_can_write as others_can_write
