"""The verb studio: a local page to play with a design."""

import os
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..._app import app
from ..._common import Common, emit
from ..._counts import count
from ..._plugins import plugin_words
from ..._progress import clear

_DEFAULT = Common()


@app.command
def studio(
    file: str,
    *,
    port: Annotated[
        int, count(0, 65_535, help="Port of the loopback interface; 0 for any that is free.")
    ] = 0,
    no_browser: Annotated[
        bool, Parameter(negative="", help="Print the address; do not open a browser.")
    ] = False,
    common: Common = _DEFAULT,
) -> int:
    """Open a local page to play with a design; Ctrl-C ends it.

    Sliders move the variables of the file's [optimise] table (without one: lead, contact angle,
    roller and profile radius); drawing, status, numbers and derivatives follow. The page is served
    to this machine alone, at an address with a random token. Files are written into the folder of
    --out (default out/studio) and nowhere else.
    """
    common.check_targets("out/studio")
    from ....studio import Session, needs_extra, serve

    needs_extra()
    folder = Path("out/studio") if common.out is None else common.out
    session = Session(file, folder, common.settings, options=plugin_words())

    def told(address: str) -> None:
        results = {"address": address, "folder": session.folder.path}
        emit(common, results, lambda: f"{address}\nThe studio runs; Ctrl-C ends it.")
        sys.stdout.flush()
        if not no_browser and common.json is None and _has_display():
            import webbrowser

            webbrowser.open(address)

    serve(session, port=port, told=told)
    clear()
    return 0


def _has_display() -> bool:
    """Whether a browser can open a window; else one for terminals would take this one."""
    if sys.platform in ("darwin", "win32"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
