"""Debian's Chromium without a screen, driven by selenium."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    # WebGL without a graphics card.
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    # Without a card, curves of plots are drawn six times faster past WebGL.
    "--disable-accelerated-2d-canvas",
    # Nothing but this machine can be reached.
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)


@contextmanager
def chromium(profile: Path, width: int, height: int) -> Iterator[webdriver.Chrome]:
    """A browser with a window of this size; the test is skipped where there is none.

    Args:
        profile: an empty folder.
        width: of the window, pixels.
        height: of the window.
    """
    program, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("Debian's chromium and chromium-driver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(driver))
    try:
        browser.set_window_size(width, height)
        yield browser
    finally:
        browser.quit()


PHONE = 400
"""Pixels; a window as wide as this is a phone's."""


def emulate(
    browser: webdriver.Chrome,
    width: int,
    height: int,
    scheme: str = "light",
    media: str = "screen",
) -> None:
    """Show the page in a window of this size, pixels, as a medium has it.

    Args:
        browser: shows a page.
        width: of the window.
        height: of the window.
        scheme: `light` or `dark`, as a user prefers it.
        media: `screen` or `print`.
    """
    size = {"width": width, "height": height, "deviceScaleFactor": 1}
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {**size, "mobile": width <= PHONE}
    )
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"media": media, "features": [feature]}
    )
