"""Ctrl-C at any moment: one line, exit status 130 within two seconds, and nothing left behind."""

import errno
import os
import pty
import re
import select
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

import prsm_jax
from prsm_jax.sweeps._store import stored_identity

PACKAGE = Path(prsm_jax.__file__).parent
#: The process has to end in this time [s], whatever it is doing.
PATIENCE = 2.0
#: A job in the background of a script ignores SIGINT, and so would its children.
HEARS = "import signal, sys\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
MAIN = "from prsm_jax.cli import main\nsys.exit(main())"
SWEEP = ("sweep", "wu2022", "--axis", "lead=5 mm:15 mm:3000", "--axis")
STUDY = ("study", "wu2022", "--driver", "lead", "--driver", "contact_angle")
STUDY += ("--maximise", "efficiency", "--minimise", "max_pressure", "--points")


def start(folder, words, stderr, tmp_path):
    """`prsm` as a process of its own, which compiles everything anew."""
    return subprocess.Popen(
        [sys.executable, "-c", f"{HEARS}sys.argv = ['prsm', *{words!r}]\n{MAIN}"],
        cwd=folder,
        env=os.environ | {"PRSM_JAX_CACHE": "", "TERM": "xterm", "COLUMNS": "80"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=stderr,
    )


class Terminal:
    """A pseudo-terminal for stderr, and what has been written to it."""

    def __init__(self):
        self.ours, self.theirs = pty.openpty()
        self.text = ""

    def read(self, seconds):
        ready, _, _ = select.select([self.ours], [], [], seconds)
        if ready:
            try:
                self.text += os.read(self.ours, 65536).decode()
            except OSError as error:
                # Linux says so where the other end is closed.
                if error.errno != errno.EIO:
                    raise

    def wait_for(self, words, process, seconds=200):
        end = time.monotonic() + seconds
        while words not in self.text:
            assert process.poll() is None, self.text
            assert time.monotonic() < end, self.text
            self.read(0.1)

    @property
    def last_line(self):
        """What stands in the last line that is not empty: after the last erasure of it."""
        lines = [line for line in self.text.replace("\r\n", "\n").split("\n") if line]
        return lines[-1].rpartition("\r\x1b[K")[2]


@pytest.mark.parametrize(
    ("words", "moment"),
    # The total grows as long programs are found, and a quick machine finds fewer.
    [
        ((*SWEEP, "contact_angle=35 deg:55 deg:9"), "compiling 1 of "),
        ((*SWEEP, "contact_angle=35 deg:55 deg:3000"), "of 9000000 designs"),
        (("optimise", "actuator", "--starts", "1"), "compiling 1 of "),
        (("simulate", "actuator_mission"), "compiling"),
        (("demo",), "compiling"),
        ((*STUDY, "9"), "compiling 1 of "),
        ((*STUDY, "3000"), "of 9000000 designs"),
        (("pareto", "actuator", "--minimise", "mass,max_pressure"), "prsm pareto: compiling"),
        (("tolerance", "actuator_tolerances"), "prsm tolerance: compiling"),
        # Its programs are small: the first may be ready before the line of progress appears.
        (("calibrate", "wu2022", "--data", "wu2022_torque"), "prsm calibrate: "),
    ],
    ids=[
        *("sweep compiles", "sweep runs", "optimise", "simulate", "demo"),
        *("study compiles", "study runs", "pareto", "tolerance", "calibrate"),
    ],
)
def test_ctrl_c_while_compiling_or_running(tmp_path, words, moment):
    folder = tmp_path / "empty"
    folder.mkdir()
    terminal = Terminal()
    process = start(folder, words, terminal.theirs, tmp_path)
    os.close(terminal.theirs)
    try:
        terminal.wait_for(moment, process)
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)
        taken = time.monotonic() - began
        for _ in range(10):
            terminal.read(0.02)
    finally:
        process.kill()
        os.close(terminal.ours)
        process.stdout.close()
    assert process.returncode == 130
    assert taken < PATIENCE
    assert terminal.last_line == "prsm: stopped (Ctrl-C)"
    # The line of progress is erased, and nothing but it and the message was written.
    assert "Traceback" not in terminal.text
    assert re.fullmatch(r"(\r\x1b\[K(prsm [^\r\n]*)?)+\r\x1b\[Kprsm: stopped.*\s*", terminal.text)
    written = sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))
    if written and words[0] in ("sweep", "study"):
        # The store stays, for the next run to continue: whole, and nothing beside it.
        store = folder / "out" / f"wu2022-{words[0]}.zarr"
        assert stored_identity(store)["quantities"] == ["efficiency", "max_pressure"]
        assert [path for path in written if not path.startswith(f"out/{store.name}")] == ["out"]
    else:
        # A sweep and a study make their store while its program is compiled.
        assert not moment.endswith("designs")
        assert written == []


@pytest.mark.parametrize(
    ("number", "message"),
    [(signal.SIGINT, "prsm: stopped (Ctrl-C)\n"), (signal.SIGTERM, "prsm: terminated\n")],
)
def test_a_signal_while_jax_is_imported(tmp_path, number, message):
    """Nothing but the message where stderr is no terminal."""
    code = textwrap.dedent(
        f"""
        import os, sys, threading
        sys.argv = ["prsm", "quantities"]
        class Hook:
            def find_spec(self, name, path=None, target=None):
                if name == "jax":
                    os.kill(os.getpid(), {int(number)})
                    # As an extension module that is loaded: nothing of Python's runs.
                    import time; time.sleep(60)
        sys.meta_path.insert(0, Hook())
        from prsm_jax.cli import main
        sys.exit(main())
        """
    )
    began = time.monotonic()
    found = subprocess.run(
        [sys.executable, "-c", HEARS + code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert (found.returncode, found.stdout, found.stderr) == (128 + number, "", message)
    assert time.monotonic() - began < 20


#: Files and signals of the package without the rest of it, as in a process that is `prsm`.
ALONE = f"""
import contextlib, os, pathlib, signal, sys, threading, time, types
sys.argv = ["prsm"]
sys.modules["jax"] = None  # neither files nor signals need it
package = types.ModuleType("prsm_jax"); package.__path__ = [{str(PACKAGE)!r}]
sys.modules["prsm_jax"] = package
from prsm_jax.process import _files
from prsm_jax.process import _interrupt
from prsm_jax.process import _own_process
"""


def stopped(code, folder):
    """A process of its own that runs this code and is stopped by the signal in it."""
    found = subprocess.run(
        [sys.executable, "-c", HEARS + ALONE + code],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert (found.returncode, found.stderr) == (130, "prsm: stopped (Ctrl-C)\n")
    return {path.name: path.read_text() for path in folder.iterdir()}


HALF_WRITTEN = """
def write(folder):
    number = 0
    while True:
        with contextlib.suppress(OSError):
            (folder / f"{number % 100}").mkdir(parents=True, exist_ok=True)
            (folder / f"{number % 100}" / "chunk").write_text("half")
        number += 1

here = pathlib.Path(".")
with _files.folder_for_results(here / "new" / "inner") as folder:
    with _files.temporary_folder(folder, ".store-") as building:
        for _ in range(12):
            threading.Thread(target=write, args=(building,), daemon=True).start()
        with _files.whole_file(here / "kept.json") as partial:
            partial.write_text("half")
            time.sleep(0.2)
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(60)
"""


def test_what_is_half_written_goes_and_what_was_there_stays(tmp_path):
    (tmp_path / "kept.json").write_text("old")
    assert stopped(HALF_WRITTEN, tmp_path) == {"kept.json": "old"}


BUSY = """
def work():
    while True:
        sum(range(1000))

with _files.folder_for_results(pathlib.Path("new")):
    for _ in range(6):
        threading.Thread(target=work, daemon=True).start()
    time.sleep(0.2)
    pathlib.Path("began").write_text(str(time.monotonic()))
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(60)
"""


def test_threads_that_work_in_python_do_not_delay_the_end(tmp_path):
    """As those that trace: each of them keeps the lock of the interpreter for a while."""
    written = stopped(BUSY, tmp_path)
    assert time.monotonic() - float(written.pop("began")) < PATIENCE
    assert written == {}


TAKING_PLACE = """
here = pathlib.Path(".")
with _files.temporary_folder(here, ".building-") as building:
    for name in ("a", "b"):
        (building / name).write_text("new")
    with _files.taking_place():
        os.replace(building / "a", "a")
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.5)
        os.replace(building / "b", "b")
    time.sleep(60)
"""


def test_a_result_that_takes_its_place_is_not_cut_in_two(tmp_path):
    """A signal in the middle of several renames waits until they are done."""
    for name in ("a", "b"):
        (tmp_path / name).write_text("old")
    assert stopped(TAKING_PLACE, tmp_path) == {"a": "new", "b": "new"}
