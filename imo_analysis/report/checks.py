"""What is slow, made by a process of its own beside the simulations: mutants, proofs on Table II, and the drive as it is.

    python -m imo_analysis.report.checks FILE.json STUDY.toml

The checks are plain data, the same for every study; what `imo_analysis.report.drive` computes is left beside FILE.json.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any


def checks() -> dict[str, Any]:
    """What seeded faults show of the ledger and the definitions, and what is proved on Table II.

    Returns
    -------
    dict
        ``mutants``: claims, tried, rejected (by kernel), equivalent and missed (texts). ``definition_mutants``: modules,
        functions, tried, killed, equivalent, survived and unchecked (texts). ``constants``: name, unit, low and high of the
        values that give all 24 printed numbers. ``answers``: what the table says, question by question, as
        `imo_analysis.pencils.table2_answers.Answer`. ``refutations``: form, source, column, what is forced, what the printed
        digits give by speed, the values of alpha, and whether it is proved.
    """
    from imo_analysis.ledger.book import claims
    from imo_analysis.ledger.definition_mutants import try_definitions
    from imo_analysis.ledger.mutants import try_mutants
    from imo_analysis.pencils.table2_answers import answers
    from imo_analysis.pencils.table2_constants import UNITS, ranges
    from imo_analysis.pencils.table2_proofs import refutations

    return {
        "schema": "imo-report-checks/1",
        "mutants": try_mutants(claims(), ("flint",)).to_dict(),
        "definition_mutants": try_definitions().to_dict(),
        "constants": [
            {"name": one.name, "unit": UNITS[one.name], "low": float(one.outer.low), "high": float(one.outer.high)}
            for one in ranges()
        ],
        "answers": [asdict(one) for one in answers()],
        "refutations": [
            {
                "form": one.form, "source": one.source, "column": one.column, "forced": one.forced,
                "printed": [[omega, float(value.low), float(value.high)] for omega, value in one.printed.items()],
                "alphas": list(one.alphas), "proved": one.proved,
            }
            for one in refutations()
        ],
    }


@contextmanager
def beside(path: Path, study: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start the checks and the drive of a study file in another process, which ends with the block whatever happens in it."""
    worker = subprocess.Popen([sys.executable, "-m", "imo_analysis.report.checks", str(path), str(study)],
                              stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)
    try:
        yield worker
    finally:
        worker.kill()
        worker.wait()


def collect(worker: subprocess.Popen[bytes], path: Path) -> dict[str, Any]:
    """Wait for the checks and read them.

    Raises
    ------
    RuntimeError
        If the process failed; with what it said.
    """
    said = worker.stderr.read() if worker.stderr else b""
    worker.wait()
    if worker.returncode != 0:
        raise RuntimeError(f"the checks failed: {said.decode(errors='replace').strip()[-2000:]}")
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    found["searched"] = json.loads(beside_file(path).read_text(encoding="utf-8"))
    beside_file(path).unlink()
    return found


def beside_file(path: Path) -> Path:
    """Where the search for gains is left until it is read."""
    return path.with_name("searched.json")


def main(file: Path, study: Path) -> None:
    """Compute all and write it."""
    from imo_analysis.report import drive, searched
    from imo_analysis.study import Study

    found, loaded = checks(), Study.load(study)
    found["no_map"] = drive.compute(loaded, file.parent)
    beside_file(file).write_text(json.dumps(searched.compute(loaded)), encoding="utf-8")  # in which a time may be infinite
    file.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
