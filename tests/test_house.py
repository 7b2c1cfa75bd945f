"""The house keeps its own rules: documented formats, docstrings, small files, nothing of the machine it was written on."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[1]
SOURCES = sorted((TOP / "imo_analysis").rglob("*.py"))
TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES}
NAMES = [str(path.relative_to(TOP)) for path in SOURCES]


@pytest.mark.parametrize("path", SOURCES, ids=NAMES)
def test_every_module_says_what_it_is(path: Path) -> None:
    assert ast.get_docstring(TREES[path]), "the first lines say what the file is and which equation or source it carries"


@pytest.mark.parametrize("path", SOURCES, ids=NAMES)
def test_every_public_function_and_class_has_a_docstring(path: Path) -> None:
    if "commands" in path.parts:
        return  # DESCRIPTION, EXAMPLE, add_arguments and run are the same in each
    bare = [
        node.name
        for node in TREES[path].body
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_") and not ast.get_docstring(node)
    ]
    assert not bare


@pytest.mark.parametrize("path", SOURCES, ids=NAMES)
def test_a_file_is_one_idea(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 450


def test_every_layout_that_is_written_is_documented() -> None:
    formats = (TOP / "FORMATS.md").read_text(encoding="utf-8")
    written = {name for path in SOURCES for name in re.findall(r'"(imo-[a-z-]+/\d+)"', path.read_text(encoding="utf-8"))}
    assert written, "no layout found: has the naming changed?"
    assert not [name for name in sorted(written) if name not in formats]


def test_nothing_user_given_is_executed() -> None:
    """Studies, machines, logs and runs are data: no eval, exec or pickle in what reads them.

    Only the tool that changes one token of our own definitions runs text, and that text is a file of this package; and the
    loader of an observer's file, which a user names as the program that it is (`equations.own`).
    """
    for path, tree in TREES.items():
        if path.name == "definition_mutants.py" or path.parts[-2:] == ("equations", "own.py"):
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in ("eval", "exec"), path
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                names = [alias.name for alias in node.names] + [getattr(node, "module", "") or ""]
                assert not {"pickle", "marshal", "shelve"} & set(names), path


def test_no_path_of_a_machine_is_written_down() -> None:
    listed = [*SOURCES, *(TOP / "tests").rglob("*.py"), *(TOP / "derivations").rglob("*.py"), *TOP.glob("*.md"),
              *(path for kind in ("md", "rst", "py", "css") for path in (TOP / "manual").rglob(f"*.{kind}"))]
    pattern = re.compile(r"(?<![\w.])/(?:" + "home|root|work" + r")/\w")
    assert not [str(path) for path in listed if pattern.search(path.read_text(encoding="utf-8"))]


def test_the_readme_s_commands_exist() -> None:
    from imo_analysis.cli import COMMANDS

    readme = (TOP / "README.md").read_text(encoding="utf-8")
    used = set(re.findall(r"^\s*(?:\$ )?imo (\w+)", readme, flags=re.MULTILINE))
    assert used and used <= set(COMMANDS)
    extras = tomllib.loads((TOP / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert set(re.findall(r"\.\[(\w+)\]", readme)) <= set(extras)


def test_the_readme_s_pictures_and_files_are_there() -> None:
    readme = (TOP / "README.md").read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", readme) if "://" not in link]
    assert links and not [link for link in links if not (TOP / link).exists()]
