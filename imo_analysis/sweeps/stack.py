"""Working memory on the stack of a compiled function, aligned to cache lines.

LLVM keeps what does not fit into registers on the stack, and aligns the stack for vectors only when it knows of an aligned
variable before it assigns registers. Without one, 32-byte spills cross cache lines or not as the caller's stack happens to
lie: the same kernel then costs between 1 and 1.4 times as much, from process to process. With the working memory itself beside
the spills, their distance, on which the processor's guesses about memory depend, is always the same.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

ALIGNMENT = 64


@intrinsic
def stack_memory(typing_context: Any, size: Any) -> Any:
    """Pointer to ``size`` doubles, a constant, on the stack of the calling function; they hold anything at first."""
    if not isinstance(size, types.IntegerLiteral):
        return None
    count = size.literal_value

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), count))
        place.align = ALIGNMENT
        return builder.bitcast(place, ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(size), generate  # type: ignore[attr-defined]
