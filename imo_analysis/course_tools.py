"""What the lessons in ``course/`` share: checks, predictions, formulas from the definitions, figures that can be varied.

A lesson is a script, a test and a notebook. As a script it prints and draws nothing; in a notebook formulas are typeset and
figures shown, with sliders where ipywidgets is installed. ``IMO_STATIC`` in the environment asks for figures without sliders.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from imo_analysis.derivation_tools import in_notebook
from imo_analysis.errors import InputError
from imo_analysis.exercises.exercise import judge

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imo_analysis.ledger.expression import Expr


def check(identifier: str, answer: Any) -> None:
    """Say whether an answer to an exercise is right; with ``...`` that there is none yet. Never fails a notebook.

    Parameters
    ----------
    identifier : str
        Such as ``"3.2"``.
    answer : object
        A number in SI units, text with a unit, a formula as text or sympy expression, a letter, ...: as the exercise asks.
    """
    print(judge(identifier, answer).text)


def expected(guess: Any, value: float, unit: str = "") -> None:
    """Lay a prediction beside what came out; a count (an int) is right or not. Without a prediction say what came out.

    Parameters
    ----------
    guess : float or ...
        The reader's; ``...`` where there is none.
    value : float
        What came out.
    unit : str
        Its unit, for the text.
    """
    found = f"{value:.4g} {unit}".rstrip()
    if guess is Ellipsis:
        print(f"it is {found}; you made no prediction")
        return
    try:
        share = abs(float(guess) - value) / abs(value) if value else abs(float(guess))
    except (TypeError, ValueError):
        print(f"it is {found}; you wrote {guess!r}")
        return
    if isinstance(value, int):
        words = "well seen" if share == 0 else "not so: stop and find out why"
    else:
        words = "well seen" if share <= 0.1 else "the right order" if share <= 1 else "far off: stop and find out why"
    print(f"it is {found}; you expected {float(guess):.4g} {unit}".rstrip() + f": {words}")


def rows(left: Iterable[str], right: Iterable[Any]) -> None:
    """Show formulas, ``left = right``, as the definitions give them when they are fed names.

    Parameters
    ----------
    left : iterable of str
        Names; ``i_ds_dot`` is typeset with its dot.
    right : iterable of Expr
        What a definition of `imo_analysis.equations` returns for `ledger.expression.names`.
    """
    from imo_analysis.ledger.expression import as_expr
    from imo_analysis.ledger.latex import name_latex, to_latex

    pairs = [(name, plain(as_expr(tree))) for name, tree in zip(left, right, strict=True)]
    if in_notebook():
        lines = (rf"{name_latex(name)} &= {to_latex(tree)}" for name, tree in pairs)
        _display("Math", r"\begin{aligned}" + r" \\ ".join(lines) + r"\end{aligned}")
    else:
        for name, tree in pairs:
            print(f"    {name} = {tree}")


def plain(tree: Expr) -> Expr:
    """The same formula with ``a + (-b)`` written ``a - b`` and factors 1 left out."""
    from imo_analysis.ledger.expression import Number, Op

    if not isinstance(tree, Op) or tree.kind == "**":
        return tree
    args = tuple(plain(one) for one in tree.args)
    if tree.kind == "*" and (ones := [one for one in args if isinstance(one, Number) and one.value == 1]):
        return next((one for one in args if one not in ones), ones[0])
    if tree.kind == "+" and (positive := _without_minus(args[1])) is not None:
        return Op("-", (args[0], positive))
    return Op(tree.kind, args)


def _without_minus(tree: Expr) -> Expr | None:
    """What a product or quotient that begins with a minus is the negative of."""
    from imo_analysis.ledger.expression import Op

    if not isinstance(tree, Op):
        return None
    if tree.kind == "neg":
        return tree.args[0]
    inner = _without_minus(tree.args[0]) if tree.kind in "*/" else None
    return None if inner is None else Op(tree.kind, (inner, *tree.args[1:]))


def entry(identifier: str) -> None:
    """Show an entry of the ledger: what is printed, what is right, and the verdict by two kernels.

    Parameters
    ----------
    identifier : str
        Such as ``eq12.i_qs``; `imo derive` lists them.

    Raises
    ------
    InputError
        If there is no entry of that id.
    """
    from imo_analysis.ledger.book import claims, entries
    from imo_analysis.ledger.show import full

    wanted = [one for one in claims() if one.id == identifier]
    if not wanted:
        raise InputError(f"entry {identifier!r} is not in the ledger; imo derive lists them")
    print(full(entries(("flint", "sympy"), wanted)[0], 100))


def picture(figure: Figure, caption: str) -> None:
    """Show a figure as SVG in a notebook; a script says only that there is one.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    caption : str
        What it shows, printed above it: notebooks and their converters take no other text for readers who do not see it.
    """
    if in_notebook():
        from imo_analysis.drawing import svg_text

        print(f"figure: {caption}")
        _display("SVG", svg_text(figure))
    else:
        print(f"    (a figure with {len(figure.axes)} axes: {caption})")


def vary(draw: Callable[..., Figure], **ranges: Sequence[float]) -> None:
    """Show a figure whose parameters can be varied; returns nothing, since a notebook would show a returned widget again.

    Parameters
    ----------
    draw : callable
        Returns a figure. Its defaults are what is shown first; its docstring, with the values, is the figure's caption.
    **ranges : (lowest, highest, step)
        For each parameter that gets a slider. Where ipywidgets is missing, call ``draw`` again with other values.

    Raises
    ------
    InputError
        If a range is for no parameter of ``draw``, or for one without a default.
    """
    defaults = {name: one.default for name, one in inspect.signature(draw).parameters.items()}
    for name in ranges:
        if defaults.get(name, inspect.Parameter.empty) is inspect.Parameter.empty:
            raise InputError(f"vary: {name!r} must be a parameter of the drawing function with a default")
    about = (inspect.getdoc(draw) or draw.__name__).partition("\n")[0].rstrip(".")

    def show(**values: float) -> None:
        picture(draw(**values), f"{about}; " + ", ".join(f"{name} = {value:g}" for name, value in values.items()))

    widgets = _widgets()
    if widgets is None:
        show(**{name: defaults[name] for name in ranges})
        print("to vary it: " + ", ".join(f"{name} from {low:g} to {high:g}" for name, (low, high, _) in ranges.items()))
        return
    sliders = {
        name: widgets.FloatSlider(value=defaults[name], min=low, max=high, step=step, description=name, continuous_update=False)
        for name, (low, high, step) in ranges.items()
    }
    _display("display", widgets.interactive(show, **sliders))


def _widgets() -> Any:
    """The module ipywidgets where sliders can be shown."""
    if not in_notebook() or os.environ.get("IMO_STATIC"):
        return None
    try:
        import ipywidgets
    except ImportError:
        return None
    return ipywidgets


def _display(kind: str, value: Any) -> None:
    from IPython import display

    display.display(value if kind == "display" else getattr(display, kind)(value))
