"""Drawings by matplotlib, and how they are kept; the one import of matplotlib."""

from io import BytesIO, StringIO
from pathlib import Path

from orbident.extras import extra
from orbident.files.replacing import replacing
from orbident.files.text import write_text
from orbident.report.page import Picture

with extra("report", "drawing a figure"):
    from matplotlib import rc_context
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Axes", "Drawing", "kept"]


class Drawing(Figure):
    """A figure that belongs to no window; a notebook shows it."""

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png")
        return picture.getvalue()


def kept(drawing: Drawing, path: Path, title: str) -> Picture:
    """The drawing as a PNG and an SVG file, and for a report.

    Args:
        drawing: complete.
        path: of the files, without a suffix.
        title: of the picture in the report.

    Raises:
        InputError: nothing can be written there.
    """
    with replacing(path.with_suffix(".png")) as target:
        drawing.savefig(target, format="png", dpi=150)
    # Without a date and with a fixed salt the same data give the same file.
    svg = StringIO()
    with rc_context({"svg.hashsalt": path.name}):
        drawing.savefig(svg, format="svg", metadata={"Date": None})
    write_text(path.with_suffix(".svg"), svg.getvalue())
    return Picture(title, svg.getvalue())
