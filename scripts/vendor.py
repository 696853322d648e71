"""Libraries in the page of `azimesh report`: three.js and uPlot, from npm into src/report/vendor.

    python3 scripts/vendor.py              fetches them again and compares with what is there, byte for byte
    python3 scripts/vendor.py --update     writes them, and SHA256SUMS

Versions are those of scripts/vendor/package-lock.json, whose hashes npm checks. uPlot's files are taken as they are;
of three.js esbuild makes one file of what scripts/vendor/three.js names. Needs npm.
"""

import hashlib
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "scripts" / "vendor"
VENDOR = ROOT / "src" / "report" / "vendor"
SUMS = VENDOR / "SHA256SUMS"
COPIES = {
    "uPlot.iife.min.js": "uplot/dist/uPlot.iife.min.js",
    "uPlot.min.css": "uplot/dist/uPlot.min.css",
    "LICENSE-uPlot": "uplot/LICENSE",
    "LICENSE-three": "three/LICENSE",
}


def fetch(folder):
    """File names and their bytes, made anew in a folder."""
    for name in ("package.json", "package-lock.json", "three.js"):
        shutil.copy(SOURCE / name, folder)
    subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"], cwd=folder, check=True)
    modules = folder / "node_modules"
    made = {name: (modules / path).read_bytes() for name, path in COPIES.items()}
    bundle = ["--bundle", "--minify", "--format=iife", "--global-name=THREE", "--target=es2020", "--legal-comments=none"]
    run = [modules / ".bin" / "esbuild", "three.js", *bundle, "--log-level=warning"]
    made["three.min.js"] = subprocess.run(run, cwd=folder, check=True, stdout=subprocess.PIPE).stdout
    return made


def main(update):
    """What npm gives is what the page has."""
    with tempfile.TemporaryDirectory() as folder:
        made = fetch(Path(folder))
    sums = "".join(f"{hashlib.sha256(made[name]).hexdigest()}  {name}\n" for name in sorted(made))
    if update:
        VENDOR.mkdir(exist_ok=True)
        for name, content in made.items():
            (VENDOR / name).write_bytes(content)
        SUMS.write_text(sums)
    wrong = [name for name, content in made.items() if (VENDOR / name).read_bytes() != content]
    if wrong or SUMS.read_text() != sums:
        sys.exit(f"vendor: {', '.join(wrong) or 'SHA256SUMS'} in {VENDOR} is not what npm gives; --update writes it")
    print(f"vendor: {len(made)} files are those of npm, {sum(map(len, made.values()))} bytes")


if __name__ == "__main__":
    main("--update" in sys.argv[1:])
