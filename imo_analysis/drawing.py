"""How every figure of the project looks: size, fonts, colours and line styles that survive grey scale, and stable SVG.

Functions that draw take data and return a `matplotlib.figure.Figure`; they use these helpers and no pyplot state.
"""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True)
class Line:
    """A colour of Okabe and Ito's palette with a line style and a marker of its own, so that no reader needs the colour."""

    color: str
    linestyle: Any
    marker: str

    def kwargs(self) -> dict[str, Any]:
        """Keyword arguments for ``Axes.plot``."""
        return {"color": self.color, "linestyle": self.linestyle}


LINES = (
    Line("#0072B2", "-", "o"),
    Line("#D55E00", "--", "s"),
    Line("#009E73", "-.", "^"),
    Line("#CC79A7", ":", "D"),
    Line("#56B4E9", (0, (5, 1, 1, 1, 1, 1)), "v"),
    Line("#E69F00", (0, (7, 3)), "P"),
)
TRUTH = Line("#1a1a1a", "-", "x")
LIMIT = Line("#7a7a7a", (0, (2, 2)), "_")

# An observer keeps its colour and line style in every figure.
_OBSERVER_LINES = {
    "baseline": LINES[1],
    "baseline_scheduled": LINES[4],
    "consistent_12": LINES[0],
    "repaired": LINES[2],
    "printed_7": LINES[3],
    "printed_L": LINES[5],
    "supervised": LINES[1],
}

_RC: Any = {
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#d9d9d9",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.5,
    "legend.fontsize": 8.0,
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "#cccccc",
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "mathtext.fontset": "stix",
    "svg.hashsalt": "imo_analysis",
    "svg.fonttype": "path",
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "figure.dpi": 100.0,
    "savefig.facecolor": "white",
    "figure.facecolor": "white",
}


@contextmanager
def style() -> Iterator[None]:
    """The project's settings for the length of a block; the user's own are put back afterwards."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def in_style(draw: Callable[P, T]) -> Callable[P, T]:
    """Decorator: the project's settings hold while the function draws."""

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> T:
        with style():
            return draw(*args, **kwargs)

    return drawn


def line(name_or_number: str | int) -> Line:
    """The line of an observer by name (also ``luenberger_...``), or of a series by its number."""
    if isinstance(name_or_number, int):
        return LINES[name_or_number % len(LINES)]
    if name_or_number in ("true", "plant", "reference"):
        return TRUTH if name_or_number != "reference" else LIMIT
    known = _OBSERVER_LINES.get(name_or_number.removeprefix("luenberger_"))
    return known or LINES[sum(map(ord, name_or_number)) % len(LINES)]


def new_figure(
    rows: int = 1, columns: int = 1, *, width: float = 7.2, height: float = 3.0, **kwargs: Any
) -> tuple[Figure, Any]:
    """A figure in the project's style and its axes.

    Parameters
    ----------
    rows, columns : int
        Axes.
    width, height : float
        Size of the whole figure in inches.
    **kwargs
        Passed to ``Figure.subplots``: ``sharex``, ``gridspec_kw``, ...

    Returns
    -------
    matplotlib.figure.Figure
    matplotlib.axes.Axes or array of them
        As ``Figure.subplots`` gives them.
    """
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(width, height), layout="constrained")
        return figure, figure.subplots(rows, columns, **kwargs)


def legend_above(axes: Axes, **kwargs: Any) -> None:
    """A legend above the axes, where it covers no data."""
    columns = kwargs.pop("ncols", 4)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False, borderaxespad=0.2, **kwargs)


def svg_text(figure: Figure) -> str:
    """The figure as SVG text, the same bytes for the same data: no date, a fixed salt for the ids."""
    buffer = io.StringIO()
    with style():
        engine = figure.get_layout_engine()
        if engine is not None:  # laid out here once: savefig would draw the whole figure for it, and then again
            engine.execute(figure)
            figure.set_layout_engine("none")
        figure.savefig(buffer, format="svg", dpi=130, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return _PATH.sub(lambda path: _LONG.sub(_short, path[0]), buffer.getvalue())


# A hundredth of a point is finer than any screen or printer, and a third of the file's size.
_PATH = re.compile(r'\bd="[^"]*"')
_LONG = re.compile(r"-?\d+\.\d{3,}")


def _short(number: re.Match[str]) -> str:
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def rasterized(figure: Figure) -> Figure:
    """The same figure with its line collections as one picture each: hundreds of coloured pieces make an SVG of megabytes."""
    for axes in figure.axes:
        for collection in axes.collections:
            collection.set_rasterized(True)
    return figure


def save_svg(figure: Figure, path: str | Path) -> None:
    """Write the figure as SVG, whole or not at all.

    Raises
    ------
    InputError
        If the place cannot be written to.
    """
    from imo_analysis.files import write_text

    write_text(path, svg_text(figure))
