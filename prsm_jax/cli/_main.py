"""Entry point: one line on stderr and exit status 2 for errors that the user can correct."""

import gc
import os
import sys
from collections.abc import Sequence

from .._errors import PrsmError, missing_extra
from ..process import clear_first, end_on_signals, keep_result, remove_empty_folders
from ..programs import works_beside
from ..text import printable
from ._plugins import has_plugins, load_plugin, without_plugins
from ._progress import erase_for_good, progress
from ._streams import ignore_failed_output, stdout_failure


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    **Arguments:**

    - `arguments`: the words after `prsm`; default those of the process.

    **Returns:** the exit status: 0; 1 if the analysis has no valid result; 2 for input that
    cannot be used, with one line on stderr and nothing written. A process started as the command
    line ends with 130 on Ctrl-C and 143 on SIGTERM.
    """
    if arguments is None:
        # This process is the command line; a program that calls it keeps its own signal handlers.
        end_on_signals()
        clear_first(erase_for_good)
        ignore_failed_output()
        # Imported objects stay: the garbage collector need not visit them again.
        gc.freeze()
    words = list(sys.argv[1:] if arguments is None else arguments)
    status, message = _run(words, alone=arguments is None)
    failure = stdout_failure()
    if failure is not None and not message:
        status, message = 2, f"stdout: {failure.strerror}"
    # A run that failed before it wrote anything leaves no folder.
    remove_empty_folders()
    # From here on the result is final; an earlier signal has ended the process.
    keep_result()
    if arguments is None:
        # The last garbage collection before the process ends takes a twentieth of its time.
        gc.disable()
    if message:
        print(f"prsm: {printable(' '.join(message.split()))}", file=sys.stderr)
    if arguments is None and works_beside():
        # The compiler may be at work for a program that an error has made useless. Python would
        # destroy what that thread uses.
        sys.stderr.flush()
        os._exit(status)
    return status


def _run(words: list[str], alone: bool) -> tuple[int, str]:
    """Exit status and error message; the message is empty if there was no error."""
    try:
        from cyclopts import CycloptsError
    except ModuleNotFoundError as error:
        return 2, str(missing_extra("cli", "the command line", error))
    try:
        words, plugins = without_plugins(words)
    except PrsmError as error:
        return 2, str(error)
    with progress(words[0] if words else ""):
        from ..programs import keep_list, run_one_verb, runs_one_verb
        from ._compiled import keep_compiled_programs, tell_of_trouble_once
        from ._counts import error_text
        from ._verbs import app

        keep_compiled_programs()
        if alone:
            tell_of_trouble_once()
        try:
            for plugin in plugins:
                load_plugin(plugin)
            # Results of a plugin depend on its own files, which no stored program knows.
            if alone and not has_plugins():
                run_one_verb()
            status = app(
                words, exit_on_error=False, print_error=False, result_action="return_value"
            )
            if runs_one_verb():
                keep_list(words)
            return (status if isinstance(status, int) else 0), ""
        except KeyboardInterrupt:
            return 130, "stopped (Ctrl-C)"
        except CycloptsError as error:
            return 2, error_text(error, words)
        except (PrsmError, ValueError) as error:
            return 2, str(error)
        except OSError as error:
            return 2, f"{error.filename or 'file'}: {error.strerror or error}"


if __name__ == "__main__":
    raise SystemExit(main())
