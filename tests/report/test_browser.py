"""The page in a real browser: a desktop, a phone, dark, by keyboard, and on paper."""

import base64
import re
import struct
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from browsers import missing
from contrast import CONTRAST, LARGE, TEXT
from pdf_objects import pdf_objects

from imo_analysis.ledger.book import claims

pytestmark = pytest.mark.slow

A4 = (794 - 2 * 53, 1123 - 2 * 59)  # CSS pixels within margins of 14 and 15.5 mm


class Seen:
    """A page with what it asked for and complained of."""

    def __init__(self, browser: Any, file: Path, width: int = 1300, dark: bool = False, script: bool = True) -> None:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme="dark" if dark else "light",
                                      java_script_enabled=script)
        self.page = context.new_page()
        self.asked: list[str] = []
        self.complaints: list[str] = []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("console", lambda message: self.complaints.append(message.text) if message.type in ("error", "warning")
                     else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(file.as_uri())
        self.page.evaluate("document.fonts.ready") if script else None


@pytest.fixture(scope="module")
def file(folder: Path) -> Path:
    return folder / "index.html"


@pytest.fixture(scope="module")
def desktop(browser: Any, file: Path) -> Seen:
    return Seen(browser, file)


def poles(page: Any) -> list[str]:
    found: list[str] = page.eval_on_selector_all(".slider .poles path", "all => all.map(e => e.getAttribute('transform'))")
    return found


def test_nothing_leaves_the_file_and_nothing_is_complained_of(desktop: Seen, file: Path) -> None:
    asked = [url for url in desktop.asked if not url.startswith("data:")]
    assert asked == [file.as_uri()]
    assert desktop.complaints == []


def test_formulas_are_set(desktop: Seen) -> None:
    sizes = desktop.page.eval_on_selector_all("math", "all => all.filter(e => e.checkVisibility()).map(e => "
                                              "{const r = e.getBoundingClientRect(); return [r.width, r.height]})")
    assert len(sizes) > 100 and all(width > 2 and height > 5 for width, height in sizes)
    shown = desktop.page.inner_text("main")
    assert not re.search(r"\\\\(?:hat|frac|alpha|tilde|mathrm)|\\$", shown), "raw LaTeX in the text"
    assert desktop.page.evaluate("document.fonts.check('16px \"Imo Math\"')")
    assert desktop.page.locator(".unread").count() == 0


def test_the_slider_moves_the_poles_by_keyboard(browser: Any, file: Path) -> None:
    page = Seen(browser, file).page
    page.focus(".slider input[type=range]")
    places, said = [poles(page)], [page.inner_text(".slider output")]
    for key in ("ArrowRight", "End", "Home"):
        page.keyboard.press(key)
        places.append(poles(page))
        said.append(page.inner_text(".slider output"))
    assert len({tuple(one) for one in places}) == 4 and len(set(said)) == 4
    assert all(re.fullmatch(r"−?[\d.]+ rad/s", one) for one in said)
    assert page.get_attribute(".slider input[type=range]", "aria-valuetext") == said[-1]
    assert "rightmost pole at" in page.inner_text(".slider .say")
    page.keyboard.press("Tab")  # to the first observer, which the space bar takes out
    first = page.locator(".slider .poles").first
    assert first.is_visible()
    page.keyboard.press("Space")
    assert not first.is_visible()


def test_the_map_shows_what_is_chosen(browser: Any, file: Path) -> None:
    """Without the observers whose poles lie far out the axes are shorter, and no pole of the others leaves the frame."""
    page = Seen(browser, file).page

    def numbers() -> list[float]:
        texts = page.eval_on_selector_all(".slider .axes text", "all => all.map(e => e.textContent)")
        return [float(text.replace("−", "-")) for text in texts if re.fullmatch(r"−?[\d.]+", text)]

    whole = numbers()
    for label in ("printed_7", "printed_L", "consistent_12"):
        page.locator(".slider .keys label", has_text=re.compile(rf"^{label}$")).locator("input").uncheck()
    assert 0 < max(map(abs, numbers())) < max(map(abs, whole))
    width, height = (float(size) for size in page.get_attribute(".slider .map", "viewBox").split()[2:])
    steps = int(page.get_attribute(".slider input[type=range]", "max"))
    for at in range(0, steps + 1, max(1, steps // 8)):
        page.eval_on_selector(".slider input[type=range]", f"e => {{e.value = {at}; e.dispatchEvent(new Event('input'))}}")
        shown = page.eval_on_selector_all(".slider .poles", "all => all.filter(g => g.style.display !== 'none').flatMap(g => "
                                          "[...g.children].map(e => e.getAttribute('transform')))")
        assert shown
        for place in shown:
            x, y = (float(part) for part in re.findall(r"-?[\d.]+", place))
            assert 64 <= x <= width - 16 and 14 <= y <= height - 46, (at, place)


def test_the_map_agrees_with_the_data(browser: Any, file: Path, folder: Path) -> None:
    """The rightmost pole that is told at the last speed is that of the sweep's file."""
    import xarray as xr

    page = Seen(browser, file).page
    page.focus(".slider input[type=range]")
    page.keyboard.press("End")
    told = dict(re.findall(r"(\w+): rightmost pole at (\S+) /s", page.inner_text(".slider .say")))
    sweep = xr.load_dataset(folder / "poles.nc", engine="h5netcdf")
    assert set(told) == {str(name) for name in sweep["observer"].values}
    for name, value in told.items():
        one = sweep.sel(observer=name).isel(omega=-1)
        moving = abs(one["re"]) + abs(one["im"]) > 1e-6
        assert float(value.replace("−", "-")) == pytest.approx(float(one["re"].where(moving).max()), abs=0.006)


def test_the_ledger_opens_and_filters(browser: Any, file: Path) -> None:
    page = Seen(browser, file).page
    entries = page.locator("details.entry")
    assert entries.count() == len(claims())
    summary = entries.first.locator("summary")
    summary.focus()
    page.keyboard.press("Enter")
    assert entries.first.evaluate("e => e.open") and entries.first.locator(".inside").is_visible()
    page.click('#ledger-tools button[data-verdict="fails"]')
    shown = page.locator("details.entry:visible").count()
    assert 0 < shown < entries.count() and page.inner_text("#ledger-tools output").startswith(f"{shown} of ")
    page.click('#ledger-tools button[data-verdict=""]')
    page.fill("#ledger-tools input", "alpha")
    assert 0 < page.locator("details.entry:visible").count() < entries.count()
    identifier = entries.last.get_attribute("id")
    page.fill("#ledger-tools input", "")
    page.evaluate("id => { location.hash = '#' + id }", identifier)
    page.wait_for_function("id => document.getElementById(id).open", arg=identifier)


@pytest.mark.parametrize("width", [380, 800, 1300])
def test_nothing_is_wider_than_the_window(browser: Any, file: Path, width: int) -> None:
    page = Seen(browser, file, width).page
    page.evaluate("document.querySelectorAll('details').forEach(e => { e.open = true })")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    wide = page.evaluate("""limit => [...document.querySelectorAll("main *")].filter(e => {
        if (e.closest(".scroll,.plate,dd,pre,svg,math") && !e.matches(".scroll,.plate,dd,pre")) return false;
        return e.checkVisibility() && e.getBoundingClientRect().right > limit + 1;
    }).map(e => e.outerHTML.slice(0, 120))""", width)
    assert wide == []


@pytest.mark.parametrize("width", [1200, 1300])
def test_no_table_is_cut(browser: Any, file: Path, width: int) -> None:
    """On a desktop every table and formula is seen whole; where one scrolls on a phone, a shade says so."""
    page = Seen(browser, file, width).page
    page.evaluate("document.querySelectorAll('details').forEach(e => { e.open = true })")
    cut = page.evaluate("""() => [...document.querySelectorAll(".scroll,.plate,dl.facts dd")].filter(e => e.checkVisibility() &&
        e.scrollWidth > e.clientWidth + 1).map(e => [e.className, e.clientWidth, e.scrollWidth, e.textContent.slice(0, 80)])""")
    assert cut == []
    assert "gradient" in page.evaluate("getComputedStyle(document.querySelector('.scroll')).backgroundImage")


def test_no_name_in_a_head_is_broken_inside_a_word(browser: Any, file: Path) -> None:
    """A name in the head of a table takes as many lines as it has parts between underscores at most."""
    page = Seen(browser, file, 380).page
    names = page.evaluate("""() => [...document.querySelectorAll("th code")].filter(e => e.checkVisibility()).map(e =>
        [e.textContent, e.getClientRects().length])""")
    assert names and [name for name, lines in names if lines > name.count("_") + 1] == []


LEGIBLE = 9.0  # px


@pytest.mark.parametrize("width", [380, 800])
def test_text_in_figures_can_be_read_on_a_phone(browser: Any, file: Path, width: int) -> None:
    page = Seen(browser, file, width).page
    page.evaluate("document.querySelectorAll('details').forEach(e => { e.open = true })")
    sizes = page.eval_on_selector_all("figure", """all => all.map(e => Math.min(...[...e.querySelectorAll("text,tspan")].filter(
        t => t.textContent.trim()).map(t => parseFloat(getComputedStyle(t).fontSize) * t.closest("svg").getScreenCTM().a)))""")
    assert len(sizes) > 8 and [(k, round(size, 2)) for k, size in enumerate(sizes, start=1) if size < LEGIBLE - 0.05] == []


def test_the_pdf_holds_what_the_page_holds(file: Path, tmp_path: Path) -> None:
    """As many pictures as the page has, and every figure with what it shows; and twice the same bytes."""
    from imo_analysis.report import pdf

    if pdf.browser() is None:
        missing("a browser that prints")
    for name in ("one.pdf", "two.pdf"):
        assert pdf.print_page(file, tmp_path / name) == ""
    printed, text = (tmp_path / "one.pdf").read_bytes(), file.read_text(encoding="utf-8")
    assert printed == (tmp_path / "two.pdf").read_bytes()
    objects = pdf_objects(printed)
    images = [one for one in objects if re.search(rb"/Subtype\s*/Image", one)]
    there = Counter(tuple(int(re.search(rb"/%b (\d+)" % side, one)[1]) for side in (b"Width", b"Height"))  # type: ignore[index]
                    for one in images if b"/DeviceGray" not in one)  # those are masks
    pictures = set(re.findall(r'<image[^>]*href="data:image/png;base64,([^"]*)"', text))
    wanted = Counter(struct.unpack(">II", base64.b64decode(re.sub(r"\s", "", one))[16:24]) for one in pictures)
    assert len(wanted) > 3 and wanted <= there, "a picture is missing"
    figures = [one for one in objects if re.search(rb"/S\s*/Figure\b.*/Alt", one, re.DOTALL)]
    assert len(figures) == text.count("<figure") > 8
    assert any(b"/Outlines" in one for one in objects), "bookmarks"


def test_a_picture_in_a_page_is_printed(tmp_path: Path) -> None:
    from imo_analysis.report import pdf

    if pdf.browser() is None:
        missing("a browser that prints")
    dot = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
    for name, link in (("with", f' href="data:image/png;base64,{dot}"'), ("without", "")):
        page = tmp_path / f"{name}.html"
        page.write_text(f'<svg width="99" height="99"><image width="99" height="99"{link}/></svg>', encoding="utf-8")
        assert pdf.print_page(page, tmp_path / f"{name}.pdf") == ""
        assert bool(re.search(rb"/Subtype\s*/Image", (tmp_path / f"{name}.pdf").read_bytes())) == bool(link)


def test_without_a_script_the_static_pictures_stand_in(browser: Any, file: Path) -> None:
    page = Seen(browser, file, script=False).page
    assert not page.locator(".slider").is_visible() and not page.locator("#ledger-tools").is_visible()
    assert page.locator("#poles figure").first.is_visible()


def test_on_paper(browser: Any, file: Path, tmp_path: Path) -> None:
    page = Seen(browser, file, A4[0], dark=True).page
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert not page.locator(".slider").is_visible() and not page.locator("nav").is_visible()
    assert page.locator("details:not([open])").count() == 0, "a closed entry says nothing on paper"
    figures = page.eval_on_selector_all("figure", """all => all.map(e => {
        const r = e.getBoundingClientRect(), s = e.querySelector("svg").getBoundingClientRect();
        return [r.width, r.height, s.right, getComputedStyle(e).breakInside]; })""")
    assert len(figures) > 8
    for width, height, right, breaks in figures:
        assert width <= A4[0] and right <= A4[0] + 1 and height <= A4[1] and breaks == "avoid"
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)", "dark on paper"
    wide = page.evaluate("""limit => [...document.querySelectorAll("main *")].filter(e => !e.closest("svg") &&
        e.getBoundingClientRect().right > limit + 1).map(e => e.outerHTML.slice(0, 120))""", A4[0])
    assert wide == [], "beyond the edge of the paper"
    page.pdf(path=tmp_path / "page.pdf", prefer_css_page_size=True)
    printed = (tmp_path / "page.pdf").read_bytes()
    assert printed.startswith(b"%PDF") and len(re.findall(rb"/Type\s*/Page\b", printed)) > 10


@pytest.mark.parametrize("dark", [False, True])
def test_contrast(browser: Any, file: Path, dark: bool) -> None:
    page = Seen(browser, file, dark=dark).page
    page.evaluate("document.querySelectorAll('details.more,details.entry:nth-of-type(-n+9)').forEach(e => { e.open = true })")
    found = page.evaluate(CONTRAST)
    assert len(found) > 8
    assert [(round(ratio, 2), what) for ratio, large, what in found if ratio < (LARGE if large else TEXT)] == []
    background = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (background == "rgb(255, 255, 255)") != dark


def test_for_those_who_do_not_see(desktop: Seen) -> None:
    page = desktop.page
    assert page.get_attribute("html", "lang") == "en" and page.title()
    levels = page.eval_on_selector_all("h1,h2,h3,h4", "all => all.map(e => +e.tagName[1])")
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels)), "a level of headings is left out"
    pictures = page.eval_on_selector_all(
        "main svg:not([aria-hidden]),main img",
        "all => all.map(e => [e.getAttribute('role'), e.getAttribute('aria-label') || e.getAttribute('alt')])")
    assert pictures and all(role == "img" and len(said or "") > 15 for role, said in pictures)
    assert page.eval_on_selector_all("figure", "all => all.every(e => e.querySelector('figcaption').textContent.length > 20)")
    unlabelled = page.evaluate("""() => [...document.querySelectorAll("input,select,button,output")].filter(e =>
        !(e.labels && e.labels.length) && !e.getAttribute("aria-label") && !e.textContent.trim() && e.tagName !== "OUTPUT")
        .map(e => e.outerHTML)""")
    assert unlabelled == []
    assert page.evaluate("[...document.querySelectorAll('table')].every(t => t.querySelector('thead th'))")
    assert page.evaluate("[...document.querySelectorAll('nav a')].every(a => document.querySelector(a.getAttribute('href')))")
    for selector in ("nav a", "#ledger-tools button", "details.entry summary", ".slider input[type=range]"):
        page.focus(selector)
        page.keyboard.press("Shift+Tab")
        page.keyboard.press("Tab")
        outline = page.evaluate("(s => [s.outlineStyle, s.outlineWidth])(getComputedStyle(document.activeElement))")
        assert outline[0] != "none" and float(outline[1][:-2]) >= 2, selector
