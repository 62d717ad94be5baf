"""Numbers in README and documentation are those that the code computes, and none is left out."""

import re

import pytest

from tests.docs.claims import NUMBER, check, covered, numbers_of, page_text, value_of
from tests.docs.claims.claims_contact import CLAIMS as CONTACT
from tests.docs.claims.claims_published import CLAIMS as PUBLISHED
from tests.docs.claims.claims_readme import CLAIMS as README
from tests.docs.claims.claims_settings import CLAIMS as SETTINGS
from tests.docs.claims.claims_sharing import CLAIMS as SHARING
from tests.docs.claims.claims_strength import CLAIMS as STRENGTH
from tests.docs.claims.claims_stress import CLAIMS as STRESS

CLAIMS = [*PUBLISHED, *CONTACT, *STRESS, *STRENGTH, *SHARING, *README, *SETTINGS]
#: Pages whose every number is a claim, and what of them is none: what a paper prints, what is
#: chosen, run times of the authors' machine. Pieces of text, as regular expressions.
GIVEN = {
    "docs/published_tables.md": (
        r"a load of 43 N",
        r"half a unit of its last digit",
        r"Electronics 11, 1395",
        r"for 7 to 12 rollers",
        r"all 60 frequencies and all ten shapes of\s17 entries",
        r"0\.033 kg",
        r"are\s45° at the threads and 20° at",
        r"^\|[^|]*\|[^|]*\|",
        r"within 0\.1 %:|within 0\.01 %:",
        r"1000, 1260 and 1588 MPa\sfor 999, 1259 and 1585",
        r"nut's 1585 MPa at 100 N",
        r"the printed 0\.5 % to",
        r"\(−0\.072576\)",
        r"at 25, 50 and 100 N",
        r"\(0\.20 mm at 25 N\)",
        r"\(nut, 50 and 100 N\)",
        r"elements\s+of\s+0\.01 mm",
        r"At 100 N they agree",
        r"nut, 50 N\)\. A nut thread that ends 0\.075 or 0\.05 mm",
        r"rounded by 0\.2 mm",
        r"32 cells an axis",
        r"Table 1's 30°",
        r"and 30° is no optimum",
        r"10⁵",
        r"figures 8 to 10",
        r"equations 17, 18 and 28|[Ee]quation (17|23|35)",
        r"below 0\.45, nearly 0\.80",
        r"the printed 879 MPa",
        # Planetary gear: rows of `prsm validate lin_parker1999`, tested with it.
        r"gfsReboucas/Drivetrain.*`test_01`|all 42 frequencies",
        r"three\sof them \(2614\.8, 1072\.0 and 7382\.4 Hz",
        r"727\.0 and 1091\.0 are",
    ),
    "docs/contact_hertz.md": (
        r"for \$B/A\$ 1\.15 to 1\.6|10⁴",
        r"with 64 nodes|against 1024 nodes, 150\srandom points within 1\.5 semi-axes",
        r"^\| 0\.(7|1|01), (64|96) \|",
        r"Friction of 0\.1 |of 0\.25 by",
        r"profile angles of 30°",
        r"For 55 N:",
        r"half-space, 64 × 32 \| 128 × 64",
    ),
    "docs/contact_surfaces.md": (
        r"principal directions, 1\.3\s|grid 1\.3 times the ellipse",
        r"^\| \d+ × \d+ \|",
        r"1e-4 leaves errors like|default of 1e-8",
        # Run times.
        r"for errors up to 1e-4 .*\(64 × 64|cells\): 2\.1 ms .*; with 16$",
        r"on\s32 × 32 cells|on 32 × 32 cells and|on 64 × 64",
        r"at a depth of 0\.3",
        r"at 25, 50 and 100 N",
        r"^\| \| screw, 25 N.*$|^\| paper, .*$",
        r"on 32 cells an axis",
        r"deviations from Hertz at 25 and 50 N",
        r"grid of 0\.01 mm.*at\s+25 N",
        r"nominal radius \(50\s+N\)",
        r"Hertz for 0\.05 mm and an edge rounded by 0\.2\s+mm",
        r"\(\*(Phil\. Trans\. R\. Soc\. A|Wear|Int\. J\. Solids Struct\.|J\. Tribology)\* \d+\)",
        r"^1998 \(\*J\. Tribology\* 120\)",
    ),
    "docs/load_sharing.md": (
        r"20 threads, 10 rollers",
        r"^\| all unlike \| 11 \|",
        # Published.
        r"importances of 47 % for the nut's eccentricity, 34 % for the screw's and 19 %",
    ),
    "docs/vibration.md": (
        r"1e12 apart",
        r"×1700|1700 times",
        # Sources.
        r"J\. Appl\. Mech\. 16 \(1949\) 259–268",
        r"\(1985\), section 7\.2",
        r"J\. Vib\. Acoust\.\s121 \(1999\) 316–321",
        r"AIAA J\. 6 \(1968\) 2426–2429",
    ),
    "docs/response.md": (r"80 teeth on 10 rollers",),
    "docs/dynamics.md": (r"\(17 to 28\)", r"tested down to 0\.01 rad/s"),
}


@pytest.mark.parametrize(
    "claim",
    CLAIMS,
    ids=lambda claim: f"{claim.page[5:]}: {claim.text[:60]}",
)
def test_number_is_the_computed_one(claim):
    check(claim)


def test_numbers_are_read_as_they_are_printed():
    assert value_of("22,308") == (22308.0, 0.5)
    assert value_of("−361.2") == (-361.2, pytest.approx(0.05))
    assert value_of("4e-16") == (4e-16, pytest.approx(0.5e-16))
    assert value_of("2.4·10⁻⁵") == (pytest.approx(2.4e-5), pytest.approx(0.05e-5))
    assert re.findall(NUMBER, "22,308 Hz, 3·10⁻⁸; 2e-15.") == ["22,308", "3·10⁻⁸", "2e-15"]


@pytest.mark.parametrize("page", GIVEN)
def test_no_number_of_a_page_is_left_out(page):
    """A number that is neither computed here nor given from outside fails, with its line."""
    text, spans = page_text(page), covered(page, CLAIMS)
    spans += [m.span() for one in GIVEN[page] for m in re.finditer(one, text, flags=re.M)]
    left = [
        f"{number} in: {text[text.rfind(chr(10), 0, start) + 1 : text.find(chr(10), end)]}"
        for start, end, number in numbers_of(page)
        if not any(first <= start and end <= last for first, last in spans)
    ]
    assert not left, "\n".join(left)
