"""What others have published on motions that hide the speed, beside what is computed here.

``read`` says what a statement was checked against: the text or abstract of the work itself, or nothing but its record ("cited
only": its title and identifier). A statement that can be put as a condition on a steady state carries the problem and the
surface; `compare` then decides whether it is the one that `imo_analysis.excitation.observability` finds.
"""

from __future__ import annotations

from dataclasses import dataclass

from imo_analysis.excitation.observability import Problem, steady_conditions


@dataclass(frozen=True)
class Published:
    """A published statement.

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
    problem : Problem, optional
        Unknowns for which the statement is a condition on steady states.
    surface : tuple of str
        The condition: where one of these is zero the unknowns are lost.
    """

    source: str
    says: str
    read: str
    ours: str
    problem: Problem | None = None
    surface: tuple[str, ...] = ()


ABSTRACT, TEXT, CITED = "abstract", "text", "cited only"
_LINE = ("at constant flux the line is torque = -(3 n_p flux^2 / (2 R_r)) omega (excitation.slip); on it the current knows "
         "neither omega nor alpha (excitation.standstill)")

PUBLISHED = (
    Published(
        "P. Combes, F. Malrait, P. Martin, P. Rouchon, arXiv:1511.09349, 2015",
        "without signal injection the machine is not observable while the stator frequency is zero, also with saturation",
        ABSTRACT, _LINE, Problem(("omega", "T_l")), ("omega + slip",)),
    Published(
        "S. Ibarra-Rojas, J. Moreno, G. Espinosa-Perez, Automatica 40(6), 2004, doi 10.1016/j.automatica.2004.01.020",
        "some motions cannot be told apart whatever the parameters, so that no observer converges along every motion", ABSTRACT,
        "such motions are the deficits of the tables above; at constant speed they are even circles and lines of the flux "
        "(excitation.circle)"),
    Published(
        "M. Hinkkanen and others, motulator, documentation of its flux observers",
        "the two poles of the sensorless flux observer multiply to the square of the stator frequency, whatever damping is "
        "chosen: one is zero exactly where that frequency is", TEXT,
        "a line at zero frequency leaves no trace in the current, H(0) = 0 (excitation.response): the pole is no fault of the "
        "observer's", Problem(("omega",), mechanical=False), ("omega + slip",)),
    Published(
        "J. Holtz, J. Quan, IEEE Trans. Ind. Appl. 38(4), 2002",
        "operation without a speed sensor is poor at very low speed, for errors of voltage and parameters", ABSTRACT,
        "even without such errors what a window T tells of the speed falls as the square of the stator frequency times "
        "T^3 / 12 towards the line (excitation.window)"),
    Published("C. Canudas de Wit, A. Youssef, J. P. Barbot, P. Martin, F. Malrait, IEEE CDC 2000, doi 10.1109/CDC.2000.914093",
              "observability at low frequencies", CITED, ""),
    Published("M. Ghanes, J. de Leon, A. Glumineau, IEEE CDC 2006, doi 10.1109/CDC.2006.376711",
              "an observability study of the sensorless machine", CITED, ""),
    Published("J. Holtz, IEEE Trans. Ind. Electron. 53(1), 2006, doi 10.1109/TIE.2005.862324",
              "sensorless control with and without signal injection", CITED, ""),
    Published("P. Vaclavek, P. Blaha, I. Herman, IEEE Trans. Ind. Electron. 60(8), 2013",
              "observability of AC drives", CITED, ""),
    Published("H. Kubota, K. Matsuse, IEEE Trans. Ind. Appl. 30(5), 1994, the paper's reference 5",
              "speed together with the rotor's resistance", CITED,
              "both are lost in every steady state; a swing of the flux tells them apart (excitation.parting)"),
)


def compare(one: Published) -> str:
    """Whether the condition as published is the one that is found here; empty where it is not put as a condition."""
    if one.problem is None:
        return ""
    _, factors = steady_conditions(one.problem)
    return "the same" if {str(factor) for factor in factors} == set(one.surface) else "different"
