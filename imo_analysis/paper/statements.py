"""Lemma, propositions, remark, and the claims of the running text that can be checked, each in our words."""

from __future__ import annotations

from dataclasses import dataclass

from imo_analysis.paper.item import Item, Row


@dataclass(frozen=True)
class Figure:
    """A figure by its caption: number, steps of the speed reference in rad/s, whether alpha is biased in it."""

    number: int
    steps: tuple[int, int]
    alpha_biased: bool


# The figures themselves are lost in the scan, and so is the caption of Fig. 1, whose steps the text gives.
FIGURES: tuple[Figure, ...] = (Figure(1, (50, 100), False), Figure(2, (20, 40), False), Figure(3, (40, 100), True))
# Section V: where alpha_hat starts and ends in the last run, in 1/s, and that run's figure.
ALPHA_START, ALPHA_FINAL, ALPHA_FIGURE = 6.6, 10.5, 4
COMPARED_IN = (2, 3)  # the figures that the text names for the comparison with unbiased parameters

STATEMENTS: tuple[Item, ...] = (
    Item("guaranteed-stability", "", "Abstract",
         "The observer guarantees asymptotic stability of the estimation errors."),
    Item("baseline-not-convergent", "", "Section II-B, below (4)",
         "The zero solution of the baseline observer's error dynamics cannot be asymptotically stable."),
    Item("z-needs-measurements-only", "", "Section III-A, below (7)",
         "The dynamics of z involve measured currents and voltages only."),
    Item("projection-keeps-bound", "", "Section III-B, below (10)",
         "The projection keeps alpha_hat above alpha_l, and is smooth."),
    Item("remark-III.1", "Remark III.1", "Section III-B",
         "The law (11) and its analysis need the direction of rotation; at medium and high speed that is no restriction."),
    Item("lemma-IV.1", "Lemma IV.1", "Section IV-A",
         "Barbalat: a uniformly continuous function on [0, infinity] whose integral has a finite limit tends to zero."),
    Item("proposition-IV.2", "Proposition IV.2", "Section IV-A",
         "With (8), (9) and (11) the current errors tend to zero and all state errors stay bounded."),
    Item("projection-inequality", "", "Section IV-A, below (15)",
         "With (9), the alpha terms of the derivative of V are together at most zero.",
         (Row("inequality", "i_ds_tilde*alpha_tilde*(xi_1_hat - (1 + beta*L_m)*i_ds)"
              " + i_qs_tilde*alpha_tilde*(xi_2_hat - (1 + beta*L_m)*i_ds) + alpha_tilde*alpha_tilde_dot/g <= 0"),)),
    Item("sign-operator", "", "Section IV-A, below (15)",
         "The sign operator makes the term with the rate of omega_hat at most zero.",
         (Row("inequality", "-omega_dot/omega_hat**2*omega/(2*k_2)*(z_1_tilde**2 + z_2_tilde**2) <= 0",
              scan="The numerator shows omega with a dot and no hat, as in (14); the denominator shows omega**2 without the "
              "hat that (14) has."),)),
    Item("bounded-from-16", "", "Section IV-A, below (16)",
         "(16) implies V(t) < V(0), and from that all errors are bounded."),
    Item("barbalat-step", "", "Section IV-A, below (18)",
         "The current errors are uniformly continuous and square integrable, so they tend to zero."),
    Item("proposition-IV.3", "Proposition IV.3", "Section IV-A",
         "Under (19), the errors of z, xi, alpha and omega tend to zero, exponentially from arbitrary initial conditions."),
    Item("proposition-IV.4", "Proposition IV.4", "Section IV-B",
         "Under (19) and (22), the speed error obeys (23)."),
    Item("initial-conditions", "", "Section V",
         "All observers start from zero initial conditions."),
    Item("similar-eigenvalues", "", "Section V",
         "The two observers have similar negative eigenvalues, so the proposed one converges fast."),
    Item("unbiased-parameters", "", "Section V",
         "All parameters of both observers are unbiased; the nominal alpha is 10."),
    Item("figure-references", "", "Section V",
         "Figures 2(b) and 3(b) compare the observers at different speeds; Figures 1 and 2 show steps 50-100 and 20-40 rad/s."),
    Item("alpha-final", "", "Section V, last paragraph",
         "alpha_hat ends at 10.5, slightly off the nominal 9.9354."),
)
