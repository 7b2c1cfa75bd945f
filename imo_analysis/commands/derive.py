"""``imo derive``: the ledger as a table, one entry in full, kernels, mutants, and the Coq script."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from imo_analysis.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from imo_analysis.ledger.claim import Claim

DESCRIPTION = """\
Every equation, table and claim of the paper with a verdict settled by exact arithmetic.
Exit code 1 if a computed verdict is not the expected one, two kernels disagree, or a mutant is missed."""
EXAMPLE = """\
  imo derive                      the ledger as a table
  imo derive eq12                 the entries whose id begins with eq12, in full
  imo derive --kernel all --mutants --json ledger.json
  imo derive --subject kubota     another observer's argument, audited with the same tool"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("ids", nargs="*", metavar="ID", help="show in full the entries whose id begins with ID")
    parser.add_argument("--kernel", default=None, choices=("sympy", "flint", "coq", "all"),
                        help="who settles the claims; without it sympy and flint, which must agree")
    parser.add_argument("--mutants", nargs="?", const="claims", choices=("claims", "definitions", "all"),
                        help="also change each sign, coefficient, exponent, index, hat and tilde of the claims in turn "
                             "(or each token of the definitions): every one that is not equal must be rejected")
    parser.add_argument("--subject", default="paper", help="paper (default) or kubota")
    parser.add_argument("--export-coq", metavar="DIR", help="write all lemmas to DIR/ledger.v")


def run(args: argparse.Namespace) -> int:
    """Settle the claims and print the ledger."""
    from imo_analysis.commands.output import check_places, emit_json, say
    from imo_analysis.ledger import show
    from imo_analysis.ledger.book import entries, kernel_names, subject

    check_places(args)
    claims = _chosen(subject(args.subject), args.ids)
    kernels = ("sympy", "flint") if args.kernel is None else kernel_names(args.kernel)
    settled = entries(kernels, claims)
    data: dict[str, Any] = {
        "subject": args.subject, "kernels": list(kernels), "counts": show.counts(settled),
        "disagreements": sum("kernels disagree" in error for entry in settled for error in entry.errors),
        "entries": [entry.to_dict() for entry in settled],
    }
    if args.ids:
        say(args, "\n\n".join(show.full(entry) for entry in settled))
    else:
        say(args, show.table(settled))
    say(args, f"\n{show.summary(settled)}; kernels: {', '.join(kernels)}")
    good = all(entry.ok for entry in settled)
    if args.mutants in ("claims", "all"):
        from imo_analysis.ledger.mutants import try_mutants

        report = try_mutants(claims, kernels)
        say(args, report.text())
        data["mutants"] = report.to_dict()
        good = good and report.ok
    if args.mutants in ("definitions", "all"):
        from imo_analysis.ledger.definition_mutants import try_definitions

        seeded = try_definitions()
        say(args, seeded.text())
        data["definition_mutants"] = seeded.to_dict()
        good = good and seeded.ok
    if args.export_coq:
        say(args, f"wrote {_export(claims, args.export_coq)}")
    emit_json(args, "imo-ledger/1", data)
    return 0 if good else 1


def _chosen(claims: Sequence[Claim], ids: Sequence[str]) -> Sequence[Claim]:
    """The claims whose id begins with one of ``ids``; all without ids."""
    for prefix in ids:
        if not any(claim.id.startswith(prefix) for claim in claims):
            import difflib

            stems = sorted({claim.id.split(".")[0] for claim in claims})
            close = difflib.get_close_matches(prefix, stems, 3) or stems[:8]
            raise InputError(f"no entry begins with {prefix!r}; for example {', '.join(close)} (imo derive lists all)")
    return [claim for claim in claims if not ids or claim.id.startswith(tuple(ids))]


def _export(claims: Sequence[Claim], directory: str) -> str:
    from imo_analysis.files import folder, write_text
    from imo_analysis.ledger.kernels.coq_script import lemma, script
    from imo_analysis.ledger.settle import plan

    path = folder(directory) / "ledger.v"
    write_text(path, script([lemma(one.question) for claim in claims for one in plan(claim)[0]]))
    return str(path)
