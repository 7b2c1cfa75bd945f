"""The dossier as Markdown for a repository, made from the page itself, so that the two cannot tell different stories.

Only the tags that `imo_analysis.report.page` writes are known. Formulas are the LaTeX that the page carries with them; figures
are links to their files; what needs a script is left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser

_VOID = frozenset(("meta", "img", "input", "br", "link", "wbr"))
_LEFT_OUT = frozenset(("nav", "script", "style", "head", "svg", "button", "input", "output"))
_BLOCKS = frozenset(("p", "h1", "h2", "h3", "h4", "ul", "ol", "table", "pre", "figure", "details", "dl", "div", "section",
                     "main", "footer", "body", "html"))


@dataclass
class Node:
    """An element with its attributes and children, texts among them."""

    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Node | str] = field(default_factory=list)

    def kind(self) -> list[str]:
        """Its classes."""
        return self.attributes.get("class", "").split()

    def find(self, tag: str) -> Iterator[Node]:
        """The elements of a tag below this one."""
        for child in self.children:
            if isinstance(child, Node):
                if child.tag == tag:
                    yield child
                yield from child.find(tag)


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.root = Node("root")
        self.open = [self.root]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        node = Node(tag, {name: value or "" for name, value in attrs})
        self.open[-1].children.append(node)
        if tag not in _VOID:
            self.open.append(node)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open[-1].children.append(Node(tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        if tag not in _VOID:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        self.open[-1].children.append(data)


def read(page: str) -> Node:
    """The page as a tree."""
    reader = _Reader()
    reader.feed(page)
    reader.close()
    return reader.root


def markdown(page: str) -> str:
    """The page as Markdown with pipe tables and formulas in dollars.

    Parameters
    ----------
    page : str
        From `imo_analysis.report.page.page`.
    """
    text = "\n\n".join(part for part in _blocks(read(page)) if part.strip())
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def _blocks(node: Node) -> Iterator[str]:
    """What stands below a node, a block each."""
    run: list[Node | str] = []
    for child in node.children:
        if isinstance(child, Node) and child.tag in _BLOCKS | _LEFT_OUT:
            yield _inline(run)
            run = []
            yield from _block(child)
        else:
            run.append(child)
    yield _inline(run)


def _block(node: Node) -> Iterator[str]:
    if node.tag in _LEFT_OUT or "js-only" in node.kind():
        return
    anchor = f'<a id="{node.attributes["id"]}"></a>\n' if node.tag in ("section", "details") and "id" in node.attributes else ""
    if node.tag in ("h1", "h2", "h3", "h4"):
        yield f"{'#' * int(node.tag[1])} {_inline(node.children)}"
    elif node.tag == "p":
        yield _inline(node.children)
    elif node.tag in ("ul", "ol"):
        yield "\n".join(f"- {_one_line(item)}" for item in node.children if isinstance(item, Node))
    elif node.tag == "pre":
        yield f"```\n{_plain(node)}\n```"
    elif node.tag == "table":
        yield from _table(node)
    elif node.tag == "figure":
        yield from _figure(node)
    elif node.tag == "dl":
        yield from _definitions(node)
    elif node.tag == "details":
        summary = next(node.find("summary"))
        yield f"{anchor}**{_joined(summary)}**"
        yield from _blocks(Node("div", children=[child for child in node.children if child is not summary]))
    elif "formula" in node.kind():
        yield f"$${_latex(next(node.find('math')))}$$" if any(node.find("math")) else _inline(node.children)
    elif "answer" in node.kind():
        yield "\n>\n".join(f"> {block}" for block in _blocks(node) if block.strip())
    else:
        if anchor:
            yield anchor.strip()
        yield from _blocks(node)


def _joined(summary: Node) -> str:
    """The parts of a line that opens, with a colon or a dash between."""
    parts = [_inline([child]) for child in summary.children]
    return ": ".join(part for part in parts if part)


def _one_line(item: Node) -> str:
    """A list's item; its blocks on one line."""
    return " ".join(block.replace("\n", " ") for block in _blocks(item) if block.strip())


def _table(node: Node) -> Iterator[str]:
    caption = next(node.find("caption"), None)
    if caption is not None:
        yield f"**{_inline(caption.children)}**"
    rows = [[_cell(cell) for cell in row.children if isinstance(cell, Node)] for row in node.find("tr")]
    right = ["n" in cell.kind() for cell in next(node.find("tr")).children if isinstance(cell, Node)]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    lines.insert(1, f"|{'|'.join('---:' if one else '---' for one in right)}|")
    yield "\n".join(lines)


def _cell(cell: Node) -> str:
    return re.sub(r"(?<!\\)\|", r"\\|", _one_line(cell)) or " "


def _figure(node: Node) -> Iterator[str]:
    caption = next(node.find("figcaption"), None)
    links = [link.attributes.get("href", "") for link in caption.find("a")] if caption else []
    file = next((link for link in links if link.endswith(".svg")), "")
    said = next((svg.attributes.get("aria-label", "") for svg in node.find("svg")), "")
    if file:
        yield f"![{said.replace('[', '(').replace(']', ')')}]({file})"
    if caption is not None:
        yield _inline([child for child in caption.children if not (isinstance(child, Node) and any(child.find("a")))])


def _definitions(node: Node) -> Iterator[str]:
    for child in node.children:
        if isinstance(child, Node) and child.tag == "dt":
            yield f"*{_inline(child.children)}*"
        elif isinstance(child, Node) and child.tag == "dd":
            yield from _blocks(child)


def _inline(nodes: list[Node | str]) -> str:
    return re.sub(r"\s+", " ", "".join(map(_piece, nodes))).strip()


def _piece(node: Node | str) -> str:
    if isinstance(node, str):
        return re.sub(r"([*_<>|])", r"\\\1", node)
    if node.tag in _LEFT_OUT:
        return ""
    inner = "".join(map(_piece, node.children))
    if node.tag == "math":
        return f"${_latex(node)}$"
    if node.tag == "code":
        return f"`{_plain(node)}`"
    if node.tag == "b" and inner.strip():
        return f"**{inner.strip()}**{' ' if inner.endswith(' ') else ''}"
    if node.tag == "a" and inner:
        return f"[{inner}]({node.attributes.get('href', '')})"
    return f" *{inner}*" if "badge" in node.kind() else inner


def _latex(node: Node) -> str:
    """LaTeX without what only the page's own colours need."""
    return re.sub(r"\\class\{differs\}", "", node.attributes.get("alttext", "")).replace("\n", " ").replace("|", r"\vert ")


def _plain(node: Node) -> str:
    return "".join(child if isinstance(child, str) else _plain(child) for child in node.children)
