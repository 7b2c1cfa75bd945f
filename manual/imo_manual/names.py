"""Every public name of the package, read from its source without importing it: signatures, docstrings, what they document.

Public is what has no underscore in front, in any module of the package: functions, classes, their methods, properties and
fields. Left out are the modules of `imo_analysis.commands`, whose interface is the command line.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "imo_analysis"
_SECTION = re.compile(r"^([A-Z][A-Za-z ]+)\n-{3,}\n", re.MULTILINE)
_ENTRY = re.compile(r"^(\*{0,2}\w+(?:,\s*\*{0,2}\w+)*)\s*(?::\s*(.*))?$")


@dataclass(frozen=True)
class Argument:
    """An argument of a function, or a field of a class: its name, its annotation and its default as written."""

    name: str
    annotation: str = ""
    default: str = ""
    mark: str = ""


@dataclass(frozen=True)
class Public:
    """A public function, class, method or property.

    Attributes
    ----------
    module, name : str
        Where it is, and its name there; ``Class.method`` for a method.
    kind : str
        ``function``, ``class``, ``method`` or ``property``.
    arguments : tuple of Argument
        Of a function or method without self; of a class its fields, or the arguments of its ``__init__``.
    returns : str
        The annotation of what it returns.
    doc : str
        Its docstring.
    members : tuple of Public
        Methods and properties of a class.
    bases : tuple of str
        Classes that a class is made from.
    """

    module: str
    name: str
    kind: str
    arguments: tuple[Argument, ...]
    returns: str
    doc: str
    members: tuple[Public, ...] = ()
    bases: tuple[str, ...] = ()

    @property
    def full(self) -> str:
        """The dotted name."""
        return f"{self.module}.{self.name}"


@dataclass(frozen=True)
class Module:
    """A module: its dotted name, its docstring, its public names, and the constants that it defines."""

    name: str
    doc: str
    public: tuple[Public, ...]
    constants: tuple[str, ...]
    tree: ast.Module = field(repr=False, compare=False)


@cache
def modules(package: Path = PACKAGE) -> tuple[Module, ...]:
    """All modules of the package but those of its commands, by name."""
    return tuple(sorted(_modules(package), key=lambda one: one.name))


def _modules(package: Path) -> Iterator[Module]:
    for path in package.rglob("*.py"):
        parts = [*path.relative_to(package.parent).with_suffix("").parts]
        if "commands" in parts or path.name == "build.py":
            continue
        if parts[-1] == "__init__":
            parts.pop()
        yield read_module(path.read_text(encoding="utf-8"), ".".join(parts))


def read_module(source: str, name: str) -> Module:
    """A module from its source."""
    tree = ast.parse(source)
    public = [one for node in tree.body for one in _public(node, name)]
    constants = [target.id for node in tree.body for target in _targets(node)
                 if isinstance(target, ast.Name) and target.id.isupper() and not target.id.startswith("_")]
    return Module(name, ast.get_docstring(tree) or "", tuple(public), tuple(constants), tree)


def _targets(node: ast.stmt) -> list[ast.expr]:
    if isinstance(node, ast.Assign):
        return node.targets
    return [node.target] if isinstance(node, ast.AnnAssign) else []


def _public(node: ast.stmt, module: str) -> Iterator[Public]:
    if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
        yield _function(node, module, node.name, "function", 0)
    elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
        members: dict[str, Public] = {}
        for inner in node.body:
            if isinstance(inner, ast.FunctionDef) and not inner.name.startswith("_"):
                marks = {ast.unparse(one).split("(")[0].split(".")[-1] for one in inner.decorator_list}
                if marks & {"setter", "overload"}:
                    continue
                kind = "property" if marks & {"property", "cached_property"} else "method"
                members[inner.name] = _function(inner, module, f"{node.name}.{inner.name}", kind, "staticmethod" not in marks)
        made = next((one for one in node.body if isinstance(one, ast.FunctionDef) and one.name == "__init__"), None)
        fields = _arguments(made.args, 1) if made else _fields(node)
        yield Public(module, node.name, "class", fields, "", ast.get_docstring(node) or "", tuple(members.values()),
                     tuple(ast.unparse(one) for one in node.bases))


def _fields(node: ast.ClassDef) -> tuple[Argument, ...]:
    found = [one for one in node.body if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name)]
    return tuple(
        Argument(one.target.id, ast.unparse(one.annotation), ast.unparse(one.value) if one.value else "")  # type: ignore[union-attr]
        for one in found
        if not one.target.id.startswith("_") and "ClassVar" not in ast.unparse(one.annotation))  # type: ignore[union-attr]


def _function(node: ast.FunctionDef, module: str, name: str, kind: str, skip: int) -> Public:
    returns = ast.unparse(node.returns) if node.returns else ""
    return Public(module, name, kind, _arguments(node.args, skip), returns, ast.get_docstring(node) or "")


def _arguments(args: ast.arguments, skip: int) -> tuple[Argument, ...]:
    plain = [*args.posonlyargs, *args.args]
    defaults: list[ast.expr | None] = [*([None] * (len(plain) - len(args.defaults))), *args.defaults]
    found = [_argument(one, default) for one, default in zip(plain, defaults, strict=True)][skip:]
    if args.vararg:
        found.append(_argument(args.vararg, None, "*"))
    found += [_argument(one, default) for one, default in zip(args.kwonlyargs, args.kw_defaults, strict=True)]
    if args.kwarg:
        found.append(_argument(args.kwarg, None, "**"))
    return tuple(one for one in found if not one.name.startswith("_"))


def _argument(node: ast.arg, default: ast.expr | None, mark: str = "") -> Argument:
    return Argument(node.arg, ast.unparse(node.annotation) if node.annotation else "",
                    ast.unparse(default) if default is not None else "", mark)


# Docstrings ---------------------------------------------------------------------------------------------------------
def sections(doc: str) -> dict[str, str]:
    """The text of a numpydoc docstring before its first section, under ``""``, and that of each section."""
    pieces = _SECTION.split(doc)
    heads = ["", *pieces[1::2]]
    return {head: text.strip("\n") for head, text in zip(heads, pieces[::2], strict=True)}


def entries(section: str) -> list[tuple[tuple[str, ...], str, str]]:
    """Names, type and text of each entry of a section such as Parameters."""
    found: list[tuple[tuple[str, ...], str, str]] = []
    for line in section.splitlines():
        match = _ENTRY.match(line)
        if line and not line.startswith(" ") and match:
            names = tuple(name.strip(" *") for name in match[1].split(","))
            found.append((names, (match[2] or "").strip(), ""))
        elif found:
            names, kind, text = found[-1]
            found[-1] = (names, kind, f"{text}\n{line.strip()}".strip("\n"))
    return found


def documented(doc: str) -> dict[str, tuple[str, str]]:
    """Name -> type and text, of all entries of Parameters and Attributes."""
    parts = sections(doc)
    return {name: (kind, text) for head in ("Parameters", "Attributes") for names, kind, text in entries(parts.get(head, ""))
            for name in names}
