"""What a claim speaks about: names defined through the plain definitions, and the hypotheses under which it is settled."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType

from imo_analysis.errors import InputError
from imo_analysis.ledger.expression import Expr, Relation, as_expr, evaluate, free_names, parse_relation

COMPARE = {"=": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


@dataclass(frozen=True, eq=False)
class Setting:
    """A field of rational functions to settle claims in.

    Attributes
    ----------
    name : str
        A short name, used in exported lemmas.
    text : str
        What it describes, in a sentence for the reader.
    definitions : mapping of str to Expr
        Names that stand for something: ``i_ds_tilde_dot`` for the difference of two rows, traced from the plain
        definitions. A definition may use others, in any order, but not itself. Every other name is a free real variable.
    hypotheses : tuple of Relation
        Signs and non-zero denominators, explicit: ``sigma > 0``, ``omega_hat != 0``.
    cases : tuple of mappings of str to Fraction
        A claim is settled once a case, with these free names replaced, e.g. ``({"direction": 1}, {"direction": -1})``.
    units : mapping of str to str
        Units of free names that are not in the notation table.
    """

    name: str
    text: str
    definitions: Mapping[str, Expr] = field(default_factory=dict)
    hypotheses: tuple[Relation, ...] = ()
    cases: tuple[Mapping[str, Fraction], ...] = ({},)
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "definitions", MappingProxyType(_ordered(self.name, dict(self.definitions))))

    def free(self, *relations: Relation) -> list[str]:
        """The free variables under some relations, through the definitions, in order of appearance.

        Parameters
        ----------
        *relations : Relation
            Where they are looked for.
        """
        seen: dict[str, None] = {}
        done: set[str] = set()

        def visit(tree: Expr) -> None:
            for name in free_names(tree):
                if name in self.definitions:
                    if name not in done:
                        done.add(name)
                        visit(self.definitions[name])
                else:
                    seen.setdefault(name)

        for relation in relations:
            visit(relation.left)
            visit(relation.right)
        return list(seen)

    def used(self, *relations: Relation) -> list[str]:
        """The defined names under some relations, in the order of their definition.

        Parameters
        ----------
        *relations : Relation
            Where they are looked for.
        """
        wanted: set[str] = set()

        def visit(tree: Expr) -> None:
            for name in free_names(tree):
                if name in self.definitions and name not in wanted:
                    wanted.add(name)
                    visit(self.definitions[name])

        for relation in relations:
            visit(relation.left)
            visit(relation.right)
        return [name for name in self.definitions if name in wanted]

    def hypotheses_for(self, variables: Iterable[str]) -> list[Relation]:
        """The hypotheses that speak of these free variables only.

        Parameters
        ----------
        variables : iterable of str
            Free names.
        """
        have = set(variables)
        return [one for one in self.hypotheses if set(self.free(one)) <= have]

    def values(self, point: Mapping[str, Fraction]) -> dict[str, Fraction]:
        """All values at a rational point: free names as given, defined names computed.

        Parameters
        ----------
        point : mapping of str to Fraction
            A value for each free name.

        Raises
        ------
        ZeroDivisionError
            If a denominator vanishes there.
        """
        values = _Lazy(self, dict(point))
        return values

    def extended(self, name: str, text: str = "", definitions: Mapping[str, Expr] | None = None,
                 hypotheses: Iterable[str] = (), cases: Iterable[Mapping[str, int | Fraction]] | None = None,
                 units: Mapping[str, str] | None = None) -> Setting:
        """This setting with more definitions and hypotheses; new cases replace the old.

        Parameters
        ----------
        name, text : str
            Of the new setting; without a text it keeps this one's.
        definitions, hypotheses, cases, units
            As `setting` takes them, in addition.
        """
        return setting(name, text or self.text, {**self.definitions, **(definitions or {})}, (*self.hypotheses, *hypotheses),
                       self.cases if cases is None else cases, {**self.units, **(units or {})})


def _ordered(where: str, definitions: dict[str, Expr]) -> dict[str, Expr]:
    """The definitions, each after those that it uses.

    Raises
    ------
    InputError
        If one uses itself, through others or not.
    """
    done: dict[str, Expr] = {}

    def add(name: str, path: tuple[str, ...]) -> None:
        if name in path:
            raise InputError(f"setting {where}: {name} is defined through itself ({' -> '.join((*path, name))})")
        if name not in done:
            for used in free_names(definitions[name]):
                if used in definitions:
                    add(used, (*path, name))
            done[name] = definitions[name]

    for name in definitions:
        add(name, ())
    return done


class _Lazy(dict[str, Fraction]):
    """Values of names, definitions computed when they are first asked for."""

    def __init__(self, owner: Setting, point: dict[str, Fraction]) -> None:
        super().__init__(point)
        self._owner = owner

    def __missing__(self, name: str) -> Fraction:
        if name not in self._owner.definitions:
            raise KeyError(name)
        value = Fraction(evaluate(self._owner.definitions[name], self))
        self[name] = value
        return value


def setting(name: str, text: str, definitions: Mapping[str, object] | None = None, hypotheses: Iterable[str | Relation] = (),
            cases: Iterable[Mapping[str, int | Fraction]] = ({},), units: Mapping[str, str] | None = None) -> Setting:
    """A `Setting` from plain parts: definitions as trees or numbers, hypotheses as text, cases as numbers.

    Parameters
    ----------
    name, text : str
        Its short name, and what it describes.
    definitions : mapping of str to Expr or number
        Names that stand for something.
    hypotheses : iterable of str or Relation
        Such as ``sigma > 0``.
    cases : iterable of mapping of str to int or Fraction
        Free names to replace, a case each.
    units : mapping of str to str
        Units of free names that are not in the notation table.
    """
    return Setting(
        name, text,
        {key: as_expr(value) for key, value in (definitions or {}).items()},
        tuple(parse_relation(one) if isinstance(one, str) else one for one in hypotheses),
        tuple({key: Fraction(value) for key, value in case.items()} for case in cases),
        dict(units or {}),
    )


def true_at(relation: Relation, values: Mapping[str, Fraction]) -> bool:
    """Whether a relation is true at a point, in exact arithmetic."""
    return bool(COMPARE[relation.op](evaluate(relation.left, values), evaluate(relation.right, values)))
