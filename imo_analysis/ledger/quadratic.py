"""A quadratic form as a sum of squares, exactly: L D L^T over rational functions, as weights and bases for a claim."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Name, Number, Relation, parse, substitute
from imo_analysis.ledger.kernels.flint_kernel import FlintKernel, Quotient
from imo_analysis.ledger.setting import setting


def squares_of(form: str | Expr, variables: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Weights and bases with ``form = sum of weight * base**2``, ready for ``Claim.squares``.

    The weights are the pivots; whether they are >= 0 is for the claim's hypotheses to say. The decomposition is only found
    here: the kernels check it as an identity.

    Parameters
    ----------
    form : str or Expr
        A quadratic form in ``variables``; its coefficients are rational functions of the other names.
    variables : sequence of str
        In the order of elimination.

    Raises
    ------
    InputError
        If it is not a quadratic form, or a pivot vanishes where the rest of its row does not (then it is indefinite).
    """
    tree = parse(form) if isinstance(form, str) else form
    size = len(variables)
    kernel = FlintKernel()
    names = dict.fromkeys([*setting("form", "").free(Relation("=", tree, tree)), *variables])
    generators, constant = kernel.field(list(names))

    def at(*ones: int) -> Quotient:
        point = {name: Number(Fraction(int(position in ones))) for position, name in enumerate(variables)}
        return kernel.value(substitute(tree, point), generators, constant)

    half = constant(Fraction(1, 2))
    matrix: list[list[Any]] = [[None] * size for _ in range(size)]
    for row in range(size):
        matrix[row][row] = at(row)
        for column in range(row):
            matrix[row][column] = matrix[column][row] = (at(row, column) - at(row) - at(column)) * half
    again = Number(Fraction(0)) + sum_of(kernel, matrix, variables)
    if not kernel.equal(kernel.value(again, generators, constant), kernel.value(tree, generators, constant)):
        raise InputError(f"{tree} is not a quadratic form in {', '.join(variables)}")
    found = []
    for pivot in range(size):
        weight = matrix[pivot][pivot]
        if weight.num.is_zero():
            if any(not matrix[pivot][column].num.is_zero() for column in range(pivot + 1, size)):
                raise InputError(f"the pivot of {variables[pivot]} is zero and its row is not: the form is indefinite")
            continue
        ratios = {column: matrix[pivot][column] / weight for column in range(pivot + 1, size)}
        base = variables[pivot] + "".join(
            f" + ({kernel.show(ratio)})*{variables[column]}" for column, ratio in ratios.items() if not ratio.num.is_zero())
        found.append((kernel.show(weight), base))
        for row in range(pivot + 1, size):
            for column in range(pivot + 1, size):
                matrix[row][column] = matrix[row][column] - matrix[pivot][row] * ratios[column]
    return tuple(found)


def sum_of(kernel: FlintKernel, matrix: Sequence[Sequence[Quotient]], variables: Sequence[str]) -> Expr:
    """``x^T M x`` as a tree."""
    total: Expr = Number(Fraction(0))
    for row, first in enumerate(variables):
        for column, second in enumerate(variables):
            if not matrix[row][column].num.is_zero():
                total = total + parse(kernel.show(matrix[row][column])) * Name(first) * Name(second)
    return total
