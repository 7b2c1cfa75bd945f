"""Kubota's speed-scheduled gain of the baseline: where its poles are, that no other gain does it, and where its loop fails.

The statements are ours; the gain is that of Kubota, Matsuse and Nakano (IEEE Trans. Ind. Appl. 29(2), 1993). Matrices are found
by differentiating the definitions with dual numbers: the observer's Jacobian with respect to its own state is the matrix of its
errors, since the machine's rates do not depend on them. Complex numbers stand for d + j q.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from imo_analysis.equations import baseline, parameters, plant, scheduled
from imo_analysis.ledger.claim import Algebra, Claim, Computed, Trajectory, Verdict
from imo_analysis.ledger.dual import Dual
from imo_analysis.ledger.expression import Name, names, parse
from imo_analysis.ledger.gauss import Gauss
from imo_analysis.ledger.intervals import add, divide, overlap
from imo_analysis.ledger.intervals import printed as interval
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, MACHINE, PHYSICAL, VOLTAGES
from imo_analysis.paper.tables import EIGENVALUES, Pair, printed

ITEM = "Scheduled gain (ours)"
_STATE = (*CURRENTS, *names("phi_dr phi_qr"))
_GAINS = names("l_1 l_2 l_3 l_4")
_HALVES = ("re", "im")
_UNITS = {
    "p_re": "1/s", "p_im": "1/s", "x": "1/s", "psi": "Wb", "share": "1", "at_zero": "1/s^5", "characteristic": "1/s^5",
    "routh": "1/s^3", "a_2": "1/s", "a_1": "1/s^2", "a_0": "1/s^3",
    **{f"{name}_{half}": unit for half in _HALVES for name, unit in (
        ("machine", "1/s^2"), ("observer", "1/s^2"), ("sum", "1/s"), ("own_sum", "1/s"), ("product", "1/s^2"),
        ("own_product", "1/s^2"), ("sum_gap", "1/s"), ("product_gap", "1/s^2"))},
    **{f"scheduled_{n}": "1/s" if n < 3 else "ohm" for n in (1, 2, 3, 4)},
}
Rates = Callable[[tuple[Any, ...]], Sequence[Any]]


def _still(values: Sequence[Any]) -> tuple[Dual, ...]:
    return tuple(Dual(value) for value in values)


def _jacobian(rates: Rates, state: Sequence[Any]) -> list[tuple[Any, ...]]:
    """Rows of the Jacobian of some rates at a state, exactly."""
    columns = []
    for moving in range(len(state)):
        row = rates(tuple(Dual(value, int(place == moving)) for place, value in enumerate(state)))
        columns.append([one.rate if isinstance(one, Dual) else 0 for one in row])
    return list(zip(*columns, strict=True))


def _rates(observer: Callable[..., Any], gains: Sequence[Any]) -> Rates:
    """The rates of an observer as a function of its state, all else standing still."""
    fixed = (_still(CURRENTS), _still(VOLTAGES), Name("direction"), _still(MACHINE), _still(gains))
    return lambda x: observer(x, *fixed)


def _machine(x: tuple[Any, ...]) -> Sequence[Any]:
    return plant.plant((*x, *_still(names("omega"))), _still(VOLTAGES), 0, 0, _still((*MACHINE, *names("mu n_p J"))))[:4]


def _sum_and_product(matrix: Sequence[Sequence[Any]]) -> tuple[Gauss, Gauss]:
    """Sum and product of the two poles of a 4x4 matrix of d/q pairs, as complex numbers."""
    a, b, c, d = (Gauss(matrix[2 * r][2 * q], matrix[2 * r + 1][2 * q]) for r in (0, 1) for q in (0, 1))
    return a + d, a * d - b * c


def _frozen(observer: Callable[..., Any], gains: Sequence[Any]) -> list[tuple[Any, ...]]:
    """The matrix of the errors of currents and flux at a frozen speed, omega_hat = omega."""
    rates = _rates(observer, gains)
    return _jacobian(lambda x: rates((*x, Dual(Name("omega"))))[:4], [Name(f"{one.name}_hat") for one in _STATE])


def _parts(name: str, value: Gauss) -> dict[str, Any]:
    return {f"{name}_{half}": part for half, part in zip(_HALVES, value.pair, strict=True)}


def _polynomial(poles: tuple[Gauss, Gauss], p: Gauss) -> Gauss:
    return p * p - poles[0] * p + poles[1]


def _schedule() -> dict[str, Any]:
    gain = scheduled.proportional_gain(Name("k"), Name("omega"), MACHINE)
    return {f"scheduled_{n + 1}": one for n, one in enumerate(gain)}


def _known() -> dict[str, Any]:
    return {"gamma": parameters.current_decay(*names("R_s L_m sigma alpha beta"))}


@cache
def frozen() -> Setting:
    """Machine and scheduled observer at a frozen speed: the polynomials whose roots are their poles, p being any number."""
    own = _sum_and_product(_jacobian(_machine, _STATE))
    matrix = _frozen(scheduled.baseline_scheduled, names("k h"))
    p, k = Gauss(*names("p_re p_im")), Name("k")
    poles = _sum_and_product(matrix)
    defined: dict[str, Any] = {
        **_known(), **_schedule(), **_parts("sum", poles[0]), **_parts("product", poles[1]), **_parts("own_sum", own[0]),
        **_parts("own_product", own[1]), **_parts("machine", _polynomial(own, p)),
        **_parts("observer", _polynomial(poles, p * k)),
        **{f"m_{r + 1}{c + 1}": entry for r, row in enumerate(matrix) for c, entry in enumerate(row)},
    }
    return setting("scheduled_frozen", "the machine (1) and the baseline with Kubota's gain, speed known and constant",
                   defined, (*PHYSICAL, "J != 0"), units=_UNITS)


@cache
def any_gain() -> Setting:
    """The baseline with free gains: by how much sum and product of its poles miss k and k^2 times the machine's."""
    own, k = _sum_and_product(_jacobian(_machine, _STATE)), Name("k")
    poles = _sum_and_product(_frozen(baseline.baseline, (*_GAINS, Name("h"))))
    defined = {**_known(), **_schedule(), **_parts("sum_gap", poles[0] - own[0] * k),
               **_parts("product_gap", poles[1] - own[1] * (k * k))}
    return setting("any_gain", "the machine (1) and the baseline with any gain, speed known and constant", defined,
                   (*PHYSICAL, "J != 0"), units=_UNITS)


@cache
def turned() -> Setting:
    """The baseline with Kubota's gain on the wrong side: on i_hat - i where it belongs on i - i_hat, or the other way round."""
    own = _sum_and_product(_jacobian(_machine, _STATE))
    wrong = [-one for one in scheduled.proportional_gain(Name("k"), Name("omega"), MACHINE)]
    poles = _sum_and_product(_frozen(baseline.baseline, (*wrong, Name("h"))))
    defined = {**_parts("sum", poles[0]), **_parts("product", poles[1]), **_parts("own_sum", own[0]),
               **_parts("own_product", own[1])}
    return setting("scheduled_turned", "the baseline with the opposite of Kubota's gain, speed known and constant", defined,
                   (*PHYSICAL, "J != 0"), units=_UNITS)


def _determinant(matrix: Sequence[Sequence[Any]]) -> Any:
    """Expansion along the first row, without the entries that are zero as written."""
    if len(matrix) == 1:
        return matrix[0][0]
    total: Any = 0
    for place, entry in enumerate(matrix[0]):
        if not (isinstance(entry, int) and entry == 0):
            minor = [[*row[:place], *row[place + 1:]] for row in matrix[1:]]
            total = total + (-1) ** place * entry * _determinant(minor)
    return total


def adaptive_determinant(observer: Callable[..., Any], gains: Sequence[Any], at: Any, further: tuple[Any, ...] = ()) -> Any:
    """det(at I - A) of the errors with the adaptation, near zero error at constant speed and flux psi, in the flux's frame.

    ``further`` are the values of the states that follow omega_hat.
    """
    state = (*CURRENTS, Name("psi"), 0, Name("omega"), *further)
    matrix = [list(row) for row in _jacobian(_rates(observer, gains), state)]
    frame = Name("stator_frequency")
    for d, q in ((0, 1), (2, 3)):
        matrix[d][q] = matrix[d][q] + frame
        matrix[q][d] = matrix[q][d] - frame
    return _determinant([[(at if r == c else 0) - entry for c, entry in enumerate(row)] for r, row in enumerate(matrix)])


@cache
def adaptive_loop() -> Setting:
    """The scheduled observer with its speed law near zero error; ``x`` is any number, the argument of the polynomial."""
    frame, x = names("stator_frequency x")
    gains = names("k h")
    poles = _sum_and_product(_frozen(scheduled.baseline_scheduled, gains))
    defined = {
        **_known(), **_parts("observer", _polynomial(poles, Gauss(x, frame))),
        "characteristic": adaptive_determinant(scheduled.baseline_scheduled, gains, x),
        "at_zero": adaptive_determinant(scheduled.baseline_scheduled, gains, 0),
    }
    return setting("scheduled_loop", "errors of the baseline with Kubota's gain and its speed law, to first order, omega, slip "
                   "and flux psi constant, in the frame of the flux", defined, (*PHYSICAL, "h > 0", "psi > 0", "k > 0"),
                   units=_UNITS)


@cache
def between() -> Setting:
    """`adaptive_loop` where the stator frequency is a share of omega between zero and k (R_s/sigma) / (gamma + alpha)."""
    return adaptive_loop().extended("scheduled_between", definitions={"stator_frequency": Name("share") * Name("omega")},
                                    hypotheses=("omega != 0", "share > 0", "k*R_s/sigma - share*(gamma + alpha) > 0"))


@cache
def constant_loop() -> Setting:
    """The baseline with any gain and its speed law near zero error."""
    gains = (*_GAINS, Name("h"))
    poles = _sum_and_product(_frozen(baseline.baseline, gains))
    defined = {**_known(), **_parts("sum", poles[0]), **_parts("product", poles[1]),
               "at_zero": adaptive_determinant(baseline.baseline, gains, 0)}
    return setting("constant_loop", "errors of the baseline with any gain and its speed law, to first order, omega, slip and "
                   "flux psi constant, in the frame of the flux", defined, (*PHYSICAL, "h > 0", "psi > 0"), units=_UNITS)


@cache
def fast_adaptation() -> Setting:
    """The cubic x^3 + a_2 x^2 + a_1 x + a_0 that multiplies h in the characteristic polynomial, and its Routh determinant."""
    return setting(
        "fast_adaptation", "the cubic that multiplies h beta^2 psi^2 in the characteristic polynomial",
        {**_known(), "a_2": parse("k*(gamma + alpha)"), "a_1": parse("stator_frequency**2 + k**2*R_s/sigma*alpha"),
         "a_0": parse("k*(gamma + alpha)*stator_frequency**2 - k**2*R_s/sigma*omega*stator_frequency"),
         "routh": parse("a_2*a_1 - a_0")},
        (*PHYSICAL, "k > 0"), units=_UNITS)


def outside_table2(pairs: tuple[Pair, ...]) -> tuple[bool, str]:
    """Whether no k gives the printed pairs with Table III, whichever of its two values alpha has.

    With the gain a pair adds up to -k (gamma + alpha - j omega_hat), which gives k twice.
    """
    R_s, L_m = printed("R_s"), printed("L_m")
    L_s, L_r = L_m + printed("L_s - L_m"), L_m + printed("L_r - L_m")
    sigma = parameters.leakage(L_s, L_m, L_r)
    beta = parameters.coupling(L_m, sigma, L_r)
    words, apart = [], True
    for alpha in (printed("alpha"), parameters.rotor_rate(printed("R_r"), L_r)):
        decay = parameters.current_decay(R_s, L_m, sigma, alpha, beta) + alpha
        for pair in pairs:
            real, imag = (add(interval(pair.first[n]), interval(pair.second[n])) for n in (0, 1))
            from_real, from_imag = divide(real, (-decay, -decay)), divide(imag, (Fraction(pair.omega_hat),) * 2)
            apart = apart and not overlap(from_real, from_imag)
            words.append(f"{float(from_real[0]):.4f} and {float(from_imag[0]):.4f} at {pair.omega_hat} rad/s")
    return apart, "k from the real and from the imaginary part of the sum: " + ", ".join(words)


_BASELINE = tuple(pair for pair in EIGENVALUES if pair.column == "baseline")
# the sum of the poles with k = 3/2 and the printed alpha, split anyhow
_FITS = Pair("baseline", 60, ("-480.00", "40.00"), ("-20.39", "50.00"))
_CUBIC = ("(x**2 + stator_frequency**2)*(x + k*(gamma + alpha))"
          " + k**2*R_s/sigma*(alpha*x - omega*stator_frequency)")

CLAIMS: list[Claim] = [
    Claim(
        id="scheduled.poles", item=ITEM, title="Kubota's gain puts the poles at k times the machine's, at every speed",
        expected=Verdict.HOLDS, setting=frozen(),
        prose="With P(p) the polynomial of the machine's two poles and P_k that of the observer's errors at a frozen speed, "
              "P_k(k p) = k^2 P(p) for every complex p: the poles of one are k times those of the other, whatever the speed "
              "and the parameters.",
        printed=("observer_re = k**2*machine_re", "observer_im = k**2*machine_im"),
        checks=(
            Algebra("evidence", "the poles of the machine: their sum, and their product (alpha - j omega) R_s/sigma",
                    ("own_sum_re = -(gamma + alpha)", "own_sum_im = omega", "own_product_re = R_s/sigma*alpha",
                     "own_product_im = -R_s/sigma*omega")),
            Algebra("evidence", "the error matrix turns with the axes, so that complex numbers may stand for d/q pairs",
                    tuple(f"m_{r}{c} = {sign}m_{3 - r if r < 3 else 7 - r}{3 - c if c < 3 else 7 - c}"
                          for r, c, sign in ((1, 1, ""), (1, 2, "-"), (1, 3, ""), (1, 4, "-"), (3, 1, ""), (3, 2, "-"),
                                             (3, 3, ""), (3, 4, "-")))),
            Algebra("evidence", "the gain, which in the usual notation is minus g_1 ... g_4 with c = 1/beta",
                    ("scheduled_1 = (k - 1)*(gamma + alpha)", "scheduled_2 = -(k - 1)*omega",
                     "beta*scheduled_3 = (k**2 - 1)*(gamma - beta*alpha*L_m) - (k - 1)*(gamma + alpha)",
                     "beta*scheduled_4 = (k - 1)*omega")),
        ),
        note="The usual formulas multiply i_hat - i: their signs are right there, and all four turn for i - i_hat as here "
             "(scheduled.sign). The 1993 paper itself was not at hand; three public sources that quote its formulas, two "
             "programs and a set of notes, agree with what is derived here.",
    ),
    Claim(
        id="scheduled.unique", item=ITEM, title="no other gain of the form (3) puts the poles there",
        expected=Verdict.HOLDS, setting=any_gain(),
        prose="The gaps are those between sum and product of the observer's poles and k and k^2 times the machine's. They are "
              "zero exactly where the four gains are Kubota's.",
        printed=(
            "l_1 - scheduled_1 = -sum_gap_re", "l_2 - scheduled_2 = -sum_gap_im",
            "(alpha**2 + omega**2)*(beta*(l_3 - scheduled_3) - sum_gap_re) = alpha*product_gap_re - omega*product_gap_im",
            "(alpha**2 + omega**2)*(beta*(l_4 - scheduled_4) - sum_gap_im) = alpha*product_gap_im + omega*product_gap_re",
        ),
        assumptions=("gains that commute with rotations, as in (3); a real 4x2 gain has four more",),
    ),
    Claim(
        id="scheduled.no_feedback", item=ITEM, title="k = 1 is no feedback at all",
        expected=Verdict.HOLDS, setting=frozen().extended("scheduled_one", cases=({"k": 1},)),
        printed=tuple(f"scheduled_{n} = 0" for n in (1, 2, 3, 4)),
        prose="The observer is then a copy of the machine that runs beside it, and its errors die out no faster than the "
              "machine's own transients.",
        mutate=False,
    ),
    Claim(
        id="scheduled.sign", item=ITEM, title="on the wrong side of the current error the gain makes the poles grow",
        expected=Verdict.HOLDS, setting=turned(),
        prose="With all signs turned the poles have the sum (2 - k) and the product (2 - k^2) times the machine's: at "
              "standstill one of them is positive from k = sqrt(2) on.",
        printed=(
            "sum_re = (2 - k)*own_sum_re", "sum_im = (2 - k)*own_sum_im", "product_re = (2 - k**2)*own_product_re",
            "product_im = (2 - k**2)*own_product_im",
        ),
    ),
    Claim(
        id="scheduled.table2", item=ITEM, title="the baseline column of Table II is not that of Kubota's gain",
        expected=Verdict.HOLDS, setting=frozen(),
        prose="A pair of poles adds up to -k (gamma + alpha - j omega_hat). The printed pairs need k = 1 for the imaginary "
              "part and, with Table III, 1.48 or 1.84 for the real part.",
        checks=(
            Computed("reading", "the two values of k exclude each other at every speed, for both values of alpha",
                     outside_table2, exact=True, arguments=(_BASELINE,), failing=((_FITS,),)),
            Algebra("evidence", "the sum of the poles", ("sum_re = -k*(gamma + alpha)", "sum_im = k*omega")),
        ),
    ),
    Claim(
        id="scheduled.characteristic", item=ITEM, title="the characteristic polynomial with the speed law (4)",
        expected=Verdict.HOLDS, setting=adaptive_loop(),
        prose="To first order, for errors of current, flux and speed: x times the squared size of the frozen polynomial "
              "P_k(x + j omega_s), and h beta^2 psi^2 times a cubic.",
        printed=("characteristic = x*(observer_re**2 + observer_im**2)"
                 f" + h*beta**2*psi**2*({_CUBIC})",),
        checks=(
            Algebra("evidence", "as h grows three poles tend to the zeros of the cubic; where its last coefficient is positive "
                    "all three decay if and only if omega omega_s > -k alpha (gamma + alpha) (Routh)",
                    (f"x**3 + a_2*x**2 + a_1*x + a_0 = {_CUBIC}",
                     "routh = k**2*R_s/sigma*(k*alpha*(gamma + alpha) + omega*stator_frequency)"), setting=fast_adaptation()),
        ),
        assumptions=("omega, slip and flux constant; the whole commutes with rotations, so that it may be seen from the flux",),
    ),
    Claim(
        id="scheduled.regenerating", item=ITEM, title="braking at low speed, zero error is unstable whatever h is",
        expected=Verdict.HOLDS, setting=between(),
        prose="Where the stator frequency is a share of omega between 0 and k (R_s/sigma) / (gamma + alpha), the last "
              "coefficient of the characteristic polynomial is negative, and a pole is real and positive.",
        printed=("at_zero <= 0",),
        squares=(("h*beta**2*psi**2*k*share*(k*R_s/sigma - share*(gamma + alpha))", "omega"),),
        checks=(
            Algebra("evidence", "the last coefficient, which is not zero there",
                    ("at_zero = h*beta**2*psi**2*k*stator_frequency*((gamma + alpha)*stator_frequency - k*R_s/sigma*omega)",),
                    setting=adaptive_loop()),
        ),
        assumptions=("a polynomial that is negative at zero and grows without bound has a positive zero (intermediate value)",),
        note="With a share below 1 the slip is against the speed: the machine brakes. That such a region exists is known "
             "(Hinkkanen and Luomi, IEEE Trans. Ind. Electron. 51(6), 2004); its edge, a stator frequency of k (R_s/sigma) / "
             "(gamma + alpha) times the speed, is exact here. A larger k widens it in proportion, and from "
             "k = (gamma + alpha) / (R_s/sigma) on (2.39 for Table III with the printed alpha, 1.93 with its R_r/L_r) an idle "
             "machine, share = 1, is lost too, at every speed. Outside the region the last coefficient decides nothing: with a "
             "small h poles may still leave in pairs. At zero stator frequency it is zero for every gain.",
        trajectories=(
            Trajectory("regenerating", "both baselines hold 40 rad/s under -15 N m and lose 20 rad/s; consistent_12 and the "
                       "repaired observer hold both", "imo simulate --scenario regenerating"),
        ),
    ),
    Claim(
        id="scheduled.any_gain", item=ITEM, title="which gains have no such region",
        expected=Verdict.HOLDS, setting=constant_loop(),
        prose="For any gain of the form (3) the last coefficient is this. It is above zero for every stator frequency but zero "
              "if and only if gamma + alpha + l_1 > 0 and alpha (l_2 + beta l_4) = omega (R_s/sigma + l_1 + beta l_3): if the "
              "product of the frozen poles is real.",
        printed=("at_zero = h*beta**2*psi**2*stator_frequency*((gamma + alpha + l_1)*stator_frequency"
                 " + alpha*(l_2 + beta*l_4) - omega*(R_s/sigma + l_1 + beta*l_3))",),
        checks=(
            Algebra("evidence", "the same with sum and product of the frozen poles",
                    ("at_zero = h*beta**2*psi**2*stator_frequency*(product_im - sum_re*stator_frequency)",)),
        ),
        note="Kubota's gain keeps the product k^2 (alpha - j omega) R_s/sigma, so it always has such a region. Without one "
             "poles may still leave in pairs: the condition is necessary, not sufficient.",
    ),
]
