#!/usr/bin/env python3
"""Pictures of `gprodom view`, `report` and `commission`, as they are in docs/, without a screen.

Needs Xvfb and a Vulkan driver that computes (packages xvfb, mesa-vulkan-drivers), and Chromium.

    bench/view_pictures.py view OUT.lcmlog --sensors IN.lcmlog [--map FILE.map] -o docs/view.png
    bench/view_pictures.py report OUT.lcmlog --sensors IN.lcmlog -o docs/report.png
    bench/view_pictures.py commission IN.lcmlog --stretch 10 -o docs/commission.png
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from PIL import Image

from gprodom.files import temporary_folder
from gprodom.view.viewer import viewer_command, without_statistics

GPRODOM = (sys.executable, "-m", "gprodom")
WIDTH = 1280  # of the picture, pixels
WINDOW = "1440x900"
# The pointer is in the middle of the screen: not over the window, which is at its corner.
XVFB = ("xvfb-run", "-a", "-s", "-screen 0 5000x4000x24")
CHROMIUM = ("chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
MOST_BYTES = 200_000  # of a picture: the palette is as large as that leaves it


def picture_of_view(log: list[str], shot: Path, folder: Path) -> None:
    """The viewer's own screenshot, of the whole drive."""
    recording = folder / "drive.rrd"
    subprocess.run([*GPRODOM, "view", *log, "-o", str(recording)], check=True)
    more = ["--renderer", "vulkan", "--window-size", WINDOW, "--screenshot-to", str(shot)]
    with without_statistics() as environment:
        command = viewer_command("127.0.0.1", None, None, [*more, str(recording)])
        said = subprocess.run([*XVFB, *command], env=environment, capture_output=True, text=True)
    if not shot.is_file():
        sys.exit(f"view_pictures: no picture: {said.stderr[-2000:]}")


def picture_of_page(what: str, log: list[str], shot: Path, folder: Path) -> None:
    """The top of the page that a command writes, light and dark side by side."""
    page = folder / "drive.html"
    option = {"report": "-o", "commission": "--page"}[what]
    subprocess.run([*GPRODOM, what, *log, option, str(page)], check=True)
    halves = []
    for scheme in (1, 0):  # of Chromium's setting: light, dark
        half = folder / f"{scheme}.png"
        look = [f"--blink-settings=preferredColorScheme={scheme}", "--window-size=820,1400"]
        shoot = [*CHROMIUM, f"--user-data-dir={folder}/profile", *look, f"--screenshot={half}"]
        subprocess.run([*shoot, page.as_uri()], check=True, capture_output=True)
        halves.append(Image.open(half).convert("RGB"))
    both = Image.new("RGB", (sum(each.width for each in halves), halves[0].height))
    both.paste(halves[0], (0, 0))
    both.paste(halves[1], (halves[0].width, 0))
    both.save(shot)


def main() -> int:
    """Runs the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("view", "report", "commission"))
    parser.add_argument("-o", "--output", type=Path, required=True)
    args, log = parser.parse_known_args()
    with temporary_folder() as folder:
        shot = folder / "shot.png"
        if args.what == "view":
            picture_of_view(log, shot, folder)
        else:
            picture_of_page(args.what, log, shot, folder)
        image = Image.open(shot).convert("RGB")
        height = round(image.height * WIDTH / image.width)
        small = image.resize((WIDTH, height), Image.Resampling.LANCZOS)
        for colours in (256, 128, 64, 32):
            small.quantize(colours, kmeans=2, dither=Image.Dither.NONE).save(
                args.output, optimize=True
            )
            if args.output.stat().st_size < MOST_BYTES:
                break
    print(f"{args.output}: {args.output.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
