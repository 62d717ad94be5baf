"""The local server: the page, files of the report, and who may ask for them."""

import secrets
import socket
from collections.abc import Callable
from typing import Any

from .._errors import PrsmError, missing_extra
from ..text import short_heading
from ._guard import Guard
from ._session import REPORT, Session

#: The only interface that is listened on: no other machine reaches it.
_LOOPBACK = "127.0.0.1"
#: A report runs in a world of its own: it can show itself and nothing more.
_REPORT_POLICY = (
    "sandbox allow-scripts allow-popups allow-downloads allow-modals; default-src 'none'; "
    "script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
)


def needs_extra() -> None:
    """**Raises:** `MissingExtraError` without the library of the page."""
    try:
        import nicegui  # noqa: F401
    except ImportError as error:
        raise missing_extra("studio", "the studio", error) from error


def open_socket(port: int) -> socket.socket:
    """A socket on the loopback interface.

    **Arguments:**

    - `port`: its port; 0 for any that is free.

    **Raises:** `PrsmError` if the port is taken or not allowed.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((_LOOPBACK, port))
    except (OSError, OverflowError) as error:
        listening.close()
        raise PrsmError(
            f"--port {port}: {getattr(error, 'strerror', None) or error}; give another port, or 0 "
            "for any that is free"
        ) from error
    return listening


def serve(session: Session, *, port: int = 0, told: Callable[[str], None] | None = None) -> None:
    """Serve the page of a session until the process ends.

    The address carries a random token; requests without it, of other pages and for other hosts are
    refused (`refusal`). Once in a process.

    **Arguments:**

    - `session`: the state of the page.
    - `port`: of the loopback interface; 0 for any that is free.
    - `told`: called with the address as soon as it answers.

    **Raises:** `MissingExtraError` without the library of the page; `PrsmError` for a port that is
    taken.
    """
    needs_extra()
    import uvicorn
    from fastapi import FastAPI
    from nicegui import app, ui

    from ._page import Page

    title = short_heading(session.original.title) or "Planetary roller screw"
    token = secrets.token_urlsafe(24)
    listening = open_socket(port)
    # From here on the address answers: requests wait until the page is ready.
    listening.listen()
    taken = int(listening.getsockname()[1])
    # No pages about the programming interface, which nobody asked for.
    application = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    _serve_files(application, session, token)

    @ui.page("/", title=f"{title}: studio")
    def page() -> None:
        Page(session, title)

    ui.run_with(
        application,
        mount_path=f"/{token}",
        show_welcome_message=False,
        tailwind=False,
        language="en-US",
    )
    address = f"http://{_LOOPBACK}:{taken}/{token}/"
    if told is not None:
        app.on_startup(lambda: told(address))
    config = uvicorn.Config(
        Guard(application, taken, token),
        # The loop of asyncio leaves the signals of the command line alone.
        loop="asyncio",
        log_level="error",
        access_log=False,
        proxy_headers=False,
        server_header=False,
        ws_max_size=1 << 20,
    )
    uvicorn.Server(config).run(sockets=[listening])


def _serve_files(application: Any, session: Session, token: str) -> None:
    """Files of the report, from the chosen folder alone."""
    from fastapi.responses import FileResponse, PlainTextResponse

    def file(path: str):
        try:
            if not path.startswith(f"{REPORT}/"):
                raise PrsmError(f"{path!r} is not a file of the report")
            place = session.folder.readable(path)
        except PrsmError as error:
            return PlainTextResponse(f"{error}\n", 404)
        return FileResponse(place, headers={"content-security-policy": _REPORT_POLICY})

    application.get(f"/{token}/files/{{path:path}}")(file)
