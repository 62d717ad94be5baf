"""Result of `explain`: parts carried and left out, with their costs; it can be printed."""

from dataclasses import asdict, dataclass
from typing import Any

from ..fields import old_name
from ..results import Shown
from ..text import TextTable
from ._account import MEASURES, Account
from ._places import Place


@dataclass(frozen=True)
class Cost:
    """Cost of one part in one program: the difference with and without the part.

    - `present`: the program of the complete mechanism.
    - `absent`: the program of the mechanism without the part; `None` if there is none.
    - `needed`: the reason why there is no program without the part, else `None`.
    """

    present: Account
    absent: Account | None
    needed: str | None = None

    def difference(self, measure: str) -> int | float | None:
        """Value with the part minus value without it, by the name of a field of `Account`."""
        if self.absent is None:
            return None
        pair = getattr(self.present, measure), getattr(self.absent, measure)
        return None if None in pair else pair[0] - pair[1]

    @property
    def equations(self) -> int | None:
        """Equations that the part adds; `None` where the program needs it."""
        count = self.difference("equations")
        return None if count is None else int(count)


@dataclass(frozen=True)
class Part:
    """An optional part: its place, its cost in each program, and the assumptions without it.

    `costs` is empty for a part that is absent. `assumed` are the sentences of
    `prsm_jax.assumptions` that apply only without the part.
    """

    place: Place
    costs: dict[str, Cost]
    assumed: tuple[str, ...] = ()
    quantities_lost: tuple[str, ...] = ()

    @property
    def lost(self) -> tuple[str, ...]:
        """Old name of `quantities_lost`."""
        return old_name(self, "lost", "quantities_lost")

    @property
    def name(self) -> str:
        """Name of the part, such as `stage.1.friction.spin`."""
        return self.place.name

    @property
    def present(self) -> bool:
        """Whether the mechanism carries it."""
        return self.place.present

    @property
    def reason(self) -> str:
        """Why the part is there or not, in words."""
        if self.present:
            return f"given as {self.place.law}" if self.place.law else "given"
        return f"not given; write {self.place.write}"

    def to_dict(self) -> dict[str, Any]:
        """Numbers and words by the keys of the JSON."""
        place = self.place
        costs = {
            name: {m: cost.difference(m) for m in MEASURES}
            | {"needed": cost.needed}
            | {f"{m}_without": _of(cost.absent, m) for m in MEASURES}
            for name, cost in self.costs.items()
        }
        return {
            "name": place.name,
            "kind": place.kind,
            "present": place.present,
            "law": place.law,
            "laws": list(place.laws),
            "meaning": place.meaning,
            "without": place.without,
            "reason": self.reason,
            "write": place.write,
            "assumed_without": list(self.assumed),
            "quantities_lost_without": list(self.quantities_lost),
            "costs": costs,
        }


@dataclass(frozen=True)
class Program:
    """One program of the complete mechanism: its cost, or the reason why there is none."""

    name: str
    account: Account | None
    error: str | None = None


def _of(account: Account | None, measure: str) -> int | float | None:
    return None if account is None else getattr(account, measure)


@dataclass(frozen=True, repr=False)
class Explanation(Shown):
    """Optional parts that a mechanism has, those left out and why, and the cost of each."""

    title: str
    programs: tuple[Program, ...]
    parts: tuple[Part, ...]

    @property
    def carried(self) -> tuple[Part, ...]:
        """Parts that the mechanism has."""
        return tuple(part for part in self.parts if part.present)

    @property
    def left_out(self) -> tuple[Part, ...]:
        """Parts that it could have."""
        return tuple(part for part in self.parts if not part.present)

    def part(self, name: str) -> Part:
        """The part with a name. **Raises:** `KeyError` if there is none."""
        for one in self.parts:
            if one.name == name:
                return one
        raise KeyError(name)

    @property
    def rows(self) -> tuple[dict[str, Any], ...]:
        """Every part as a dictionary, as in the JSON."""
        return tuple(part.to_dict() for part in self.parts)

    def to_dict(self) -> dict[str, Any]:
        """Everything by the keys of the JSON."""
        empty: dict[str, Any] = dict.fromkeys(MEASURES)
        programs = [
            {
                "name": p.name,
                **(asdict(p.account) if p.account else empty),
                "error": p.error,
            }
            for p in self.programs
        ]
        return {"title": self.title, "programs": programs, "parts": list(self.rows)}

    def tables(self, numbers: bool = False) -> list[TextTable]:
        """Programs, parts carried and parts left out, as tables.

        **Arguments:**

        - `numbers`: optional numbers too.
        """
        counted = [p for p in self.programs if p.account is not None]
        # All measures if programs were compiled, else only equations.
        shown = [m for m in MEASURES if any(getattr(p.account, m) is not None for p in counted)]
        rows = [(p.name, *(_of(p.account, m) for m in shown)) for p in self.programs]
        heads = ("", *map(_words, shown))
        if any(p.error for p in self.programs):
            rows = [(*row, p.error or "") for row, p in zip(rows, self.programs, strict=True)]
            heads = (*heads, "why there is none")
        tables = [TextTable("Programs", heads, rows)]
        for number in (False, True) if numbers else (False,):
            carried = [p for p in self.carried if (p.place.kind == "number") == number]
            columns = [(p.name, m) for p in counted for m in shown]
            cells = [
                (
                    part.name if part.place.law is None else f"{part.name} ({part.place.law})",
                    *(_cell(part.costs.get(program), m) for program, m in columns),
                    part.place.without,
                )
                for part in carried
            ]
            title = "Numbers given" if number else "Parts carried"
            heads = [f"{program}: {_words(m)}" for program, m in columns]
            if shown == ["equations"]:
                title += ", and equations that each adds"
                heads = [program.replace("_", " ") for program, _ in columns]
            tables.append(TextTable(title, ("", *heads, "without it"), cells))
            absent = [p for p in self.left_out if (p.place.kind == "number") == number]
            title = "Numbers not given" if number else "Parts left out, since they are not given"
            tables.append(TextTable(title, ("", "to have it, write", "without it"), _once(absent)))
        return tables

    def text(self, width: int | None = None, numbers: bool = False) -> str:
        """Tables as plain text.

        **Arguments:**

        - `width`: characters in a line; default as many as needed.
        - `numbers`: optional numbers too.
        """
        return "\n".join(table.text(width) for table in self.tables(numbers))

    def __str__(self) -> str:
        return self.text(100)


def _words(measure: str) -> str:
    return {
        "memory_bytes": "memory [B]",
        "bytes": "bytes",
        "compile_s": "compiling [s]",
        "run_s": "run [s]",
    }.get(measure, measure)


def _once(parts: list[Part]) -> list[tuple[str, str, str]]:
    """Name, text to write, and what results miss: one row for all stages that lack a part."""
    stages: dict[tuple[str, str, str], list[str]] = {}
    for part in parts:
        head, _, rest = part.name.partition(".")
        number, _, field = rest.partition(".")
        in_stage = head == "stage" and field != ""
        key = (f"stage.{field}" if in_stage else part.name, part.place.write, part.place.without)
        stages.setdefault(key, []).append(number if in_stage else "")
    several = len({n for numbers in stages.values() for n in numbers if n}) > 1
    return [
        (f"{name} (stage {', '.join(n)})" if several and n[0] else name, write, misses)
        for (name, write, misses), n in stages.items()
    ]


def _cell(cost: Cost | None, measure: str) -> Any:
    if cost is None:
        return None
    return "needed" if cost.needed is not None else cost.difference(measure)
