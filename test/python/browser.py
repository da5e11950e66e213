"""A page as headless Chromium shows it: what is cut, what cannot be read, what it complains of."""

import html
import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

SCHEMES = {"dark": 0, "light": 1}  # of Chromium's setting preferredColorScheme

# For each frame: elements whose content is wider or higher than they are and that do not scroll, or
# that end right of the frame; and the least contrast of a text against the page (WCAG 2: relative
# luminance).
MEASURE = """
const rgb = (text) => text.match(/[\\d.]+/g).slice(0, 3).map((v) => v / 255);
const light = (c) => {
  const [r, g, b] = rgb(c).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const contrast = (a, b) => {
  const [x, y] = [light(a), light(b)].sort((m, n) => n - m); return (x + 0.05) / (y + 0.05); };
const measure = (frame) => {
  const page = frame.contentDocument, view = frame.contentWindow, cut = [];
  let least = 100;
  const shown = (e) => e.getClientRects().length > 0;
  const scrolls = (e) => e && (/auto|scroll/.test(view.getComputedStyle(e).overflowX)
    || scrolls(e.parentElement));
  for (const e of page.body.querySelectorAll('*')) {
    if (!shown(e) || e.closest('svg') !== null && e.tagName !== 'svg') continue;
    const box = e.getBoundingClientRect(), style = view.getComputedStyle(e);
    if (box.right > view.innerWidth + 0.5 && !scrolls(e)) cut.push(e.tagName + ' ' + box.right);
    if (e.tagName !== 'svg' && e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0
      && !scrolls(e)) cut.push(e.tagName + ' inside ' + e.scrollWidth);
    if (e.tagName !== 'svg' && e.innerText) least = Math.min(least,
      contrast(style.color, view.getComputedStyle(page.body).backgroundColor));
  }
  const svg = [...page.querySelectorAll('svg.figure')].filter(shown);
  return { width: view.innerWidth, cut, contrast: least, scroll: page.body.scrollWidth,
    height: page.documentElement.scrollHeight,
    figures: svg.map((e) => e.getBoundingClientRect().width),
    ink: svg.length ? view.getComputedStyle(svg[0]).fill : view.getComputedStyle(page.body).color,
    paper: view.getComputedStyle(page.body).backgroundColor }; };
addEventListener('load', () => {
  const found = [...document.querySelectorAll('iframe')].map(measure);
  document.body.textContent = 'MEASURED' + JSON.stringify(found) + 'END'; });
"""


@dataclass(frozen=True)
class Shown:
    """What was measured at each width, and the lines of the console."""

    frames: list[dict[str, Any]]
    console: list[str]


def program() -> str | None:
    """Chromium, where it is installed."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


def _chromium(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    chromium = program()
    if chromium is None:
        pytest.skip("chromium is not installed, so no page is shown (apt install chromium)")
    return subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
         "--allow-file-access-from-files", f"--user-data-dir={folder}", *arguments],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip


def _frame(page: Path, width: int, height: int) -> str:
    """Of that size, CSS pixels; a window cannot be as narrow as a phone."""
    address = html.escape(page.absolute().as_uri())
    return f'<iframe src="{address}" width={width} height={height} style="border:0"></iframe>'


def _options(scheme: str) -> list[str]:
    return [
        f"--blink-settings=preferredColorScheme={SCHEMES[scheme]}",
        "--virtual-time-budget=5000",
    ]


def show(page: Path, widths: list[int], scheme: str, folder: Path) -> Shown:
    """Shows `page` in frames of those widths (CSS pixels)."""
    frames = "".join(_frame(page, width, 800) for width in widths)
    outer = folder / "frames.html"
    outer.write_text(f"<!doctype html><script>{MEASURE}</script><body>{frames}</body>")
    done = _chromium(folder / "profile", *_options(scheme), "--dump-dom", outer.absolute().as_uri())
    measured = re.search(r"<body>MEASURED(.*)END", done.stdout, re.S)
    assert measured, done.stderr
    console = [each for each in done.stderr.splitlines() if "CONSOLE" in each]
    return Shown(json.loads(html.unescape(measured[1])), console)


def picture(page: Path, width: int, height: int, scheme: str, folder: Path) -> Image.Image:
    """What is seen of `page` in a frame of that size."""
    outer, shot = folder / "frame.html", folder / "frame.png"
    outer.write_text(f"<!doctype html><body style='margin:0'>{_frame(page, width, height)}</body>")
    _chromium(
        folder / "profile",
        *_options(scheme),
        "--hide-scrollbars",
        f"--window-size={width + 200},{height + 200}",  # with its own frame, and at least 500
        f"--screenshot={shot.absolute()}",
        outer.absolute().as_uri(),
    )
    return Image.open(shot).convert("RGB").crop((0, 0, width, height))


def printed_pages(page: Path, folder: Path) -> int:
    """Number of sheets on paper."""
    paper = folder / "paper.pdf"
    _chromium(folder / "profile", f"--print-to-pdf={paper}", page.absolute().as_uri())
    return len(re.findall(rb"/Type\s*/Page\b", paper.read_bytes()))
