"""A headless Chromium with its driver, and a studio in a process of its own."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import prsm_jax

#: Commands of Debian's packages chromium and chromium-driver.
_BROWSER, _DRIVER = "chromium", "chromedriver"
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def missing() -> str:
    """What is missing to drive a browser; empty if nothing is."""
    absent = [name for name in (_BROWSER, _DRIVER) if shutil.which(name) is None]
    return f"{' and '.join(absent)} missing: run make browser as root" if absent else ""


@contextlib.contextmanager
def browser(profile: Path) -> Generator[Any, None, None]:
    """A browser with an empty profile in a folder, and the log of its console."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which(_BROWSER) or _BROWSER
    for flag in (*_FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options, webdriver.ChromeService(shutil.which(_DRIVER)))
    try:
        yield driver
    finally:
        driver.quit()


@contextlib.contextmanager
def studio(
    file: Path | str, folder: Path, *, environment: dict[str, str] | None = None
) -> Generator[tuple[str, subprocess.Popen[str]], None, None]:
    """A studio as a user starts it; its address, with the process, which Ctrl-C ends."""
    told = folder / "address.json"
    command = [sys.executable, "-m", "prsm_jax", "studio", str(file), "--json", str(told)]
    # The package under test, wherever another one is installed.
    paths = [str(Path(prsm_jax.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    own = {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    process = subprocess.Popen(
        [*command, "--out", str(folder / "chosen"), "--no-browser"],
        cwd=folder,
        env={**os.environ, **own, **(environment or {})},
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        limit = time.monotonic() + 120
        while not told.exists():
            if process.poll() is not None or time.monotonic() > limit:
                process.kill()
                assert process.stderr is not None
                raise AssertionError(f"the studio did not start: {process.stderr.read()}")
            time.sleep(0.05)
        yield json.loads(told.read_text(encoding="utf-8"))["address"], process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(20)
        process.kill()
        if process.stderr is not None:
            process.stderr.close()
