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
from imo_analysis.ledger.kernels.coq_script import HEADER, lemma, script
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
        return self.accepts(HEADER, [lemma(one) for one in questions])

    def accepts(self, header: str, blocks: Sequence[str]) -> list[bool]:
        """For each block of a script, whether Coq accepts it after the header and the accepted blocks before it."""
        shares = [range(start, len(blocks), self._processes) for start in range(self._processes)]
        with ThreadPoolExecutor(self._processes) as pool:
            accepted = set().union(*pool.map(lambda share: self._accepted(header, blocks, share), shares))
        return [number in accepted for number in range(len(blocks))]

    def _accepted(self, header: str, blocks: Sequence[str], share: Sequence[int]) -> set[int]:
        """The blocks of a share that Coq accepts: after a rejected one the run goes on with the next."""
        left = list(share)
        good: set[int] = set()
        while left:
            rejected = self._first_rejected(header, [blocks[number] for number in left])
            if rejected is None:
                return good | set(left)
            good |= set(left[:rejected])
            left = left[rejected + 1:]
        return good

    def _first_rejected(self, header: str, blocks: Sequence[str]) -> int | None:
        """Position of the first block that Coq rejects, None if it accepts all."""
        result = run_coq(self._program, script(blocks, header))
        if result.returncode == 0:
            return None
        match = _LINE.search(result.stderr)
        if not match:
            raise InputError(f"coqc ended with code {result.returncode}: {result.stderr.strip()[:300] or 'no message'}")
        line, end = int(match[1]), header.count("\n")
        for position, text in enumerate(blocks):
            end += text.count("\n") + 1
            if line <= end:
                return position
        raise InputError(f"coqc stopped after the last lemma: {result.stderr.strip()[:300]}")


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
