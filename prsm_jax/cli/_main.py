"""Entry point: one line on stderr and exit status 2 for whatever the user can mend."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from .._errors import PrsmError, missing_extra
from .._interrupt import clear_first, end_on_signals, keep_result
from ._progress import erase_for_good, progress

#: Where compiled programs are kept between runs, unless this variable says otherwise.
_CACHE_VARIABLE = "PRSM_JAX_CACHE"


def _keep_compiled_programs() -> None:
    """Let JAX keep what it compiles, however small: a second run then starts at once."""
    import jax

    default = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "prsm_jax"
    folder = os.environ.get(_CACHE_VARIABLE, str(default))
    if folder:
        jax.config.update("jax_compilation_cache_dir", folder)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    **Arguments:**

    - `arguments`: the words after `prsm`; default those of the process.

    **Returns:** the exit status: 0; 1 if the analysis has no valid result; 2 for input that
    cannot be used, with one line on stderr and nothing written. A process that is the command line
    ends with 130 on Ctrl-C and 143 on SIGTERM.
    """
    if arguments is None:
        # This process is the command line; a program that calls it keeps its own signal handlers.
        end_on_signals()
        clear_first(erase_for_good)
    words = list(sys.argv[1:] if arguments is None else arguments)
    status, message = _run(words)
    # From here on the result stands: a signal that came before ended the process.
    keep_result()
    if message:
        print(f"prsm: {' '.join(message.split())}", file=sys.stderr)
    return status


def _run(words: list[str]) -> tuple[int, str]:
    """Exit status, and what went wrong in words, if something did."""
    try:
        from cyclopts import CycloptsError
    except ModuleNotFoundError as error:
        return 2, str(missing_extra("cli", "the command line", error))
    with progress(words[0] if words else ""):
        from ._verbs import app

        _keep_compiled_programs()
        try:
            status = app(
                words, exit_on_error=False, print_error=False, result_action="return_value"
            )
            sys.stdout.flush()
            return (status if isinstance(status, int) else 0), ""
        except BrokenPipeError:
            # The reader (`head`, a pager) has seen enough; there is nothing left to flush to.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0, ""
        except KeyboardInterrupt:
            return 130, "stopped (Ctrl-C)"
        except CycloptsError as error:
            return 2, str(error)
        except (PrsmError, ValueError) as error:
            return 2, str(error)
        except OSError as error:
            return 2, f"{error.filename or 'file'}: {error.strerror or error}"


if __name__ == "__main__":
    raise SystemExit(main())
