"""`azimesh report` in headless Chromium: the slider shows the values of steps.csv and marks them in the plots.

    .venv/bin/python scripts/verify/report.py [FOLDER]

With a folder, screenshots of the page go there.
"""

import base64
import json
import shutil
import sys
import time
from pathlib import Path

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import outputs
from browser import chromium
from program import TESTDATA, azimesh, report, scratch

WIDTHS = {"desktop": 1280, "phone": 390, "narrow": 360}
TEXT = {"file", "blake3"}
SECONDS = 5.0


def sequence(folder, step):
    """A revolution of the sample airfoil in steps of so many degrees; the rows of steps.csv."""
    shutil.copy(TESTDATA / "naca0012.vtu", folder)
    text = (TESTDATA / "naca0012.toml").read_text()
    assert "step = 10.0" in text
    schedule = folder / "revolution.toml"
    schedule.write_text(text.replace("step = 10.0", f"step = {step}"))
    return outputs.deform(folder / "naca0012.vtu", schedule, folder / "out")


def values(driver):
    """What stands beside the slider: column to the number as written and in full."""
    found = driver.find_elements(By.CSS_SELECTOR, ".values output")
    return {o.get_attribute("data-column"): (o.text, o.get_attribute("title")) for o in found}


def marks(driver):
    """Value of the horizontal axis at the line that marks the step, plot by plot."""
    return driver.execute_script("""
        return [...document.querySelectorAll("svg[data-from]")].map(plot => {
            const { from, to, left, width } = plot.dataset;
            const x = plot.querySelector(".mark").transform.baseVal[0].matrix.e;
            return Number(from) + (x - left) / width * (to - from);
        });""")


def check_step(driver, row):
    """(values compared, largest relative difference) of what the page shows and a row of steps.csv."""
    shown = values(driver)
    largest, n = 0.0, 0
    for column, text in row.items():
        if text == "" and column not in shown:
            continue
        short, full = shown[column]
        assert full == text, f"{column}: {full!r} on the page, {text!r} in steps.csv"
        if column in TEXT:
            assert short == text
            continue
        wanted = float(text)
        largest = max(largest, abs(float(short) - wanted) / max(abs(wanted), 1e-300))
        n += 1
    for at in marks(driver):
        assert abs(at - float(row["azimuth_deg"])) < 1e-3, f"a mark is at {at}, not {row['azimuth_deg']}"
    said = driver.find_element(By.ID, "which").text
    assert said.startswith(f"Step {row['step']} of "), said
    return n, largest


def move(driver, row, step):
    """Moves the slider as a user does: keys, buttons, a click into a plot; the step that it is at then."""
    slider = driver.find_element(By.ID, "step")
    if step == 0:
        slider.send_keys(Keys.HOME)
    elif step == 1:
        driver.find_element(By.CSS_SELECTOR, "[data-by='1']").click()
    elif step == len(row) - 1:
        slider.send_keys(Keys.END)
    elif step % 2:
        driver.execute_script("arguments[0].value = arguments[1];"
                              "arguments[0].dispatchEvent(new Event('input', { bubbles: true }));", slider, step)
    else:
        driver.execute_script("""
            const plot = document.querySelector("svg[data-from]"), box = plot.getBoundingClientRect();
            const { from, to, left, width } = plot.dataset;
            const part = (arguments[0] - from) / (to - from);
            const x = box.left + (Number(left) + part * width) / plot.viewBox.baseVal.width * box.width;
            plot.dispatchEvent(new MouseEvent("click", { bubbles: true, clientX: x, clientY: box.top + 20 }));
            """, float(row[step]["azimuth_deg"]))
        # A click is a whole number of pixels, and a step may be narrower than one.
        found = int(slider.get_attribute("value"))
        assert abs(found - step) <= 2, f"a click at step {step} chose {found}"
        return found
    return step


def check_slider(page, rows):
    """Every kind of move, and the button of the worst step."""
    n, largest = 0, 0.0
    with chromium() as driver:
        driver.get(page.as_uri())
        for step in (0, 1, 7, 90, 181, len(rows) - 1):
            step = move(driver, rows, step)
            compared, difference = check_step(driver, rows[step])
            n, largest = n + compared, max(largest, difference)
        driver.find_element(By.CSS_SELECTOR, "[data-stop]").click()
        worst = min(rows, key=lambda row: float(row["min_scaled_jacobian"]))
        check_step(driver, worst)
        assert len(driver.find_elements(By.CSS_SELECTOR, "figure.chosen-step")) == 1, "its cut is not marked"
        check_alone(driver)
    return n, largest


def check_alone(driver):
    """No request but for the page itself, no complaint in the console, every picture with a text."""
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    outside = [url for url in sent if not url.startswith(("file:", "data:"))]
    assert not outside, f"the page asks for {outside}"
    complaints = driver.get_log("browser")
    assert not complaints, complaints
    silent = driver.execute_script(
        "return [...document.querySelectorAll('svg')].filter(s => !s.ariaLabel && s.ariaHidden !== 'true').length")
    assert silent == 0, f"{silent} pictures have no text"


def check_widths(page, folder):
    """Nothing is wider than the screen, and text can be read, on a desk, on a phone, in the dark, on paper."""
    for name, width in WIDTHS.items():
        for dark in (False, True):
            with chromium(width, dark=dark) as driver:
                driver.get(page.as_uri())
                wide = driver.execute_script("return document.documentElement.scrollWidth")
                assert wide <= width, f"{name}: {wide} wide on a screen of {width}"
                scale = driver.execute_script(
                    "const s = document.querySelector('.plot > svg'); return s.getBoundingClientRect().width / 400")
                assert 12 * scale >= 9.5, f"{name}: text of plots is {12 * scale:.1f} pixels high"
                ground = driver.execute_script("return getComputedStyle(document.body).backgroundColor")
                assert (ground == "rgb(255, 255, 255)") != dark, f"{ground} in {'the dark' if dark else 'the light'}"
                if folder:
                    shoot(driver, folder / f"{name}{'_dark' if dark else ''}.png", width)
    with chromium() as driver:
        driver.get(page.as_uri())
        paper = driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})
        pdf = base64.b64decode(paper["data"])
        assert pdf.startswith(b"%PDF")
        if folder:
            (folder / "print.pdf").write_bytes(pdf)


def shoot(driver, path, width):
    """A picture of the whole page."""
    height = driver.execute_script("return document.documentElement.scrollHeight")
    clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
    picture = driver.execute_cdp_cmd("Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True})
    path.write_bytes(base64.b64decode(picture["data"]))


def main(folder=None):
    """A page of 361 steps, made in time, then looked at."""
    with scratch() as work:
        rows = sequence(work, 1.0)
        assert len(rows) == 361
        started = time.monotonic()
        azimesh("report", work / "out")
        seconds = time.monotonic() - started
        assert seconds < SECONDS, f"the page took {seconds:.1f} s"
        page = work / "out" / "report.html"
        size = page.stat().st_size
        assert size < 3e6, f"the page has {size} bytes"
        n, largest = check_slider(page, rows)
        check_widths(page, folder)
    report("report", n, largest, "values in a browser", f"page of {len(rows)} steps, {size / 1e6:.2f} MB in {seconds:.2f} s")
    assert largest <= 5.1e-4, "numbers are shown to four digits at least"


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
