"""No number of the dossier's prose is typed in: the sources hold none, and what is filled in changes with the data."""

import ast
import re
from pathlib import Path

import pytest

import imo_analysis.report

ROOM = Path(imo_analysis.report.__file__).parent
SOURCES = [path for path in sorted((*ROOM.glob("*.py"), *ROOM.glob("chapters/*.py")))
           if path.name not in ("page.py", "math.py", "markdown.py", "pdf.py", "words.py")]

# What may hold digits: formulas and names, which have their own checks; places in the paper; papers that are cited; units.
ALLOWED = [
    re.compile(pattern) for pattern in (
        r"(?:Automatica|Electron\.)\s+\d+\(\d+\),\s+\d{4}", r"CDC\s+\d{4}", r"IV\.\d", r"<[a-z][^>]*>",
        r"right half plane", r"half (?:its|the) swing", r"half of what an ohmmeter shows", r"\(slip 0\)",  # definitions
        r"\$[^$]*\$", r"`[^`]*`", r"\\[A-Za-z]+\{[^}]*\}",
        r"\((?:\d+)\)(?:-\(\d+\))?",  # (12), (8)-(11)
        r"Figs?\. \d(?:-\d)?", r"SHA-256", r"1\.1\)",  # the last: a version of a licence
        r"\b\w+_\d+\b", r"\b(?:eq|fig)\d+\b", r"\b(?:alpha|omega|beta)\b",
        r"\(1/s\)|\(1\)|1/s|/s²|A\$\^2\$|N m|m²",
        r"#[0-9a-f]{3,6}\b|0\.9", r"[.\d]+(?:rem|px|pt)\b",
    )
]
# Words that are numbers. In a sentence on what is always so (two components of a vector) they are no result.
WORDS = re.compile(r"\b(?:half|twice|double|third|tenth|percent|per cent|dozen|hundred)\b")
LETTERS = re.compile(r"[A-Za-z]{2,} +[A-Za-z]{2,}")  # two words in a row: prose


def docstrings(tree: ast.AST) -> set[int]:
    """Ids of the nodes that are docstrings."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and node.body:
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                found.add(id(first.value))
    return found


def prose(source: str) -> list[tuple[int, str]]:
    """Strings with at least two words, with the pieces of an f-string put together and {} for what is filled in."""
    tree = ast.parse(source)
    skip = docstrings(tree)
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            skip |= {id(value) for value in ast.walk(node) if isinstance(value, ast.Constant)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            text = "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skip:
            text = node.value
        else:
            continue
        if LETTERS.search(text):
            found.append((node.lineno, text))
    return found


def numbers(text: str) -> list[str]:
    """Digits and number words that nothing allows."""
    for pattern in ALLOWED:
        text = pattern.sub(" ", text)
    return re.findall(r"\S*\d\S*", text) + WORDS.findall(text)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.stem)
def test_no_number_is_typed_into_a_sentence(path: Path) -> None:
    found = [(line, numbers(text), text[:80]) for line, text in prose(path.read_text(encoding="utf-8")) if numbers(text)]
    assert found == [], f"fill them from data: {path.name}"


@pytest.mark.parametrize(("text", "bad"), [
    ("it holds at 87 % of the points", ["87"]), ("the error is within 2 % of it", ["2"]), ("raised by half of it", ["half"]),
    ("see (12) and Fig. 3 in $x_1^2$ with `k_2`", []), ("one of eq12 and the others", []),
])
def test_the_scan_finds_what_is_typed(text: str, bad: list[str]) -> None:
    assert numbers(text) == bad


def test_the_scan_sees_f_strings_and_leaves_docstrings_alone() -> None:
    source = '"""A file of 12 words."""\nx = f"it is {y:.3f} and then 7 more"\nz = "plain words 5"\n'
    assert [text for _, text in prose(source)] == ["it is {} and then 7 more", "plain words 5"]
