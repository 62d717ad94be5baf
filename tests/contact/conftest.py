"""Names of approximations that a test adds are those of this test alone: messages list all."""

import pytest

from prsm_jax.mechanism import _contact_methods


@pytest.fixture(autouse=True)
def _own_approximations():
    before = dict(_contact_methods._APPROXIMATIONS)
    yield
    _contact_methods._APPROXIMATIONS.clear()
    _contact_methods._APPROXIMATIONS.update(before)
