"""The manual is built, warnings as errors, into a folder of the test; its pages load nothing, and fit a narrow screen."""

import html
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from contrast import CONTRAST, LARGE, TEXT
from documents import MANUAL, TOP
from imo_manual import formulas
from imo_manual.names import modules

from imo_analysis.equations.catalogue import OBSERVERS
from imo_analysis.errors import InputError
from imo_analysis.ledger.book import claims
from imo_analysis.notation import SYMBOLS

pytestmark = pytest.mark.slow


def build(source: Path, out: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-n", "-d", str(out / "doctrees"), str(source),
               str(out / "html")]
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": os.pathsep.join([str(TOP), str(MANUAL)])}
    return subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("manual")
    done = build(MANUAL, place)
    assert done.returncode == 0, done.stderr[-4000:]
    return place / "html"


@pytest.fixture(scope="module")
def texts(folder: Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.html"))}


class Links(html.parser.HTMLParser):
    """What a page loads, what it links to, and its ids."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.linked: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            elif name in ("src", "srcset", "data", "poster") or (name == "href" and tag == "link"):
                self.loaded += [value] if value and value != "#" else []
            elif name == "href":
                self.linked.append(value or "")


def read(text: str) -> Links:
    links = Links()
    links.feed(text)
    return links


_SHEET = re.compile(r"url\(\s*['\"]?(?:https?:)?//|@import")


def fetched(text: str) -> list[str]:
    """What a page would fetch from a network: of its own, or by a style in it."""
    return [place for place in read(text).loaded if re.match(r"(?:\w+:)?//", place)] + _SHEET.findall(text)


def test_nothing_is_loaded_from_a_network(texts: dict[str, str], folder: Path) -> None:
    for name, text in texts.items():
        assert not fetched(text), name
        for place in read(text).loaded:
            assert (folder / name).parent.joinpath(place.partition("?")[0]).resolve().exists(), (name, place)
    for sheet in folder.rglob("*.css"):
        assert not _SHEET.search(sheet.read_text(encoding="utf-8")), sheet
    page = texts["index.html"]
    for planted in ('<script src="https://cdn.example/m.js"></script>', '<link rel="stylesheet" href="//fonts.example/a.css">',
                    "<style>@import 'a.css'</style>", "<style>p{background:url(https://a.example/b.png)}</style>"):
        assert len(fetched(page.replace("</head>", f"{planted}</head>"))) == 1, planted


def test_every_link_leads_somewhere(texts: dict[str, str], folder: Path) -> None:
    ids = {name: set(read(text).ids) for name, text in texts.items()}
    for name, text in texts.items():
        for link in read(text).linked:
            if re.match(r"\w+:", link) or not link:
                continue
            place, _, anchor = link.partition("#")
            other = str((folder / name).parent.joinpath(place).resolve().relative_to(folder)) if place else name
            assert (folder / other).exists(), (name, link)
            if anchor and other in ids:
                assert html.unescape(anchor) in ids[other], (name, link)


def test_all_is_there(texts: dict[str, str]) -> None:
    whole = "".join(texts.values())
    for module in modules():
        for one in module.public:
            assert f'id="{one.full}"' in whole, one.full
            for member in one.members:
                assert f'id="{member.full}"' in whole, member.full
    for name in OBSERVERS:
        assert f'id="observer-{name.replace("_", "-")}"' in texts["reference/observers.html"]
    for name in SYMBOLS:
        assert f'<span class="pre">{name}</span>' in texts["reference/notation.html"]
    for claim in claims():
        assert f'<span class="pre">{claim.id}</span>' in texts["reference/ledger.html"]


def test_formulas_are_mathml_in_the_font_s_letters(texts: dict[str, str]) -> None:
    from fontTools.ttLib import TTFont

    font = TTFont(TOP / "imo_analysis" / "fonts" / "math.woff2").getBestCmap()
    formulas_ = [formula for text in texts.values() for formula in re.findall(r"<math.*?</math>", text, re.DOTALL)]
    assert len(formulas_) > 250
    for name, text in texts.items():
        assert 'class="unread"' not in text and not re.search(r"\\(?:hat|frac|dot)\b", strip(text)), name
    letters = {letter for formula in formulas_ for letter in html.unescape(re.sub(r"<[^>]*>", "", formula))}
    unseen = set("\u2061\u2062\u2063\u2064\u00a0\u2003")  # signs without a shape, and spaces
    assert not {letter for letter in letters if ord(letter) > 127 and ord(letter) not in font} - unseen


def headless(text: str) -> list[str]:
    """Formulas set apart that have no left side."""
    found = re.findall(r'<div class="scrolled".*?</math></div>', text, re.DOTALL)
    return [formula for formula in found if not re.search(r">(?:=|&#x0003D;|&#x02264;|&#x02265;)</mo>", formula)]


def test_every_formula_set_apart_says_of_what(texts: dict[str, str]) -> None:
    pages = [name for name in texts if name.startswith("theory/")]
    assert len(pages) == 6 and sum(texts[name].count('class="scrolled"') for name in pages) > 60
    assert not [(name, formula) for name in pages for formula in headless(texts[name])]
    machine = texts["theory/machine.html"]
    assert len(headless(re.sub(r"<mo[^>]*>(?:=|&#x0003D;)</mo>", "", machine))) == machine.count('class="scrolled"')


def strip(text: str) -> str:
    """The page without attributes, of which MathML's have LaTeX in them."""
    return re.sub(r"<[^>]*>", " ", re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL))


def test_a_formula_follows_its_definition(monkeypatch: pytest.MonkeyPatch) -> None:
    """The manual types no equation: change the function and the page changes."""
    from imo_analysis.equations import parameters

    before = formulas.equations(formulas.find("imo_analysis.equations.parameters:rotor_rate"), {}, ["alpha"])
    assert before == [r"\alpha = \frac{R_r}{L_r}"]
    monkeypatch.setattr(parameters, "rotor_rate", lambda R_r, L_r: R_r * L_r)
    assert formulas.equations(formulas.find("imo_analysis.equations.parameters:rotor_rate"), {}, ["alpha"]) != before
    with pytest.raises(InputError, match="is not a function"):
        formulas.find("imo_analysis.equations.parameters:rotor_rat")
    pages = "".join(page.read_text(encoding="utf-8") for page in MANUAL.rglob("*.md"))
    assert not re.findall(r"\$\$|\\frac|\\dot\{\\hat|```\{math\}|\\begin", pages), "name the function in a definition directive"


def test_signs_stand_in_for_helpers_only_while_a_formula_is_written() -> None:
    from imo_analysis.equations import adaptive

    base, rows = formulas.observer_equations("supervised")
    assert base == "across" and any(r"G\left(S\right)" in row for row, _ in rows)
    assert adaptive.projection(2.0, 1.0, 0.05, 0.01) == 2.0
    assert [number for _, number in formulas.observer_equations("consistent_12")[1]] == ["(8)"] * 6 + ["(9), (10)", "(11)"]
    assert {one.source for one in OBSERVERS.values() if one.source.startswith("(")} == set(formulas.NUMBERS)


@pytest.mark.parametrize(("old", "new", "said"), [
    ("plant:plant\n", "plant:plantt\n", "is not a function"),
    ("omega_dot", "omega_dot T_l", "6 names were given"),
    ("p = R_s", "q = R_s", "no argument q"),
    ("{doc}`b`", "{doc}`c`", "unknown document"),
    ("`control`", "{py:obj}`imo_analysis.machin`", "reference target not found"),
])
def test_a_fault_stops_the_build(tmp_path: Path, old: str, new: str, said: str) -> None:
    source = tmp_path / "source"
    source.mkdir()
    shutil.copy(MANUAL / "conf.py", source)
    (source / "_static").mkdir()
    (source / "_static" / "manual.css").write_text("")
    (source / "b.md").write_text("# B\n")
    page = """# A

{doc}`b` and `control`

```{toctree}
b
```

```{definition} imo_analysis.equations.plant:plant
:gives: i_ds_dot i_qs_dot phi_dr_dot phi_qr_dot omega_dot
x = i_ds i_qs phi_dr phi_qr omega
u = u_ds u_qs
p = R_s L_m sigma beta alpha mu n_p J
```
"""
    assert old in page
    (source / "index.md").write_text(page.replace(old, new))
    done = build(source, tmp_path / "out")
    assert done.returncode != 0 and said in done.stderr


# In a browser ----------------------------------------------------------------------------------------------------------
PROBE = """<script>addEventListener("load",function(){setTimeout(function(){
var m=document.querySelector("math");parent.postMessage({page:"PAGE",
width:document.documentElement.scrollWidth,inner:innerWidth,math:m?m.getBoundingClientRect().height:9,
loaded:performance.getEntriesByType("resource").map(function(e){return e.name}).filter(function(n){return !n.startsWith("file:")
&&!n.startsWith("data:")})},"*")},50)});</script>"""
# a window of a browser without a screen is 500 px wide at least; a frame can be narrower, and one window holds all pages
LISTEN = """<script>var a=[];addEventListener("message",function(e){a.push(e.data);
document.body.setAttribute("data-probe",JSON.stringify(a))})</script>"""


def browser() -> str:
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        if os.environ.get("CI") == "true":
            pytest.fail("chromium is missing; CI installs it")
        pytest.skip("chromium is not installed")
    return found


@pytest.mark.parametrize("width", [1280, 380])
def test_every_page_in_a_browser(folder: Path, texts: dict[str, str], tmp_path: Path, width: int) -> None:
    names = [name for name in texts if name != "search.html"]  # which says so until a word is given
    whole = tmp_path / "html"
    shutil.copytree(folder, whole)
    for name in names:
        (whole / name).write_text(texts[name].replace("</body>", PROBE.replace("PAGE", name) + "</body>"), encoding="utf-8")
    style = f"border:0;width:{width}px;height:700px"
    frames = "".join(f'<iframe src="{(whole / name).as_uri()}" style="{style}"></iframe>' for name in names)
    (tmp_path / "all.html").write_text(f"<body>{LISTEN}{frames}</body>", encoding="utf-8")
    command = [browser(), "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
               "--disable-background-networking", "--disable-component-update", f"--user-data-dir={tmp_path / 'profile'}",
               "--window-size=1400,900", "--virtual-time-budget=30000", "--dump-dom", (tmp_path / "all.html").as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    match = re.search(r'data-probe="([^"]*)"', done.stdout)
    assert match, done.stderr[-2000:]
    seen = {one["page"]: one for one in json.loads(html.unescape(match[1]))}
    assert set(seen) == set(names)
    for name, one in seen.items():
        assert one["loaded"] == [], name
        assert one["inner"] == width and one["width"] <= width, f"{name} is wider than the window"
        assert one["math"] > 5, name


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        if os.environ.get("CI") == "true":
            pytest.fail("playwright is missing; CI installs it")
        pytest.skip("playwright is not installed")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=browser(), args=["--no-sandbox", "--disable-gpu"])
        yield started
        started.close()


def opened(chromium: Any, file: Path, width: int = 1280, dark: bool = False) -> Any:
    page = chromium.new_context(viewport={"width": width, "height": 900}, color_scheme="dark" if dark else "light").new_page()
    page.goto(file.as_uri())
    return page


def pale(page: Any) -> list[tuple[float, str]]:
    return [(round(ratio, 2), what) for ratio, large, what in page.evaluate(CONTRAST) if ratio < (LARGE if large else TEXT)]


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("name", ["index", "tutorial", "numbers", "how-to/machine", "theory/observers", "reference/study"])
def test_contrast(chromium: Any, folder: Path, name: str, dark: bool) -> None:
    page = opened(chromium, folder / f"{name}.html", dark=dark)
    assert (page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)") != dark
    assert len(page.evaluate(CONTRAST)) > 4
    assert pale(page) == []
    page.add_style_tag(content="article p{color:#888!important;background:#8f8f8f!important}")
    assert pale(page), "a pale letter is seen"


def test_a_formula_that_is_too_wide_scrolls_beside_its_number(chromium: Any, folder: Path) -> None:
    page = opened(chromium, folder / "theory" / "observers.html", width=380)
    right = page.eval_on_selector_all(".formula .number", "all => all.map(e => e.getBoundingClientRect().right)")
    assert len(right) > 10 and max(right) <= 380
    wide = page.eval_on_selector_all(".formula .scrolled", """all => all.filter(e => e.scrollWidth > e.clientWidth).map(
        e => [getComputedStyle(e).overflowX, getComputedStyle(e).backgroundImage.includes("gradient"), e.tabIndex])""")
    assert wide and all(one == ["auto", True, 0] for one in wide), "its edge is dark, and the keyboard reaches it"


@pytest.mark.parametrize("name", ["notation", "observers", "study"])
def test_sentences_in_tables_have_room(chromium: Any, folder: Path, name: str) -> None:
    """The column of what a thing means is wider than any of single words."""
    page = opened(chromium, folder / "reference" / f"{name}.html")
    tables = page.eval_on_selector_all("table.wide", """all => all.map(t => [...t.querySelectorAll("tr:first-child td")].map(
        e => [e.classList.contains("said"), e.getBoundingClientRect().width]))""")
    assert tables
    for cells in tables:
        said = [width for sentence, width in cells if sentence]
        assert said and min(said) >= 200 and min(said) > max(width for sentence, width in cells if not sentence), cells
