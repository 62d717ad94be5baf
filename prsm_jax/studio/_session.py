"""The state of the studio: a design, its way, its numbers, its files. No page is needed."""

import shlex
import threading
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from .._errors import PrsmError
from ..file import apply_settings, edit, load, round_in_unit, source_text
from ..mechanism import Mechanism, find_parameters
from ..optimisation import LimitReading
from ..quantities import catalogue
from ..report import analyse, origin_of_file, section_svg, write_report
from ._folder import ChosenFolder
from ._history import History, Values
from ._improve import Improvement
from ._readings import (
    Numbers,
    Verdicts,
    limits_of,
    numbers_of,
    shown_quantities,
    verdicts_of,
)
from ._variables import StudioVariable, present_values, studio_variables, with_values

#: Folder of the report inside the chosen one.
REPORT = "report"
#: Significant digits of numbers from a search, as `prsm optimise` writes them.
_DIGITS = 6


class Session:
    """A mechanism of which some numbers are moved.

    Its methods may be called from several threads.

    **Arguments:**

    - `source`: a file or the name of an example.
    - `folder`: the only folder that files are written into.
    - `settings`: numbers to set after reading, such as `lead=12 mm`.
    - `options`: words of other options, such as `--plugin` and its module, for the command that a
      report names.

    **Raises:** `FileError` if the source cannot be read; `PrsmError` if the folder is a file, or
    the mechanism has nothing to move.
    """

    def __init__(
        self,
        source: str,
        folder: Path | str,
        settings: Sequence[str] = (),
        *,
        options: Sequence[str] = (),
    ):
        loaded = load(source)
        self.original: Mechanism = apply_settings(loaded, settings) if settings else loaded
        self.source: str = source
        self.settings: tuple[str, ...] = tuple(settings)
        self.options: tuple[str, ...] = tuple(options)
        self.folder: ChosenFolder = ChosenFolder(folder)
        self.variables: tuple[StudioVariable, ...] = studio_variables(self.original)
        if not self.variables:
            raise PrsmError(f"{source}: has no number to move; give an [optimise] table with some")
        present = present_values(self.original, self.variables)
        self._base: Mechanism = with_values(self.original, present)
        self._first: History = History.of(present)
        self._history: History = self._first
        self._lock = threading.RLock()
        #: Counts changes, so that a page knows when to draw itself anew.
        self.version: int = 0
        #: The design that others are compared with, and its numbers.
        self.kept: Numbers | None = None
        self.improvement: Improvement | None = None
        self._quantities: tuple[str, ...] | None = None
        #: The last design and its mechanism: drawing, numbers and verdicts share it.
        self._last: tuple[dict[str, float], Mechanism] = dict(present), self._base

    @property
    def design(self) -> Values:
        """Present values of the variables [SI]."""
        return self._history.present

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return bool(self._history.past) or self._history.present != self._history.settled

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step."""
        return bool(self._history.future)

    def variable(self, name: str) -> StudioVariable:
        """The variable of a name.

        **Raises:** `PrsmError` if there is none.
        """
        found = [one for one in self.variables if one.name == name]
        if not found:
            known = ", ".join(one.name for one in self.variables)
            raise PrsmError(f"unknown variable {name!r}; known: {known}")
        return found[0]

    def move(self, name: str, shown: float | int | None) -> None:
        """Move a variable, in the unit of the page, without a step that can be undone.

        **Raises:** `PrsmError` without a number, such as `None`, or beyond the limits;
        `ValueError` where it excludes another number.
        """
        value = self.variable(name).read(shown)
        with self._lock:
            moved = self._history.moved({name: value})
            # A design that cannot be is refused here.
            self._with(moved.present)
            self._become(moved)

    def commit(self) -> None:
        """Make what has moved one step that can be undone."""
        with self._lock:
            self._become(self._history.committed())

    def set(self, name: str, shown: float | int | None) -> None:
        """Move a variable as one step; raises as `move`."""
        with self._lock:
            self.move(name, shown)
            self.commit()

    def undo(self) -> None:
        """Go back by one step."""
        with self._lock:
            self._become(self._history.undone())

    def redo(self) -> None:
        """Go forward again by one step."""
        with self._lock:
            self._become(self._history.redone())

    def _become(self, history: History) -> None:
        if history is not self._history:
            self._history = history
            self.version += 1

    def mechanism(self, design: Values | None = None) -> Mechanism:
        """The mechanism with the values of a design [SI], default the present one.

        With the values of the file it is that of the file.
        """
        values = self.design if design is None else design
        return self.original if values == self._first.present else self._with(values)

    def _with(self, values: Values) -> Mechanism:
        """The mechanism with values, each a number of its own: one structure for all designs."""
        known, mechanism = self._last
        if known != values:
            mechanism = with_values(self._base, values)
            self._last = dict(values), mechanism
        return mechanism

    def numbers(self, design: Values | None = None) -> Numbers:
        """Values and derivatives of a design; compiles at first, then takes milliseconds."""
        values = dict(self.design if design is None else design)
        mechanism = self._with(values)
        if self._quantities is None:
            self._quantities = shown_quantities(mechanism)
        return numbers_of(mechanism, values, self._quantities)

    def verdicts(self, design: Values | None = None) -> Verdicts:
        """Checks and findings of a design; compiles at first, then takes milliseconds."""
        return verdicts_of(self._with(self.design if design is None else design))

    def limits(self, numbers: Numbers) -> tuple[LimitReading, ...]:
        """The limits of the file's `[optimise]` table beside numbers; none without a table."""
        return limits_of(self._with(dict(numbers.design)), numbers)

    def drawings(self, design: Values | None = None) -> tuple[tuple[str, str, float], ...]:
        """Both views of every stage as SVG, and their scale."""
        mechanism = self._with(self.design if design is None else design)
        return tuple(section_svg(mechanism, i + 1) for i in range(len(mechanism.stages)))

    def keep(self, numbers: Numbers) -> None:
        """Keep a design to compare others with."""
        with self._lock:
            self.kept = numbers
            self.version += 1

    def forget(self) -> None:
        """Forget the kept design."""
        with self._lock:
            self.kept = None
            self.version += 1

    def back_to_kept(self) -> None:
        """Make the kept design the present one, as one step.

        **Raises:** `PrsmError` if there is none.
        """
        if self.kept is None:
            raise PrsmError("no design is kept; keep one first")
        with self._lock:
            self._become(self._history.committed().moved(self.kept.design).committed())

    def improve(self) -> Improvement:
        """Start the search of the `[optimise]` table from the present design, in a thread.

        **Raises:** `PrsmError` without such a table, or while a search runs.
        """
        with self._lock:
            if self.improvement is not None and self.improvement.running:
                raise PrsmError("a search runs already; stop it first")
            self.commit()
            self.improvement = Improvement(self._with(self.design))
            return self.improvement

    def take_improvement(self) -> None:
        """Make the best design of the search the present one, to six digits, as one step.

        **Raises:** `PrsmError` if no design keeps all limits.
        """
        best = None if self.improvement is None else self.improvement.best
        if best is None:
            raise PrsmError("the search has found no design that keeps all limits")
        rounded = {
            name: round_in_unit(value, find_parameters(self._base, name)[0].unit, _DIGITS)
            for name, value in best.items()
        }
        with self._lock:
            self._become(self._history.committed().moved(rounded).committed())

    def text(self) -> str:
        """The text of the file with the present values; a comment above names the changed ones."""
        units = {quantity.name: quantity.unit for quantity in catalogue()}
        return edit(source_text(self.source), self.mechanism(), units, by="prsm studio")

    def save(self, name: str, *, replace: bool = False) -> Path:
        """Write the file into the chosen folder.

        **Arguments:**

        - `name`: a plain name; `.toml` is added.
        - `replace`: whether a file of that name may be replaced.

        **Raises:** `PrsmError` for a name that is not plain, a link, or an existing file.
        """
        plain = name.strip()
        full = plain if plain.endswith(".toml") else f"{plain}.toml"
        self.folder.place(full)
        return self.folder.write(full, self.text(), replace=replace)

    def report(self) -> Path:
        """Write the report on the present design into the folder `report` of the chosen one.

        **Returns:** the path of `report.html`.

        **Raises:** `PrsmError` if a link there could lead elsewhere.
        """
        place = self.folder.free_of_links(REPORT)
        changed = [f"{one.name}={self._written(one)}" for one in self._changed()]
        settings = (*self.settings, *changed)
        origin = origin_of_file(self.source, settings=settings, date=date.today().isoformat())
        # Entered again, the studio opens with this design.
        set_words = [word for one in settings for word in ("--set", one)]
        start = ["prsm", "studio", self.source, "--out", str(self.folder.path)]
        command = shlex.join([*start, *set_words, *self.options])
        data = analyse(self.mechanism(), source=self.source, command=command, origin=origin)
        return write_report(place, data)

    def _changed(self) -> list[StudioVariable]:
        return [v for v in self.variables if self.design[v.name] != self._first.present[v.name]]

    def _written(self, one: StudioVariable) -> str:
        return f"{one.shown(self.design[one.name]):.12g} {one.unit.label}".rstrip()
