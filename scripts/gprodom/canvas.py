"""One look for all pictures, and pages that fetch nothing."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gprodom.files import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRUTH_COLOUR = "0.55"
# Okabe and Ito's palette: told apart by colour-blind readers and in print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#F0E442")

# Told apart in grey, too; five and the eight colours come together again only after forty lines.
DASHES: tuple[Any, ...] = (
    "-",
    (0, (6, 2)),
    (0, (1.5, 1.5)),
    (0, (6, 2, 1.5, 2)),
    (0, (3, 1, 1, 1, 1, 1)),
)
MARKERS = ("o", "s", "^", "D", "v", "x", "P")


def line_style(i: int, count: int) -> dict[str, Any]:
    """Style of the i-th of `count` lines, for `Axes.plot`.

    Each has its own colour and dashes, and is thinner than the one before. So two equal lines lie
    on each other and can both be seen.
    """
    share = i / max(count - 1, 1)
    return {
        "color": COLOURS[i % len(COLOURS)],
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


def png(figure: Figure, dpi: int = 110) -> bytes:
    """The figure as PNG, without a creation date, so that equal data give equal files."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def save(figure: Figure, path: Path) -> bytes:
    """Writes the figure as PNG and returns its bytes."""
    data = png(figure)
    write_bytes(path, data)
    return data


STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 62rem; padding: 0 1rem;
       color: #222; background: #fff; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 0.9rem; }
th, td { padding: 0.25rem 0.7rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; white-space: nowrap; }
td.prose { text-align: left; }
tr.mean td { font-weight: 600; border-top: 2px solid #999; }
img { max-width: 100%; height: auto; } figure { margin: 1rem 0; }
figcaption, .note { color: #555; font-size: 0.9rem; }
"""


def paragraph(text: str) -> str:
    """A remark."""
    return f'<p class="note">{html.escape(text)}</p>'


def heading(text: str) -> str:
    """A section's heading."""
    return f"<h2>{html.escape(text)}</h2>"


def picture(data: bytes, caption: str) -> str:
    """A PNG inside the page."""
    code = base64.b64encode(data).decode("ascii")
    text = html.escape(caption)
    return (
        f'<figure><img alt="{text}" src="data:image/png;base64,{code}">'
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

    def line(cells: Sequence[str], tag: str) -> str:
        kinds = [" class=prose" if tag == "td" and is_prose(cell) else "" for cell in cells]
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


def page(title: str, parts: Sequence[str]) -> str:
    """A whole HTML document: style and pictures inside, nothing fetched from anywhere."""
    safe = html.escape(title)
    content = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{safe}</title>\n<style>{STYLE}</style></head>\n"
        f"<body>\n<h1>{safe}</h1>\n{content}\n</body>\n</html>\n"
    )
