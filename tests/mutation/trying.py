"""Tries faults one after the other, the likeliest tests first."""

import json
import os
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from .operators import Fault
from .processes import Process, preload, start
from .rooms import quick_tests

#: Processor time of one test alone [s].
_LIMIT = 600
#: So many tests that saw faults of the same file, and of the same room, come first.
_SAME_FILE, _SAME_ROOM = 6, 4
#: A test that takes so long does not come first, whatever it saw [s].
_LONG = 8.0


def _copy(tree: Path, folder: Path) -> None:
    """The tree without what is built, for a process of its own."""
    for name in ("prsm_jax", "tests", "docs", "benchmarks"):
        if (tree / name).exists():
            ignore = shutil.ignore_patterns("__pycache__", "images", "*.png", "*.svg")
            shutil.copytree(tree / name, folder / name, ignore=ignore)
    shutil.copy(tree / "pyproject.toml", folder)


class _Records:
    """Results as they come, kept in a file, and what they say of tests."""

    def __init__(self, output: Path):
        self._output = output
        kept = json.loads(output.read_text()) if output.exists() else {}
        self.rows: dict[str, dict] = {row["fault"]: row for row in kept.get("faults", [])}
        self.sound: dict[str, bool] = kept.get("sound", {})
        self.seconds: dict[str, float] = kept.get("seconds", {})
        # Of this run and of those before it, for their order.
        self.killers: dict[str, list[str]] = kept.get("killers", {})

    def save(self) -> None:
        self._output.parent.mkdir(parents=True, exist_ok=True)
        whole = {"faults": list(self.rows.values()), "sound": self.sound, "seconds": self.seconds}
        whole["killers"] = self.killers
        part = self._output.with_suffix(".part")
        part.write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n")
        os.replace(part, self._output)

    def first(self, path: str) -> list[str]:
        """Tests that a fault of a file is tried with first.

        Short ones that saw faults of the same file, then those that saw most in the room.
        """
        room = path.partition("/")[0]
        same = [name for name in reversed(self.killers.get(path, [])) if self._short(name)]
        often = Counter(
            name
            for other, names in self.killers.items()
            if other.partition("/")[0] == room
            for name in names
            if self._short(name)
        )
        front = [*list(dict.fromkeys(same))[:_SAME_FILE]]
        return list(dict.fromkeys([*front, *(name for name, _ in often.most_common(_SAME_ROOM))]))

    def _short(self, name: str) -> bool:
        return self.seconds.get(name, 0.0) < _LONG

    def add(self, row: dict) -> None:
        self.rows[row["fault"]] = row
        if row["seen"]:
            self.killers.setdefault(row["path"], []).append(row["by"])
        self.save()


def _fails_when_sound(name: str, folder: Path, records: _Records) -> bool:
    """Whether a test fails without a fault, and so tells nothing; each is asked once."""
    if name not in records.sound:
        process = start(folder, [name], [], [], {}, _LIMIT)
        while not process.finished():
            time.sleep(0.1)
        records.sound[name] = not (process.failed or process.hung)
        records.seconds.update(process.seconds)
        if not records.sound[name]:
            print(f"fails without a fault: {name}\n{process.output()[-2000:]}", flush=True)
    return not records.sound[name]


class _Attempt:
    """One fault in one folder."""

    def __init__(self, fault: Fault, folder: Path, records: _Records, budget: int):
        self.fault, self._folder, self._records = fault, folder, records
        self._budget = budget
        self._target = folder / "prsm_jax" / fault.path
        self._text = self._target.read_text()
        self._began = time.monotonic()
        self._put(fault.applied(self._text))
        self._process = self._start()

    def _put(self, text: str) -> None:
        # Compiled files are found by whole seconds of the time of the last change.
        later = self._target.stat().st_mtime + 2.0
        self._target.write_text(text)
        os.utime(self._target, (later, later))

    def _start(self) -> Process:
        unsound = [name for name, sound in self._records.sound.items() if not sound]
        tests = [f"tests/{name}" for name in quick_tests(self.fault.path)]
        tests = [name for name in tests if (self._folder / name).exists()]
        first, usual = self._records.first(self.fault.path), self._records.seconds
        return start(self._folder, tests, first, unsound, usual, self._budget)

    def result(self) -> dict | None:
        """None while it runs."""
        if not self._process.finished():
            return None
        name = self._process.hung or self._process.failed
        self._put(self._text)
        # A fault can keep a file of tests from being collected, or the package from being imported.
        if "::" in name and _fails_when_sound(name, self._folder, self._records):
            self._put(self.fault.applied(self._text))
            self._process = self._start()
            return None
        seen = "time" if self._process.hung else "test" if name else ""
        seconds = round(time.monotonic() - self._began, 1)
        passed, spent = len(self._process.seconds), self._process.spent
        return {"seen": seen, "by": name, "passed": passed, "spent": spent, "seconds": seconds}


def try_faults(
    chosen: list[Fault], tree: Path, output: Path, jobs: int, budget: int, again: bool = False
) -> Iterator[dict]:
    """A row of results for each fault, those that the file has without trying them again.

    With `again` only what was seen is not tried again.
    """
    records = _Records(output)
    if again:
        records.rows = {name: row for name, row in records.rows.items() if row["seen"]}
    todo = [fault for fault in chosen if fault.name not in records.rows]
    yield from (records.rows[fault.name] for fault in chosen if fault.name in records.rows)
    if not todo:
        return
    preload()
    with tempfile.TemporaryDirectory() as place:
        free = [Path(place).resolve() / str(index) for index in range(jobs)]
        for folder in free:
            _copy(tree, folder)
        running: list[tuple[Path, _Attempt]] = []
        while todo or running:
            while todo and free:
                folder, fault = free.pop(), todo.pop(0)
                running.append((folder, _Attempt(fault, folder, records, budget)))
            time.sleep(0.1)
            for pair in tuple(running):
                folder, attempt = pair
                result = attempt.result()
                if result is None:
                    continue
                running.remove(pair)
                free.append(folder)
                fault = attempt.fault
                row = {"fault": fault.name, "path": fault.path, "line": fault.line, **result}
                records.add(row)
                yield row
