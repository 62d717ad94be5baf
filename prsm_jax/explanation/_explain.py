"""The function `explain`: counts programs with every part, and without each."""

from collections.abc import Callable, Sequence
from typing import Any

from .._errors import PrsmError, UnknownNameError, closest
from ..mechanism import Mechanism, of_one_known_design
from ..programs import runs_one_verb, stored_facts
from ..quantities import assumptions, available_quantities
from ._account import PROGRAMS, REFUSALS, Account, analysis_of, compiled, number_paths, traced
from ._explanation import Cost, Explanation, Part, Program
from ._places import Place, places, without

_DEFAULT = ("steady_state", "modes")


class _Counted:
    """One program, for the complete mechanism and without each part."""

    def __init__(self, name: str, mechanism: Mechanism, time: bool):
        self.name, self.complete = name, mechanism
        self.analysis = analysis_of(name, mechanism)
        self.time = time
        self.account, self.read = self._count(mechanism, None)

    def _count(self, mechanism: Mechanism, same: Account | None) -> tuple[Account, frozenset[Any]]:
        account, read = self._traced(mechanism)
        if not self.time:
            return account, read
        # A program with as many equations is the same one, and is not compiled again.
        if same is not None and account.equations == same.equations:
            return same, read
        return compiled(self.analysis, mechanism, account.equations), read

    def _traced(self, mechanism: Mechanism) -> tuple[Account, frozenset[Any]]:
        # In this process nothing is counted twice; the next one finds the counts in a file.
        if not runs_one_verb():
            return traced(self.analysis, mechanism)
        found = stored_facts(f"account of {self.name}", self._told, mechanism, self.complete)
        if isinstance(found, str):
            raise PrsmError(found)
        return found

    def _told(self, mechanism: Mechanism, _: Mechanism) -> tuple[Account, frozenset[Any]] | str:
        """The count, or why there is none."""
        try:
            return traced(self.analysis, mechanism)
        except REFUSALS as error:
            return str(error)

    def cost(self, place: Place, rest: Mechanism, has_numbers: bool) -> Cost:
        """Cost of the part at a place, whose absence leaves `rest`.

        `has_numbers` says whether the part has numbers; if the program reads none of them, the part
        costs nothing.
        """
        depth = len(place.path)
        if has_numbers and not any(path[:depth] == place.path for path in self.read):
            return Cost(self.account, self.account)
        try:
            return Cost(self.account, self._count(rest, self.account)[0])
        except REFUSALS as error:
            return Cost(self.account, None, str(error))


@of_one_known_design
def explain(
    mechanism: Mechanism,
    *,
    programs: Sequence[str] | None = None,
    numbers: bool = False,
    time: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> Explanation:
    """List the optional parts of a mechanism, those that it leaves out, and the cost of each.

    The cost of a part is the difference between a program of the mechanism with it and without it.
    Programs are traced, which takes a fraction of a second each; with `time` they are compiled and
    run, which takes seconds to minutes.

    **Arguments:**

    - `mechanism`: the mechanism.
    - `programs`: analyses that are counted, from `steady_state`, `modes`, `transient` and
      `quantities` (all that there are data for); default the first two, and with `time` the
      transient too if there is a scenario.
    - `numbers`: also count what each optional number costs.
    - `time`: also compile and run: flops, bytes, memory, compiling and run time.
    - `progress`: called with the number of counted parts, their total, and the word "parts".

    **Raises:** `UnknownNameError` for an unknown program.
    """
    if programs is None:
        programs = (*_DEFAULT, *(("transient",) if time and mechanism.scenario else ()))
    for name in programs:
        if name not in PROGRAMS:
            raise UnknownNameError(f"unknown program {name!r}; {closest(name, PROGRAMS)}")
    counted: dict[str, _Counted] = {}
    totals = []
    for name in programs:
        try:
            counted[name] = _Counted(name, mechanism, time)
            totals.append(Program(name, counted[name].account))
        except REFUSALS as error:
            totals.append(Program(name, None, str(error)))
    parts, all_places = [], places(mechanism)
    for done, place in enumerate(all_places):
        if progress is not None:
            progress(done, len(all_places), "parts")
        parts.append(_part(place, mechanism, counted, numbers))
    return Explanation(mechanism.title, tuple(totals), tuple(parts))


def _part(place: Place, mechanism: Mechanism, counted: dict[str, _Counted], numbers: bool) -> Part:
    if not place.present or (place.kind == "number" and not numbers):
        return Part(place, {})
    try:
        rest = without(mechanism, place)
    except REFUSALS as error:
        return Part(place, {n: Cost(c.account, None, str(error)) for n, c in counted.items()})
    before = assumptions(mechanism)
    assumed = tuple(one for one in assumptions(rest) if one not in before)
    depth = len(place.path)
    has_numbers = any(path[:depth] == place.path for path in number_paths(mechanism))
    costs = {name: one.cost(place, rest, has_numbers) for name, one in counted.items()}
    quantities_lost: tuple[str, ...] = ()
    if "quantities" in counted and costs["quantities"].absent is not counted["quantities"].account:
        remaining = set(available_quantities(rest))
        quantities_lost = tuple(
            name for name in available_quantities(mechanism) if name not in remaining
        )
    return Part(place, costs, assumed, quantities_lost)
