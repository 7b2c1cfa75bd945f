"""``imo report``: the dossier of a study."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from imo_analysis.errors import InputError

DESCRIPTION = """Writes the dossier of a study into a folder: index.html (one file, opens from disk), ledger.json, table2.csv,
the pole sweep, the runs as NetCDF and CSV, and every figure as SVG. Without a study it takes the paper's own."""
EXAMPLE = "  imo report study.toml --out dossier"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options."""
    parser.add_argument("study", nargs="?", help="study file (TOML); the paper's own study when left out")
    parser.add_argument("--out", default="imo-report", metavar="DIR", help="folder to write to (default: imo-report)")
    parser.add_argument("--small", action="store_true", help="leave out runs and pole sweep (20 MB) and the figures' own files")
    parser.add_argument("--markdown", action="store_true", help="the same as Markdown, too: index.md, with its figures")
    parser.add_argument("--pdf", action="store_true", help="the same as PDF, too: index.pdf; needs a browser")
    parser.add_argument("--quiet", action="store_true", help="no lines of progress, only what was found")


def run(args: argparse.Namespace) -> int:
    """Compute and write; 1 if an entry of the ledger is not what it should be, or a scenario diverged."""
    from imo_analysis.commands.output import check_places, emit_json, say
    from imo_analysis.files import remove_empty
    from imo_analysis.ledger.show import counts
    from imo_analysis.report.dossier import summary, write_dossier
    from imo_analysis.study import Study

    check_places(args)
    if not args.out:
        raise InputError("--out is empty; name a folder")
    study = Study.load(args.study) if args.study else Study.paper()
    if args.study and Path(args.out, "study.toml").resolve() == Path(args.study).resolve():
        raise InputError(f"--out {args.out} would replace {args.study} by a copy without comments; choose another folder")
    start = time.perf_counter()

    def note(text: str) -> None:
        if not args.quiet:
            print(f"[{time.perf_counter() - start:5.1f} s] {text}", file=sys.stderr, flush=True)

    before = Path(args.out).exists()
    try:
        written = write_dossier(study, args.out, note, args.small, args.markdown, args.pdf)
    except KeyboardInterrupt:
        if not before:
            remove_empty(args.out)
        raise
    figures = sum(name.endswith(".svg") for name, _ in written.files)
    verdicts = ", ".join(f"{number} {word}" for word, number in counts(written.entries).items())
    others = len(written.files) - 1
    say(args, f"{written.folder}/index.html: open it in a browser; beside it {others} files, {figures} of them figures.")
    say(args, f"Ledger: {len(written.entries)} entries: {verdicts}.")
    for line in written.own or written.found[:3]:
        say(args, line.replace("`", ""))
    if written.no_pdf:
        print(f"imo: {written.no_pdf}", file=sys.stderr)
    for fault in written.faults:
        print(f"imo: {fault}", file=sys.stderr)
    emit_json(args, "imo-report/1", summary(written))
    return 1 if written.faults else 0
