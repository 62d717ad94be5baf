"""The folder in which the command line keeps compiled programs between runs."""

import os
from pathlib import Path

#: Names another folder; if it is empty, no programs are kept.
CACHE_VARIABLE = "PRSM_JAX_CACHE"


def usual_folder() -> Path | None:
    """That of the variable, or else the user's cache folder; `None` if no programs are kept."""
    default = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "prsm_jax"
    folder = os.environ.get(CACHE_VARIABLE, str(default))
    return Path(folder) if folder else None
