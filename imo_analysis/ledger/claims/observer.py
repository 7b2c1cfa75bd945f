"""(7) and (8): the observer with known and with adapted alpha, and the three feedbacks of z that are printed."""

from __future__ import annotations

from functools import cache

from imo_analysis.equations import adaptive
from imo_analysis.ledger.claim import Algebra, Claim, Trajectory, Verdict
from imo_analysis.ledger.claims.transcript import claim, same, shapes
from imo_analysis.ledger.claims.unfluxed import growing
from imo_analysis.ledger.expression import Name, as_expr, names
from imo_analysis.ledger.setting import Setting, setting
from imo_analysis.ledger.settings import CURRENTS, GAINS, MACHINE, VOLTAGES, errors, luenberger_errors, machine

HOLDS, CORRECTED = Verdict.HOLDS, Verdict.CORRECTED

@cache
def zero_estimates() -> Setting:
    """The expanded (8) where all estimates of currents, z and xi are zero: what it does with the measured currents alone."""
    state = (0, 0, 0, 0, 0, 0, *names("alpha_hat omega_hat"))
    rates = adaptive.printed_7(tuple(map(as_expr, state)), CURRENTS, VOLTAGES, Name("direction"), MACHINE, GAINS)
    which = ("i_ds", "i_qs", "z_1", "z_2", "xi_1", "xi_2")
    return setting(
        "zero_estimates",
        "the expanded (8) at a zero estimate of currents, z and xi, where A x_hat and C x_hat vanish",
        {f"{one}_hat_dot": as_expr(rate) for one, rate in zip(which, rates[:6], strict=True)},
        ("sigma > 0",),
    )


_EDIT_Z = "exchange i_ds_tilde and i_qs_tilde between the two z rows"
_WHY_Z = (
    "(7), the expanded (8) and the matrix L(omega_hat) print three different patterns; only the one that (12) needs lets "
    "the z terms of (14) cancel"
)
_Z_FALL = ("eq12.z_1", "eq12.z_2", "eq15.z", "proposition-IV.2")

_DIVERGES = (Trajectory("divergence", "both printed z feedbacks leave all bounds", "imo simulate --scenario divergence"),)

_seven = luenberger_errors()
CLAIMS: list[Claim] = [
    claim(
        "eq7.i_ds",
        "rate of the d-axis current estimate",
        HOLDS,
        _seven,
        checks=(
            Algebra(
                "evidence",
                "its error, with alpha known",
                (
                    "i_ds_tilde_dot = -(R_s/sigma + k_1)*i_ds_tilde - omega*i_qs_tilde - omega_tilde*i_qs_hat"
                    " + alpha*z_1_tilde + omega*z_2_tilde + omega_tilde*z_2_hat",
                ),
            ),
        ),
    ),
    claim(
        "eq7.i_qs",
        "rate of the q-axis current estimate",
        HOLDS,
        _seven,
        checks=(
            Algebra(
                "evidence",
                "its error, with alpha known",
                (
                    "i_qs_tilde_dot = -(R_s/sigma + k_1)*i_qs_tilde + omega*i_ds_tilde + omega_tilde*i_ds_hat"
                    " + alpha*z_2_tilde - omega*z_1_tilde - omega_tilde*z_1_hat",
                ),
            ),
        ),
    ),
    claim(
        "eq7.z_1",
        "rate of the first z estimate",
        CORRECTED,
        _seven,
        corrected=same("eq7.z_1", "(i_ds - i_ds_hat)", "(i_qs - i_qs_hat)"),
        edit=_EDIT_Z,
        origin="paper",
        why=_WHY_Z,
        consequences=("eq8.z_1", *_Z_FALL),
    ),
    claim(
        "eq7.z_2",
        "rate of the second z estimate",
        CORRECTED,
        _seven,
        corrected=same("eq7.z_2", "(i_qs - i_qs_hat)", "(i_ds - i_ds_hat)"),
        edit=_EDIT_Z,
        origin="paper",
        why=_WHY_Z,
        consequences=("eq8.z_2", *_Z_FALL),
    ),
    claim(
        "z-needs-measurements-only",
        "the rate of z needs measured signals only",
        HOLDS,
        machine(),
        printed=("z_1_dot = u_ds/sigma - R_s/sigma*i_ds", "z_2_dot = u_qs/sigma - R_s/sigma*i_qs"),
        assumptions=("stationary frame; in a frame that turns, z itself enters",),
        note="z is the stator's flux linkage over sigma, so z_hat and xi_hat are integrators of the voltage behind R_s.",
    ),
    *(claim(f"eq8.{name}", f"rate of the estimate of {name}", HOLDS, errors()) for name in ("i_ds", "i_qs")),
    claim(
        "eq8.z_1",
        "rate of the first z estimate",
        CORRECTED,
        errors(),
        corrected=same("eq8.z_1", "(i_ds - i_ds_hat)", "(i_qs - i_qs_hat)"),
        edit=_EDIT_Z,
        origin="paper",
        why=_WHY_Z,
        trajectories=_DIVERGES,
        consequences=_Z_FALL,
        checks=(
            *growing("7"),
        ),
    ),
    claim(
        "eq8.z_2",
        "rate of the second z estimate",
        CORRECTED,
        errors(),
        corrected=same("eq8.z_2", "(i_qs - i_qs_hat)", "(i_ds - i_ds_hat)"),
        edit=_EDIT_Z,
        origin="paper",
        why=_WHY_Z,
        consequences=_Z_FALL,
    ),
    *(claim(f"eq8.{name}", f"rate of the estimate of {name}", HOLDS, errors()) for name in ("xi_1", "xi_2")),
    claim(
        "eq8.matrix",
        "the matrix form says what the rows say",
        CORRECTED,
        zero_estimates(),
        printed=("i_ds_hat_dot = k_1*i_ds + u_ds/sigma", "xi_1_hat_dot = k_3*i_ds + u_ds/sigma"),
        corrected=(
            "i_ds_hat_dot = k_1*i_ds + u_ds/sigma - alpha_hat*(1 + beta*L_m)*i_ds",
            "xi_1_hat_dot = k_3*i_ds + u_ds/sigma - R_s/sigma*i_ds",
        ),
        edit="add G y, with -alpha_hat (1 + beta L_m) I in the current rows of G and -R_s/sigma I in its z and xi rows",
        prose="At a zero estimate, A x_hat and C x_hat vanish whatever A is, and B u + L y must be what the rows give.",
        origin="paper",
        why="the rows use the measured current where a matrix form of this kind has no place for it; the rows "
        "agree with (12), the matrix form does not; A also depends on alpha_hat",
        checks=(
            shapes(
                "evidence",
                "shapes agree: A 6x6, B 6x2, L 6x2, C 2x6",
                (6, 1),
                ((6, 6), (6, 1)),
                ((6, 2), (2, 1)),
                ((6, 2), (2, 6), (6, 1)),
            ),
        ),
    ),
    claim(
        "eq8.L",
        "the gain matrix",
        CORRECTED,
        errors(),
        printed=(
            "z_1_hat_dot = -R_s/sigma*i_ds + k_2*omega_hat*(i_qs - i_qs_hat) + u_ds/sigma",
            "z_2_hat_dot = -R_s/sigma*i_qs - k_2*omega_hat*(i_ds - i_ds_hat) + u_qs/sigma",
        ),
        corrected=(
            "z_1_hat_dot = -R_s/sigma*i_ds - k_2*omega_hat*(i_qs - i_qs_hat) + u_ds/sigma",
            "z_2_hat_dot = -R_s/sigma*i_qs + k_2*omega_hat*(i_ds - i_ds_hat) + u_qs/sigma",
        ),
        edit="change the sign of both k_2 omega_hat entries of L",
        prose="The z rows of L y, with the rest of (8).",
        origin="paper",
        why=_WHY_Z,
        trajectories=_DIVERGES,
        consequences=_Z_FALL,
        checks=(
            *growing("L"),
            shapes("evidence", "L is 6x2", (6, 1), ((6, 2), (2, 1))),
        ),
    ),
    claim(
        "eq8.C",
        "shape of C",
        HOLDS,
        prose="C is the transpose of a 6x2 matrix that picks the currents.",
        checks=(shapes("printed", "C picks the two currents", (2, 1), ((2, 6), (6, 1))),),
    ),
]
