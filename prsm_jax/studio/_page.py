"""The page: controls on the left, drawing and status in the middle, numbers on the right.

It only shows a `Session` and passes on what is moved; everything else happens there.
"""

import asyncio
import html
from collections.abc import Callable
from typing import Any

from nicegui import ui

from .._errors import PrsmError
from ..quantities import find_quantity
from ._page_style import STYLE
from ._readings import Numbers
from ._session import REPORT, Session
from ._snippets import (
    checks_html,
    comparison_html,
    improvement_html,
    notes_html,
    numbers_html,
    status_html,
)
from ._variables import StudioVariable

#: How often the page looks for news of a search and of other windows [s].
_TICK_S = 0.3
#: Outside a field the browser would undo what was typed into the last one, beside the step.
_OWN_KEYS = """<script>
document.addEventListener("keydown", (event) => {
  const own = (event.ctrlKey || event.metaKey) && !event.altKey;
  const field = ["INPUT", "SELECT", "TEXTAREA"].includes(document.activeElement?.tagName);
  if (own && !field && ["z", "y"].includes(event.key.toLowerCase())) event.preventDefault();
});
</script>"""
#: A number is complete with Enter: then the keys undo it as a step, not as text.
_LEAVE = "(event) => event.target.blur()"
#: A slider that is dragged sends at most one position in this time [s].
_THROTTLE_S = 0.05


def _html(words: str, *classes: str) -> Any:
    """A part of the page that is made of escaped text."""
    return ui.html(words, sanitize=False).classes(" ".join(classes))


class Page:
    """One window of the studio."""

    def __init__(self, session: Session, title: str):
        self._session = session
        self._seen = -1
        self._busy = False
        self._told: tuple[Any, ...] = ()
        self._numbers: Numbers | None = None
        self._controls: dict[str, tuple[Any, Any]] = {}
        #: The values that sliders and fields were last set to [SI].
        self._placed: dict[str, float] = {}
        ui.add_head_html(f"<style>{STYLE}</style>{_OWN_KEYS}")
        _html(f"<h1>{html.escape(title)}</h1>")
        _html(
            f'<p class="quiet">{html.escape(session.source)}; files are written into '
            f"{html.escape(str(session.folder.path))} only</p>"
        )
        with ui.element("main").classes("studio-columns"):
            with ui.element("div").classes("studio-column"):
                self._design_panel()
                self._improve_panel()
                self._compare_panel()
                self._files_panel()
            with ui.element("div").classes("studio-column"):
                with _panel("Drawing to scale, in mm"):
                    self._drawing = _html('<p class="quiet">drawing</p>', "drawing")
                with _panel("Status"):
                    self._status = _html('<p class="quiet">compiling: up to two minutes</p>')
                    self._status.props('aria-live=polite data-part="status"')
                    # Not part of the status itself, which is replaced: what is open stays open.
                    with ui.expansion("All checks").props("dense dense-toggle"):
                        self._checks = _html("").props('data-part="checks"')
                    with ui.expansion("Notes").props("dense dense-toggle"):
                        self._notes = _html("").props('data-part="notes"')
            title = "Numbers, and what 1 % more of a variable does to them"
            with ui.element("div").classes("studio-column"), _panel(title):
                self._values = _html('<p class="quiet">compiling: up to two minutes</p>')
                self._values.props('data-part="numbers"')
        ui.timer(_TICK_S, self._tick)

    def _design_panel(self) -> None:
        with _panel("Design"):
            for one in self._session.variables:
                self._control(one)
            with ui.element("div").classes("buttons"):
                self._undo = _button("Undo", lambda: self._do(self._session.undo))
                self._redo = _button("Redo", lambda: self._do(self._session.redo))
            # Not in a field, whose text has an undo of its own; on sliders and buttons, too.
            ui.keyboard(self._key, ignore=["input", "select", "textarea"])
            self._error = _html("", "error").props('role=alert data-part="error"')

    async def _key(self, event: Any) -> None:
        """Ctrl+Z (on a Mac Command+Z) undoes a step; with Shift, or Ctrl+Y, redoes one."""
        modifiers, key = event.modifiers, event.key.name.lower()
        pressed = event.action.keydown and (modifiers.ctrl or modifiers.meta)
        if not pressed or modifiers.alt or key not in ("z", "y"):
            return
        again = key == "y" or modifiers.shift
        await self._do(self._session.redo if again else self._session.undo)

    def _control(self, one: StudioVariable) -> None:
        value = one.shown(self._session.design[one.name])
        label = f"{one.label} in {one.unit.label}" if one.unit.label else one.label
        with ui.element("div").classes("variable"):
            _html(
                f"<span>{html.escape(one.label)}</span>"
                f'<span class="limits">{html.escape(one.limits)}</span>',
                "name",
            )
            slider = ui.slider(
                min=one.shown(one.lower), max=one.shown(one.upper), step=one.step, value=value
            ).props(f'aria-label="{label}, slider" data-slider="{one.name}"')
            field = ui.number(value=value, format="%.5g", suffix=one.unit.label, step=one.step)
            field.props(f'dense outlined input-class="field-{_plain(one.name)}"')
            field.props(f'aria-label="{label}"')
        self._controls[one.name] = slider, field
        self._placed[one.name] = self._session.design[one.name]

        async def dragged(event: Any) -> None:
            await self._do(lambda: self._session.move(one.name, event.args), one, held=slider)

        async def released(event: Any) -> None:
            await self._do(lambda: self._session.set(one.name, event.args), one, held=slider)

        async def typed(_: Any) -> None:
            # The value of an empty field, or one with text, is None, which is refused.
            await self._do(lambda: self._session.set(one.name, field.value), one)

        slider.on("update:model-value", dragged, throttle=_THROTTLE_S)
        slider.on("change", released)
        field.on("change", typed)
        field.on("keydown.enter", js_handler=_LEAVE)

    def _improve_panel(self) -> None:
        with _panel("Improve"):
            problem = self._session.original.design_problem
            if problem is None:
                words = "The file has no [optimise] table; with one, a search starts here."
                _html(f'<p class="quiet">{words}</p>')
            else:
                terms = " and ".join(
                    f"{one.sense} {one.quantity.replace('_', ' ')}" for one in problem.objectives
                )
                _html(f"<p>{html.escape(terms)}, within the limits of the file</p>")
            with ui.element("div").classes("buttons"):
                self._start = _button("Improve", lambda: self._do(self._session.improve))
                self._stop = _button("Stop", self._stop_search)
                self._take = _button(
                    "Take the best", lambda: self._do(self._session.take_improvement)
                )
            self._way = _html("").props('aria-live=polite data-part="way"')

    def _files_panel(self) -> None:
        with _panel("Files"):
            with ui.element("div").classes("buttons"):
                name = ui.input("name of the file", value="design.toml").props("dense outlined")
                replace = ui.checkbox("replace")
                _button("Save", lambda: self._save(str(name.value), bool(replace.value)))
            with ui.element("div").classes("buttons"):
                self._report = _button("Write report", self._write_report)
            self._files = _html("").props('aria-live=polite data-part="files"')

    def _compare_panel(self) -> None:
        with _panel("Compare two designs"):
            with ui.element("div").classes("buttons"):
                _button("Keep this design as A", lambda: self._do(self._keep))
                self._back = _button("Go back to A", lambda: self._do(self._session.back_to_kept))
                self._forget = _button("Forget A", lambda: self._do(self._session.forget))
            self._comparison = _html("").props('data-part="comparison"')

    def _keep(self) -> None:
        numbers = self._numbers
        if numbers is None or numbers.design != self._session.design:
            raise PrsmError("the numbers of this design are not ready yet; wait a moment")
        self._session.keep(numbers)

    def _stop_search(self) -> None:
        if self._session.improvement is not None:
            self._session.improvement.stop()

    def _save(self, name: str, replace: bool) -> None:
        try:
            path = self._session.save(name, replace=replace)
        except (PrsmError, ValueError, OSError) as error:
            self._files.content = f'<p class="error">{html.escape(str(error))}</p>'
        else:
            self._files.content = f"<p>Saved {html.escape(str(path))}.</p>"

    async def _write_report(self) -> None:
        self._report.disable()
        self._files.content = "<p>Writing the report; this takes up to some minutes.</p>"
        try:
            path = await asyncio.to_thread(self._session.report)
        except (PrsmError, ValueError, OSError) as error:
            self._files.content = f'<p class="error">{html.escape(str(error))}</p>'
            return
        finally:
            self._report.enable()
        self._files.content = (
            f"<p>Written: {html.escape(str(path))}. "
            f'<a href="files/{REPORT}/report.html" target="_blank" rel="noopener">Open the report'
            "</a></p>"
        )

    async def _do(
        self, action: Callable[[], Any], moved: StudioVariable | None = None, held: Any = None
    ) -> None:
        """Act on the session, on a variable that is moved, and show what follows, or why not."""
        if moved is not None:
            # Set anew whatever becomes of it: a refused number must not stay in its field.
            self._placed.pop(moved.name, None)
        try:
            action()
        except (PrsmError, ValueError, OSError) as error:
            self._error.content = f"<p>{html.escape(str(error))}</p>"
            self._set_controls()
            return
        self._error.content = ""
        await self._show(held)

    def _set_controls(self, held: Any = None) -> None:
        """Sliders and fields at the present values, but for a slider that is held.

        Those of a value that stays are left alone: a number may be half typed.
        """
        for one in self._session.variables:
            design = self._session.design[one.name]
            if self._placed.get(one.name) == design:
                continue
            self._placed[one.name] = design
            slider, field = self._controls[one.name]
            field.value = one.shown(design)
            if slider is not held:
                slider.value = one.shown(design)
        problem = self._session.original.design_problem
        job = self._session.improvement
        self._undo.set_enabled(self._session.can_undo)
        self._redo.set_enabled(self._session.can_redo)
        self._start.set_enabled(problem is not None and not (job and job.running))
        self._stop.set_enabled(job is not None and job.state == "running")
        self._take.set_enabled(job is not None and job.best is not None)
        self._back.set_enabled(self._session.kept is not None)
        self._forget.set_enabled(self._session.kept is not None)

    async def _show(self, held: Any = None) -> None:
        """Draw and compute the present design; of several in a row only the last."""
        self._set_controls(held)
        if self._busy:
            return
        self._busy = True
        try:
            while self._seen != self._session.version:
                version = self._session.version
                await self._compute()
                self._seen = version
        finally:
            self._busy = False

    async def _compute(self) -> None:
        session, design = self._session, self._session.design
        try:
            drawings = await asyncio.to_thread(session.drawings, design)
            self._drawing.content = "".join(map(_view, drawings))
            numbers = await asyncio.to_thread(session.numbers, design)
            self._numbers = numbers
            self._values.content = numbers_html(numbers, session.variables)
            kept = session.kept
            same = kept is not None and kept.quantities == numbers.quantities
            words = comparison_html(kept, numbers, session.variables) if kept and same else ""
            self._comparison.content = words
            verdicts = await asyncio.to_thread(session.verdicts, design)
            stages = len(session.original.stages)
            self._status.content = status_html(verdicts, session.limits(numbers), stages)
            self._checks.content = checks_html(verdicts.checks, stages) or "<p>none</p>"
            self._notes.content = notes_html(verdicts.findings)
        except (PrsmError, ValueError) as error:
            self._status.content = f'<p class="status fail">{html.escape(str(error))}</p>'

    async def _tick(self) -> None:
        job = self._session.improvement
        if job is not None:
            told = (job, len(job.steps), job.state)
            if told != self._told:
                self._told = told
                self._way.content = improvement_html(
                    job, self._session.variables, *self._objective()
                )
                self._set_controls()
        if self._seen != self._session.version and not self._busy:
            await self._show()

    def _objective(self) -> tuple[str, str]:
        """Name and SI unit of the objective; empty for a sum of several."""
        problem = self._session.original.design_problem
        if problem is None or len(problem.objectives) != 1:
            return "", ""
        quantity = find_quantity(problem.objectives[0].quantity)
        return quantity.name, quantity.unit


def _panel(title: str) -> Any:
    panel = ui.element("section").classes("panel")
    with panel:
        _html(f"<h2>{html.escape(title)}</h2>")
    return panel


def _button(words: str, action: Callable[[], Any]) -> Any:
    return ui.button(words, on_click=action).props("no-caps outline dense padding='4px 10px'")


def _plain(name: str) -> str:
    return name.replace(".", "-").replace("_", "-")


def _view(drawing: tuple[str, str, float]) -> str:
    across, along, scale = drawing
    ratio = f"{scale:g} : 1" if scale >= 1 else f"1 : {1 / scale:g}"
    return f'{across}{along}<p class="quiet">Both views at one scale ({ratio} at 96 mm width).</p>'
