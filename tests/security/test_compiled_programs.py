"""Compiled programs of other users are not run: such a program has the rights of its reader.

Every attempt puts a program that writes a file when it is read in the place of a stored one.
"""

import hashlib
import os
import pickle
from pathlib import Path

import jax
import pytest

from prsm_jax.cli._compiled import keep_compiled_programs
from prsm_jax.process import others_can_write
from prsm_jax.programs import _files

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and permissions of POSIX")
_STRANGER = 12345


class _Planted:
    """Pickled, it writes a file in the place where it is read."""

    def __init__(self, mark: Path):
        self.mark = mark

    def __reduce__(self):
        return Path.write_text, (self.mark, "run")


@pytest.fixture
def planted(tmp_path):
    """A stored program that somebody else has written, and the file that it writes if read."""
    data = pickle.dumps(_Planted(tmp_path / "mark"))
    folder = tmp_path / "programs"
    folder.mkdir(mode=0o700)
    (folder / "key").write_bytes(hashlib.sha256(data).digest() + data)
    (folder / "key").chmod(0o600)
    return folder / "key", tmp_path / "mark"


@pytest.fixture
def stranger(monkeypatch):
    """Makes this user somebody else than the owner of its files, also where tests run as root."""
    stat = os.stat

    def owned(path, *args, **options):
        values = list(stat(path, *args, **options))
        values[4] = _STRANGER
        return os.stat_result(values)

    def change():
        monkeypatch.setattr("prsm_jax.process._private.os.stat", owned)

    return change


def test_an_own_program_is_read(planted):
    """The attempts below fail for no other reason than the owner and the permissions."""
    path, mark = planted
    pickle.loads(_files.read(path))
    assert mark.read_text() == "run"


@pytest.mark.parametrize("which", ["file", "folder"])
@pytest.mark.parametrize("mode", [0o020, 0o002])
def test_a_program_that_others_can_write_is_refused(planted, which, mode):
    path, mark = planted
    place = path if which == "file" else path.parent
    place.chmod(0o700 | mode)
    with pytest.raises(ValueError, match="is not read: others can write to it"):
        _files.read(path)
    assert not mark.exists()


def test_a_program_of_another_user_is_refused(planted, stranger):
    path, mark = planted
    stranger()
    with pytest.raises(ValueError, match="is not read: it belongs to another user"):
        _files.read(path)
    assert not mark.exists()


def test_programs_are_written_for_this_user_alone(tmp_path):
    path = tmp_path / "cache" / "programs" / "key"
    before = os.umask(0)
    try:
        _files.write(path, b"program")
    finally:
        os.umask(before)
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700
    assert _files.read(path) == b"program"


def test_nothing_is_written_where_others_can_write(tmp_path):
    path = tmp_path / "programs" / "key"
    path.parent.mkdir()
    path.parent.chmod(0o777)
    _files.write(path, b"program")
    assert not path.exists()


@pytest.fixture
def setting(monkeypatch):
    """Records the settings of JAX instead of changing them."""
    found: dict[str, object] = {}
    monkeypatch.setattr(jax.config, "update", found.__setitem__)
    monkeypatch.setattr("prsm_jax.cli._compiled.write_whole_entries", lambda: None)
    return found


def test_the_command_line_refuses_a_folder_of_others(tmp_path, monkeypatch, setting, capsys):
    folder = tmp_path / "cache"
    folder.mkdir()
    folder.chmod(0o777)
    monkeypatch.setenv("PRSM_JAX_CACHE", str(folder))
    keep_compiled_programs()
    assert not setting
    told = capsys.readouterr().err
    assert f"{folder}: compiled programs of earlier runs are not used (others can write" in told
    assert "remove the folder" in told
    folder.rmdir()
    keep_compiled_programs()
    assert setting["jax_compilation_cache_dir"] == str(folder)
    assert folder.stat().st_mode & 0o777 == 0o700
    assert capsys.readouterr().err == ""


def test_folders_of_the_administrator_and_of_this_user_are_trusted(tmp_path):
    tmp_path.chmod(0o755)
    assert others_can_write(tmp_path) is None
    assert others_can_write(Path("/")) is None
