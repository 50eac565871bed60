"""The report as a browser shows it: from disk, without a network, names as text."""

import csv
import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import report_runs
from chromium import chromium, emulate
from contrasts import faint_texts
from selenium.webdriver import Chrome, Keys
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

from orbident.report.write import report_page

SIZES = {"desk": (1400, 900), "small": (1000, 800), "phone": (400, 800)}

slow = partial(pytest.param, marks=pytest.mark.slow)
PATIENCE = 60.0
"""s: on two busy cores."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chrome]:
    with chromium(tmp_path_factory.mktemp("profile"), 1400, 900) as browser:
        yield browser


@pytest.fixture(
    scope="module",
    params=["desk", *map(slow, ("small", "phone"))],
)
def page(
    request: pytest.FixtureRequest,
    browser: Chrome,
    tmp_path_factory: pytest.TempPathFactory,
) -> Chrome:
    """The report of a robot with hostile names, all charts drawn."""
    path: Path = tmp_path_factory.mktemp("run") / "report.html"
    path.write_text(report_page(report_runs.hostile()), encoding="utf-8")
    emulate(browser, *SIZES[request.param])
    browser.get(path.as_uri())
    WebDriverWait(browser, PATIENCE).until(_drawn)
    return browser


def _drawn(browser: Chrome) -> bool:
    return browser.execute_script(
        "return !document.querySelector('.chart:not([data-drawn])')"
    )


def test_nothing_on_the_console(page: Chrome):
    severe = [line for line in page.get_log("browser") if line["level"] == "SEVERE"]
    assert severe == []


def test_every_chart_is_drawn(page: Chrome):
    empty = page.execute_script(
        "return [...document.querySelectorAll('.chart')]"
        ".filter((c) => !c.querySelector('.trace path, .heatmaplayer image'))"
        ".map((c) => c.dataset.figure)"
    )
    assert empty == []
    assert page.execute_script("return document.querySelectorAll('.chart').length") > 8


def test_a_chart_is_saved_as_png(page: Chrome):
    """By the one button of each chart, which a mouse shows."""
    names = page.execute_script(
        "return [...document.querySelectorAll('.modebar-btn')]"
        ".map((b) => b.getAttribute('data-title'))"
    )
    charts = page.execute_script("return document.querySelectorAll('.chart').length")
    assert len(names) == charts
    assert all("PNG" in name for name in names)


def test_no_column_of_a_table_beside_a_chart_is_cut(page: Chrome):
    cut = page.execute_script(
        "return [...document.querySelectorAll('.beside details[open]')]"
        ".filter((d) => d.scrollWidth > d.clientWidth + 1)"
        ".map((d) => d.innerText.slice(0, 40))"
    )
    assert cut == []


def test_the_verdict_is_seen_first(page: Chrome):
    """Without scrolling: the words and the mass."""
    for part in ("#verdict h2", "#verdict .mass"):
        box = page.execute_script(
            "const r = document.querySelector(arguments[0]).getBoundingClientRect();"
            "return [r.top, r.bottom, scrollY, innerHeight]",
            part,
        )
        top, bottom, scrolled, height = box
        assert scrolled == 0
        assert 0 < top < bottom < height


def test_no_scrolling_to_the_side(page: Chrome):
    wide, window = page.execute_script(
        "return [document.documentElement.scrollWidth, innerWidth]"
    )
    assert wide <= window


def test_charts_are_wide_enough_to_be_read(page: Chrome):
    widths = page.execute_script(
        "return [...document.querySelectorAll('.chart > .plot-container .main-svg')]"
        ".map((svg) => svg.clientWidth)"
    )
    assert min(widths) > 200


def test_hostile_names_are_text(page: Chrome):
    assert "taken" not in page.title.replace(report_runs.HOSTILE["name"], "")
    body = page.execute_script("return document.body.innerText")
    for name in report_runs.HOSTILE.values():
        assert name.strip() in body
    # Headings of panels, shortened.
    drawn = page.execute_script(
        "return [...document.querySelectorAll('.chart svg text')]"
        ".map((each) => each.textContent)"
    )
    assert any(text.startswith("<img src=x onerror=") for text in drawn)
    assert any("<b>bold</b> %{y} &amp;" in text for text in drawn)
    assert (
        page.execute_script("return document.querySelectorAll('.chart a').length") == 0
    )


PANELS = """
const panels = (chart) => [...document.querySelectorAll(
  `[data-figure="${chart}"] .annotation-text`)].map((text) => text.textContent);
return ["momentum-signal", "momentum-lags", "velocity-lags"].map(panels)
"""


def test_one_axis_is_shown_alone(page: Chrome):
    """In all charts of its signal, and in no other; the keyboard does it too."""
    choice = page.find_element(By.CSS_SELECTOR, "[aria-label^='Axes of momentum']")
    whole = page.execute_script(PANELS)
    assert [len(panels) for panels in whole] == [3, 3, 3]
    choice.send_keys(Keys.DOWN, Keys.DOWN)
    alone = [[whole[0][1]], [whole[1][1]], whole[2]]
    WebDriverWait(page, PATIENCE).until(lambda b: b.execute_script(PANELS) == alone)
    assert page.execute_script(CURVES) == 2
    choice.send_keys(Keys.HOME)
    WebDriverWait(page, PATIENCE).until(lambda b: b.execute_script(PANELS) == whole)


CURVES = """
return document.querySelectorAll('[data-figure="momentum-signal"] .trace').length
"""


def test_a_row_of_the_intervals_says_its_numbers(page: Chrome):
    """Wherever the mouse is in it."""
    words = re.compile(r"total mass.*\d ± .* kg.*CAD: 1110", re.S)
    WebDriverWait(page, PATIENCE).until(lambda b: words.match(b.execute_script(HOVER)))


HOVER = """
const chart = document.querySelector("[data-figure='base']");
const area = chart.querySelector(".nsewdrag"), at = area.getBoundingClientRect();
area.dispatchEvent(new MouseEvent("mousemove",
  { bubbles: true, clientX: at.left + 5, clientY: at.top + 12 }));
return chart.querySelector(".hoverlayer").textContent;
"""


COLORS = """
const color = (where, of) => getComputedStyle(document.querySelector(where))[of];
return [color("body", "color"), color(".chart .xtick text", "fill"),
        color(".chart .ytick text", "fill")]
"""


def test_dark_as_well_as_light(page: Chrome):
    inks, size = set(), page.execute_script("return [innerWidth, innerHeight]")
    for scheme in ("dark", "light"):
        emulate(page, size[0], size[1], scheme)
        WebDriverWait(page, PATIENCE).until(_of_one_color)
        assert faint_texts(page, "body") == []
        inks.add(page.execute_script(COLORS)[0])
    assert len(inks) == 2


def _of_one_color(browser: Chrome) -> bool:
    return len(set(browser.execute_script(COLORS))) == 1


def test_formulas_are_read_in_lines(page: Chrome):
    """Also on a phone, where they would have no width beside the numbers."""
    widths = page.execute_script(
        "return [...document.querySelectorAll('details[open] .name th')]"
        ".map((th) => th.clientWidth)"
    )
    assert min(widths) > 200


COPIED = """
addEventListener("copy", (event) => {
  window.copied = event.clipboardData.getData("text/plain");
}, { once: true });
"""


def _copied(page: Chrome, table: int, button: int) -> str:
    """What the clipboard has after a click below a table."""
    page.execute_script(COPIED)
    found = page.find_elements(By.CSS_SELECTOR, ".copy")[table]
    page.execute_script(
        "arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", found
    )
    pressed = found.find_elements(By.TAG_NAME, "button")[button]
    pressed.click()
    assert pressed.text == "Copied"
    return page.execute_script("return window.copied")


def test_a_table_is_copied_as_csv(page: Chrome):
    head, *rows = csv.reader(_copied(page, table=0, button=0).splitlines())
    shown = page.execute_script(
        "return [...document.querySelectorAll('tbody')[0].rows]"
        ".filter((row) => !row.classList.contains('name')).map((row) => row.innerText)"
    )
    assert len(rows) == len(shown)
    assert {len(row) for row in rows} == {len(head)}
    found = report_runs.result()
    values = [float(row[head.index("estimate")]) for row in rows]
    # Two digits of the deviation are shown.
    np.testing.assert_array_less(
        np.abs(values - found.base.values), 0.06 * found.base.std
    )
    # Every name is a formula in a note, quotes and commas included.
    assert all(row[head.index("note")] for row in rows)


def test_a_table_is_copied_for_latex(page: Chrome):
    first, *rows, last = _copied(page, table=0, button=1).splitlines()
    assert first.startswith(r"\begin{tabular}{lr")
    assert last == r"\end{tabular}"
    columns = len(first.partition("{l")[2].rstrip("}")) + 1
    for row in rows:
        # What is no command of LaTeX's is escaped, names too.
        assert len(re.findall(r"(?<!\\)&", row)) == columns - 1
        assert not re.findall(r"(?<!\\)[%#]", row)
        assert row.isascii()
        assert row.endswith((r"\\", r"\hline"))


def test_print(page: Chrome):
    """Two charts side by side on paper, a wide one alone, and what was open."""
    page.execute_script("document.querySelector('details').open = false")
    page.execute_script("dispatchEvent(new Event('beforeprint'))")
    widths, closed = page.execute_script(
        "return [[...document.querySelectorAll('.chart > .plot-container .main-svg')]"
        ".map((svg) => svg.clientWidth / (svg.closest('.wide') ? 2 : 1)),"
        "!document.querySelector('details').open]"
    )
    page.execute_script("dispatchEvent(new Event('afterprint'))")
    page.execute_script("document.querySelector('details').open = true")
    assert set(widths) == {330}
    assert closed


PAPER = 718
"""Pixels of an A4 page between margins of 1 cm, at 96 a inch."""

WIDER = """
const width = document.documentElement.clientWidth;
return [...document.querySelectorAll("body *")]
  .filter((e) => !e.closest("svg *") && e.getBoundingClientRect().right > width + 1)
  .map((e) => `${e.tagName} ${e.className} ${e.textContent.slice(0, 40)}`);
"""


def test_nothing_is_wider_than_paper(page: Chrome):
    size = page.execute_script("return [innerWidth, innerHeight]")
    emulate(page, PAPER, 1000, media="print")
    page.execute_script("dispatchEvent(new Event('beforeprint'))")
    wider, faint = page.execute_script(WIDER), faint_texts(page, "body")
    page.execute_script("dispatchEvent(new Event('afterprint'))")
    emulate(page, *size)
    assert wider == []
    assert faint == []
