"""Who may ask, and what may be read and written."""

import asyncio
import os

import pytest

import prsm_jax as prsm
from prsm_jax.cli import main
from prsm_jax.studio import ChosenFolder, Guard, Session, open_socket, refusal

_PORT, _TOKEN = 4711, "a-token"
_HOST = f"127.0.0.1:{_PORT}"


def _scope(kind="http", path=f"/{_TOKEN}/", host: str | None = _HOST, origin: str | None = None):
    headers = [(b"host", host.encode())] if host is not None else []
    headers += [(b"Origin", origin.encode())] if origin is not None else []
    return {"type": kind, "path": path, "headers": headers}


_ALLOWED = [
    _scope(),
    _scope(host=f"localhost:{_PORT}"),
    _scope(path=f"/{_TOKEN}/_nicegui/x.js"),
    _scope(origin=f"http://{_HOST}"),
    _scope("websocket", origin=f"http://{_HOST}"),
    _scope("websocket", host=f"localhost:{_PORT}", origin=f"http://localhost:{_PORT}"),
]
_REFUSED = [
    # A name of a stranger that leads to this machine, and other ports.
    _scope(host="evil.example"),
    _scope(host=f"evil.example:{_PORT}"),
    _scope(host="127.0.0.1"),
    _scope(host="127.0.0.1:80"),
    _scope(host=f"127.0.0.1:{_PORT}@evil.example"),
    _scope(host=None),
    # Pages of others.
    _scope(origin="https://evil.example"),
    _scope(origin="null"),
    _scope(origin=f"https://{_HOST}"),
    _scope(origin="http://127.0.0.1:80"),
    _scope(origin=f"http://localhost:{_PORT}"),
    _scope("websocket", origin="https://evil.example"),
    _scope("websocket", origin="null"),
    _scope("websocket"),
    # Without the token, or with another one.
    _scope(path="/"),
    _scope(path="/another/"),
    _scope(path=f"/{_TOKEN}x/"),
    _scope(path=f"//{_TOKEN}/"),
    _scope(path=f"/x/../{_TOKEN}/"),
    _scope("websocket", path="/_nicegui_ws/socket.io/", origin=f"http://{_HOST}"),
]


def _answers(scope):
    """What a guarded application sends, and whether it was asked."""
    asked, sent = [], []

    async def application(scope, receive, send):
        asked.append(scope["path"])
        if scope["type"] == "http":
            await send({"type": "http.response.start", "status": 200, "headers": []})
        else:
            await send({"type": "websocket.accept"})

    async def receive():
        return {"type": "websocket.connect"}

    async def send(message):
        sent.append(message)

    asyncio.run(Guard(application, _PORT, _TOKEN)(scope, receive, send))
    return asked, sent


@pytest.mark.parametrize("scope", _ALLOWED)
def test_own_requests_pass(scope):
    assert refusal(scope, _PORT, _TOKEN) is None
    asked, sent = _answers(scope)
    assert asked == [scope["path"]]
    if scope["type"] == "http":
        headers = dict(sent[0]["headers"])
        assert b"default-src 'self'" in headers[b"content-security-policy"]
        assert b"frame-ancestors 'none'" in headers[b"content-security-policy"]
        assert headers[b"referrer-policy"] == b"no-referrer"


@pytest.mark.parametrize("scope", _REFUSED)
def test_foreign_requests_do_not_reach_the_page(scope):
    asked, sent = _answers(scope)
    assert not asked
    if scope["type"] == "http":
        assert sent[0]["status"] == 403
        assert sent[1]["body"].startswith(b"refused: ")
    else:
        assert [message["type"] for message in sent] == ["websocket.close"]


def test_two_hosts_or_origins_are_refused():
    scope = _scope(origin=f"http://{_HOST}")
    for extra in ((b"host", _HOST.encode()), (b"origin", f"http://{_HOST}".encode())):
        twice = {**scope, "headers": [*scope["headers"], extra]}
        assert refusal(twice, _PORT, _TOKEN) is not None


_NAMES = ["../x.toml", "/tmp/x.toml", "a/b.toml", "..", ".", "", ".hidden", "a\\b", "C:x", "a\0b"]


@pytest.mark.parametrize("name", [*_NAMES, "ends.", "ü.toml", "x" * 300, "-x", "a\nb"])
def test_only_plain_names_are_written(tmp_path, name):
    folder = ChosenFolder(tmp_path / "chosen")
    with pytest.raises(prsm.PrsmError, match="is not a plain file name"):
        folder.write(name, "text")
    assert not list(tmp_path.iterdir())


def test_a_design_is_not_saved_elsewhere(session, tmp_path):
    # With .toml behind them, ".." and "" are hidden names.
    for name in _NAMES:
        with pytest.raises(prsm.PrsmError, match="is not a plain file name"):
            session.save(name)
    assert not list(tmp_path.iterdir())


def test_links_are_not_followed(session, tmp_path):
    outside = tmp_path / "outside.toml"
    outside.write_text("mine", encoding="utf-8")
    chosen = tmp_path / "chosen"
    (chosen / "report" / "figures").mkdir(parents=True)
    (chosen / "link.toml").symlink_to(outside)
    with pytest.raises(prsm.PrsmError, match=r"link\.toml: is a link"):
        session.save("link", replace=True)
    (chosen / "report" / "figures" / "a.png").symlink_to(outside)
    with pytest.raises(prsm.PrsmError, match=r"a\.png: is a link .*; remove it"):
        session.report()
    (chosen / "report" / "figures" / "a.png").unlink()
    (chosen / "report" / "figures").rmdir()
    (chosen / "report").rmdir()
    (chosen / "report").symlink_to(tmp_path)
    with pytest.raises(prsm.PrsmError, match="report: is a link"):
        session.report()
    assert outside.read_text(encoding="utf-8") == "mine"


def test_only_files_below_the_folder_are_read(tmp_path):
    outside = tmp_path / "outside.html"
    outside.write_text("secret", encoding="utf-8")
    chosen = tmp_path / "chosen"
    (chosen / "report").mkdir(parents=True)
    inside = chosen / "report" / "report.html"
    inside.write_text("report", encoding="utf-8")
    (chosen / "report" / "link.html").symlink_to(outside)
    (chosen / "up").symlink_to(tmp_path)
    folder = ChosenFolder(chosen)
    assert folder.readable("report/report.html") == inside
    for wrong in (
        "../outside.html",
        "report/../../outside.html",
        str(outside),
        f"/{outside}",
        "report//report.html",
        "./report/report.html",
        "report/link.html",
        "up/outside.html",
        "report",
        "report/",
        "",
        "report\\report.html",
        "report/report.html\0",
        "absent.html",
    ):
        with pytest.raises(prsm.PrsmError, match="not a file below the chosen folder"):
            folder.readable(wrong)


def test_a_chosen_folder_that_is_a_link_is_that_folder(tmp_path, small):
    real = tmp_path / "real"
    real.mkdir()
    (tmp_path / "link").symlink_to(real)
    path = Session(small, tmp_path / "link").save("mine")
    assert (real / "mine.toml").is_file()
    assert os.path.realpath(path) == str(real / "mine.toml")


def test_a_file_is_no_folder(tmp_path, small):
    (tmp_path / "file").write_text("x", encoding="utf-8")
    with pytest.raises(prsm.PrsmError, match="is a file; choose a folder"):
        Session(small, tmp_path / "file")


def test_a_taken_port_is_told():
    with open_socket(0) as taken:
        taken.listen()
        host, port = taken.getsockname()
        assert host == "127.0.0.1"
        with pytest.raises(prsm.PrsmError, match=f"--port {port}: .*; give another port"):
            open_socket(port)
    with pytest.raises(prsm.PrsmError, match="--port 70000"):
        open_socket(70000)


def test_without_the_extra_one_sentence_says_so(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PRSM_JAX_CACHE", "")
    monkeypatch.setitem(__import__("sys").modules, "nicegui", None)
    assert main(["studio", "wu2022"]) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1
    assert "pip install 'prsm-jax[studio]'" in told[0]
    assert not list(tmp_path.iterdir())
