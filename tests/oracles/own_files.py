"""Observers in files of their own: one that the catalogue does not have, and copies of those that it has."""

import inspect
from pathlib import Path

from imo_analysis.equations.catalogue import OBSERVERS

HEAD = """from imo_analysis.equations.baseline import baseline
from imo_analysis.equations.catalogue import Observer


def flux(x, i, beta):
    return x[2], x[3]


def rates(x, i, u, direction, p, gains):
"""
TAIL = """

OBSERVER = Observer(name="mine", rates=rates, flux=flux, source="a test", meaning="the baseline with R_s adapted",
                    states=("i_ds_hat", "i_qs_hat", "phi_dr_hat", "phi_qr_hat", "omega_hat", "R_s_shift"),
                    gains=("l_1", "l_2", "l_3", "l_4", "h", "h_R"), units={"R_s_shift": "ohm", "h_R": "ohm/(A^2 s)"})
"""
ADAPTED = """    R_s, L_m, sigma, beta, alpha = p
    along = (i[0] - x[0]) * x[0] + (i[1] - x[1]) * x[1]
    adapted = baseline(x[:5], i, u, direction, (R_s + x[5], L_m, sigma, beta, alpha), gains[:5])
    return (*adapted, -gains[5] * along)
"""
GAINS = {"l_1": 161.8, "l_2": 0.0, "l_3": 0.020431, "l_4": 0.0, "h": 100.0, "h_R": 0.03}


def own_text(body: str = ADAPTED, head: str = HEAD, tail: str = TAIL) -> str:
    """The text of the file, whose function of rates has this body."""
    return head + body + tail


def copy_of(kind: str, name: str) -> str:
    """An observer of the catalogue as the text of a file: the module that defines its rates, and its entry."""
    observer = OBSERVERS[kind]
    text = Path(inspect.getsourcefile(observer.rates)).read_text(encoding="utf-8")
    returned = "x[2], x[3]" if kind == "baseline" else (
        "reconstructed_flux(i[0], i[1], x[2], x[3], x[4], x[5], x[6], x[7], beta)")
    return (f"{text}\nfrom imo_analysis.equations.catalogue import Observer\n"
            "from imo_analysis.equations.transformation import reconstructed_flux\n\n\n"
            f"def flux(x, i, beta):\n    return {returned}\n\n\n"
            f"OBSERVER = Observer({name!r}, {observer.rates.__name__}, {observer.states!r}, {observer.gains!r}, flux, "
            f"'a copy', '{kind} again', {observer.needs_direction})\n")
