"""The page of `takagi explore` in a browser: by keyboard alone, and as its command says.

Needs a Chromium of the system; the tests say so where there is none.
"""

from __future__ import annotations

import json
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from queue import Queue
from typing import TYPE_CHECKING

import pytest

from takagi.certificates import TurbineDesign
from takagi.cli.main import main
from takagi.reports.explore.server import bound_socket, serve
from takagi.reports.explore.turbine_cells import turbine_book
from takagi.reports.simulation.measured_loop import NOTHING
from tests.reports.test_explore_designs import PENDULUM

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

BROWSER = next((p for name in ("chromium", "google-chrome") if (p := shutil.which(name))), None)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(BROWSER is None, reason="no chromium and no google-chrome on this machine"),
    # Of playwright's own event loop.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]
# A design, on a busy machine [ms].
LONG = 180_000
WIDTHS = (390, 768, 1280)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield started
        started.close()


@contextmanager
def window(browser: Browser, address: str) -> Iterator[Page]:
    context = browser.new_context(permissions=["clipboard-read", "clipboard-write"])
    page = context.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda line: complaints.append(line.text) if line.type == "error" else None)
    page.goto(address)
    yield page
    context.close()
    assert [text for text in complaints if "409" not in text and "REFUSED" not in text] == []


def require_accessible(page: Page) -> None:
    """No serious fault by axe, and nothing beyond the edge, at three widths, light and dark."""
    from axe_playwright_python.sync_playwright import Axe

    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 850})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            faults = Axe().run(page).response["violations"]
            serious = [f["id"] for f in faults if f["impact"] in ("serious", "critical")]
            assert serious == [], (width, scheme)


def test_by_keyboard_from_a_slider_to_the_command(browser: Browser, tmp_path: Path) -> None:
    """A slider moves, gains and set change, and the copied command has the page's gains."""
    (tmp_path / "pendulum.toml").write_text(PENDULUM, encoding="utf-8")
    command = [sys.executable, "-m", "takagi.cli", "explore", "pendulum.toml", "--cache", "cache"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=tmp_path) as running:
        try:
            assert running.stdout is not None
            address = running.stdout.readline().strip()
            with window(browser, address) as page:
                copied = turned_and_copied(page)
                gains = table_of(page)
                require_accessible(page)
                with window(browser, address) as second:
                    second.wait_for_selector('#answer[data-at="0-0-0"]', timeout=LONG)
                    page.locator("input[type=range]").first.press("ArrowRight")
                    page.wait_for_selector("#problem:visible")
                    assert "Another window" in page.inner_text("#problem")
                running.send_signal(signal.SIGINT)
                assert running.wait(60) == 0
                page.locator("input[type=range]").first.press("ArrowRight")
                page.get_by_text("start it again in the terminal").wait_for()
        finally:
            running.kill()

    assert copied[:3] == ["takagi", "design", "pendulum.toml"]
    out = tmp_path / "made"
    copied[2], copied[copied.index("--out") + 1] = str(tmp_path / "pendulum.toml"), str(out)
    assert main([*copied[1:], "--no-report"]) == 0
    made = json.loads((out / "certificate.json").read_text(encoding="utf-8"))
    assert gains == [row for rule in made["gains"]["K"] for row in rule]


def turned_and_copied(page: Page) -> list[str]:
    """Move the first slider by keys alone; return the words of the command that is copied."""
    page.wait_for_selector('#answer[data-at="0-0-0"]', timeout=LONG)
    assert page.inner_text("#badge") == "PROVED"
    before = table_of(page), page.get_attribute("#drawing .safe", "d"), page.inner_text("#command")
    for key in ("Tab", "Tab", "ArrowRight", "ArrowRight", "ArrowRight"):
        page.keyboard.press(key)
    slider = page.locator("input[type=range]").first
    page.wait_for_selector('#answer[data-at="3-0-0"]', timeout=LONG)
    assert slider.get_attribute("aria-valuetext") == page.inner_text("output >> nth=0")
    assert page.get_by_label("Settling time").input_value() == "3"
    after = table_of(page), page.get_attribute("#drawing .safe", "d"), page.inner_text("#command")
    assert all(old != new for old, new in zip(before, after, strict=True))
    assert page.inner_text("#badge") == "PROVED"
    assert "are proved to come to rest" in page.inner_text("#sentence")
    while page.evaluate("document.activeElement.id") != "copy":
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.get_by_text("Copied.").wait_for()
    copied = str(page.evaluate("navigator.clipboard.readText()"))
    assert copied == page.inner_text("#command")
    return shlex.split(copied)


def table_of(page: Page) -> list[list[float]]:
    rows = page.locator("#gains tbody tr").all()
    return [[float(text) for text in row.locator("td").all_inner_texts()] for row in rows]


def test_the_wind_of_a_turbine_by_keyboard(browser: Browser, turbine_design: TurbineDesign) -> None:
    """The end key goes to the last cell, whose bounds and shares follow."""
    addresses: Queue[str] = Queue()
    book = turbine_book(replace(turbine_design, measured=NOTHING), Path("build/nrel5mw"))
    options = {"ready": addresses.put, "seconds": 600.0}
    listening = bound_socket(0)
    threading.Thread(target=serve, args=(book, listening), kwargs=options, daemon=True).start()
    with window(browser, addresses.get(timeout=60)) as page:
        page.wait_for_selector('#answer[data-at="0"]')
        first = page.inner_text("#sentence"), table_of(page)
        page.locator("input[type=range]").press("End")
        page.wait_for_selector(f'#answer[data-at="{len(book.cells) - 1}"]')

        assert (page.inner_text("#sentence"), table_of(page)) != first
        assert page.inner_text("output") == "24.5021 to 25 m/s"
        assert page.locator("#drawing svg").count() == len(book.panels)
        assert page.inner_text("#command") == "takagi check build/nrel5mw"
        require_accessible(page)
