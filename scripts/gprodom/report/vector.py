"""Figures as SVG inside a page: sharp on every screen and on paper, and in the page's colours."""

import html
import io
import re

from gprodom import canvas

# matplotlib's black is the page's ink, and the grid's grey the page's faint lines, light or dark.
INK, GRID = "#000000", "#e6e6e6"
POINTS_A_PIXEL = 0.75  # CSS has 96 pixels to the inch, SVG of matplotlib 72 points
_USED = re.compile(r'(?:xlink:href="#|href="#|url\(#)([^")]+)')


def inline(figure: canvas.Figure, name: str, label: str) -> str:
    """The figure as an element of HTML.

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
