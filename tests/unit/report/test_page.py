"""The page: every section, names as text, not too large."""

import html
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import plotly.graph_objects as go
import pytest
import report_runs

from orbident.estimation.checks import Check
from orbident.estimation.result import Result
from orbident.report.charts import label, numbers
from orbident.report.page import Chart, Section, embedded
from orbident.report.write import report_page

SECTIONS = (
    "parameters",
    "masses",
    "budget",
    "fit",
    "conditioning",
    "sensitivity",
    "identifiability",
    "excitation",
    "provenance",
    "references",
)


class _Seen(HTMLParser):
    """Tags, and the text that a person reads."""

    def __init__(self) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.tags: list[str] = []
        self.text = ""

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.ids += [value or "" for name, value in attrs if name == "id"]

    def handle_data(self, data):
        if self.tags and self.tags[-1] not in {"script", "style"}:
            self.text += data


def _seen(page: str) -> _Seen:
    seen = _Seen()
    seen.feed(page)
    return seen


def _figures(page: str) -> dict:
    (found,) = re.findall(r'<script class="figures"[^>]*>(.*?)</script>', page, re.S)
    return json.loads(found)


@pytest.fixture(scope="module")
def page() -> str:
    return report_page(report_runs.result())


def test_sections(page: str):
    seen = _seen(page)
    assert [name for name in seen.ids if name != "verdict"] == list(SECTIONS)
    assert page.index("Trusted") < page.index('id="parameters"')
    for words in (
        *("pi_19", "phi_5", "sigma_1", "M from pi_13", "SHA-256", "mx(link3)"),
        *("Numerische Mathematik", "N m s", "0.360 rad/s"),
    ):
        assert words in seen.text, words


def test_replay_and_intervals_are_on_top():
    chart = Chart("replay", "The motion", {"data": [], "layout": {"height": 100}})
    replay = [Section("replay", "Replay", charts=(chart,))]
    page = report_page(report_runs.result(), replay=replay)
    places = ("replay", "base")
    at = [page.index(f'class="chart" data-figure="{name}"') for name in places]
    assert page.index('id="verdict"') < at[0] < at[1] < page.index('id="parameters"')
    # A refused result has no intervals.
    assert 'class="chart" data-figure="replay"' in report_page(
        report_runs.rejected(), replay=replay
    )


def test_a_route_that_is_off_has_no_tick():
    """A rule that is passed may still call for care, and the result stands."""
    routes = Check("routes to the mass", "trust", "1110 kg, but 1106 kg", "use this")
    page = report_page(replace(report_runs.result(), checks=(routes,)))
    assert '<li class="doubt">1110 kg, but 1106 kg; use this</li>' in page
    assert "Trusted" in page


def test_nothing_from_elsewhere(page: str):
    own = re.sub(r"<script.*?</script>", "", page, flags=re.S)
    assert "http" not in own
    assert re.findall(r"<link [^>]*>", own) == ['<link rel="icon" href="data:,">']


def test_a_notebook_shows_the_first_table(page: str):
    """The one of the page, below verdict and mass; a refused result has its text."""
    shown = report_runs.result()._repr_html_()
    assert shown is not None
    words, table = shown.split("\n", 1)
    assert words.startswith("<p>paper-spatial: trusted, ")
    assert " kg by least-squares (95 %: " in words
    assert table in page
    hostile = report_runs.hostile()._repr_html_()
    assert hostile is not None
    assert not {"script", "img", "b"} & set(_seen(hostile).tags)
    assert report_runs.rejected()._repr_html_() is None


def test_a_row_of_the_intervals_says_its_numbers(page: str):
    """With the digits of the table, whose names are longer than the chart's."""
    figures = _figures(page)
    for name, rows in {"base": "total mass<br>1", "masses": "M from pi_1"}.items():
        _, intervals = figures[name]["data"]
        assert len(intervals["hovertext"]) == len(intervals["y"])
        assert intervals["hovertext"][0].startswith(rows)
    mass = figures["base"]["data"][1]["hovertext"][0].split("<br>")
    assert re.fullmatch(r"[\d.]+ ± [\d.]+ kg", mass[1])
    assert mass[2] == "CAD: 1110.00 kg"
    text = json.dumps(_figures(report_page(report_runs.hostile()))["base"])
    assert not re.search("<(?!br>)", text)


def test_any_axis_of_a_signal_can_be_shown_alone(page: str):
    """By a choice beside the title of its first chart."""
    found = re.findall(r'<select [^>]*aria-label="([^"]*)">(.*?)</select>', page, re.S)
    names = ["momentum", "velocity"]
    assert [title for title, _ in found] == [
        f"Axes of {name}: measured, predicted" for name in names
    ]
    for name, (_, options) in zip(names, found, strict=True):
        panels = _figures(page)[f"{name}-lags"]["layout"]["annotations"]
        axes = ["all", *(panel["text"] for panel in panels)]
        assert re.findall("<option.*?>(.*?)</option>", options) == axes


def test_size(page: str):
    # Most of it is plotly.js; the aim is 8 MB.
    assert len(page.encode()) < 3e6


def test_charts_are_what_plotly_takes(page: str):
    figures = _figures(page)
    assert {"base", "masses", "momentum-signal", "velocity-lags"} <= set(figures)
    for figure in figures.values():
        # Roles of colours become colours in the page.
        text = re.sub(r'"--[a-z]+"', '"#123456"', json.dumps(figure))
        go.Figure(json.loads(text))


def test_hostile_names_are_text():
    page = report_page(report_runs.hostile())
    seen = _seen(page)
    # Of the page itself: figures, plotly, and its own two.
    assert seen.tags.count("script") == 4
    assert not {"img", "b"} & set(seen.tags)
    for name in report_runs.HOSTILE.values():
        assert name.strip() in seen.text, name
    headings = [
        annotation["text"]
        for figure in _figures(page).values()
        for annotation in figure["layout"].get("annotations", ())
    ]
    assert any("&lt;img" in text for text in headings)
    assert not any("<" in text for text in headings)


def test_rejected_has_a_report_too():
    seen = _seen(report_page(report_runs.rejected()))
    assert "Refused" in seen.text
    assert "record one of them" in seen.text
    assert "record one of them" in seen.text
    # There is no mass, by any route.
    assert "masses" not in seen.ids


def test_a_result_that_says_little_has_one():
    """As one that an older version wrote."""
    found: Result = replace(
        report_runs.result(), signals=tuple, motion=None, input={}, residual={}
    )
    ids = _seen(report_page(found)).ids
    assert "parameters" in ids
    assert not {"fit", "excitation"} & set(ids)


def test_labels():
    assert label("<b>&amp;") == "&lt;b&gt;&amp;amp;"
    assert len(html.unescape(label("x" * 300))) == 40


def test_numbers_read_back():
    packed = numbers(np.array([1.5, np.nan]))
    figure = go.Figure(go.Scatter(y=packed))
    assert packed["dtype"] == "f8"
    assert figure.to_dict()["data"][0]["y"] == packed


def test_json_ends_no_script():
    assert "<" not in embedded({"a": "</script><!--"})
    assert json.loads(embedded({"a": "</script><!--"})) == {"a": "</script><!--"}


def test_what_is_not_finite_is_a_gap():
    data = {"range": [math.nan, 1.0], "y": (math.inf, -math.inf, 0.5)}
    assert json.loads(embedded(data)) == {"range": [None, 1.0], "y": [None, None, 0.5]}
