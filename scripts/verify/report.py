"""`azimesh report` in headless Chromium: the slider shows the values of steps.csv, pictures and plots follow it; the cut has every cell.

A plane airfoil, and a blade in space that turns with the azimuth. Where there is no Chromium the check says SKIPPED.
"""

import base64
import json
import shutil
import time

import browser
import outputs
from browser import chromium
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from program import TESTDATA, azimesh, report, scratch

WIDTHS = {"desktop": 1280, "phone": 390, "narrow": 360}
TEXT = {"file", "blake3"}
SECONDS = 12.0
PATIENCE = 30.0


def sequence(folder, step):
    """A revolution of the sample airfoil in steps of so many degrees; the rows of steps.csv."""
    shutil.copy(TESTDATA / "naca0012.vtu", folder)
    text = (TESTDATA / "naca0012.toml").read_text()
    assert "step = 10.0" in text
    schedule = folder / "revolution.toml"
    label = '[output]\ntitle = "NACA 0012, pitching"\nlength_unit = "chords"\n'
    schedule.write_text(text.replace("step = 10.0", f"step = {step}") + label)
    return outputs.deform(folder / "naca0012.vtu", schedule, folder / "out")


def blade(folder):
    """A blade of sample in the inertial frame, ten steps; the rows of steps.csv."""
    azimesh("sample", "blade", "--nodes", "20000", "--first-cell", "1e-3", "-o", folder / "blade.vtu")
    text = (folder / "blade.toml").read_text()
    assert "step = 10.0" in text and 'frame = "rotating"' in text
    schedule = folder / "turning.toml"
    schedule.write_text(text.replace("step = 10.0", "step = 40.0").replace('frame = "rotating"', 'frame = "inertial"'))
    return outputs.deform(folder / "blade.vtu", schedule, folder / "turning")


def wait_for(driver, told, script):
    """What a script gives as soon as it is not nothing."""
    end = time.monotonic() + PATIENCE
    while not (found := driver.execute_script(script)):
        assert time.monotonic() < end, f"{told}: nothing within {PATIENCE} s"
        time.sleep(0.05)
    return found


def values(driver):
    """What stands in the table: column to the number as written and in full."""
    return driver.execute_script("""
        return Object.fromEntries([...document.querySelectorAll(".values output")].map(o =>
            [o.dataset.column, [o.textContent, o.title]]));""")


def marks(driver):
    """Value of the horizontal axis at the line that marks the step, in each plot."""
    return driver.execute_script("""
        return steps.map(plot => plot.live.posToVal(new DOMMatrix(plot.mark.style.transform).e, "x"));""")


def check_step(driver, row):
    """(values compared, largest relative difference) of what the page shows and a row of steps.csv."""
    shown = values(driver)
    largest, n = 0.0, 0
    for column, text in row.items():
        if (text == "" and column not in shown) or column == "checksum":
            continue
        short, full = shown[column]
        assert full == text, f"{column}: {full!r} on the page, {text!r} in steps.csv"
        if column in TEXT:
            assert short == text
            continue
        wanted = float(text)
        largest = max(largest, abs(float(short) - wanted) / max(abs(wanted), 1e-300))
        n += 1
    azimuth, end = float(row["azimuth_deg"]), time.monotonic() + PATIENCE
    # Plots are drawn with the next frame.
    found = marks(driver)
    while any(abs(at - azimuth) >= 1e-3 for at in found) and time.monotonic() < end:
        time.sleep(0.05)
        found = marks(driver)
    assert len(found) > 5, found
    for at in found:
        assert abs(at - azimuth) < 1e-3, f"a mark is at {at}, not {azimuth}"
    said = driver.find_element("id", "which").text
    assert said.startswith(f"Step {row['step']} of "), said
    return n, largest


def move(driver, row, step):
    """Moves the slider as a user does: keys, buttons, a click into a plot; the step that it is at then."""
    slider = driver.find_element("id", "step")
    if step == 0:
        slider.send_keys("\ue011")
    elif step == 1:
        driver.find_element("css selector", "[data-by='1']").click()
    elif step == len(row) - 1:
        slider.send_keys("\ue010")
    elif step % 2:
        driver.execute_script("arguments[0].value = arguments[1];"
                              "arguments[0].dispatchEvent(new Event('input', { bubbles: true }));", slider, step)
    else:
        driver.execute_script("""
            const plot = steps[0].live, box = plot.over.getBoundingClientRect();
            const x = box.left + plot.valToPos(arguments[0], "x");
            for (const kind of ["mousedown", "mouseup", "click"]) {
                plot.over.dispatchEvent(new MouseEvent(kind, { bubbles: true, clientX: x, clientY: box.top + 20 }));
            }
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
        wait_for(driver, "cuts", "return document.getElementById('cut').dataset.ready")
        assert driver.find_element("css selector", "h1").text == "NACA 0012, pitching"
        assert "mesh units" not in driver.execute_script("return document.body.innerText")
        for step in (0, 1, 7, 90, 181, len(rows) - 1):
            step = move(driver, rows, step)
            compared, difference = check_step(driver, rows[step])
            n, largest = n + compared, max(largest, difference)
        driver.find_element("css selector", "[data-stop]").click()
        check_step(driver, min(rows, key=lambda row: float(row["min_scaled_jacobian"])))
        assert len(driver.find_elements("css selector", "figure.chosen-step")) == 1, "its still picture is not marked"
        check_cut(driver, rows)
        cells = json.loads(azimesh("info", TESTDATA / "naca0012.vtu", "--json"))["cells_by_kind"]
        check_cells(driver, cells["quadrilateral"], "chords", ["airfoil"])
        check_floor(driver)
        check_copy(driver)
        check_zoom(driver, rows)
        check_play(driver)
        check_alone(driver)
    return n, largest


def check_cut(driver, rows):
    """The cut is that of the step, or of the nearest that has one, which the page says then."""
    frames = driver.execute_script("return data.frames")
    assert len(frames) == min(len(rows), len(frames)) and len(frames) >= min(len(rows), 100)
    for step in (0, len(rows) // 3, len(rows) - 1):
        driver.execute_script("showStep(arguments[0])", step)
        nearest = min(frames, key=lambda frame: abs(frame - step))
        told = driver.execute_script("return document.querySelector('#cut .slice').ariaLabel.split(' Keys:')[0]")
        assert any(told.startswith(f"Step {frame}, ") for frame in frames if abs(frame - step) == abs(nearest - step)), (step, told)
        remark = driver.execute_script("return document.getElementById('cut-step').textContent")
        assert remark.startswith(told) and ("nearest" in remark) == (nearest != step), (step, remark)
        wait_for(driver, "the cut", f"return document.querySelector('#cut .slice').dataset.frame == {1 + min(range(len(frames)), key=lambda at: abs(frames[at] - step))}")
        marks = driver.execute_script("return [...document.querySelectorAll('#cut .mark')].map(mark => mark.title)")
        assert marks and all(mark.startswith("Worst cell ") for mark in marks), marks


def seen(driver):
    """Cells that the cut draws in its view, and the axes of the view."""
    return driver.execute_script("""
        const { live } = plots.find(plot => plot.box?.parentElement.id === "cut"), { x, y } = live.scales;
        return [Number(document.querySelector("#cut .slice").dataset.seen), [x.min, x.max, y.min, y.max],
                live.axes.map(axis => [axis.label, axis._values.filter(value => value).length])];""")


def view_of(driver, act, before):
    """What is seen after an act that changes the view."""
    act()
    end = time.monotonic() + PATIENCE
    while (found := seen(driver))[1] == before[1]:
        assert time.monotonic() < end, "the view of the cut stays"
        time.sleep(0.05)
    left, right, low, high = found[1]
    ratio = driver.execute_script("const { over } = plots.find(plot => plot.box?.parentElement.id === 'cut').live;"
                                  "return over.clientHeight / over.clientWidth")  # fmt: skip
    assert abs((high - low) / (right - left) - ratio) < 0.02 * ratio, f"scales differ: {found[1]}"
    return found


def check_cells(driver, n_cells, unit, bodies):
    """Buttons, keys, wheel and pointer move the cut, which has ticks and the outlines; with all in view it draws each cell of a plane mesh."""
    box, first = driver.find_element("css selector", "#cut .slice"), seen(driver)
    assert [label for label, _ in first[2]] == [f"{axis}, {unit}" for axis in "xy"] and all(n > 2 for _, n in first[2]), first[2]
    assert set(bodies) < set(box.get_attribute("data-outlines").split(";")), box.get_attribute("data-outlines")
    button = {name: driver.find_element("css selector", f"#cut .tools [aria-label^='{name}']") for name in ("zoom into", "zoom out", "first", "all")}
    near = view_of(driver, button["zoom into"].click, first)
    assert 0 < near[0] < first[0] and abs((near[1][1] - near[1][0]) / (first[1][1] - first[1][0]) - 0.5) < 1e-6
    moved = view_of(driver, lambda: box.send_keys("\ue014"), near)
    assert moved[1][0] > near[1][0] and moved[1][2] == near[1][2], "an arrow moves it to the right"
    act = ActionChains(driver)
    dragged = view_of(driver, act.move_to_element(box).click_and_hold().move_by_offset(60, 40).release().perform, moved)
    assert dragged[1][0] < moved[1][0] and dragged[1][2] > moved[1][2], (moved, dragged)
    wheeled = view_of(driver, ActionChains(driver).scroll_from_origin(ScrollOrigin.from_element(box), 0, -200).perform, dragged)
    assert wheeled[1][1] - wheeled[1][0] < 0.9 * (dragged[1][1] - dragged[1][0]), "the wheel goes nearer"
    view_of(driver, button["all"].click, wheeled)
    assert seen(driver)[0] == n_cells, f"{seen(driver)[0]} of {n_cells} cells"
    view_of(driver, button["first"].click, seen(driver))
    assert seen(driver)[:2] == first[:2]


def check_floor(driver):
    """A logarithmic axis does not reach to round-off of few steps; values below its end are said to be at the edge."""
    found = driver.execute_script("""
        const floor = (...line) => floorOf({ is_log: true, bars: [] }, [line]), errors = steps.find(plot => plot.is_log);
        const known = errors.values.slice(1).flat().filter(y => y > 0).sort((a, b) => a - b);
        return [[floor(1e-20, 2e-5, 3e-5, 1e-4, 1e-4), floor(0, 2e-5), floor(1e-5, 1e-4, 1e-3), floor(1e-16, 1e-16, 1e-4, 1e-4)],
                errors.live.scales.y.min / known[Math.floor(known.length / 2)], errors.floor, errors.figure.querySelector(".remark").textContent];""")
    floors, part, floor, remark = found
    assert floors == [1e-6, 1e-6, 0, 0], floors
    assert part > 1e-6 and (floor == 0 or "lower edge" in remark), found


def check_copy(driver):
    """A click copies the command of the run, or selects it where the browser keeps the page from the clipboard."""
    command, button = driver.find_element("id", "command").text, driver.find_element("id", "copy")
    assert command.startswith("azimesh ") and " deform " in command and " -o " in command, command
    button.click()
    wait_for(driver, "copied", "return document.getElementById('copy').textContent !== 'Copy'")


def scale_of(driver, plot):
    """The part of the axis that a plot shows."""
    return driver.execute_script("const { min, max } = steps[arguments[0]].live.scales.x; return [min, max];", plot)


def check_zoom(driver, rows):
    """Buttons and keys zoom all plots over the steps around the chosen step, and back; alone where they are not over steps."""
    driver.execute_script("showStep(90)")
    azimuth = float(rows[90]["azimuth_deg"])
    whole = scale_of(driver, 0)
    driver.find_element("css selector", "figure.plot .zoom [aria-label^='zoom into']").click()
    near = scale_of(driver, 0)
    assert near[1] - near[0] < 0.51 * (whole[1] - whole[0]) and near[0] < azimuth < near[1], (whole, near)
    assert scale_of(driver, 3) == near, "another plot shows other steps"
    box = driver.find_element("css selector", ".live-plot")
    box.send_keys("+")
    nearer = scale_of(driver, 0)
    assert nearer[1] - nearer[0] < 0.51 * (near[1] - near[0])
    check_step(driver, rows[90])
    box.send_keys("0")
    assert scale_of(driver, 0) == whole and scale_of(driver, 3) == whole


def check_play(driver):
    """The space bar plays, and again it stops."""
    driver.execute_script("showStep(0); document.activeElement.blur()")
    body = driver.find_element("css selector", "body")
    body.send_keys(" ")
    wait_for(driver, "playing", "return Number(document.getElementById('step').value) > 3")
    body.send_keys(" ")
    assert driver.find_element("id", "play").get_attribute("aria-pressed") == "false"
    stopped = driver.execute_script("return document.getElementById('step').value")
    time.sleep(0.3)
    assert driver.execute_script("return document.getElementById('step').value") == stopped


def check_alone(driver):
    """No request but for the page itself, no complaint in the console, every picture with a text."""
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    outside = [url for url in sent if not url.startswith(("file:", "data:"))]
    assert not outside, f"the page asks for {outside}"
    # The browser says when it draws without a graphics card.
    complaints = [entry for entry in driver.get_log("browser") if "GPU stall due to ReadPixels" not in entry["message"]]
    assert not complaints, complaints
    silent = driver.execute_script(
        "return [...document.querySelectorAll('svg, canvas')].filter(s => !s.ariaLabel && !s.closest('[aria-hidden=true]')).length")
    assert silent == 0, f"{silent} pictures have no text"


PIXELS = """
    const canvas = document.getElementById("scene"), copy = document.createElement("canvas");
    [copy.width, copy.height] = [100, 70];
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0, 100, 70);
    return [...context.getImageData(0, 0, 100, 70).data];
"""


def drawn(driver):
    """The picture in space, small, once it is drawn."""
    time.sleep(0.5)
    return driver.execute_script(PIXELS)


def differ(one, other):
    """Part of the pixels that differ."""
    pixels = [one[i : i + 4] != other[i : i + 4] for i in range(0, len(one), 4)]
    return sum(pixels) / len(pixels)


def check_space(page, rows):
    """The bodies in space follow the slider, turn, and have colours and still pictures; without WebGL the page says so."""
    with chromium() as driver:
        driver.get(page.as_uri())
        wait_for(driver, "space", "return document.getElementById('scene').dataset.ready")
        assert driver.execute_script("return data.frames") == list(range(len(rows)))
        pictures = []
        for step in (0, 2, 5):
            driver.execute_script("showStep(arguments[0])", step)
            pictures.append(drawn(driver))
            assert driver.execute_script("return document.getElementById('scene').dataset.frame") == str(step)
        seen = sum(pictures[0][i + 3] > 0 for i in range(0, len(pictures[0]), 4)) / 7000
        assert 0.003 < seen < 0.6, f"the blade covers {seen} of the picture"
        assert min(differ(pictures[0], pictures[1]), differ(pictures[1], pictures[2])) > 0.003, "it does not move"
        driver.find_element("id", "scene").send_keys("\ue012")
        assert differ(drawn(driver), pictures[2]) > 0.003, "it does not turn"
        driver.find_element("css selector", "[data-view='0']").click()
        assert differ(drawn(driver), pictures[2]) == 0.0, "the first view is another"
        letters = driver.execute_script("return [...document.querySelectorAll('.stage .triad text')].map(text => text.textContent).sort()")
        assert letters == ["x", "y", "z"], letters
        check_area(driver)
        boxes = driver.find_elements("css selector", "#scene-choices input")
        assert len(boxes) == 5, "a body, a boundary, the worst cell, edges, the reference shape"
        fields = [pictures[2]]
        for field in ("displacement", "quality"):
            driver.find_element("css selector", f"#field option[value={field}]").click()
            fields.append(drawn(driver))
            assert min(differ(fields[-1], before) for before in fields[:-1]) > 0.003, f"{field} has no colour"
            assert driver.find_element("id", f"key-{field}").is_displayed()
        stills = driver.execute_script("return [...document.querySelectorAll('figure[data-picture] img.solid')].map(i => [i.src, i.naturalWidth, i.hidden])")
        assert len(stills) > 2 and len({src for src, _, _ in stills}) == len(stills), "stills in space are alike"
        assert all(width > 100 and not hidden for _, width, hidden in stills)
        check_alone(driver)
    with chromium(webgl=False) as driver:
        driver.get(page.as_uri())
        note = wait_for(driver, "note", "return document.getElementById('scene-note').textContent")
        assert "WebGL" in note, note
        assert not driver.find_elements("css selector", "img.solid:not([hidden])")
        check_alone(driver)


def check_area(driver):
    """The cells of the cut in 3D fill what is between the outlines of the cylinder and the blade, at each frame."""
    found = driver.execute_async_script("""
        const done = arguments[arguments.length - 1];
        cutOf(JSON.parse(document.getElementById("cut-data").textContent)).then((cut) => {
            const twice = (line) => line.reduce((sum, x, i) => i % 2 ? sum : sum + x * line[(i + 3) % line.length] - line[(i + 2) % line.length] * line[i + 1], 0);
            const sum = (lines) => lines.reduce((all, { line }) => all + Math.abs(twice(line)), 0);
            done(cut.frames.map((_, frame) => {
                const { cells, walls } = stateOf(cut, frame);
                return [cells, ...walls].map(sum);
            }));
        });""")
    for cells, blade, outer in found:
        assert 0 < blade < 0.02 * outer and abs(cells + blade - outer) < 1e-3 * outer, (cells, blade, outer)


def check_widths(page):
    """Nothing is wider than the screen, and text can be read, on a desk, on a phone, in the dark, on paper."""
    for name, width in WIDTHS.items():
        for dark in (False, True):
            with chromium(width, dark=dark) as driver:
                driver.get(page.as_uri())
                wide = driver.execute_script("return document.documentElement.scrollWidth")
                assert wide <= width, f"{name}: {wide} wide on a screen of {width}"
                overflowing = driver.execute_script("""
                    return plots.filter(plot => plot.live.root.getBoundingClientRect().right > innerWidth + 1).length""")
                assert overflowing == 0, f"{name}: {overflowing} plots are too wide"
                ground = driver.execute_script("return getComputedStyle(document.body).backgroundColor")
                assert (ground == "rgb(255, 255, 255)") != dark, f"{ground} in {'the dark' if dark else 'the light'}"
                check_colours(driver)
    with chromium() as driver:
        driver.get(page.as_uri())
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        shown = driver.execute_script("""
            const seen = (part) => [...document.querySelectorAll(part)].filter(e => e.getClientRects().length > 0).length;
            return [seen(".live-plot canvas"), seen("#play")];""")
        assert shown[0] > 5 and shown[1] == 0, shown
        paper = driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})
        pdf = base64.b64decode(paper["data"])
        assert pdf.startswith(b"%PDF")


def check_colours(driver):
    """Text has the contrast of WCAG's level AA, 4.5, against what is behind it; lines of plots have 3."""
    for name, least in [("--ink", 4.5), ("--soft", 4.5), ("--accent", 4.5), ("--bad", 4.5), *((f"--s{i}", 3.0) for i in range(8))]:
        for ground in ("--ground", "--card"):
            found = driver.execute_script("""
                const light = (name) => {
                    const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim().slice(1);
                    const parts = hex.length === 3 ? [...hex].map(c => c + c) : hex.match(/../g);
                    const [r, g, b] = parts.map(p => parseInt(p, 16) / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
                    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
                };
                const [a, b] = [light(arguments[0]), light(arguments[1])];
                return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);""", name, ground)
            assert found >= least, f"{name} on {ground}: contrast {found:.2f}"


def main():
    """A page of 361 steps, made in time, then looked at; one of bodies in space."""
    if not browser.is_there():
        print("report: SKIPPED, as chromium or chromedriver is missing: apt-get install chromium chromium-driver")
        return
    with scratch() as work:
        rows = sequence(work, 1.0)
        assert len(rows) == 361
        started = time.monotonic()
        azimesh("report", work / "out")
        seconds = time.monotonic() - started
        assert seconds < SECONDS, f"the page took {seconds:.1f} s"
        page = work / "out" / "report.html"
        size = page.stat().st_size
        assert size < 8e6, f"the page has {size} bytes"
        n, largest = check_slider(page, rows)
        check_widths(page)
        turning = blade(work)
        azimesh("report", work / "turning")
        check_space(work / "turning" / "report.html", turning)
    report("report", n, largest, "values in a browser", f"page of {len(rows)} steps, {size / 1e6:.2f} MB in {seconds:.2f} s")
    assert largest <= 5.1e-4, "numbers are shown to four digits at least"
