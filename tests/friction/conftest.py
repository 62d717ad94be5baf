"""Names of laws that a test adds are those of this test alone: messages and files list all."""

import pytest

from prsm_jax.friction import _register


@pytest.fixture(autouse=True)
def _own_laws():
    before = dict(_register._LAWS)
    yield
    _register._LAWS.clear()
    _register._LAWS.update(before)
