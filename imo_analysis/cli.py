"""The command line ``imo``: finds the command, runs it, and turns every fault of the input into one line and exit code 2."""

from __future__ import annotations

import argparse
import os
import re
import sys
import warnings
from importlib import import_module
from typing import Any

from imo_analysis import __version__
from imo_analysis.errors import Diverged, InputError

# name -> what it does, in a line; the module is imo_analysis.commands.<name>, imported only when it is the one called
COMMANDS = {
    "report": "write the dossier of a study: verdicts, tables, poles, runs, excitation",
    "derive": "verified derivations: the ledger of the paper's equations",
    "poles": "poles of the observers' frozen-speed error dynamics",
    "tune": "gains that meet a wish over a range of speeds, found, chosen and verified",
    "simulate": "run plant, drive and observers of a study",
    "excite": "persistence of excitation along a run, and where it is lost",
    "sweep": "Monte Carlo and grids over any field of a study",
    "replay": "run an observer over a recorded log",
    "study": "write a study file to start from",
    "notebook": "the course and the derivations as Jupyter notebooks",
}
_NUMBER_LIKE = re.compile(r"^-[\d.]")


def main(argv: list[str] | None = None) -> int:
    """Run the command line; returns the exit code: 0 done, 1 a check failed or a run diverged, 2 bad input."""
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _warn
            return _run(sys.argv[1:] if argv is None else argv)
    except InputError as error:
        return _stop(str(error), 2)
    except Diverged as error:
        return _stop(str(error), 1)
    except KeyboardInterrupt as error:
        return _stop(str(error) or "interrupted; files written so far are whole, the one in work was left out", 2)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 2
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _stop(f"{place}{error.strerror or error}", 2)
    except MemoryError:
        return _stop("out of memory; shorten the run, record less often or sweep fewer points", 2)


def _warn(message: Warning | str, *_: Any, **__: Any) -> None:
    """A warning is one line too, without the place in the code that gave it."""
    print(f"imo: warning: {message}", file=sys.stderr)


def _stop(text: str, code: int) -> int:
    print(f"imo: {text}", file=sys.stderr)
    return code


def _run(argv: list[str]) -> int:
    if not argv or argv[0] in ("-h", "--help"):
        print(_overview())
        return 0
    if argv[0] in ("-V", "--version"):
        print(f"imo_analysis {__version__}")
        return 0
    name = argv[0]
    if name not in COMMANDS:
        raise InputError(f"{name!r} is not a command; choose one of: {', '.join(COMMANDS)}")
    return _called(name, parser_of(name).parse_args(_joined(argv[1:])))


def _called(name: str, args: argparse.Namespace) -> int:
    """Run the command; where it draws for a slide, all of it is in a block that says so."""
    if getattr(args, "size", "column") == "column":
        return int(_module(name).run(args))
    if name != "report" and not (args.plot or getattr(args, "map", None)):
        raise InputError(f"--size {args.size} is about a figure; ask for one too, such as with --plot FILE.svg")
    from imo_analysis.drawing import sized

    with sized(args.size):
        return int(_module(name).run(args))


def parser_of(name: str) -> argparse.ArgumentParser:
    """The parser of a command, one of `COMMANDS`; the manual lists its options from it."""
    command = _module(name)
    parser = _Parser(
        prog=f"imo {name}",
        description=command.DESCRIPTION,
        epilog="\n".join(["example:", *(f"  {line.strip()}" for line in command.EXAMPLE.strip().splitlines())]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    command.add_arguments(parser)
    if name == "report" or any(action.dest == "plot" for action in parser._actions):
        parser.add_argument("--size", choices=("column", "slide"), default="column", metavar="SIZE",
                            help="of figures: for a page column, or for a slide")
    parser.add_argument("--json", metavar="FILE", help="write it as JSON (FORMATS.md); - for standard output")
    return parser


def _module(name: str) -> Any:
    return import_module(f"imo_analysis.commands.{name}")


def _joined(argv: list[str]) -> list[str]:
    """Join ``--full -2`` with ``=``, since argparse takes a value that begins with a dash for an option."""
    joined: list[str] = []
    for word in argv:
        if _NUMBER_LIKE.match(word) and joined and joined[-1].startswith("--") and "=" not in joined[-1]:
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


class _Parser(argparse.ArgumentParser):
    """argparse, with faults as `InputError` so that all faults look the same."""

    def error(self, message: str) -> None:  # type: ignore[override]
        raise InputError(f"{message} (see {self.prog} --help)")


def _overview() -> str:
    lines = ["usage: imo COMMAND [options]", ""]
    lines += ["Speed-sensorless observers of induction machines: proved, linearised, run, written up.", ""]
    lines += [f"  {name:<10} {meaning}" for name, meaning in COMMANDS.items()]
    lines += ["", "imo COMMAND --help shows its options and an example; imo report, with nothing else, is the main job."]
    lines += ["Exit codes: 0 done, 1 a check failed or a run diverged, 2 bad input."]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
