"""Who may ask: pages of this address alone, with the token in the path."""

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any, TypeAlias

#: Of ASGI (asgi.readthedocs.io).
Scope: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send: TypeAlias = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Asgi: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]
#: The page loads nothing from elsewhere and stands in no other page.
_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data:; font-src 'self' data:; "
    "connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
_HEADERS = (
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
)


def refusal(scope: Scope, port: int, token: str) -> str | None:
    """Why a request is refused; `None` if it is not.

    The `Host` must be this address, so that a name of a stranger that leads here is refused; so
    must the `Origin`, which browsers send with requests of other pages and with every websocket;
    and the path must begin with the token, which no other page knows.

    **Arguments:**

    - `scope`: the request, as ASGI describes it.
    - `port`, `token`: of this studio.
    """
    hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
    given = [(key.lower(), value) for key, value in scope["headers"]]
    host = [value.decode("latin-1") for key, value in given if key == b"host"]
    origin = [value.decode("latin-1") for key, value in given if key == b"origin"]
    if len(host) != 1 or host[0] not in hosts:
        return "refused: the Host is not the address of this studio"
    if any(one != f"http://{host[0]}" for one in origin) or len(origin) > 1:
        return "refused: the Origin is not the address of this studio"
    if scope["type"] == "websocket" and not origin:
        return "refused: a websocket needs an Origin"
    first = scope["path"].split("/")[1:2] or [""]
    if not hmac.compare_digest(first[0].encode(), token.encode()):
        return "refused: use the whole address that prsm studio printed, with its token"
    return None


class Guard:
    """An ASGI application that passes on only what `refusal` lets pass.

    **Arguments:**

    - `application`: the application behind it.
    - `port`, `token`: of this studio.
    """

    def __init__(self, application: Asgi, port: int, token: str):
        self._application, self._port, self._token = application, port, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._application(scope, receive, send)
            return
        why = refusal(scope, self._port, self._token)
        if why is None:
            await self._application(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            body = why.encode()
            headers = [
                (b"content-type", b"text/plain; charset=utf-8"),
                (b"content-length", str(len(body)).encode()),
                *_HEADERS,
            ]
            await send({"type": "http.response.start", "status": 403, "headers": headers})
            await send({"type": "http.response.body", "body": body})


def _with_headers(send: Send) -> Send:
    async def sent(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            present = {key.lower() for key, _ in message["headers"]}
            added = [pair for pair in _HEADERS if pair[0] not in present]
            if b"content-security-policy" not in present:
                added.append((b"content-security-policy", _POLICY.encode()))
            message = {**message, "headers": [*message["headers"], *added]}
        await send(message)

    return sent
