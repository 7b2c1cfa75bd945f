"""What others have published on what the currents tell of a sensorless machine, beside what is computed here.

A statement counts where it can be put as a condition: on steady states, the surfaces on which unknowns are lost; or on a family
of motions, whether unknowns are told apart there. `compare` decides by exact ranks whether it is what
`imo_analysis.excitation.observability` finds. ``read`` says what a statement was checked against; works of which no statement
could be checked are only named, in `CITED`.
"""

from __future__ import annotations

from dataclasses import dataclass

from imo_analysis.excitation.observability import FAMILIES, Problem, rank_table, steady_conditions


@dataclass(frozen=True)
class Published:
    """A published statement that is put as a condition.

    Attributes
    ----------
    source : str
        Authors, place, year and identifier.
    says : str
        What it states, in our words.
    read : str
        What this was checked against.
    ours : str
        What stands here instead, with the claim that proves it.
    problem : Problem
        The unknowns.
    surface : tuple of str
        In steady states the unknowns are lost where one of these is zero; empty, with no ``motions``: nowhere.
    motions : tuple of str
        Names of `FAMILIES` of which the statement speaks, where it is none on the surfaces of steady states.
    told : bool
        Whether the unknowns are told apart on all of ``motions``; otherwise they are lost on one at least.
    """

    source: str
    says: str
    read: str
    ours: str
    problem: Problem
    surface: tuple[str, ...] = ()
    motions: tuple[str, ...] = ()
    told: bool = True


ABSTRACT = "abstract"
QUOTED = "as quoted in the documentation of motulator"
SAME, IMPLIED, DIFFERENT = "the same", "implied", "different"
_GENERAL = ("general motion",)
_STEADY = tuple(family.name for family in FAMILIES if family.steady and family.fixed != "psi")
_PARTED = "they are lost in every steady state; a flux magnitude that moves parts them at once (excitation.parting)"

PUBLISHED = (
    Published(
        "P. Combes, F. Malrait, P. Martin, P. Rouchon, arXiv:1511.09349, 2015",
        "without signal injection the machine is not observable while the stator frequency is zero, also with saturation",
        ABSTRACT,
        "at constant flux the line is torque = -(3 n_p flux^2 / (2 R_r)) omega (excitation.slip); on it the current knows "
        "neither omega nor alpha (excitation.standstill); without saturation", Problem(("omega", "T_l")), ("omega + slip",)),
    Published(
        "S. Ibarra-Rojas, J. Moreno, G. Espinosa-Perez, Automatica 40(6), 2004, doi 10.1016/j.automatica.2004.01.020",
        "some motions cannot be told apart whatever the parameters, so that no observer converges along every motion", ABSTRACT,
        "in steady state it is the line alone; at constant speed such motions are even circles and lines of the flux "
        "(excitation.circle)", Problem(("omega", "T_l")), motions=_STEADY, told=False),
    Published(
        "M. Hinkkanen, L. Harnefors, J. Luomi, IEEE Trans. Power Electron., 2010, doi 10.1109/TPEL.2009.2039650",
        "the two poles of the sensorless flux observer multiply to the square of the stator frequency, whatever damping is "
        "chosen: one is zero exactly where that frequency is", QUOTED,
        "a line at zero frequency leaves no trace in the current, H(0) = 0 (excitation.response): the pole is no fault of the "
        "observer's", Problem(("omega",), mechanical=False), ("omega + slip",)),
    Published(
        "G. C. Verghese, S. R. Sanders, IEEE Trans. Ind. Electron. 35(1), 1988",
        "with the speed measured the pole of a flux observer can be placed at will, at any speed and stator frequency", QUOTED,
        "the flux alone is lost in no steady state", Problem((), mechanical=False)),
    Published(
        "M. Li, J. Chiasson, M. Bodson, L. M. Tolbert, Identification of the rotor time constant in induction machines without "
        "speed sensor",
        "without a speed sensor the rotor time constant is the root of a polynomial in voltages, currents and their "
        "derivatives", ABSTRACT, _PARTED, Problem(("omega", "alpha", "T_l")), motions=_GENERAL),
    Published(
        "M. Montanari, S. Peresada, A. Tilli, A. Tonielli, Speed sensorless control of induction motor based on indirect "
        "field-orientation",
        "speed and rotor resistance are estimated together", ABSTRACT, _PARTED, Problem(("omega", "alpha")), motions=_GENERAL),
    Published(
        "D. Traoré, J. de León, A. Glumineau, Automatica 48, 2012, pages 682 to 687",
        "speed, load torque and stator resistance are estimated together", ABSTRACT,
        "in steady state not without load, nor at zero stator frequency: the conditions above",
        Problem(("omega", "R_s", "T_l")), motions=_GENERAL),
    Published(
        "M. Comanescu, Design and implementation of a MRAS sliding mode observer for the inverse of the rotor time constant of "
        "the induction motor",
        "with speed and flux given, the error of the rotor time constant grows with the ratio of flux to torque current; put "
        "here as its limit, lost where the torque current is zero", ABSTRACT,
        "where the flux is not given, at zero stator frequency too (excitation.standstill)",
        Problem(("alpha",), mechanical=False), ("slip",)),
)

# Nothing that could be put as a condition was found in an abstract, or not even that could be read.
CITED = (
    "H. Kubota, K. Matsuse, IEEE Trans. Ind. Appl. 30(5), 1994, the paper's reference 5",
    "C. Canudas de Wit, A. Youssef, J. P. Barbot, P. Martin, F. Malrait, IEEE CDC 2000, doi 10.1109/CDC.2000.914093",
    "J. Holtz, J. Quan, IEEE Trans. Ind. Appl. 38(4), 2002",
    "J. Holtz, IEEE Trans. Ind. Electron. 53(1), 2006, doi 10.1109/TIE.2005.862324",
    "M. Ghanes, J. de Leon, A. Glumineau, IEEE CDC 2006, doi 10.1109/CDC.2006.376711",
    "P. Vaclavek, P. Blaha, I. Herman, IEEE Trans. Ind. Electron. 60(8), 2013",
    "M. Koteich, doctoral thesis, Université Paris-Saclay, 2016, HAL tel-01320377",
)


def compare(one: Published) -> str:
    """Whether the condition as published is `SAME` as the one found here, `IMPLIED` by it, or `DIFFERENT`.

    Implied is a loss that is found here, beside others that the statement does not name.
    """
    if one.motions:
        row = next(row for row in rank_table(one.problem.mechanical) if row.problem == one.problem)
        lost = [row.ranks[name] < row.size for name in one.motions]
        if one.told:
            return DIFFERENT if any(lost) else SAME
        return SAME if all(lost) else IMPLIED if any(lost) else DIFFERENT
    rank, factors = steady_conditions(one.problem)
    found, said = {str(factor) for factor in factors}, set(one.surface)
    if rank < len(one.problem.columns):  # lost in every steady state
        return DIFFERENT
    return SAME if said == found else IMPLIED if said and said < found else DIFFERENT
