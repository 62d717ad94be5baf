"""One real analysis, and mechanisms from the shipped examples."""

import pytest
from report_scenes import make_optimum

from prsm_jax.file import load
from prsm_jax.report import analyse, summarise_optimisation
from prsm_jax.report.document import _write


@pytest.fixture(scope="session", autouse=True)
def _pages_without_the_library():
    """Pages of some hundred kilobytes, whether plotly is installed or not; one test embeds it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_write, "plotly_library", lambda: None)
        yield


@pytest.fixture(scope="session")
def wu2022():
    return load("wu2022")


@pytest.fixture(scope="session")
def actuator():
    return load("actuator")


@pytest.fixture(scope="session")
def data(wu2022):
    return analyse(wu2022, source="wu2022", command="prsm demo", transient=False)


@pytest.fixture(scope="session")
def optimisation(wu2022):
    return summarise_optimisation(make_optimum(wu2022))
