"""Numbers that README and documentation print, beside what computes them.

A claim is a piece of a page with every computed number put as `{}`, and a function that computes
them. The page is searched for the piece (spaces and line breaks count alike); a number is right if
it is the computed one rounded to the digits that are printed.
"""

import dataclasses
import re
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[3]
_SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
#: A number as pages print it: 22,308; −361.2; 4e-16; 3·10⁻⁸.
NUMBER = r"[−+-]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[−-]?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"


@dataclasses.dataclass(frozen=True)
class Claim:
    """Numbers of one piece of a page.

    - `rounded`: `True` if each is the computed number to its digits; `False` if it is a limit that
      the computed number must keep, and use up to a share of `slack`.
    """

    page: str
    text: str
    values: Callable[[], Sequence[float]]
    rounded: bool = True
    #: Units of half the last digit that are allowed, for numbers that hang on a threshold.
    halves: float = 1.0
    #: Least share of a limit that the computed number reaches, so that no limit is idle.
    least: float = 0.05

    @property
    def pattern(self) -> re.Pattern[str]:
        """The piece, with a group for every number and any white space for any other."""
        parts = [re.escape(part) for part in self.text.split("{}")]
        parts = [re.sub(r"(?:\\?\s)+", r"\\s+", part) for part in parts]
        return re.compile(f"({NUMBER})".join(parts))


def page_text(page: str) -> str:
    """A page as it stands."""
    return (ROOT / page).read_text(encoding="utf-8")


def value_of(printed: str) -> tuple[float, float]:
    """A printed number, and half a unit of its last digit."""
    plain = printed.replace(",", "").replace("−", "-")
    if "·10" in plain:
        mantissa, power = plain.split("·10")
        plain = f"{mantissa}e{power.translate(_SUPERSCRIPT)}"
    mantissa, _, power = plain.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(plain), 0.5 * 10.0 ** (int(power or 0) - decimals)


def check(claim: Claim) -> None:
    """Assert that the page has the piece once, with the numbers that are computed."""
    found = list(claim.pattern.finditer(page_text(claim.page)))
    assert len(found) == 1, f"{claim.page}: found {len(found)} times: {claim.text!r}"
    printed, computed = found[0].groups(), [float(value) for value in claim.values()]
    assert len(printed) == len(computed), f"{claim.text!r}: {printed} against {computed}"
    for text, value in zip(printed, computed, strict=True):
        stated, half = value_of(text)
        said = f"{claim.page}: {claim.text!r}: {text} against {value:.9g}"
        if claim.rounded:
            assert abs(stated - value) <= half * claim.halves * (1 + 1e-9), said
        else:
            assert claim.least * stated <= value <= stated + half, said


def numbers_of(page: str) -> list[tuple[int, int, str]]:
    """Every number of a page that is neither in code, a formula, a link nor a plain small count."""
    text = page_text(page)

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match.group(0))

    for pattern in (r"^```.*?^```", r"^\$\$.*?^\$\$", r"`[^`\n]*`", r"\$[^$]*\$", r"\]\([^)]*\)"):
        text = re.sub(pattern, blank, text, flags=re.M | re.S)
    found = []
    for match in re.finditer(rf"(?<![\w.]){NUMBER}", text):
        # Years, and counts in words of one digit.
        if not re.fullmatch(r"(19|20)\d\d|\d", match.group(0)):
            found.append((match.start(), match.end(), match.group(0)))
    return found


def covered(page: str, claims: Sequence[Claim]) -> list[tuple[int, int]]:
    """Where the claims' numbers stand in a page."""
    text = page_text(page)
    return [
        found.span(group)
        for claim in claims
        if claim.page == page
        for found in claim.pattern.finditer(text)
        for group in range(1, 1 + (found.lastindex or 0))
    ]
