"""One small screw for all tests of the studio: its programs compile once."""

from pathlib import Path

import pytest

from prsm_jax.studio import Session

SMALL = Path(__file__).with_name("small_screw.toml")


@pytest.fixture
def small() -> str:
    """The path of the small screw."""
    return str(SMALL)


@pytest.fixture
def session(tmp_path, small) -> Session:
    """A new session of the small screw; its chosen folder is not there yet."""
    return Session(small, tmp_path / "chosen")
