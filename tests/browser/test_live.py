"""The page of `orbident live --view` in Chromium: intervals that shrink, and alarms."""

import itertools
import json
import time
import urllib.error
import urllib.request
from collections.abc import Callable

import pytest
from chromium import chromium, emulate
from contrasts import faint_texts
from live_streams import NAME, csv_lines, samples
from processes import started
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By

PATIENCE = 60.0
"""s; the machine is shared."""


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.1)


def check_looks(browser: Chrome) -> None:
    """On a desk and on a phone, light and dark: all is within the page, and read."""
    papers = set()
    for width, scheme in itertools.product((1400, 400), ("light", "dark")):
        emulate(browser, width, 800, scheme)
        wide, window, bar, paper = browser.execute_script(
            "return [document.documentElement.scrollWidth, innerWidth,"
            "document.querySelector('td svg').clientWidth,"
            "getComputedStyle(document.body).backgroundColor]"
        )
        assert wide <= window
        assert bar > 200
        assert faint_texts(browser, "body") == []
        papers.add(paper)
    assert len(papers) == 2


def test_intervals_shrink_and_a_capture_is_told(tmp_path):
    lines = b"\n".join(csv_lines(samples(15.0))).splitlines(keepends=True)
    options = ("live", NAME, "--velocity-std", "1e-3", "--view")
    with (
        chromium(tmp_path, 1000, 900) as browser,
        started(*options, stdin=-1) as process,
    ):
        stdin, stdout = process.stdin, process.stdout
        assert stdin is not None
        assert stdout is not None
        url = json.loads(stdout.readline())["view"]
        browser.get(url)

        def width(name: str) -> float:
            found = f"tr[data-name='{name}'] rect.interval"
            bar = browser.find_element(By.CSS_SELECTOR, found)
            return float(bar.get_attribute("width") or "nan")

        def body() -> str:
            return browser.find_element(By.TAG_NAME, "body").text

        def send(part: list[bytes]) -> None:
            stdin.write(b"".join(part).decode())
            stdin.flush()

        until(lambda: NAME in body())
        send(lines[:80])
        until(lambda: "counted" in body())
        names = ("M", "sigma_1", "iota_12")
        early = [width(name) for name in names]
        send(lines[80:301])
        until(lambda: "t = 14." in body())
        late = [width(name) for name in names]
        assert all(b < a / 2 for a, b in zip(early, late, strict=True)), (early, late)
        assert "The robot changed" not in body()
        send(lines[301:])
        until(lambda: "The robot changed at t = 15.0" in body())
        assert "mass 11" in body()
        check_looks(browser)
        severe = [e for e in browser.get_log("browser") if e["level"] == "SEVERE"]
        assert [e for e in severe if "favicon" not in e["message"]] == []
        foreign = urllib.request.Request(url, headers={"Origin": "http://a.example"})
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(foreign, timeout=10)
