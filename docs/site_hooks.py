"""What the site needs beside its pages: equations as MathML, and all decisions."""

import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert

EQUATION = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def on_config(config: Any) -> Any:
    """List every decision, in order; a new one needs no other place."""
    notes = sorted((Path(config.docs_dir) / "decisions").glob("*.md"))
    decisions = [f"decisions/{note.name}" for note in notes]
    background = next(entry for entry in config.nav if "Background" in entry)
    background["Background"][-1] = {"Decisions": decisions}
    return config


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Equations that a browser draws by itself; GitHub draws the same blocks."""
    return EQUATION.sub(_drawn, markdown)


def _drawn(equation: re.Match[str]) -> str:
    formula, _, number = equation[1].strip().partition(r"\tag{")
    drawn = convert(formula.strip(), display="block")
    # On a phone a long one is scrolled, not the page.
    return (
        '<div style="display:flex;align-items:center;margin:1em 0">'
        f'<div style="flex:1;overflow-x:auto;overflow-y:hidden">{drawn}</div>'
        f"<div>({number.rstrip('}')})</div></div>"
    )
