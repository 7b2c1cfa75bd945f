"""Vector code with an aligned stack.

LLVM keeps what does not fit into registers on the stack, and aligns the stack for vectors only when it knows of an aligned
variable before it assigns registers. Without one, 32-byte spills cross cache lines or not as the caller's stack happens to
lie: the same kernel then costs between 1 and 1.4 times as much, from process to process.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

ALIGNMENT = 64


@intrinsic
def align_stack(typing_context: Any) -> Any:
    """Give the calling function one aligned variable on its stack, which nothing may remove; costs nothing at run time."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = cgutils.alloca_once(builder, ir.IntType(64))
        place.align = ALIGNMENT
        builder.asm(ir.FunctionType(ir.VoidType(), [place.type]), "", "r,~{memory}", [place], True)
        return context.get_dummy_value()

    return types.void(), generate
