"""The replay page in a browser: it is drawn, it plays, and it can be scrubbed."""

import io
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
from chromium import PHONE, chromium, emulate
from contrasts import faint_texts
from PIL import Image
from random_motions import random_motion
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from orbident.robot.robot_file import load_robot
from orbident.scene.replay import recorded_motion
from orbident.scene.scene import scene_of
from orbident.simulation.simulate import simulate
from orbident.viewer.pages import ReplayPage
from orbident.viewer.server import PERIOD, close, open_server

PATIENCE = 180.0
"""s. A processor that draws instead of a graphics card, and is shared, takes long."""
WIDTH, HEIGHT = 900, 700
SCENE = (0, 160, 520, 520)
"""Where nothing but the scene is drawn: left, top, right, bottom, pixels."""


class Shown(NamedTuple):
    browser: Any
    page: ReplayPage
    server: Any
    url: str

    def load_again(self, query: str = "") -> None:
        # Light from all around is shown by the first page; it takes most of the time
        # that a page needs.
        self.server.scene.configure_environment_map(None)
        self.browser.get(self.url + query)

    def until(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline
            time.sleep(0.1)

    def click(self, words: str) -> None:
        found = (By.XPATH, f"//*[normalize-space(text())='{words}']")
        self.until(lambda: len(self.browser.find_elements(*found)) == 1)
        self.browser.find_element(*found).click()

    def place(self, selector: str) -> dict[str, float]:
        """Of the first element, once there is one."""
        found = (By.CSS_SELECTOR, selector)
        self.until(lambda: len(self.browser.find_elements(*found)) > 0)
        return self.browser.find_elements(*found)[0].rect

    def press(self, label: str) -> None:
        found = (By.XPATH, f"//button[.='{label}']")
        self.until(lambda: len(self.browser.find_elements(*found)) == 1)
        self.browser.find_element(*found).click()

    def picture(self) -> np.ndarray:
        image = Image.open(io.BytesIO(self.browser.get_screenshot_as_png()))
        return np.asarray(image.convert("RGB").crop(SCENE)).astype(int)

    def link_moves_from(self, before: np.ndarray) -> bool:
        """Whether more than some hundred pixels have changed."""
        changed = np.abs(self.picture() - before).max(axis=2) > 40
        return changed.sum() > 300


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    robot = load_robot("cepheus-like")
    motion = random_motion(robot, duration=20.0)
    replay = recorded_motion(robot, simulate(robot, motion))
    # The ghost is the robot half a second later.
    late = replay.measured.x_WB[np.minimum(np.arange(2001) + 50, 2000)]
    replay = replay._replace(predicted=replay.measured._replace(x_WB=late))
    hostile = "<script>document.title='hit'</script>\"'" + "x" * 300
    with chromium(tmp_path_factory.mktemp("profile"), WIDTH, HEIGHT) as browser:
        server, url, _ = open_server("127.0.0.1", 0)
        page = ReplayPage(server, scene_of(robot), replay, hostile)
        ended = threading.Event()

        def play() -> None:
            while not ended.wait(PERIOD):
                page.advance(PERIOD)

        player = threading.Thread(target=play)
        player.start()
        try:
            browser.get(url)
            yield Shown(browser, page, server, url)
        finally:
            ended.set()
            player.join()
            close(server)


@pytest.mark.slow
def test_the_robot_is_drawn(shown: Shown):
    def lit() -> bool:
        # The base's grey and the arm's orange, in many lights.
        return len(np.unique(shown.picture().reshape(-1, 3), axis=0)) > 100

    def arm() -> bool:
        r, g, b = np.moveaxis(shown.picture(), -1, 0)
        return ((r > b + 60) & (g > b + 20)).sum() > 200

    # Shapes arrive one after the other.
    shown.until(lit)
    shown.until(arm)


def test_a_hostile_name_is_text(shown: Shown):
    shown.until(
        lambda: "<script>" in shown.browser.find_element(By.TAG_NAME, "body").text
    )
    assert shown.browser.title != "hit"


@pytest.mark.slow
def test_it_plays(shown: Shown):
    before = shown.picture()
    # The motion must not end before "Pause" is pressed, however slow the browser is.
    shown.page._loop.value = True
    shown.press("Play")
    shown.until(lambda: shown.page._time.value > 2.0)
    shown.until(lambda: shown.link_moves_from(before))
    shown.press("Pause")
    shown.until(lambda: not shown.page._playing)
    stopped = shown.page._time.value
    time.sleep(3 * PERIOD)
    assert shown.page._time.value == stopped


@pytest.mark.slow
def test_it_can_be_scrubbed(shown: Shown):
    handle = shown.browser.find_elements(By.CSS_SELECTOR, "[role='slider']")[0]
    start = shown.page._time.value = 5.0
    shown.until(lambda: handle.get_attribute("aria-valuenow") == "5")
    before = shown.picture()
    handle.send_keys(60 * Keys.ARROW_RIGHT)
    shown.until(lambda: shown.page._time.value > start + 0.5)
    shown.until(lambda: shown.link_moves_from(before))


def test_the_panel_is_beside_the_robot(shown: Shown):
    scene, slider = shown.place("canvas"), shown.place("[role='slider']")
    assert scene["width"] > WIDTH / 2
    assert scene["x"] + scene["width"] <= slider["x"]
    assert shown.place(".uplot canvas")["width"] > 200


@pytest.mark.slow
def test_trails_and_names_are_drawn(shown: Shown):
    before = shown.picture()
    shown.page._traced.value = shown.page._named.value = True
    shown.until(lambda: shown.link_moves_from(before))
    shown.page._traced.value = shown.page._named.value = False


OURS = "div[style^='font-size:0.8em'], div[style^='padding:0.5em']"
"""What this page writes itself; labels of controls are viser's."""


@pytest.mark.slow
def test_text_is_read_on_light_and_dark_pages(shown: Shown):
    papers = set()
    for query in ("?darkMode", ""):
        shown.load_again(query)
        shown.place(".uplot canvas")
        shown.click("Show")
        shown.until(lambda: len(shown.browser.find_elements(By.CSS_SELECTOR, OURS)) > 4)
        assert faint_texts(shown.browser, OURS) == []
        papers.add(
            shown.browser.execute_script(
                "return getComputedStyle(document.querySelector('canvas')"
                ".closest('[style*=background-color]')).backgroundColor"
            )
        )
    assert len(papers) == 2


@pytest.mark.slow
def test_a_phone_shows_the_robot_above_the_panel(shown: Shown):
    emulate(shown.browser, PHONE, 800)
    shown.load_again()
    scene = shown.place("canvas")
    assert (scene["width"], scene["height"]) == (PHONE, 800)
    top = shown.place(".mantine-Paper-root")["y"]
    # The robot is seen in the middle.
    assert top > 400
    shown.click("Plots")
    shown.until(lambda: shown.place(".uplot canvas")["width"] > 200)
    wide = shown.browser.execute_script("return document.documentElement.scrollWidth")
    assert wide <= PHONE


def test_no_error_in_the_console(shown: Shown):
    errors = [e for e in shown.browser.get_log("browser") if e["level"] == "SEVERE"]
    assert errors == []
