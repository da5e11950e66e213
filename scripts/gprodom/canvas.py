"""One look for all pictures, and pages that fetch nothing."""

import base64
import html
import io
import re
from collections.abc import Sequence
from math import floor, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gprodom.files import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure as Figure
else:  # matplotlib is slow to import, and only its users do
    Axes = Figure = Any

TRUTH_COLOUR = "0.55"
# Okabe and Ito's palette: told apart by colour-blind readers and in print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442")

LINE_COLOURS = COLOURS[:7]  # a thin line of yellow is not seen on white
MOST_SQUARES = 20  # of a grid, along a way
LABEL_IN = 0.45  # height of ticks and label of an x axis

# Told apart in grey, too; five and the seven colours come together again only after 35 lines.
DASHES: tuple[Any, ...] = (
    "-",
    (0, (6, 2)),
    (0, (1.5, 1.5)),
    (0, (6, 2, 1.5, 2)),
    (0, (3, 1, 1, 1, 1, 1)),
)
MARKERS = ("o", "s", "^", "D", "v", "x", "P")

# matplotlib's black is the page's ink, and the grid's grey the page's faint lines, light or dark.
INK, GRID = "#000000", "#e6e6e6"
POINTS_A_PIXEL = 0.75  # CSS has 96 pixels to the inch, SVG of matplotlib 72 points
_USED = re.compile(r'(?:xlink:href="#|href="#|url\(#)([^")]+)')


def grid_square(extent_m: float) -> float:
    """Side of a square of a viewer's ground grid, m: 1, 2 or 5 times a power of ten and at least 1,
    so that at most some twenty lie along a way of that extent. A viewer writes no figures beside
    its grid, so the panel's title has to tell the side."""
    decade = 10.0 ** floor(log10(max(extent_m / MOST_SQUARES, 1.0)))
    return next(k * decade for k in (1, 2, 5, 10) if extent_m <= MOST_SQUARES * k * decade)


def line_style(i: int, count: int) -> dict[str, Any]:
    """Style of the i-th of `count` lines, for `Axes.plot`.

    Each has its own colour and dashes, and is thinner than the one before. So two equal lines lie
    on each other and can both be seen. One alone is thin.
    """
    share = i / (count - 1) if count > 1 else 0.7
    return {
        "color": LINE_COLOURS[i % len(LINE_COLOURS)],
        "linestyle": DASHES[i % len(DASHES)],
        "linewidth": 2.4 - 1.4 * share,
    }


def new_figure(
    rows: int = 1, columns: int = 1, width: float = 7.0, height: float = 4.5, **options: Any
) -> tuple[Figure, list[Axes]]:
    """A figure (inches) that belongs to no window, and its axes row by row."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    flat = [axis for row in axes for axis in row]
    for axis in flat:
        axis.grid(True, color="0.9", linewidth=0.6)
        axis.set_axisbelow(True)
    return figure, flat


def seen_from_above(axis: Axes) -> None:
    """A plane in metres, which are alike along both axes."""
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="x (m)", ylabel="y (m)")


def legend_beside(axis: Axes) -> None:
    """A legend right of its axes, where no data lie."""
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def legend_below(axis: Axes, columns: int, **options: Any) -> None:
    """A legend under the label of the x axis, where no data lie."""
    from matplotlib.transforms import ScaledTranslation

    figure = axis.get_figure()
    assert figure is not None
    down = ScaledTranslation(0.0, -LABEL_IN, figure.dpi_scale_trans)
    axis.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axis.transAxes + down,
        ncols=columns,
        **{"frameon": False, **options},
    )


def png(figure: Figure, dpi: int = 110) -> bytes:
    """The figure as PNG, without a creation date, so that equal data give equal files."""
    return _rendered(figure, "png", dpi, {"Software": None})


def save(figure: Figure, path: Path) -> None:
    """Writes the figure in the format of the file's ending, PNG where it has none."""
    kind = path.suffix.lower()
    if kind in (".png", ""):
        write_bytes(path, png(figure))
    else:  # without the time of creation, as in a PNG
        date = {".svg": "Date", ".pdf": "CreationDate"}[kind]
        write_bytes(path, _rendered(figure, kind[1:], 110, {date: None}))


def _rendered(figure: Figure, kind: str, dpi: int, metadata: dict[str, Any]) -> bytes:
    from matplotlib import rc_context

    buffer = io.BytesIO()
    with rc_context({"svg.hashsalt": "gprodom"}):  # its identifiers are drawn at random else
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=metadata)
    return buffer.getvalue()


def log_scales(axes: Axes, *names: str) -> None:
    """Logarithmic axes (`names`: x, y) whose ticks read as numbers, 0.5 and not 5x10^-1. Call it
    when all is drawn."""
    from matplotlib.ticker import AutoLocator, FuncFormatter, LogLocator, NullFormatter

    for name in names:
        axes.set(**{f"{name}scale": "log"})
        axis = axes.xaxis if name == "x" else axes.yaxis
        low, high = axis.get_view_interval()
        decades = log10(high / low) if 0 < low < high else 1.0
        if decades < 1:
            axis.set_major_locator(AutoLocator())
        else:
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 2.5 else (1.0,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
        axis.set_minor_formatter(NullFormatter())


STYLE = """
:root { --paper: #fff; --ink: #222; --soft: #555; --faint: #ddd;
        --cover: linear-gradient(to left, #fff 1rem, transparent);
        --cast: linear-gradient(to left, #0003, transparent); }
@media screen and (prefers-color-scheme: dark) {
  :root { --paper: #16181c; --ink: #e3e5e8; --soft: #a4a9b0; --faint: #3a3e45;
          --cover: linear-gradient(to left, #16181c 1rem, transparent);
          --cast: linear-gradient(to left, #fff3, transparent); } }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 90rem; padding: 0 1rem;
       color: var(--ink); background: var(--paper); }
h1 { font-size: 1.5rem; overflow-wrap: anywhere; } h2 { font-size: 1.15rem; margin-top: 2rem; }
p, figure { max-width: 62rem; }
/* A table wider than the page scrolls under its first column; a shade at its edge says so. */
.scroll { overflow-x: auto; background: var(--cover) right / 3rem 100% no-repeat local,
                                           var(--cast) right / 1rem 100% no-repeat scroll; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 0.9rem; }
th, td { padding: 0.25rem 0.55rem; text-align: right; border-bottom: 1px solid var(--faint); }
th { vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; white-space: nowrap; }
th:first-child, td:first-child { position: sticky; left: 0; background: var(--paper); }
@media (max-width: 60rem) {
  td:first-child { white-space: normal; min-width: 8rem; overflow-wrap: anywhere; } }
th.prose, td.prose { text-align: left; min-width: 10rem; }
@media print { .scroll { overflow: visible; } table { font-size: 0.65rem; } }
tr.mean td { font-weight: 600; border-top: 2px solid var(--soft); }
figure { margin: 1rem 0; overflow-x: auto; }
img { max-width: 100%; min-width: 38rem; height: auto; background: #fff; } /* smaller, its texts
  could not be read */
figcaption, .note { color: var(--soft); font-size: 0.9rem; }
"""


def paragraph(text: str) -> str:
    """A remark."""
    return f'<p class="note">{html.escape(text)}</p>'


def heading(text: str) -> str:
    """A section's heading."""
    return f"<h2>{html.escape(text)}</h2>"


def picture(data: bytes, caption: str, width_in: float | None = None) -> str:
    """A PNG inside the page, `width_in` inches wide where the page is, so that the texts of all
    pictures have one size."""
    code = base64.b64encode(data).decode("ascii")
    text = html.escape(caption)
    wide = "" if width_in is None else f' width="{96 * width_in:.0f}"'
    return (
        f'<figure><img{wide} alt="{text}" src="data:image/png;base64,{code}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


def is_prose(text: str) -> bool:
    """Whether a cell has text: two words or more, of which the first is no figure."""
    words = text.split()
    return len(words) > 1 and not any(c.isdigit() for c in words[0]) and words[0] not in "-±"


def table(
    header: Sequence[str], rows: Sequence[Sequence[str]], emphasised: Sequence[int] = ()
) -> str:
    """A table of texts; rows listed in `emphasised` are highlighted. Figures are aligned to the
    right, text to the left."""

    prose = {i for row in rows for i, cell in enumerate(row) if is_prose(cell)}

    def line(cells: Sequence[str], tag: str) -> str:
        words = prose if tag == "th" else {i for i, cell in enumerate(cells) if is_prose(cell)}
        kinds = [" class=prose" if i in words else "" for i in range(len(cells))]
        return "".join(
            f"<{tag}{kind}>{html.escape(cell)}</{tag}>"
            for cell, kind in zip(cells, kinds, strict=True)
        )

    body = "".join(
        f"<tr{' class=mean' if i in emphasised else ''}>{line(row, 'td')}</tr>\n"
        for i, row in enumerate(rows)
    )
    return (
        f'<div class="scroll"><table><thead><tr>{line(header, "th")}</tr></thead>\n'
        f"<tbody>{body}</tbody></table></div>"
    )


def page(title: str, parts: Sequence[str], style: str = "") -> str:
    """A whole HTML document: style and pictures inside, nothing fetched from anywhere.

    style: more of it, for this page alone.
    """
    safe = html.escape(title)
    content = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light dark">'
        f"<title>{safe}</title>\n<style>{STYLE}{style}</style></head>\n"
        f"<body>\n<h1>{safe}</h1>\n{content}\n</body>\n</html>\n"
    )


def svg(figure: Figure, name: str, label: str) -> str:
    """The figure as an element of HTML: sharp on every screen and on paper, in the page's colours.

    name: begins its identifiers, and is like no other figure's of the page. label: what it shows,
    for those who do not see it.
    """
    from matplotlib import rc_context

    buffer = io.StringIO()
    none = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    with rc_context({"svg.hashsalt": name, "svg.fonttype": "path", "path.simplify": True}):
        figure.savefig(buffer, format="svg", transparent=True, metadata=none)
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    used = set(_USED.findall(text))
    text = re.sub(r' id="([^"]+)"', lambda m: f' id="{name}-{m[1]}"' if m[1] in used else "", text)
    text = re.sub(r'(href="#|url\(#)', rf"\1{name}-", text).replace("xlink:href", "href")
    text = text.replace(INK, "currentColor").replace(GRID, "var(--faint)")
    text = re.sub(r"<path(?![^>]*\sd=)", '<path d=""', text)  # a space draws nothing
    # Groups that draw nothing, comments, and what XML alone needs.
    text = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>", "", text, flags=re.S)
    text = re.sub(r' xmlns(?::\w+)?="[^"]*"', "", text)
    width, height = (float(each) for each in re.findall(r'viewBox="0 0 (\S+) (\S+)"', text)[0])
    head = (
        f'<svg class="figure" role="img" aria-label="{html.escape(label)}" '
        f'viewBox="0 0 {width:g} {height:g}" width="{width / POINTS_A_PIXEL:.0f}" '
        f'height="{height / POINTS_A_PIXEL:.0f}">'
    )
    return head + re.sub(r"^<svg[^>]*>", "", text).strip()
