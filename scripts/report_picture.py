"""Takes docs/pictures/report.png: the top of a report in headless Chromium.

    .venv/bin/python scripts/report_picture.py

Makes the page of a sample rotor with four blades through one revolution. Needs what scripts/verify/report.py needs.
"""

import base64
import io
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "verify"))

PICTURE = ROOT / "docs" / "pictures" / "report.png"
WIDTH, HEIGHT = 1280, 1500
STEP = 5


def main():
    """The picture, with few colours so that it is small."""
    import outputs
    from browser import chromium
    from program import azimesh, scratch
    from report import drawn, wait_for

    with scratch() as folder:
        azimesh("sample", "rotor", "--blades", "4", "--nodes", "120000", "--first-cell", "1e-3", "-o", folder / "rotor.vtu")
        label = '\n[output]\ntitle = "Four blades in forward flight"\nlength_unit = "m"\n'
        schedule = folder / "rotor.toml"
        schedule.write_text(schedule.read_text() + label)
        outputs.deform(folder / "rotor.vtu", schedule, folder / "out")
        azimesh("report", folder / "out")
        with chromium(WIDTH) as driver:
            driver.get((folder / "out" / "report.html").as_uri())
            wait_for(driver, "space", "return document.getElementById('scene').dataset.ready")
            driver.execute_script("showStep(arguments[0])", STEP)
            drawn(driver)
            driver.execute_script("const c = document.getElementById('command'); c.textContent = c.textContent.replaceAll(arguments[0], '')", f"{folder}/")
            clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT, "scale": 1}
            taken = driver.execute_cdp_cmd("Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True})
    picture = Image.open(io.BytesIO(base64.b64decode(taken["data"]))).convert("RGB")
    picture.quantize(128, dither=Image.Dither.NONE).save(PICTURE, optimize=True)
    print(f"{PICTURE}: {PICTURE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
