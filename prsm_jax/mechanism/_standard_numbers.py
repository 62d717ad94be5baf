"""Standard modules and leads, and preferred numbers."""

import math

#: Nominal leads of ISO 3408-2 (ball screws), and those that makers of roller screws add [mm].
LEADS: tuple[float | int, ...] = (
    *(1, 2, 2.5, 3, 4, 5, 6, 8, 9, 10, 12, 15, 16, 18, 20, 24, 25, 30, 32, 35, 36, 40, 42, 50),
)
#: Modules of both series of DIN 780-1, which include those of ISO 54 from 1 mm on [mm].
MODULES: tuple[float | int, ...] = (
    *(0.05, 0.055, 0.06, 0.07, 0.08, 0.09, 0.1, 0.11, 0.12, 0.14, 0.16, 0.18, 0.2, 0.22, 0.25),
    *(0.28, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95),
    *(1, 1.125, 1.25, 1.375, 1.5, 1.75, 2, 2.25, 2.5, 2.75, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8, 9, 10),
)
#: Modules of small gears that are first choices, for the rules of catalogue sizes [mm].
USUAL_MODULES: tuple[float | int, ...] = (0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0)
#: One decade of the series R40 of ISO 3, in hundredths; R20, R10 and R5 skip numbers of it.
_R40 = (
    *(100, 106, 112, 118, 125, 132, 140, 150, 160, 170, 180, 190, 200, 212, 224, 236, 250, 265),
    *(280, 300, 315, 335, 355, 375, 400, 425, 450, 475, 500, 530, 560, 600, 630, 670, 710, 750),
    *(800, 850, 900, 950),
)
_STEPS = {"R5": 8, "R10": 4, "R20": 2, "R40": 1}
#: Words for all series, as a file has them.
SERIES = ("modules", "leads", *_STEPS)
#: A limit that a calculation has rounded includes its number [relative].
_ROUNDING = 1e-9


def _check_limits(what: str, lower: float, upper: float) -> None:
    if not 0 < lower <= upper < math.inf:
        raise ValueError(
            f"limits of {what} are {lower:g} and {upper:g}; give two finite positive numbers, the "
            "lower one first"
        )


def _within(
    what: str, numbers: tuple[float, ...], lower: float, upper: float, unit: str = ""
) -> tuple[float, ...]:
    within = tuple(x for x in numbers if lower * (1 - _ROUNDING) <= x <= upper * (1 + _ROUNDING))
    if not within:
        least, most = numbers[0], numbers[-1]
        raise ValueError(
            f"no {what} from {lower:g} to {upper:g}{unit}; those known are from {least:g} to "
            f"{most:g}{unit}: widen the limits"
        )
    return within


def _metres(millimetres: tuple[float | int, ...]) -> tuple[float, ...]:
    # As a reader of "0.3 mm" gets it: 0.3 times 1e-3 is another double.
    return tuple(float(f"{number}e-3") for number in millimetres)


def standard_modules(lower: float, upper: float) -> tuple[float, ...]:
    """Gear modules of DIN 780 and ISO 54 within limits, for `choices` of `gear_module`.

    **Arguments:**

    - `lower`, `upper`: limits, themselves included [m].

    **Returns:** the modules in ascending order [m], of 0.05 to 10 mm.

    **Raises:** `ValueError` for limits that are no range, or without a module between them.
    """
    _check_limits("standard modules", lower, upper)
    return _within("standard module", _metres(MODULES), lower, upper, " m")


def standard_leads(lower: float, upper: float) -> tuple[float, ...]:
    """Preferred leads of ISO 3408-2 and of roller screw catalogues within limits.

    **Arguments:**

    - `lower`, `upper`: limits, themselves included [m].

    **Returns:** the leads in ascending order [m], of 1 to 50 mm.

    **Raises:** `ValueError` for limits that are no range, or without a lead between them.
    """
    _check_limits("standard leads", lower, upper)
    return _within("standard lead", _metres(LEADS), lower, upper, " m")


def preferred_numbers(lower: float, upper: float, series: str = "R10") -> tuple[float, ...]:
    """Preferred numbers of ISO 3 (Renard series) within limits.

    **Arguments:**

    - `lower`, `upper`: limits, themselves included, in any unit that is a power of ten of the SI
      unit: the numbers repeat in every decade.
    - `series`: `"R5"`, `"R10"`, `"R20"` or `"R40"`, with so many numbers in a decade.

    **Returns:** the numbers in ascending order.

    **Raises:** `ValueError` for an unknown series, limits that are no range, or without a number
    of the series between them.
    """
    if series not in _STEPS:
        raise ValueError(f"series is {series!r}; choose one of {', '.join(_STEPS)}")
    _check_limits(f"preferred numbers {series}", lower, upper)
    # One decade more on either side: logarithms are rounded.
    first, last = math.floor(math.log10(lower)) - 1, math.floor(math.log10(upper)) + 1
    numbers = tuple(
        float(f"{number}e{decade - 2}")
        for decade in range(first, last + 1)
        for number in _R40[:: _STEPS[series]]
    )
    return _within(f"preferred number of {series}", numbers, lower, upper)


def numbers_of_series(series: str, lower: float, upper: float) -> tuple[float, ...]:
    """The numbers of a series within limits, by its word in `SERIES` [SI].

    **Raises:** `ValueError` as the function of the series does.
    """
    of = {"modules": standard_modules, "leads": standard_leads}
    if series in of:
        return of[series](lower, upper)
    return preferred_numbers(lower, upper, series)


__all__ = ["preferred_numbers", "standard_leads", "standard_modules"]
