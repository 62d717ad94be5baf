import pytest
import uncertainty_scenes

import prsm_jax as prsm
from prsm_jax.quantities import _catalogue


@pytest.fixture(autouse=True)
def own_quantities_of_these_tests(monkeypatch):
    """The catalogue is that of the package again afterwards."""
    monkeypatch.setattr(_catalogue, "_CATALOGUE", dict(_catalogue._CATALOGUE))
    for about, function in uncertainty_scenes.QUANTITIES:
        prsm.quantity(*about)(function)
