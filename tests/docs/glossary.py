"""`python -m tests.docs.glossary`: writes the tables of docs/glossary.md.

They follow from what the classes of a mechanism declare about their fields, and from the catalogue
of quantities. Terms and symbols above the tables are written by hand.
"""

import dataclasses
import inspect
from collections.abc import Iterator, Mapping
from pathlib import Path

from prsm_jax.fields import Declared, declared, module_classes
from prsm_jax.friction import friction_laws
from prsm_jax.mechanism import Mechanism
from prsm_jax.quantities import Quantity, catalogue

PAGE = Path(__file__).parents[2] / "docs" / "glossary.md"
_BEGIN = "<!-- Written by `python -m tests.docs.glossary` from here on. -->\n"
#: The unit of a profile's numbers is that of what it drives.
_OF_THE_VALUE = "*"


def package_quantities() -> tuple[Quantity, ...]:
    """The quantities of the package, without those that users or tests have added."""
    return tuple(q for q in catalogue() if q.function.__module__.startswith("prsm_jax."))


def _laws(*, of_threads: bool) -> tuple[type, ...]:
    known = friction_laws(of_threads=of_threads).values()
    return tuple(law for law in known if law.__module__.startswith("prsm_jax."))


@dataclasses.dataclass(frozen=True)
class _Table:
    """A table of the file in which numbers of a class stand, and units that are different there."""

    path: str
    units: Mapping[str, str]


def _tables(
    cls: type, table: _Table, above: tuple[type, ...] = ()
) -> Iterator[tuple[type, _Table]]:
    """The classes in a class, itself first, with the table where each stands."""
    yield cls, table
    for one in declared(cls, _OF_THE_VALUE):
        name = "stage" if one.name == "stages" else one.name
        inner = module_classes(one.element) if one.element else one.classes
        if any(inspect.isabstract(law) for law in inner):
            inner = _laws(of_threads=one.units is None)
        if one.units is None:
            place = _Table(f"{table.path}.{name}".lstrip("."), {})
        else:
            place = _Table(table.path, one.units)
        for part in inner:
            # A sum or a sequence may contain others of its kind.
            if part not in above:
                yield from _tables(part, place, (*above, cls))


def numbers() -> dict[type, list[_Table]]:
    """Every class with numbers, and the tables where it stands."""
    found: dict[type, list[_Table]] = {}
    for cls, table in _tables(Mechanism, _Table("", {})):
        if _numbers_of(cls) and table not in found.setdefault(cls, []):
            found[cls].append(table)
    return found


def _numbers_of(cls: type) -> list[Declared]:
    return [one for one in declared(cls, _OF_THE_VALUE) if one.unit is not None or one.whole]


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|").replace("*", r"\*") for cell in cells) + " |"


def _unit(one: Declared, places: list[_Table]) -> str:
    if one.unit == _OF_THE_VALUE:
        return "that of the value"
    unit = one.unit or "1"
    others = [f"{place.units[unit]} in `{place.path}`" for place in places if unit in place.units]
    return "; ".join([unit, *others])


def tables() -> str:
    """The generated part of the page."""
    lines = ["", "## Numbers of a mechanism", ""]
    lines += [
        "The unit of a profile's value is that of what it drives: rad/s, N·m or N. Profiles and",
        "loads may also be a `part` of a sequence or a sum.",
        "",
    ]
    for cls, places in numbers().items():
        paths = ", ".join(
            f"`{place.path}`" for place in places if "part" not in place.path.split(".")
        )
        lines += [f"### {cls.__name__}", "", f"In {paths}.", ""]
        lines += [_row("name", "unit", "meaning", "allowed"), "|---|---|---|---|"]
        lines += [
            _row(f"`{one.name}`", _unit(one, places), one.description, one.limit.allowed)
            for one in _numbers_of(cls)
        ]
        lines.append("")
    lines += ["## Quantities", ""]
    lines += ["`prsm quantities` prints the same list.", ""]
    lines += [_row("name", "symbol", "unit", "one for each", "meaning"), "|---|---|---|---|---|"]
    lines += [
        _row(f"`{q.name}`", q.symbol, q.unit, " and ".join(q.dimensions) or "–", q.description)
        for q in package_quantities()
    ]
    return "\n".join(lines) + "\n"


def page() -> str:
    """The page as it should be: its written part as it is, and the tables."""
    by_hand, _, _ = PAGE.read_text(encoding="utf-8").partition(_BEGIN)
    return by_hand + _BEGIN + tables()


def main() -> int:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(PAGE.parents[1]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
