"""Exact answers from Coq: the questions as lemmas over the reals in one script, checked by ``coqc``."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from imo_analysis.errors import InputError
from imo_analysis.ledger.kernels.coq_script import HEADER, lemma
from imo_analysis.ledger.question import Question

_SECONDS = 300  # for one run of coqc; the whole ledger takes far less
_LINE = re.compile(r"line (\d+), characters")


class CoqKernel:
    """Settles what ``coqc`` accepts. The questions are shared between ``processes`` runs of it."""

    name = "coq"

    def __init__(self, processes: int = 2) -> None:
        program = shutil.which("coqc")
        if program is None:
            raise InputError("the coq kernel needs coqc, which is not installed; on Debian and Ubuntu: apt install coq")
        self._program = program
        self._processes = processes

    def answer(self, questions: Sequence[Question]) -> list[bool]:
        """For each question, whether Coq accepts its lemma."""
        lemmas = [lemma(one) for one in questions]
        shares = [range(start, len(lemmas), self._processes) for start in range(self._processes)]
        with ThreadPoolExecutor(self._processes) as pool:
            accepted = set().union(*pool.map(lambda share: self._accepted(lemmas, share), shares))
        return [number in accepted for number in range(len(lemmas))]

    def _accepted(self, lemmas: Sequence[str], share: Sequence[int]) -> set[int]:
        """The lemmas of a share that Coq accepts: after a rejected one the run goes on with the next."""
        left = list(share)
        good: set[int] = set()
        while left:
            rejected = self._first_rejected([lemmas[number] for number in left])
            if rejected is None:
                return good | set(left)
            good |= set(left[:rejected])
            left = left[rejected + 1:]
        return good

    def _first_rejected(self, lemmas: Sequence[str]) -> int | None:
        """Position of the first lemma that Coq rejects, None if it accepts all."""
        result = run_coq(self._program, script(lemmas))
        if result.returncode == 0:
            return None
        match = _LINE.search(result.stderr)
        if not match:
            raise InputError(f"coqc ended with code {result.returncode}: {result.stderr.strip()[:300] or 'no message'}")
        line, at = int(match[1]), HEADER.count("\n") + 1
        for position, text in enumerate(lemmas):
            at += text.count("\n") + 1
            if line < at:
                return position
        raise InputError(f"coqc stopped after the last lemma: {result.stderr.strip()[:300]}")


def script(lemmas: Sequence[str]) -> str:
    """The whole file: the header, then the lemmas."""
    return HEADER + "".join(f"\n{one}" for one in lemmas)


def run_coq(program: str, text: str) -> subprocess.CompletedProcess[str]:
    """Run ``coqc`` on a script in a folder of its own.

    Raises
    ------
    InputError
        If it takes too long.
    """
    with tempfile.TemporaryDirectory(prefix="imo-coq-") as folder:
        (Path(folder) / "ledger.v").write_text(text, encoding="utf-8")
        try:
            return subprocess.run([program, "-q", "-noglob", "ledger.v"], cwd=folder, capture_output=True, text=True,
                                  timeout=_SECONDS, check=False)
        except subprocess.TimeoutExpired:
            raise InputError(f"coqc took more than {_SECONDS} s; export the script and look for the slow lemma") from None
