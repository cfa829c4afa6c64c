"""`takagi explore` through the real command line: what it refuses, and how it ends."""

from __future__ import annotations

import socket
import sys
from pathlib import Path
from urllib.request import Request, urlopen

import pytest

from takagi.cli.main import main
from takagi.reports.explore import books
from takagi.reports.explore.axes import Axis
from takagi.reports.explore.books import Book

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def cheap_book(monkeypatch: pytest.MonkeyPatch) -> Book:
    cell = {"proved": True, "verdict": "PROVED"}
    axis = Axis("settle", "Settling time", ({},), ("as the file says",))
    book = Book("Plant", (axis,), {(0,): cell}, [(0,)], lambda _: "takagi design")
    monkeypatch.setattr(books, "plant_book", lambda *_: book)
    return book


@pytest.mark.usefixtures("cheap_book")
def test_the_page_answers_at_the_address_that_is_printed_until_the_time_is_over(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its first line is the address, on this machine; another Host is refused over the socket."""
    seen = []

    def announce(address: str, *, no_browser: bool) -> None:
        seen.append((address, no_browser))

    monkeypatch.setattr("takagi.cli.verbs.explore._announce", announce)
    options = ["--cache", str(tmp_path), "--timeout", "300ms", "--no-browser"]
    assert main(["explore", "cart_pole", *options]) == 0

    ((address, no_browser),) = seen
    assert address.startswith("http://127.0.0.1:")
    assert len(address.split("/")[3]) >= 32
    assert no_browser
    assert capsys.readouterr().err == ""
    with pytest.raises(OSError):
        urlopen(Request(address), timeout=5)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nrel5mw"], "make one with 'takagi design nrel5mw --out DIR', and explore DIR"),
        (["dayawansa_martin"], "a plant without inputs has nothing to turn"),
        (["no_such_plant"], "is not known"),
        (["cart_pole", "--port", "70000"], "--port 70000: out of range; give another port"),
        (["cart_pole", "--timeout", "soon"], "option --timeout: 'soon' was given"),
        (["cart_pole", "--timeout", "0s"], "a time above 0 is needed"),
    ],
)
def test_what_cannot_be_explored_is_told_in_one_sentence(
    arguments: list[str], words: str, tmp_path: Path, capsys: Capture
) -> None:
    assert main(["explore", *arguments, "--cache", str(tmp_path)]) == 2

    error = capsys.readouterr().err
    assert words in error
    assert "Traceback" not in error


def test_a_port_in_use_is_told(tmp_path: Path, capsys: Capture) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        assert main(["explore", "cart_pole", "--port", port, "--cache", str(tmp_path)]) == 2

    assert f"--port {port}: Address already in use; give another" in capsys.readouterr().err


@pytest.mark.parametrize("content", [{}, {"gains.json": "{}", "design.json": "{}"}])
def test_a_folder_without_a_certificate_is_told(
    content: dict[str, str], tmp_path: Path, capsys: Capture
) -> None:
    for name, text in content.items():
        (tmp_path / name).write_text(text, encoding="utf-8")

    assert main(["explore", str(tmp_path)]) == 2
    assert "takagi design MODEL --out" in capsys.readouterr().err


def test_without_the_extra_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] in ("starlette", "uvicorn")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delitem(sys.modules, "takagi.reports.explore.server", raising=False)
    monkeypatch.setitem(sys.modules, "uvicorn", None)

    assert main(["explore", "cart_pole"]) == 2
    assert "pip install 'takagi[explore]'" in capsys.readouterr().err


@pytest.mark.usefixtures("cheap_book")
def test_a_plant_without_a_design_is_an_answer(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture, tmp_path: Path
) -> None:
    monkeypatch.setattr(books, "plant_book", lambda *_: "The limits leave no gains.")

    assert main(["explore", "cart_pole", "--cache", str(tmp_path)]) == 1
    assert "The limits leave no gains." in capsys.readouterr().out
