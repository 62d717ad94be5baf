"""Numbers in README and documentation are those that the code computes, and none is left out."""

import re

import pytest
from claims import NUMBER, check, value_of
from claims_contact import CLAIMS as CONTACT
from claims_published import CLAIMS as PUBLISHED

CLAIMS = [*PUBLISHED, *CONTACT]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: f"{claim.page[5:]}: {claim.text[:60]}")
def test_number_is_the_computed_one(claim):
    check(claim)


def test_numbers_are_read_as_they_are_printed():
    assert value_of("22,308") == (22308.0, 0.5)
    assert value_of("−361.2") == (-361.2, pytest.approx(0.05))
    assert value_of("4e-16") == (4e-16, pytest.approx(0.5e-16))
    assert value_of("2.4·10⁻⁵") == (pytest.approx(2.4e-5), pytest.approx(0.05e-5))
    assert re.findall(NUMBER, "22,308 Hz, 3·10⁻⁸; 2e-15.") == ["22,308", "3·10⁻⁸", "2e-15"]
