"""Claims of README's table that rest on published numbers or on a grid."""

from prsm_jax.validation import validate
from tests.docs.claims import Claim, claims_contact, claims_published as published
from tests.present import present

README = "README.md"


def _misprint() -> list[float]:
    return [
        float(
            published.row("lisowski2014", "Table 2: Hertz pressure on the nut side, 100 N").computed
        )
    ]


def _largest_of_hertz() -> list[float]:
    """Largest departure from the printed pressures that are no misprint [%]."""
    found = published.rows("lisowski2014").values()
    return [
        max(
            100 * abs(present(one.relative_difference))
            for one in found
            if ": Hertz pressure on the " in one.item and one.verdict == "reproduced"
        )
    ]


def _single_tooth() -> list[float]:
    return [2.464e8 / float(published.row("wu2022", "Table 4: gear mesh stiffness, eq").computed)]


CLAIMS = [
    Claim(
        README,
        "{} %; one of six is a misprint (1585 for",
        _largest_of_hertz,
        rounded=False,
        least=0.5,
    ),
    Claim(README, "is a misprint (1585 for {} MPa)", _misprint),
    Claim(README, "reproduced, as {} times the single-tooth value", _single_tooth),
    Claim(
        README,
        "B/A = 1.4, 128 × 128 cells; cone, punches, Cattaneo–Mindlin | {} in pressure and approach",
        lambda: [max(claims_contact._grid_errors(128))],
    ),
    Claim(
        README,
        "every statement of the text ({} rows) | efficiency 0.60 → 0.87",
        lambda: [float(len(validate("li2020")))],
    ),
    Claim(
        README,
        "every statement of the text ({} rows) | efficiency below 0.45",
        lambda: [float(len(validate("li2021")))],
    ),
    Claim(
        README,
        "influence of each friction | {} → {};",
        lambda: published._efficiencies(published.LI2020),
    ),
    Claim(
        README,
        "0.14 and 0.46 ms | {} → {}; {} and {} ms, at 0.1 % and 0.01 %",
        lambda: [
            *published._efficiencies(published.LI2021),
            published._settling()[0],
            published._settling()[3],
        ],
    ),
]
