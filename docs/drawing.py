"""SVG pictures that are right in light and dark, and say what they show."""

from collections.abc import Iterable
from html import escape

import numpy as np
from jaxtyping import Float

STYLE = """
.card { fill: #ffffff; stroke: #d0d7de }
text { font: 20px system-ui, sans-serif; fill: #1f2328 }
.small { font-size: 18px }
.right { text-anchor: end } .middle { text-anchor: middle }
.grid { stroke: #d0d7de; fill: none }
.seen { stroke: #57606a; fill: none } .face { fill: #57606a; fill-opacity: .13 }
.found { stroke: #0a7d33; fill: none } .dot { fill: #0a7d33 }
.cad { stroke: #cf222e; fill: none; stroke-dasharray: 7 4 }
.true { stroke: #1f2328; fill: none }
text.found { fill: #0a7d33; stroke: none } text.cad { fill: #cf222e; stroke: none }
@media (prefers-color-scheme: dark) {
.card { fill: #0d1117; stroke: #30363d } .grid { stroke: #30363d }
text { fill: #e6edf3 } .true { stroke: #e6edf3 }
.seen { stroke: #9aa4af } .face { fill: #9aa4af }
.found { stroke: #3fb950 } .dot, text.found { fill: #3fb950 }
.cad { stroke: #ff7b72 } text.cad { fill: #ff7b72 }
}
"""
"""Contrasts of text are above 4.5 to 1, on both cards."""

WIDTH = 760


def picture(height: float, title: str, about: str, parts: Iterable[str]) -> str:
    """An SVG that is right in light and dark, and says what it shows."""
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:g}" '
            'role="img" aria-labelledby="title about">',
            f'<title id="title">{escape(title)}</title>',
            f'<desc id="about">{escape(about)}</desc>',
            f"<style>{STYLE}</style>",
            f'<rect class="card" x="0.5" y="0.5" width="{WIDTH - 1}" '
            f'height="{height - 1:g}" rx="8"/>',
            *parts,
            "</svg>\n",
        ]
    )


def words(x: float, y: float, text: str, kind: str = "") -> str:
    """Text at a place."""
    return f'<text x="{x:g}" y="{y:g}" class="{kind}">{escape(text)}</text>'


def line(points: Float[np.ndarray, "n 2"], kind: str, width: float = 1.0) -> str:
    """A line through points."""
    return f'<path d="{path(points)}" class="{kind}" stroke-width="{width:g}"/>'


def path(points: Float[np.ndarray, "n 2"]) -> str:
    """The points as an SVG path, to a tenth of a pixel."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
