"""What Table II's 24 numbers fix and what they leave open: ours, in rational arithmetic, by `imo_analysis.pencils.table2_fit`.

Every check takes what it is about as an argument, so that it is also run on something that it must reject: a table that one of
the printed forms does give, another power of the speed, another resistance.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from imo_analysis.ledger.claim import Claim, Computed, Verdict
from imo_analysis.ledger.claims.transcript import WORDS

ITEM = "Printed poles (ours)"
CLOSE = Fraction(1, 100)  # of a range: as near to its ends quadratics that fit are shown


def cannot(source: str, form: str, made_by: str = "") -> tuple[bool, str]:
    """Whether a form that the paper prints can give neither column of Table II, or of a table made by a form of `MADE_BY`."""
    from imo_analysis.pencils.table2_proofs import refuted

    found = [one for one in refuted(_table(made_by) if made_by else None, source) if one.form.startswith(form)]
    proved = [one for one in found if one.proved]
    words = dict.fromkeys(f"{one.form}: {one.forced}" for one in (proved if len(proved) == len(found) else found))
    return bool(found) and len(proved) == len(found), f"{len(proved)} of {len(found)} contradictions; " + "; ".join(words)


# By form, real and imaginary part of the pairs' product with some gains, and what is added to R_s/sigma for a.
MADE_BY: dict[str, Any] = {
    "(7) expanded": (lambda w, rho, alpha: (50 * w * w, 50 * w * alpha), 300),
    "(7) as a matrix equation": (lambda w, rho, alpha: (alpha * rho + 50 * w * w, w * (50 * alpha - rho)), 300),
    "(8) expanded": (lambda w, rho, alpha: (100 * alpha, Fraction(-w)), 300),
    "(8) expanded, z feedback of (12)": (lambda w, rho, alpha: (100 * alpha + 50 * w * w, Fraction(0)), 300),
    "(8) as a matrix equation": (lambda w, rho, alpha: (100 * alpha + 50 * w * w, -w * rho), 300),
    "(12) with its printed signs": (lambda w, rho, alpha: (Fraction(40_000), -w * (rho + 300)), 300),
    "(2)-(3)": (lambda w, rho, alpha: (alpha * (rho + 160) + 80 * w, 80 * alpha - w * (rho + 160)), 460),
}


def _table(form: str) -> Any:
    from imo_analysis.pencils.table2_fit import SPEEDS, as_printed
    from imo_analysis.pencils.table2_proofs import ALPHAS, R_S, SIGMA

    product, more = MADE_BY[form]
    return as_printed(R_S / SIGMA + more, {omega: product(omega, R_S / SIGMA, ALPHAS["printed"]) for omega in SPEEDS})


def ranges_from(name: str, low: str, high: str) -> tuple[bool, str]:
    """Whether a constant of a fitting quadratic is never outside the range, and quadratics fit close to both its ends."""
    from imo_analysis.pencils.table2_constants import ranges

    found = next(one for one in ranges() if one.name == name)
    ends = Fraction(low), Fraction(high)
    slack = CLOSE * (ends[1] - ends[0])
    shown = (ends[0] <= found.outer.low and found.outer.high <= ends[1]
             and found.inner.low <= ends[0] + slack and found.inner.high >= ends[1] - slack)
    return shown, (f"never outside {float(found.outer.low):.9g} to {float(found.outer.high):.9g}; "
                   f"{float(found.inner.low):.9g} and {float(found.inner.high):.9g} fit")


def grows(column: str, power: int) -> tuple[bool, str]:
    """Whether the real part of the product can be b + d omega^power: the ratio of its two differences must be that power's."""
    from imo_analysis.pencils.table2_fit import SPEEDS, digits

    first, second, third = (digits(column).D_re[omega] for omega in SPEEDS)
    ratio = (third - second) / (second - first)
    low, middle, high = (omega**power for omega in SPEEDS)
    wanted = Fraction(high - middle, middle - low)
    return ratio.holds(wanted), f"the digits allow {ratio}, the power gives {float(wanted):.6g}"


def differ_by(d: int) -> tuple[bool, str]:
    """Whether b, c and d read off either column can be the same, and the products differ by d (omega^2 - omega)."""
    from imo_analysis.pencils.table2_answers import by_column
    from imo_analysis.pencils.table2_fit import COLUMNS, SPEEDS, digits

    one, other = (by_column()[column] for column in COLUMNS)
    same = all(one[name].meet(other[name]) is not None for name in ("b", "c", "d"))
    proposed, baseline = (digits(column).D_re for column in COLUMNS)
    gaps = {omega: proposed[omega] - baseline[omega] for omega in SPEEDS}
    shown = same and all(gap.holds(d * (omega * omega - omega)) for omega, gap in gaps.items())
    return shown, "; ".join(f"{gap} at {omega} rad/s" for omega, gap in gaps.items())


def not_the_rate(R_s: str) -> tuple[bool, str]:
    """Whether c is not R_s/sigma, with the leakage of Table III."""
    from imo_analysis.pencils.table2_constants import ranges
    from imo_analysis.pencils.table2_proofs import SIGMA

    c = next(one.outer for one in ranges() if one.name == "c")
    rate = Fraction(R_s) / SIGMA
    return not c.holds(rate), f"R_s/sigma = {float(rate):.6g} /s, and c is {c} /s"


def same_table(alphas: tuple[str, ...], gains_follow: bool) -> tuple[bool, str]:
    """Whether (8) as a matrix equation has the printed poles with each alpha, with gains of its own or those of the first."""
    from imo_analysis.pencils.table2_answers import machines_with_the_same_table
    from imo_analysis.pencils.table2_fit import WITNESS, mismatches
    from imo_analysis.pencils.table2_proofs import BETA, L_M

    machines_with_the_same_table()  # proves that a, b, c and d are what stands below, for every alpha
    a, b, c, d = WITNESS
    wrong, words = 0, []
    for text in alphas:
        alpha = Fraction(text)
        own = alpha if gains_follow else Fraction(alphas[0])
        k_1, k_3 = a - c - own * (1 + BETA * L_M), b / own - c
        wrong += len(mismatches(c + alpha * (1 + BETA * L_M) + k_1, alpha * (c + k_3), c, d))
        words.append(f"alpha = {text} /s with k_1 = {float(k_1):.5g}, k_3 = {float(k_3):.5g} /s")
    return not wrong, "; ".join(words)


def gains_at(column: str, speed: int) -> tuple[bool, str]:
    """Whether (2)-(3) has the column's poles with gains of each speed, or with those of one speed where that is not 0."""
    from imo_analysis.equations import parameters
    from imo_analysis.pencils.table2_answers import scheduled_baseline
    from imo_analysis.pencils.table2_fit import SPEEDS, WITNESS, scheduled
    from imo_analysis.pencils.table2_proofs import ALPHAS, BETA, L_M, R_S, SIGMA

    a, b, c, d = WITNESS
    alpha = ALPHAS["printed"]
    shown, words = True, []
    for omega in SPEEDS:
        l_1, _, l_3, l_4 = scheduled_baseline(column, speed or omega).values()
        x, y = R_S / SIGMA + l_1 + BETA * l_3, BETA * l_4
        shown &= (parameters.current_decay(R_S, L_M, SIGMA, alpha, BETA) + l_1 + alpha == a
                  and alpha * x + omega * y == b + d * scheduled(column, omega) and alpha * y - omega * x == -c * omega)
        words.append(f"l_3 = {float(l_3):.5g}, l_4 = {float(l_4):.5g} at {omega} rad/s")
    return shown, "; ".join(words)


def _form(source: str, form: str, made_by: str = "") -> Computed:
    return Computed("printed", f"{form}: neither column, for any real gains", cannot, exact=True, arguments=(source, form),
                    failing=(source, form, made_by or form))


def _claim(name: str, title: str, prose: str, *checks: Computed, note: str = "") -> Claim:
    return Claim(id=f"printed-poles.{name}", item=ITEM, title=title, expected=Verdict.HOLDS, setting=WORDS, prose=prose,
                 checks=checks, note=note)


def _range(name: str, low: str, high: str, narrow: str) -> Computed:
    return Computed("printed", f"{name} is from {low} to {high}", ranges_from, exact=True, arguments=(name, low, high),
                    failing=(name, low, narrow))


_SUMS = "A pencil with these pairs has (s^2 + a s + D_re)^2 + (omega s - D_im)^2 as its characteristic polynomial. "

CLAIMS: list[Claim] = [
    _claim(
        "constants", "the four constants of the quadratic lie within these ranges, and no others give the printed digits",
        "Of s^2 + (a - j omega) s + b - j c omega + d omega^2, with d abs(omega) in the baseline column; a and c in 1/s, b in "
        "1/s^2. Each range is an exact combination of four inequalities on the roots; quadratics that fit are shown within a "
        "hundredth of its ends.",
        _range("a", "495.38999", "495.39399", "495.39390"), _range("b", "6074.322", "6075.590", "6075.500"),
        _range("c", "254.5805", "254.6104", "254.6090"), _range("d", "49.99975", "50.00075", "50.00070"),
    ),
    _claim(
        "powers", "the product of a pair grows with omega^2 in the proposed column and with omega in the baseline one",
        "Three speeds settle a whole power: the differences of D_re between them are in a ratio that the digits enclose.",
        Computed("printed", "omega^2 in the proposed column", grows, exact=True, arguments=("proposed", 2),
                 failing=("proposed", 1)),
        Computed("printed", "omega in the baseline column", grows, exact=True, arguments=("baseline", 1),
                 failing=("baseline", 2)),
        note="Only positive speeds are printed: omega and abs(omega) cannot be told apart.",
    ),
    _claim(
        "one-factor", "the columns differ in one factor omega of one term, and in nothing else that the digits show",
        "Read separately, both columns have the same b, c and d, and their products differ by 50 (omega^2 - omega).",
        Computed("printed", "the difference at each speed", differ_by, exact=True, arguments=(50,), failing=(51,)),
        note="So the two columns are one pencil with a small and a large gain, and no comparison of two structures.",
    ),
    _claim(
        "form-7", "no reading of (7) gives either column", _SUMS + "In (7) with free gains a coefficient is then forced.",
        _form("(7)", "(7) expanded"), _form("(7)", "(7) as a matrix equation"),
    ),
    _claim(
        "form-8", "no reading of (8) with the z feedback of (7) or as a matrix equation gives either column",
        _SUMS + "D_re does not move with the speed, or -D_im / omega is Table III's R_s/sigma.",
        _form("(8)", "(8) expanded"), _form("(8)", "(8) as a matrix equation"),
    ),
    _claim(
        "form-12", "neither (8) with the z feedback of (12) or of L(omega_hat), nor (12) as printed, gives either column",
        _SUMS + "D_im is zero; or, with (12)'s printed signs, -a omega.",
        _form("(12)", "(8) expanded, z feedback of (12)"),
        _form("L(omega_hat)", "(8) expanded, z feedback of L(omega_hat)", "(8) expanded, z feedback of (12)"),
        _form("(12)", "(12) with its printed signs"),
    ),
    _claim(
        "form-2", "(2)-(3) with constant gains gives neither column, with gains that follow the speed both",
        "With any constant real 4x2 gain the last coefficient is alpha^2 + omega^2 times a constant. With gains that follow "
        "the speed any poles can be had.",
        _form("(2)-(3)", "(2)-(3)"),
        *(Computed("evidence", f"gains of each speed give the {column} column, those of one speed do not", gains_at, exact=True,
                   arguments=(column, 0), failing=(column, 60)) for column in ("proposed", "baseline")),
        note="Where poles lie says nothing of one structure against the other, only how the gains were chosen.",
    ),
    _claim(
        "table3", "in the reading that comes nearest, Table III's R_s/sigma is not what the digits need",
        "In (8) as a matrix equation c is R_s/sigma. With the leakage of Table III it would take about 0.8014 ohm for R_s, "
        "where 0.439 ohm is printed.",
        Computed("printed", "c is not R_s/sigma", not_the_rate, exact=True, arguments=("0.439",), failing=("0.8014",)),
        note="Which of R_s and sigma is off, or how much of either, the digits do not say.",
    ),
    _claim(
        "open", "the digits do not fix alpha: any has gains with which (8) as a matrix equation has the printed poles",
        "alpha, beta L_m, k_1 and k_3 enter through two sums only.",
        Computed("printed", "three values of alpha, each with gains of its own, and not with those of the first", same_table,
                 exact=True, arguments=(("9.9354", "6.6236", "20"), True), failing=(("9.9354", "6.6236", "20"), False)),
        note="Also open: the sign of omega in the baseline column; h, K_p and g, which frozen poles do not hold; and which "
             "program printed the table.",
    ),
]
