"""How every figure of the project looks: the house style, lines that survive grey scale, sizes, and stable SVG.

Functions that draw take data and return a `matplotlib.figure.Figure`; they use these helpers and no pyplot state. The settings
are in `house.mplstyle` beside this file; in a block ``with sized("slide")`` the same functions draw for a slide.
"""

from __future__ import annotations

import functools
import io
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, ParamSpec, TypeVar

from imo_analysis.svg import standalone, tidied

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


P = ParamSpec("P")
T = TypeVar("T")
Size = Literal["column", "slide"]


@dataclass(frozen=True)
class Line:
    """A colour with a line style and a marker of its own, so that no reader needs the colour."""

    color: str
    linestyle: Any
    marker: str

    def kwargs(self) -> dict[str, Any]:
        """Keyword arguments for ``Axes.plot``."""
        return {"color": self.color, "linestyle": self.linestyle}


_DASHES = ("-", (0, (5, 2)), (0, (6, 1.6, 1, 1.6)), (0, (1, 1.4)), (0, (5, 1, 1, 1, 1, 1)), (0, (10, 3)))
LINES = (
    Line("#0072B2", _DASHES[0], "o"),
    Line("#D55E00", _DASHES[1], "s"),
    Line("#00785A", _DASHES[2], "^"),
    Line("#CF4784", _DASHES[3], "D"),
    Line("#3D9BD0", _DASHES[4], "v"),
    Line("#6E2438", _DASHES[5], "P"),
    # From here on a line style comes back, much darker or lighter.
    Line("#2B2A6E", _DASHES[3], "X"),
    Line("#7F9400", _DASHES[5], "<"),
    Line("#4B1D8F", _DASHES[1], ">"),
    Line("#5A2A00", _DASHES[0], "p"),
    Line("#3F4A1A", _DASHES[4], "h"),
    Line("#3A0F2E", _DASHES[2], "*"),
    Line("#C378D2", _DASHES[2], "d"),
    Line("#7830F0", _DASHES[5], "H"),
)
TRUTH = Line("#1a1a1a", "-", "x")
LIMIT = Line("#6f6f6f", (0, (2, 2)), "_")

# A kind of observer keeps its colour and line style in every figure.
OBSERVER_LINES = dict(zip(
    ("consistent_12", "baseline", "repaired", "printed_7", "baseline_scheduled", "printed_L", "quiet", "across", "supervised",
     "luenberger_consistent_12", "luenberger_printed_7", "luenberger_printed_L", "baseline_resistance",
     "baseline_turned"), LINES, strict=True))

_SHEETS = {"column": ("house.mplstyle",), "slide": ("house.mplstyle", "house-slide.mplstyle")}
_SLIDE = (10.0, 5.625)  # inches, 16 to 9
_size: ContextVar[Size] = ContextVar("size", default="column")
_named: ContextVar[Mapping[str, Line] | None] = ContextVar("named", default=None)


@functools.lru_cache(maxsize=2)
def settings(size: Size = "column") -> Any:
    """The settings of the house style as matplotlib knows them."""
    import matplotlib as mpl

    chosen = mpl.RcParams()
    for sheet in _SHEETS[size]:
        chosen.update(mpl.rc_params_from_file(Path(__file__).with_name(sheet), use_default_template=False))
    return chosen


@contextmanager
def style() -> Iterator[None]:
    """The project's settings for the length of a block; the user's own are put back afterwards."""
    import matplotlib as mpl

    with mpl.rc_context(settings(_size.get())):
        yield


@contextmanager
def sized(size: Size) -> Iterator[None]:
    """Figures that are made and written in the block are for a page ``column`` (as anywhere else) or for a ``slide``.

    Parameters
    ----------
    size : str
        ``column`` or ``slide``.
    """
    before = _size.set(size)
    try:
        yield
    finally:
        _size.reset(before)


def points(size: float) -> float:
    """Points that stand for so many on a page column, for letters smaller than the rest or a space beside them."""
    return size * float(settings(_size.get())["font.size"] / settings()["font.size"])


def in_style(draw: Callable[P, T]) -> Callable[P, T]:
    """Decorator: the project's settings hold while the function draws.

    Parameters
    ----------
    draw : callable
        It may take and return anything.
    """

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> T:
        with style():
            return draw(*args, **kwargs)

    return drawn


def line(name_or_number: str | int) -> Line:
    """The line of an observer by name, or of a series by its number.

    The name is one that `named` gave a line, or that of a kind of observer; of any other it is some line, always the same.

    Parameters
    ----------
    name_or_number : str or int
        ``true``, ``plant`` and ``reference`` have lines of their own.
    """
    if isinstance(name_or_number, int):
        return LINES[name_or_number % len(LINES)]
    if name_or_number in ("true", "plant", "reference"):
        return TRUTH if name_or_number != "reference" else LIMIT
    known = (_named.get() or {}).get(name_or_number) or OBSERVER_LINES.get(name_or_number)
    return known or LINES[sum(map(ord, name_or_number)) % len(LINES)]


@contextmanager
def named(kinds: Mapping[str, str]) -> Iterator[None]:
    """Give each observer of a study a line of its own for the length of a block.

    Parameters
    ----------
    kinds : mapping of str to str
        Kind by name. The first of a kind has the kind's line, another the first line that is free.
    """
    lines: dict[str, Line] = {}
    for name, kind in sorted(kinds.items(), key=lambda one: one[0] != one[1]):  # an observer called as its kind goes first
        wanted = OBSERVER_LINES.get(kind)
        if wanted is not None and wanted not in lines.values():
            lines[name] = wanted
    for name in kinds:
        if name not in lines:
            lines[name] = next((one for one in LINES if one not in lines.values()), LINES[len(lines) % len(LINES)])
    before = _named.set(lines)
    try:
        yield
    finally:
        _named.reset(before)


def new_figure(
    rows: int = 1, columns: int = 1, *, width: float = 7.2, height: float = 3.0, **kwargs: Any
) -> tuple[Figure, Any]:
    """A figure in the project's style and its axes.

    Parameters
    ----------
    rows, columns : int
        Axes.
    width, height : float
        Size of the whole figure in inches, as of a page column; on a slide it is as wide as the slide, and at most as high.
    **kwargs
        Passed to ``Figure.subplots``: ``sharex``, ``gridspec_kw``, ...

    Returns
    -------
    matplotlib.figure.Figure
    matplotlib.axes.Axes or array of them
        As ``Figure.subplots`` gives them.
    """
    from matplotlib.figure import Figure

    if _size.get() == "slide":
        width, height = _SLIDE[0], min(_SLIDE[1], height * _SLIDE[0] / width)
    with style():
        figure = Figure(figsize=(width, height), layout="constrained")
        return figure, figure.subplots(rows, columns, **kwargs)


def legend_above(axes: Axes, **kwargs: Any) -> None:
    """A legend above the axes, where it covers no data.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Whose lines are named.
    kwargs : Any
        More for `matplotlib.axes.Axes.legend`; four columns unless ``ncols`` says otherwise.
    """
    columns = kwargs.pop("ncols", 4)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False, borderaxespad=0.2, **kwargs)


def svg_text(figure: Figure) -> str:
    """The figure as SVG text, the same bytes for the same data: no date, a fixed salt for the ids; a page brings its font.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What is drawn.
    """
    buffer = io.StringIO()
    with style():
        engine = figure.get_layout_engine()
        if engine is not None:  # laid out here once: savefig would draw the whole figure for it, and then again
            engine.execute(figure)
            figure.set_layout_engine("none")
        figure.savefig(buffer, format="svg", dpi=130, metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return tidied(buffer.getvalue())


def rasterized(figure: Figure) -> Figure:
    """The same figure with its line collections as one picture each: hundreds of coloured pieces make an SVG of megabytes."""
    for axes in figure.axes:
        for panel in (axes, *axes.child_axes):
            for collection in panel.collections:
                collection.set_rasterized(True)
    return figure


def save_svg(figure: Figure, path: str | Path) -> None:
    """Write the figure as SVG with its letters inside, whole or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What is drawn.
    path : str or pathlib.Path
        Ends in .svg.

    Raises
    ------
    InputError
        If the place cannot be written to.
    """
    from imo_analysis.files import write_text

    write_text(path, standalone(svg_text(figure)))
