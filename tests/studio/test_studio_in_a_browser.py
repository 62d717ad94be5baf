"""The whole studio in a headless Chromium: what is moved, and what is read on the page."""

import http.client
import math
import os
import re
import signal
import time
from pathlib import Path
from urllib.parse import urlsplit

import jax
import pytest
from browser import browser, missing, studio

import prsm_jax as prsm

#: Where the pictures of the page are kept, if anywhere.
_PICTURES = os.environ.get("PRSM_STUDIO_PICTURES")
_PATIENCE_S = 120


def _until(found, what: str):
    limit = time.monotonic() + _PATIENCE_S
    while time.monotonic() < limit:
        value = found()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"not seen: {what}")


def _shown(driver) -> dict[str, tuple[float, str]]:
    """SI value and text of every quantity on the page."""
    script = (
        "return [...document.querySelectorAll('[data-quantity]')]"
        ".map(e => [e.dataset.quantity, e.dataset.si, e.textContent])"
    )
    return {name: (float(si), text) for name, si, text in driver.execute_script(script)}


def _text(driver, part: str) -> str:
    script = "return document.querySelector(arguments[0])?.innerText ?? ''"
    return driver.execute_script(script, f'[data-part="{part}"]')


def _press(driver, words: str) -> None:
    from selenium.webdriver.common.by import By

    place = f"//button[normalize-space()='{words}']"
    button = driver.find_element(By.XPATH, place)
    _until(button.is_enabled, f"{words} enabled")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
    button.click()


def _field(driver, name: str):
    return driver.find_element("css selector", ".field-" + re.sub("[_.]", "-", name))


def _half_typed(driver, name: str, text: str) -> None:
    """Replace the text of a field without completing it."""
    from selenium.webdriver.common.keys import Keys

    field = _field(driver, name)
    field.send_keys(Keys.CONTROL, "a")
    field.send_keys(text)


def _type(driver, name: str, text: str) -> None:
    from selenium.webdriver.common.keys import Keys

    _half_typed(driver, name, text)
    _field(driver, name).send_keys(Keys.ENTER)


def _keys(driver, *keys: str) -> None:
    """Keys pressed together, on the element that has the focus."""
    from selenium.webdriver import ActionChains

    chain = ActionChains(driver)
    for key in keys[:-1]:
        chain = chain.key_down(key)
    chain = chain.send_keys(keys[-1])
    for key in keys[:-1]:
        chain = chain.key_up(key)
    chain.perform()


def _raw(address: str, path: str, headers: dict[str, str]) -> tuple[int, str]:
    """Status and text of a raw request; `Host` is only what `headers` say."""
    url = urlsplit(address)
    assert url.port is not None
    connection = http.client.HTTPConnection("127.0.0.1", url.port, timeout=20)
    try:
        connection.putrequest("GET", path, skip_host=True, skip_accept_encoding=True)
        for key, value in headers.items():
            connection.putheader(key, value)
        connection.endheaders()
        answer = connection.getresponse()
        if answer.status == 101:
            return 101, ""
        return answer.status, answer.read().decode("utf-8", errors="replace")
    finally:
        connection.close()


def _refuses_strangers(address: str) -> None:
    url = urlsplit(address)
    own, page = {"Host": url.netloc}, url.path
    upgrade = {
        "Connection": "Upgrade",
        "Upgrade": "websocket",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
    }
    socket = f"{page}_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    assert _raw(address, page, own)[0] == 200
    assert _raw(address, socket, own | upgrade | {"Origin": f"http://{url.netloc}"})[0] == 101
    for path, headers in (
        ("/", own),
        ("/_nicegui/", own),
        (page, {"Host": f"evil.example:{url.port}"}),
        (page, {}),
        (page, own | {"Origin": "https://evil.example"}),
        (socket, own | upgrade | {"Origin": "https://evil.example"}),
        (socket, own | upgrade),
        (socket.replace(page, "/"), own | upgrade | {"Origin": f"http://{url.netloc}"}),
        (socket.replace("websocket", "polling"), own | {"Origin": "null"}),
    ):
        # The server itself answers 400 to a request without a Host.
        assert _raw(address, path, headers)[0] in (400, 403), (path, headers)
    for path in (
        "files/report/../../small.toml",
        "files/report/%2e%2e/%2e%2e/address.json",
        "files//etc/passwd",
        "files/report/..%2f..%2faddress.json",
        "files/mine.toml",
        "files/report/report.html",
    ):
        status, text = _raw(address, page + path, own)
        assert status in (403, 404), path
        assert "token" not in text.replace("with its token", "")


def _picture(driver, name: str, width: int) -> None:
    height = driver.execute_script("return document.documentElement.scrollHeight")
    driver.set_window_size(width, height + 100)
    time.sleep(0.3)
    if _PICTURES:
        driver.save_screenshot(str(Path(_PICTURES) / f"{name}.png"))


def test_the_studio_in_a_browser(tmp_path, small):
    if lacking := missing():
        required = os.environ.get("PRSM_TEST_BROWSER") == "required"
        (pytest.fail if required else pytest.skip)(lacking)
    # Programs that earlier runs have compiled.
    cache = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    environment = {"PRSM_JAX_CACHE": str(cache or "")}
    with (
        studio(small, tmp_path, environment=environment) as (address, process),
        browser(tmp_path / "profile") as driver,
    ):
        driver.set_window_size(1280, 900)
        driver.get(address)
        # Text of the file is text, whatever signs it has.
        assert driver.find_element("css selector", "h1").text == "Small <screw> & nut"
        first = _until(lambda: _shown(driver), "numbers")
        assert set(first) == {"efficiency", "drive_torque", "max_pressure", "nut_radius[1]"}
        _until(lambda: "Fail" in _text(driver, "status"), "status")
        assert "nut radius" in _text(driver, "status")
        _refuses_strangers(address)

        # A field: every number on the page is that of the Python API.
        _type(driver, "contact_angle", "47.5")
        _until(lambda: _shown(driver)["max_pressure"] != first["max_pressure"], "new numbers")
        mechanism = prsm.load(small)
        angle = 47.5 / (180 / math.pi)
        radius = float(prsm.get_parameter(mechanism, "roller_radius"))
        moved = prsm.set_parameter(mechanism, "contact_angle", angle)
        moved = prsm.set_parameter(moved, "roller_radius", radius)
        names = ["efficiency", "drive_torque", "max_pressure", "nut_radius"]
        table = prsm.sensitivity(moved, names, ["contact_angle", "roller_radius"], kinks=False)
        shown = _shown(driver)
        for name, value in zip(table.quantities, table.values, strict=True):
            # Two processes may compile for other registers: the last digits are free.
            assert shown[name][0] == pytest.approx(float(value), rel=1e-13), name
        # Four digits, in MPa.
        number = float(shown["max_pressure"][1].removesuffix("MPa").strip())
        assert number == pytest.approx(1e-6 * shown["max_pressure"][0], rel=5e-4)

        # A slider, by the keyboard: an arrow is one step of 0.01 mm; the drawing follows.
        slider = driver.find_element("css selector", '[data-slider="roller_radius"] [tabindex="0"]')
        drawing = driver.find_element("css selector", ".drawing")
        assert "Ø6 roller" in drawing.text
        from selenium.webdriver.common.keys import Keys

        slider.send_keys(Keys.ARROW_RIGHT)
        _until(lambda: _field(driver, "roller_radius").get_attribute("value") == "3.01", "3.01 mm")
        _until(lambda: abs(_shown(driver)["nut_radius[1]"][0] - 15.05e-3) < 1e-12, "15.05 mm")
        assert "Ø6.02 roller" in drawing.text
        _press(driver, "Undo")
        _until(lambda: abs(_shown(driver)["nut_radius[1]"][0] - 15e-3) < 1e-12, "15 mm again")

        # The keys do what the buttons do, wherever the focus is but in a field.
        _keys(driver, Keys.CONTROL, Keys.SHIFT, "z")
        _until(lambda: abs(_shown(driver)["nut_radius[1]"][0] - 15.05e-3) < 1e-12, "redone")
        slider.send_keys(Keys.CONTROL, "z")
        _until(lambda: abs(_shown(driver)["nut_radius[1]"][0] - 15e-3) < 1e-12, "undone")
        # One step only: the browser's own undo would take back what was typed into the angle.
        assert _field(driver, "contact_angle").get_attribute("value") == "47.5"
        slider.send_keys("z")

        # The load is moved like a number of the design.
        before = _shown(driver)["max_pressure"][0]
        _type(driver, "operating_point.load", "5")
        loaded = prsm.set_parameter(moved, "operating_point.load", 5e3)
        pressure = float(prsm.compute(loaded, ["max_pressure"])["max_pressure"])
        _until(lambda: _shown(driver)["max_pressure"][0] != before, "a new pressure")
        assert _shown(driver)["max_pressure"][0] == pytest.approx(pressure, rel=1e-12)
        assert _shown(driver)["nut_radius[1]"][0] == pytest.approx(15e-3, rel=1e-12)
        # A number is complete with Enter: then the keys undo the step.
        _keys(driver, Keys.CONTROL, "z")
        _until(lambda: _shown(driver)["max_pressure"][0] == before, "the load as before")

        # A number beyond the limits is refused in words.
        _type(driver, "contact_angle", "80")
        _until(lambda: "give 35 to 55 deg" in _text(driver, "error"), "refusal")
        assert _field(driver, "contact_angle").get_attribute("value") == "47.5"

        # So is a field that is emptied; no number was typed, so none is named.
        _type(driver, "contact_angle", Keys.DELETE)
        _until(lambda: "angle is not a number; give 35" in _text(driver, "error"), "refusal")
        assert _field(driver, "contact_angle").get_attribute("value") == "47.5"

        # A search streams its way, is stopped, and its best design is taken; the page lives.
        _press(driver, "Keep this design as A")
        _press(driver, "Improve")
        _until(lambda: re.search(r"start \d+ of 2000, iteration", _text(driver, "way")), "the way")
        _until(lambda: "best so far" in _text(driver, "way"), "a design that keeps the limits")
        # News of the search leave a number alone that is half typed.
        _half_typed(driver, "contact_angle", "4")
        seen = _text(driver, "way")
        _until(lambda: _text(driver, "way") != seen, "a step while a number is half typed")
        time.sleep(0.7)
        assert _field(driver, "contact_angle").get_attribute("value") == "4"
        _field(driver, "contact_angle").send_keys("6", Keys.ENTER)
        _until(lambda: "46" in _text(driver, "comparison"), "a move during the search")
        _press(driver, "Stop")
        _until(lambda: "stopped" in _text(driver, "way"), "stopped")
        _press(driver, "Take the best")
        _until(lambda: _shown(driver)["nut_radius[1]"][0] < 14.0001e-3, "a design within limits")
        _until(lambda: "Fail" not in _text(driver, "status"), "status of the new design")
        # The nut of 14 mm is smaller than that of A by 1 mm.
        assert re.search(r"nut radius.*−1\.000?.?mm", _text(driver, "comparison"))

        # Files.
        _press(driver, "Save")
        saved = tmp_path / "chosen" / "design.toml"
        _until(lambda: "Saved" in _text(driver, "files"), "saved")
        again = prsm.load(saved)
        assert 5 * float(again.stages[0].thread.roller_radius) == pytest.approx(
            _shown(driver)["nut_radius[1]"][0], rel=1e-12
        )
        _press(driver, "Save")
        _until(lambda: "exists already" in _text(driver, "files"), "no silent replacement")

        # The report is written while the page lives, and opens without an error in its console.
        _press(driver, "Write report")
        _until(lambda: "Open the report" in _text(driver, "files"), "the report")
        window = driver.current_window_handle
        driver.find_element("link text", "Open the report").click()
        _until(lambda: len(driver.window_handles) == 2, "a window with the report")
        driver.switch_to.window(next(one for one in driver.window_handles if one != window))
        _until(lambda: driver.execute_script("return document.readyState") == "complete", "report")
        assert driver.find_element("css selector", "h1").text == "Small <screw> & nut"
        assert driver.current_url == f"{address}files/report/report.html"
        assert "contact_angle=55 deg" in driver.page_source
        # Its world is not that of the page: it has no storage and no cookies of this address.
        assert driver.execute_script("return window.origin") == "null"
        assert [line["message"] for line in driver.get_log("browser")] == []
        driver.close()
        driver.switch_to.window(window)

        _picture(driver, "wide", 1280)
        # One column, nothing beyond the edge.
        driver.set_window_size(400, 800)
        time.sleep(0.3)
        wide, inner = driver.execute_script(
            "return [document.documentElement.scrollWidth, window.innerWidth]"
        )
        assert wide <= inner
        lefts = driver.execute_script(
            "return [...document.querySelectorAll('.panel')]"
            ".map(e => Math.round(e.getBoundingClientRect().left))"
        )
        assert len(set(lefts)) == 1
        assert driver.execute_script(
            "return [...document.querySelectorAll('.panel')]"
            ".every(e => e.scrollHeight <= e.clientHeight && e.scrollWidth <= e.clientWidth)"
        )
        _picture(driver, "narrow", 400)
        assert [line["message"] for line in driver.get_log("browser")] == []
        loaded = driver.execute_script(
            "return performance.getEntriesByType('resource').map(e => e.name)"
        )
        assert loaded
        assert all(name.startswith(address) for name in loaded)

        # Ctrl-C ends it at once, in one line, and nothing else was written.
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 130
        assert process.stderr is not None
        assert process.stderr.read().strip() == "prsm: stopped (Ctrl-C)"
    assert {path.name for path in tmp_path.iterdir()} <= {"address.json", "chosen", "profile"}
    assert {path.name for path in (tmp_path / "chosen").iterdir()} == {"design.toml", "report"}
