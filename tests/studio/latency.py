"""Time from a slider to the page: `python -m tests.studio.latency [FILE-or-EXAMPLE] [PICTURES]`.

Presses an arrow on a slider in a headless Chromium and prints when the drawing, the numbers and the
status have changed on the page [ms]; the programs are compiled before. With a folder, the page is
kept there as pictures, 1280 and 400 px wide.
"""

import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

_MOVES = 20
_LISTEN = """
window.seen = {};
addEventListener('keydown', () => { window.seen = {start: performance.now()}; }, true);
const part = name => `[data-part="${name}"]`;
const parts = {drawing: '.drawing', numbers: part('numbers'), status: part('status')};
for (const [name, place] of Object.entries(parts)) {
  new MutationObserver(() => { window.seen[name] = performance.now() - window.seen.start; })
    .observe(document.querySelector(place), {childList: true, subtree: true, characterData: true});
}
"""


def _wait(driver: Any, script: str) -> None:
    limit = time.monotonic() + 600
    while not driver.execute_script(f"return {script}"):
        if time.monotonic() > limit:
            raise SystemExit(f"not seen: {script}")
        time.sleep(0.05)


def _moved(driver: Any, slider: Any, key: str) -> dict[str, float]:
    driver.execute_script("window.seen = {}")
    slider.send_keys(key)
    _wait(driver, "window.seen.drawing && window.seen.numbers && window.seen.status")
    time.sleep(0.3)
    return driver.execute_script("return window.seen")


def main(source: str, pictures: Path | None) -> None:
    """Measure and print."""
    from selenium.webdriver.common.keys import Keys

    from tests.studio.browser import browser, missing, studio

    if lacking := missing():
        raise SystemExit(lacking)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        began = time.monotonic()
        with studio(source, folder) as (address, _), browser(folder / "profile") as driver:
            print(f"address after {time.monotonic() - began:.1f} s")
            driver.set_window_size(1280, 1000)
            driver.get(address)
            _wait(driver, "!!document.querySelector('[data-quantity]')")
            print(f"numbers after {time.monotonic() - began:.1f} s")
            _wait(driver, "!!document.querySelector('[data-part=\"status\"] .status')")
            print(f"status after {time.monotonic() - began:.1f} s")
            driver.execute_script(_LISTEN)
            slider = driver.find_element("css selector", '[data-slider] [tabindex="0"]')
            keys = (Keys.ARROW_RIGHT, Keys.ARROW_LEFT)
            found = [_moved(driver, slider, keys[number % 2]) for number in range(_MOVES)]
            for part in ("drawing", "numbers", "status"):
                times = sorted(one[part] for one in found)
                print(f"{part}: median {statistics.median(times):.0f} ms, most {times[-1]:.0f} ms")
            if pictures is not None:
                for width in (1280, 400):
                    driver.set_window_size(width, 1000)
                    height = driver.execute_script("return document.documentElement.scrollHeight")
                    driver.set_window_size(width, height + 150)
                    driver.execute_script("window.scrollTo(0, 0)")
                    time.sleep(0.5)
                    driver.save_screenshot(str(pictures / f"studio-{width}.png"))


if __name__ == "__main__":
    chosen = sys.argv[1:]
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    main(chosen[0] if chosen else "actuator", Path(chosen[1]) if chosen[1:] else None)
