"""Both papers of Li et al.: radii that follow from the roller's and the number of starts."""

from collections.abc import Iterator, Sequence

from .._examples import two_stages
from .._row import Row, number


def radius_rows(name: str, section: str, radii: Sequence[tuple[str, str]]) -> Iterator[Row]:
    """Radii of screw and nut of every stage of an example, as a section prints them [mm]."""
    for index, printed in enumerate(radii):
        thread = two_stages(name).stages[index].thread
        for body, value, radius in zip(
            ("screw", "nut"), printed, (thread.screw_radius, thread.nut_radius), strict=True
        ):
            yield number(
                f"{section}: nominal radius of {body} {index + 1}",
                value,
                1e3 * float(radius),
                "mm",
                note="from the roller's radius and the number of starts: r_s = (n − 2) r_R, "
                "r_n = n r_R",
            )
