"""Takes docs/pictures/report.png: the top of a report in headless Chromium.

    .venv/bin/python scripts/report_picture.py

Makes the page of testdata/naca0012.vtu through one revolution in steps of 5 degrees. Needs what
scripts/verify/report.py needs.
"""

import base64
import io
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "verify"))

PICTURE = ROOT / "docs" / "pictures" / "report.png"
WIDTH, HEIGHT = 1280, 1420


def main():
    """The picture, with few colours so that it is small."""
    from browser import chromium
    from program import azimesh, scratch
    from report import sequence

    with scratch() as folder:
        sequence(folder, 5.0)
        azimesh("report", folder / "out")
        with chromium(WIDTH) as driver:
            driver.get((folder / "out" / "report.html").as_uri())
            driver.find_element("css selector", "[data-stop]").click()
            clip = {"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT, "scale": 1}
            taken = driver.execute_cdp_cmd("Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True})
    picture = Image.open(io.BytesIO(base64.b64decode(taken["data"]))).convert("RGB")
    picture.quantize(128, dither=Image.Dither.NONE).save(PICTURE, optimize=True)
    print(f"{PICTURE}: {PICTURE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
