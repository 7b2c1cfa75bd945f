"""A question as a Coq lemma over the reals: every variable quantified, every hypothesis and definition written out.

The formulas are written straight from the trees; nothing passes through a computer algebra system.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction

from imo_analysis.ledger.expression import Expr, Name, Number, Op, Relation, walk
from imo_analysis.ledger.question import Question

HEADER = """\
(* Lemmas exported by imo derive. Coq 8.16 or newer: coqc ledger.v *)
Require Import Reals Lra Psatz.
Open Scope R_scope.

(* a denominator is not zero: by a hypothesis, by a sign, or as a sum of squares *)
Ltac zero_quotient :=
  intro; match goal with
  | H : ?a / _ > 0 |- False => replace a with 0 in H by lra; unfold Rdiv in H; rewrite Rmult_0_l in H; lra
  | H : ?a / _ <> 0 |- False => apply H; replace a with 0 by lra; unfold Rdiv; apply Rmult_0_l
  end.
Ltac plainly_not_zero := first [ assumption | lra | nra ].
Ltac not_zero_through_a_definition :=
  intro; match goal with
  | H : _ <> 0 |- False => solve [ apply H; field_simplify_eq; [ lra | repeat split; plainly_not_zero ] ]
  end.
Ltac away_from_zero :=
  first [ assumption | lra | zero_quotient | nra
        | intro; match goal with H : _ <> _ |- False => solve [ apply H; lra | apply H; nra ] end
        | not_zero_through_a_definition ].
Ltac by_field := field; repeat split; away_from_zero.

(* signs of weights: by hypotheses, through sums, products and quotients *)
Lemma product_ge a b : a <= 0 -> b <= 0 -> 0 <= a * b. Proof. nra. Qed.
Lemma product_gt a b : a < 0 -> b < 0 -> 0 < a * b. Proof. nra. Qed.
Lemma product_le_left a b : a <= 0 -> 0 <= b -> a * b <= 0. Proof. nra. Qed.
Lemma product_le_right a b : 0 <= a -> b <= 0 -> a * b <= 0. Proof. nra. Qed.
Lemma product_lt_left a b : a < 0 -> 0 < b -> a * b < 0. Proof. nra. Qed.
Lemma product_lt_right a b : 0 < a -> b < 0 -> a * b < 0. Proof. nra. Qed.
Ltac ge := first [ lra | apply pow2_ge_0 | apply Rabs_pos | solve [ unfold Rdiv; lazymatch goal with
  | |- 0 <= _ * _ => first [ solve [ apply Rmult_le_pos; ge ] | solve [ apply product_ge; le ] ]
  | |- 0 <= _ + _ => apply Rplus_le_le_0_compat; ge
  | |- 0 <= _ ^ _ => apply pow_le; ge
  | |- 0 <= _ => apply Rlt_le; gt end ] ]
with gt := first [ lra | solve [ unfold Rdiv; lazymatch goal with
  | |- 0 < _ * _ => first [ solve [ apply Rmult_lt_0_compat; gt ] | solve [ apply product_gt; lt ] ]
  | |- 0 < / _ => apply Rinv_0_lt_compat; gt
  | |- 0 < _ ^ _ => apply pow_lt; gt
  | |- 0 < - _ => apply Ropp_gt_lt_0_contravar; red; lt
  | |- 0 < _ => first [ solve [ apply Rplus_lt_0_compat; gt ] | solve [ apply Rplus_le_lt_0_compat; [ ge | gt ] ]
    | solve [ apply Rplus_lt_le_0_compat; [ gt | ge ] ] ] end ] ]
with le := first [ lra | solve [ unfold Rdiv; lazymatch goal with
  | |- _ * _ <= 0 => first [ solve [ apply product_le_left; [ le | ge ] ] | solve [ apply product_le_right; [ ge | le ] ] ]
  | |- _ <= 0 => apply Rlt_le; lt end ] ]
with lt := first [ lra | solve [ unfold Rdiv; lazymatch goal with
  | |- _ * _ < 0 => first [ solve [ apply product_lt_left; [ lt | gt ] ] | solve [ apply product_lt_right; [ gt | lt ] ] ]
  | |- / _ < 0 => apply Rinv_lt_0_compat; lt
  | |- - _ < 0 => apply Ropp_lt_gt_0_contravar; red; gt end ] ].
Ltac sum_not_zero := first [ assumption | lra | nra | apply Rgt_not_eq; red; gt | apply Rlt_not_eq; lt ].
Ltac not_negative := first [ ge | nra ].

(* cases, definitions, absolute values *)
Ltac prepare :=
  intros;
  repeat match goal with H : _ \\/ _ |- _ => destruct H | H : _ /\\ _ |- _ => destruct H end;
  subst;
  repeat match goal with
  | |- context [Rabs (- ?x)] => rewrite (Rabs_Ropp x)
  | H : ?x <= 0 |- context [Rabs ?x] => rewrite (Rabs_left1 x H)
  | H : ?x >= 0 |- context [Rabs ?x] => rewrite (Rabs_pos_eq x (Rge_le _ _ H))
  | H : ?x < 0 |- context [Rabs ?x] => rewrite (Rabs_left1 x (Rlt_le _ _ H))
  | H : ?x > 0 |- context [Rabs ?x] => rewrite (Rabs_pos_eq x (Rlt_le _ _ H))
  | |- context [Rabs ?x] => first [ rewrite (Rabs_pos_eq x) by ge | rewrite (Rabs_left1 x) by le ]
  end;
  unfold Rabs in *;
  repeat match goal with |- context [Rcase_abs ?x] => destruct (Rcase_abs x) end;
  try solve [ exfalso; lra ].

(* a statement on numbers *)
Ltac numbers :=
  unfold Rabs; repeat match goal with |- context [Rcase_abs ?x] => destruct (Rcase_abs x) end;
  first [ lra | intro; lra | left; numbers | right; numbers ].
"""

_RESERVED = {"R", "Q", "as", "at", "end", "else", "exists", "fix", "for", "forall", "fun", "if", "in", "let", "match",
             "Prop", "Set", "then", "Type", "using", "where", "with", "S", "O", "I", "PI", "IF", "cofix", "return"}
_OPS = {"=": "=", "<=": "<=", ">=": ">=", "<": "<", ">": ">", "!=": "<>"}


def coq_name(name: str) -> str:
    """A name that Coq takes for a variable."""
    return f"{name}_" if name in _RESERVED else name


def lemma_name(key: str) -> str:
    """The lemma's name for a question's id."""
    return re.sub(r"\W", "_", key)


def coq_number(value: Fraction) -> str:
    """A rational, in brackets unless it is a plain natural number."""
    if value.denominator == 1:
        return str(value) if value >= 0 else f"({value})"
    return f"({value.numerator} / {value.denominator})"


def coq_text(tree: Expr) -> str:
    """A tree in Coq's syntax, fully bracketed below the outermost sum."""
    if isinstance(tree, Name):
        return coq_name(tree.name)
    if isinstance(tree, Number):
        return coq_number(tree.value)
    assert isinstance(tree, Op)
    first = coq_text(tree.args[0])
    if tree.kind == "neg":
        return f"(- {first})"
    if tree.kind == "abs":
        return f"(Rabs {first})" if isinstance(tree.args[0], Name) else f"(Rabs ({first}))"
    if tree.kind == "**":
        power = tree.args[1]
        assert isinstance(power, Number)
        n = int(power.value)
        return f"({first} ^ {n})" if n >= 0 else f"(/ ({first} ^ {-n}))"
    return f"({first} {tree.kind} {coq_text(tree.args[1])})"


def _relation(relation: Relation) -> str:
    return f"{coq_text(relation.left)} {_OPS[relation.op]} {coq_text(relation.right)}"


def lemma(question: Question) -> str:
    """The lemma with its proof script."""
    comment = f"(* {question.id}: {question.relation} *)\n"
    return comment + (_counterexample(question) if question.kind == "counterexample" else _proof(question))


def script(lemmas: Sequence[str], header: str = HEADER) -> str:
    """The whole file: the header, then the lemmas."""
    return header + "".join(f"\n{one}" for one in lemmas)


def _proof(question: Question) -> str:
    setting, relation = question.setting, question.relation
    trees = [relation, *(Relation("=", s.weight, s.base) for s in question.squares)]
    variables, hypotheses = _under(question, trees)
    used = setting.used(*trees, *hypotheses)
    cases = _cases(setting.cases, variables)
    premises = [
        *cases,
        *(f"{coq_name(name)} = {coq_text(setting.definitions[name])}" for name in used),
        *(_relation(one) for one in hypotheses),
    ]
    bound = " ".join(coq_name(name) for name in [*variables, *used])
    quantified = f"forall {bound} : R,\n" if bound else ""
    statement = quantified + "".join(f"  {one} ->\n" for one in premises) + f"  {_relation(relation)}"
    # while defined names are still names, sums in denominators are easily seen not to be zero; afterwards they are not
    sides = [tree for one in trees for tree in (one.left, one.right)]
    sums = _sums_below([*sides, *(setting.definitions[name] for name in used)])
    facts = "".join(f"try assert ({coq_text(one)} <> 0) by sum_not_zero. " for one in sums)
    if question.kind == "identity":
        proof = f"{'intros. ' if facts else ''}{facts}prepare; by_field."
    else:
        small, large = (relation.left, relation.right) if relation.op == "<=" else (relation.right, relation.left)
        terms = [f"{coq_text(s.weight)} * {coq_text(s.base)} ^ 2" for s in question.squares]
        total = " + ".join(terms) or "0"
        proof = (
            f"\n  intros. {facts}\n  assert (H_sum : {coq_text(large)} - {coq_text(small)} = {total}) by (prepare; by_field).\n"
            + "".join(f"  assert (H_{n} : 0 <= {term}) by (apply Rmult_le_pos; [ prepare; not_negative | apply pow2_ge_0 ]).\n"
                      for n, term in enumerate(terms))
            + f"  assert (0 <= {total}) by (repeat apply Rplus_le_le_0_compat; solve [ assumption | apply Rle_refl ]).\n  lra."
        )
    return f"Lemma {lemma_name(question.id)} : {statement}.\nProof. {proof} Qed.\n"


def _sums_below(trees: Iterable[Expr]) -> list[Expr]:
    """The sums and differences that are divided by, or are factors of what is."""
    found: list[Expr] = []

    def add(tree: Expr) -> None:
        if isinstance(tree, Op) and tree.kind in "*/neg":
            for part in tree.args:
                add(part)
        elif isinstance(tree, Op) and tree.kind == "**":
            add(tree.args[0])
        elif isinstance(tree, Op) and tree.kind in "+-" and tree not in found:
            found.append(tree)

    for tree in trees:
        for node in walk(tree):
            if isinstance(node, Op) and node.kind == "/":
                add(node.args[1])
    return found


def _under(question: Question, relations: Sequence[Relation]) -> tuple[list[str], list[Relation]]:
    """Variables and hypotheses of a question; a hypothesis counts if it speaks of these variables only."""
    variables = question.setting.free(*relations)
    return variables, question.setting.hypotheses_for(variables)


def _cases(cases: Iterable[Mapping[str, Fraction]], variables: Sequence[str]) -> list[str]:
    """The disjunction of the cases, on the variables that occur; none where some case leaves all of these free."""
    options = []
    for case in cases:
        parts = [f"{coq_name(name)} = {coq_number(value)}" for name, value in case.items() if name in variables]
        if not parts:
            return []
        options.append(" /\\ ".join(parts))
    return [" \\/ ".join(f"({one})" for one in dict.fromkeys(options))] if options else []


def _counterexample(question: Question) -> str:
    """There are values for which the cases, definitions and hypotheses hold, and the relation does not."""
    setting, relation = question.setting, question.relation
    assert question.point is not None
    variables = list(question.point)
    hypotheses = setting.hypotheses_for(variables)
    used = setting.used(relation, *hypotheses)
    values = setting.values(question.point)
    parts = [
        *_cases(setting.cases, variables),
        *(f"{coq_name(name)} = {coq_text(setting.definitions[name])}" for name in used),
        *(_relation(one) for one in hypotheses),
    ]
    bound = [*variables, *used]
    quantified = f"exists {' '.join(map(coq_name, bound))} : R,\n" if bound else ""
    statement = quantified + "".join(f"  ({one}) /\\\n" for one in parts) + f"  ~ ({_relation(relation)})"
    witnesses = f"  exists {', '.join(coq_number(Fraction(values[name])) for name in bound)}.\n" if bound else ""
    return (f"Lemma {lemma_name(question.id)} : {statement}.\nProof.\n{witnesses}"
            + "  split; [ numbers |].\n" * len(parts) + "  numbers.\nQed.\n")
