"""The yardsticks reference.c and reference_lanes.c, built with the system's compiler and called through ctypes."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-fopenmp-simd")
_POINTER = ctypes.POINTER(ctypes.c_double)


def compiler() -> str | None:
    """The C compiler: ``$CC``, or the first of cc, gcc, clang on the path; None where there is none."""
    names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    return next((found for name in names if (found := shutil.which(name))), None)


def load(name: str, flags: tuple[str, ...] = FLAGS) -> Any:
    """A C file of this folder as a loaded library. It needs `compiler`."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "reference.so"
        source = Path(__file__).parent / name
        subprocess.run([str(compiler()), *flags, "-shared", "-fPIC", "-o", str(library), str(source), "-lm"], check=True,
                       capture_output=True)
        return ctypes.CDLL(str(library))


def pointer(array: np.ndarray) -> Any:
    """A C pointer to an array of doubles, which must be contiguous."""
    assert array.dtype == float and array.flags.c_contiguous
    return array.ctypes.data_as(_POINTER)
