"""(19)-(23), Propositions IV.3 and IV.4: excitation, what is conserved, what converges."""

from __future__ import annotations

from imo_analysis.equations import excitation
from imo_analysis.ledger.claim import Algebra, Claim, Verdict
from imo_analysis.ledger.claims.model import first_principles
from imo_analysis.ledger.claims.regressors import (
    ARGUMENTS,
    COLLINEAR,
    ORDER,
    STEADY,
    at_rest,
    compact,
    moving_speed,
    null_space,
    products,
    steady_flux,
    true_regressors,
)
from imo_analysis.ledger.claims.situations import ERRORS, constant_observable, observable, repaired
from imo_analysis.ledger.claims.transcript import claim, printed, shapes
from imo_analysis.ledger.expression import names
from imo_analysis.ledger.setting import Setting

HOLDS, CORRECTED = Verdict.HOLDS, Verdict.CORRECTED

_CURRENT = "-(R_s/sigma + k_1)*{0} {1} omega*{2}"
_D, _Q = _CURRENT.format("i_ds_tilde", "-", "i_qs_tilde"), _CURRENT.format("i_qs_tilde", "+", "i_ds_tilde")
_LAWS = (
    "alpha_tilde_dot = -g*(v_11*i_ds_tilde + v_12*i_qs_tilde)",
    "omega_tilde_dot = -K_p*direction*(v_21*i_ds_tilde + v_22*i_qs_tilde)",
)
_Z = tuple(printed(f"eq12.{name}") for name in ("z_1", "z_2", "xi_1", "xi_2"))
_STRENGTH = "alpha*k_3 + kappa*(direction*omega)"
_REDUCED = (
    "w_1_dot = -strength*i_ds_tilde",
    "w_2_dot = -strength*i_qs_tilde",
    "alpha_tilde_dot = -g*(v_11*i_ds_tilde + v_12*i_qs_tilde)",
    "omega_tilde_dot = -K_p*(v_21*i_ds_tilde + v_22*i_qs_tilde)",
    f"i_ds_tilde_dot = {_D} + w_1 + v_11*alpha_tilde + v_21*omega_tilde",
    f"i_qs_tilde_dot = {_Q} + w_2 + v_12*alpha_tilde + v_22*omega_tilde",
)
_LEMMA = (
    "R. Marino, P. Tomei, C. Verrelli, Induction Motor Control Design, Lemma A.3 (Anderson 1977; Morgan and Narendra 1977): "
    "x' = A x + R y, y' = -G R^T x with A + A^T < 0, G > 0 constant, R and its rate bounded, is exponentially stable if and "
    "only if R is persistently exciting"
)
_KEPT = {
    "printed_7": (
        "k_3*z_1_tilde_dot + k_2*omega_hat*xi_1_tilde_dot = 0",
        "k_3*z_2_tilde_dot - k_2*omega_hat*xi_2_tilde_dot = 0",
    ),
    "printed_L": (
        "k_3*z_1_tilde_dot - k_2*omega_hat*xi_2_tilde_dot = 0",
        "k_3*z_2_tilde_dot + k_2*omega_hat*xi_1_tilde_dot = 0",
    ),
    "consistent_12": (
        "k_3*z_1_tilde_dot + k_2*omega_hat*xi_2_tilde_dot = 0",
        "k_3*z_2_tilde_dot - k_2*omega_hat*xi_1_tilde_dot = 0",
    ),
}


def _reduced() -> Setting:
    return constant_observable("repaired", _STRENGTH, "reduced_system", ("kappa > 0", "direction*omega > 0"))


# Two readings of (23): what its constants may depend on is not said.
_ONE_FOR_ALL = Algebra(
    "reading",
    "K_1 and K_2 are one for all initial errors: of (21), linear along a trajectory, every multiple of a solution that no "
    "acceleration drives is one, so that a speed error that starts at zero would have to stay there",
    ("omega_tilde_dot = 0",),
    setting=moving_speed("consistent_12", ({"direction": 1, "omega_tilde": 0, "omega_dot": 0},)),
)
_PER_TRAJECTORY = Algebra(
    "reading",
    "they may depend on the other initial errors: (23) then says that the speed error is bounded, and without z-loop gain "
    "(kappa = 0) it is: the acceleration enters the reduced system additively, and z_tilde stands still: the system of the "
    "lemma with a bounded input",
    (
        "w_1_dot = -alpha*k_3*i_ds_tilde + omega_dot*z_2_tilde",
        "w_2_dot = -alpha*k_3*i_qs_tilde - omega_dot*z_1_tilde",
        "z_1_tilde_dot = 0",
        "z_2_tilde_dot = 0",
        "omega_tilde_dot = omega_dot - K_p*(v_21*i_ds_tilde + v_22*i_qs_tilde)",
    ),
    setting=moving_speed("repaired", ({"kappa": 0, "direction": 1}, {"kappa": 0, "direction": -1})),
)

CLAIMS: list[Claim] = [
    claim(
        "guaranteed-stability",
        "asymptotic stability of the estimation errors",
        Verdict.FAILS,
        at_rest(),
        printed=("z_1_tilde = 0", "z_2_tilde = 0"),
        prose="All errors tend to zero from near zero; so no state but zero error may stay where it is.",
        checks=(
            Algebra(
                "evidence",
                "every one of these states stays where it is, however small",
                tuple(f"{one}_dot = 0" for one in ERRORS),
            ),
        ),
        origin="paper",
        why="the abstract states it without the condition that Proposition IV.3 has, and that condition does not help",
        note="What can be had: boundedness without any condition (repairs 1 to 3, 5, 6), and convergence of the currents, "
        "w, alpha, omega "
        "and the reconstructed flux under excitation (proposition-IV.3).",
    ),
    claim(
        "eq19.condition",
        "the excitation condition can be met",
        CORRECTED,
        null_space(),
        printed="T*(BZ_1**2 + BZ_2**2) >= m*length",
        prose="The condition, applied to the direction Z below, in which B* Z does not depend on time.",
        checks=(
            Algebra("evidence", "B* Z = 0 at every time, whatever the signals do", ("BZ_1 = 0", "BZ_2 = 0")),
            Algebra(
                "evidence", "and so it is with the sign of its last entry as printed", ("printed_BZ_1 = 0", "printed_BZ_2 = 0")
            ),
            Algebra(
                "corrected",
                "what the currents see is a product of [I, v_1, v_2] and (w, alpha_tilde, omega_tilde), with "
                "w = alpha xi_tilde - j omega z_tilde",
                ("BZ_1 = reduced_1", "BZ_2 = reduced_2"),
                setting=compact(),
            ),
        ),
        edit="[I, v_1, v_2] for B* and I_4 for I_6; v_1 = xi_hat - (1 + beta L_m) i, v_2 = -j (z_hat - i_hat)",
        assumptions=("omega and alpha constant, as Section IV-A has them",),
        origin="paper",
        why="B* has two columns for xi and two for z that are multiples of each other turned by 90 degrees",
        consequences=("proposition-IV.3", "proposition-IV.4"),
        units="the entries of the integral are in 1/s, A and A^2 s, so that one m cannot bound them all without weights",
        note="Under Section IV-B, where omega moves, the unseen direction moves with it, and the 6x6 condition is no "
        "longer empty.",
    ),
    claim(
        "eq19.B.1",
        "first row of B*",
        HOLDS,
        compact(),
        checks=(Algebra("printed", "the d-axis row of (12)", (f"i_ds_tilde_dot = {_D} + printed_BZ_1",)),),
        prose="A* S + B* Z gives the rate of the d-axis current error.",
        assumptions=("varphi stands for omega",),
    ),
    claim(
        "eq19.B.2",
        "second row of B*",
        CORRECTED,
        compact(),
        printed=f"i_qs_tilde_dot = {_Q} + printed_BZ_2",
        corrected=f"i_qs_tilde_dot = {_Q} + BZ_2",
        edit="i_ds_hat - z_1_hat for z_1_hat - i_ds_hat",
        prose="A* S + B* Z gives the rate of the q-axis current error.",
        origin="paper",
        why="the last entries of the two rows are printed alike; (12) has -omega_tilde z_1_hat",
        assumptions=("varphi stands for omega",),
    ),
    claim(
        "eq20.S",
        "rate of the current errors",
        HOLDS,
        compact(),
        prose="With B* corrected.",
        checks=(
            Algebra("printed", "the rows", (f"i_ds_tilde_dot = {_D} + BZ_1", f"i_qs_tilde_dot = {_Q} + BZ_2")),
            shapes("printed", "S is 2x1, Z is 6x1, A* 2x2, B* 2x6", (2, 1), ((2, 2), (2, 1)), ((2, 6), (6, 1))),
        ),
    ),
    claim(
        "eq20.Z",
        "rate of the other errors",
        HOLDS,
        compact(),
        prose="D* has these rows; it is 6x2 and moves with the estimates.",
        checks=(
            Algebra("printed", "the rows of D*", (*_Z, *_LAWS)),
            shapes("printed", "D* is 6x2", (6, 1), ((6, 2), (2, 1))),
            Algebra(
                "evidence",
                "D* is -G B*^T, as the lemma on excitation needs it, with this G in the z rows, which moves with "
                "omega_hat: the lemma asks for a constant one",
                (
                    "z_1_tilde_dot = -(k_2*omega_hat/omega)*(-omega*i_qs_tilde)",
                    "z_2_tilde_dot = -(k_2*omega_hat/omega)*(omega*i_ds_tilde)",
                ),
            ),
        ),
        note="With Sign(omega) in (11) the last row has the wrong sign for omega < 0.",
    ),
    claim(
        "eq20.A",
        "the matrix A*",
        HOLDS,
        compact().extended("no_Z", cases=tuple({**dict.fromkeys(ORDER, 0), "direction": s} for s in (1, -1))),
        prose="With Z = 0.",
        checks=(Algebra("printed", "its rows", (f"i_ds_tilde_dot = {_D}", f"i_qs_tilde_dot = {_Q}")),),
    ),
    claim(
        "proposition-IV.3",
        "under (19) all errors vanish",
        CORRECTED,
        at_rest(),
        printed=("z_1_tilde = 0", "xi_1_tilde = 0"),
        checks=(
            Algebra(
                "evidence",
                "the premise is never met: at these constant speeds B* does not see Z, so that the integral of (19) stays 0",
                ("BZ_1 = 0", "BZ_2 = 0"),
                setting=null_space(),
            ),
            Algebra(
                "evidence",
                "a rest point of the whole error dynamics whatever z_tilde is: no excitation moves it",
                tuple(f"{one}_dot = 0" for one in ERRORS),
            ),
            Algebra(
                "corrected",
                "what vanishes is (i_tilde, w, alpha_tilde, omega_tilde): with the repaired observer they form a "
                "closed system of the lemma's form, R = [I, v_1, v_2], G = diag(c, c, g, K_p), c = alpha k_3 + kappa |omega|",
                _REDUCED,
                setting=_reduced(),
            ),
            Algebra(
                "corrected",
                "z_tilde and xi_tilde settle at alpha q / c and j omega q / c, where q = k_3 z_tilde - j kappa s "
                "xi_tilde never changes",
                ("q_1_dot = 0", "q_2_dot = 0"),
                setting=repaired(),
            ),
            Algebra(
                "evidence",
                "z_tilde and xi_tilde from w and q",
                (
                    "(alpha*k_3 + kappa*(direction*omega))*z_1_tilde = alpha*q_1 - kappa*direction*w_2",
                    "(alpha*k_3 + kappa*(direction*omega))*z_2_tilde = alpha*q_2 + kappa*direction*w_1",
                    "(alpha*k_3 + kappa*(direction*omega))*xi_1_tilde = k_3*w_1 - omega*q_2",
                    "(alpha*k_3 + kappa*(direction*omega))*xi_2_tilde = k_3*w_2 + omega*q_1",
                ),
                setting=repaired(),
            ),
            *(
                Algebra(
                    "evidence", f"what is kept while omega_hat stands still: {words}", _KEPT[which], setting=observable(which)
                )
                for which, words in (
                    ("printed_7", "(7) and the expanded (8)"),
                    ("printed_L", "L(omega_hat)"),
                    ("consistent_12", "the feedback that (12) needs"),
                )
            ),
            Algebra(
                "evidence",
                "without errors, alpha and the speed act on the currents along one line at every moment at which the "
                "magnitude of the flux stands still",
                COLLINEAR,
                setting=true_regressors(),
            ),
            Algebra(
                "evidence",
                "with constant flux magnitude the ratio is slip / alpha: where that is constant too, one combination "
                "of the alpha and speed errors is never seen",
                STEADY,
                setting=steady_flux(),
            ),
        ),
        prose="Errors of z and xi tend to zero.",
        edit="the repaired observer; [I, v_1, v_2] exciting in place of (19); w in place of "
        "z_tilde and xi_tilde, which settle at constants that q(0) fixes",
        origin="paper",
        why="(19) cannot be met for constant omega and alpha: read strictly, the proposition is vacuously true and says "
        "nothing. What is refuted is its conclusion, which is what it is printed for",
        assumptions=(
            "omega not zero and alpha constant, alpha >= alpha_l, the projection at rest",
            "i, phi and u of the machine bounded",
            "V of repair 2 bounds the errors, hence v_1, v_2 and their rates are bounded",
            _LEMMA,
        ),
        note="The flux below (11) needs w, alpha_hat and omega_hat only (eq11.flux_d), so it converges. Exponential "
        "convergence is at a "
        "rate that depends on the trajectory, because v_1 and v_2 hold estimates.",
        consequences=("proposition-IV.4",),
    ),
    claim(
        "eq21.S",
        "rate of the current errors while the speed moves",
        HOLDS,
        moving_speed("consistent_12").extended(
            "moving_compact", definitions=products("BZ", excitation.corrected_19(*ARGUMENTS), names(*ORDER))
        ),
        prose="With B* corrected.",
        checks=(Algebra("printed", "the rows", (f"i_ds_tilde_dot = {_D} + BZ_1", f"i_qs_tilde_dot = {_Q} + BZ_2")),),
    ),
    claim(
        "eq21.Z",
        "rate of the other errors while the speed moves",
        HOLDS,
        moving_speed("consistent_12"),
        prose="With E* corrected.",
        checks=(Algebra("printed", "the rows", (*_Z, _LAWS[0], _LAWS[1].replace("= -", "= omega_dot - "))),),
    ),
    claim(
        "eq21.E",
        "shape of E*",
        CORRECTED,
        edit="six entries, the last one 1",
        origin="paper",
        why="Z has six entries, E* is printed with five",
        prose="E* has five entries, the last one 1.",
        checks=(
            shapes("printed", "E* as printed is 5x1", (6, 1), ((6, 2), (2, 1)), ((5, 1), (1, 1))),
            shapes("corrected", "with six entries it fits", (6, 1), ((6, 2), (2, 1)), ((6, 1), (1, 1))),
        ),
    ),
    claim(
        "proposition-IV.4",
        "under (19) and (22) the speed error obeys (23)",
        Verdict.OPEN,
        checks=(
            _ONE_FOR_ALL,
            _PER_TRAJECTORY,
            Algebra(
                "evidence",
                "with kappa > 0 it enters w in the same way, and c moves with the speed",
                (
                    "w_1_dot = -(alpha*k_3 + kappa*direction*omega)*i_ds_tilde + omega_dot*z_2_tilde",
                    "w_2_dot = -(alpha*k_3 + kappa*direction*omega)*i_qs_tilde - omega_dot*z_1_tilde",
                ),
                setting=moving_speed("repaired"),
            ),
        ),
        edit="kappa = 0; [I, v_1, v_2] exciting for (19); the norm of (i_tilde, w, alpha_tilde, omega_tilde)(0) for that of "
        "omega_tilde(0), and K_2 proportional to M_1 (1 + |z_tilde(0)|)",
        why="the text does not say what K_1 and K_2 may depend on; the solution of (21), linear along a trajectory, is bounded "
        "by its whole initial state, not by one entry of it",
        assumptions=(
            "alpha constant, alpha >= alpha_l, the projection at rest",
            "i, phi, omega and u of the machine bounded; v_1, v_2 and their rates bounded, which no V gives here",
            "A* moves with omega; in a frame turned by the integral of omega it is constant, R^T R is the same there, and the "
            "lemma applies",
            _LEMMA,
            "an exponentially stable linear system maps bounded inputs to bounded states (Khalil, Section 9.2)",
        ),
        note="For constant omega the condition (19) cannot be met at all; it can while omega moves. With the edit, (23) "
        "says more than that the speed error is bounded, and holds. For the printed z-loop gain k_2 omega_hat neither reading "
        "is proved.",
    ),
    claim(
        "eq22.bound",
        "the acceleration is bounded",
        HOLDS,
        first_principles(),
        checks=(
            Algebra(
                "reading",
                "it is, by (1), where the currents, the fluxes and the load are",
                ("omega_dot = mu*(phi_dr*i_qs - phi_qr*i_ds) - n_p*T_l/J",),
            ),
        ),
        cited="bounded currents, fluxes and load: an assumption, not a theorem; machine-checked is the rate in the finding",
        note="An assumption of Proposition IV.4, that bounded currents, fluxes and load fulfil.",
    ),
    claim(
        "eq23.bound",
        "the bound on the speed error",
        Verdict.OPEN,
        checks=(
            _ONE_FOR_ALL,
            _PER_TRAJECTORY,
            Algebra(
                "evidence",
                "at constant speed it is the current errors that drive the speed error, in proportion along a trajectory",
                ("omega_tilde_dot = -K_p*direction*(v_21*i_ds_tilde + v_22*i_qs_tilde)",),
                setting=observable(),
            ),
        ),
        edit="the norm of (i_tilde, w, alpha_tilde, omega_tilde)(0) for that of omega_tilde(0)",
        why="the text does not say what K_1 and K_2 may depend on",
        note="If K_1 and K_2 may depend on the other initial errors, (23) says no more than that the speed error is bounded.",
        consequences=("proposition-IV.4",),
    ),
]
