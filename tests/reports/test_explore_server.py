"""The page of `takagi explore` is for this machine, for who has its address, and for itself."""

from __future__ import annotations

import asyncio
import multiprocessing
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest

from takagi.certificates import TurbineDesign, Verdict
from takagi.certificates.design.turbine.result import claim_summary
from takagi.cli.options.plant_options import plant_settings
from takagi.models.errors import ModelError
from takagi.models.plant_files.loader import PlantFile
from takagi.reports.explore.axes import Axis
from takagi.reports.explore.books import ENDED, Book, Worker
from takagi.reports.explore.server import bound_socket, guarded_application
from takagi.reports.explore.turbine_cells import turbine_book
from takagi.reports.simulation.measured_loop import NOTHING

TOKEN, PORT = "a-random-word", 8123
HOME = f"http://127.0.0.1:{PORT}"
CELL = {"proved": True, "verdict": "PROVED"}


class Client:
    """A client of a page with one slider of three positions, all computed; without a socket."""

    def __init__(self, base: str = HOME) -> None:
        axis = Axis("wind", "Wind", ({}, {}, {}), ("3 m/s", "4 m/s", "5 m/s"))
        cells: dict[tuple[int, ...], dict[str, Any]] = {
            (k,): {**CELL, "sentence": f"cell {k}"} for k in range(3)
        }
        book = Book("Turbine", (axis,), cells, list(cells), lambda at: f"command {at[0]}")
        self._application: Any = guarded_application(book, TOKEN, PORT)
        self._base = base

    def request(self, method: str, path: str, **options: Any) -> httpx.Response:
        async def answer() -> httpx.Response:
            transport = httpx.ASGITransport(self._application)
            async with httpx.AsyncClient(transport=transport, base_url=self._base) as client:
                return await client.request(method, path, **options)

        return asyncio.run(answer())

    def get(self, path: str, **options: Any) -> httpx.Response:
        return self.request("GET", path, **options)

    def post(self, path: str, **options: Any) -> httpx.Response:
        return self.request("POST", path, **options)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("", "text/html"), ("explore.js", "text/javascript"), ("explore.css", "text/css")],
)
def test_the_page_loads_nothing_from_elsewhere_and_is_read_by_no_other_page(
    name: str, kind: str
) -> None:
    answer = Client().get(f"/{TOKEN}/{name}")

    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith(kind)
    policy = answer.headers["content-security-policy"]
    assert policy.startswith("default-src 'none'; script-src 'self';")
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert not [name for name in answer.headers if name.startswith("access-control")]
    addresses = answer.text.replace("http://www.w3.org/2000/svg", "")
    assert "//" not in "".join(line for line in addresses.splitlines() if "// " not in line)


@pytest.mark.parametrize("path", ["/", "/progress", "/another-word/", f"/{TOKEN}x/", f"//{TOKEN}/"])
def test_without_the_word_of_the_address_nothing_is_answered(path: str) -> None:
    answer = Client().get(path)

    assert answer.status_code == 403
    assert "open the whole address from the terminal" in answer.text
    assert TOKEN not in answer.text


@pytest.mark.parametrize(
    "host",
    ["evil.example", f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:1", f"[::1]:{PORT}", ""],
)
def test_a_page_that_rebinds_its_name_to_this_machine_is_refused(host: str) -> None:
    """DNS rebinding: the browser sends the name of the other page as Host."""
    answer = Client().get(f"/{TOKEN}/", headers={"Host": host})

    assert answer.status_code == 421
    assert "this machine alone" in answer.text


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": f"http://localhost:{PORT}"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_what_another_page_sends_is_refused(headers: dict[str, str]) -> None:
    """Also one with the right word: a script on another page, or a link on it."""
    answer = Client().post(f"/{TOKEN}/open", json={"page": "one"}, headers=headers)

    assert answer.status_code == 403
    assert "other pages" in answer.text


def test_localhost_is_this_machine_too() -> None:
    home = f"http://localhost:{PORT}"

    assert Client(home).get(f"/{TOKEN}/", headers={"Origin": home}).status_code == 200


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "HEAD", "TRACE"])
def test_other_methods_are_refused(method: str) -> None:
    assert Client().request(method, f"/{TOKEN}/").status_code == 405


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [("GET", "turn", 405), ("POST", "progress", 405), ("POST", "", 405),
     ("GET", "../etc/passwd", 403), ("GET", "explore.js.jinja", 404),
     ("GET", "%2e%2e/server.py", 404)],
)  # fmt: skip
def test_only_the_routes_of_the_page_are_answered(method: str, path: str, status: int) -> None:
    assert Client().request(method, f"/{TOKEN}/{path}").status_code == status


def test_a_slider_gets_the_design_of_its_position() -> None:
    page = Client()
    opened = page.post(f"/{TOKEN}/open", json={"page": "one"}).json()
    assert opened["axes"][0]["words"] == ["3 m/s", "4 m/s", "5 m/s"]

    answer = page.post(f"/{TOKEN}/turn", json={"page": "one", "steps": [2]}).json()

    assert (answer["cell"]["sentence"], answer["exact"]) == ("cell 2", True)
    assert answer["command"] == "command 2"
    assert page.get(f"/{TOKEN}/progress").json() == {"ready": 3, "total": 3}


@pytest.mark.parametrize(
    "content",
    [b"", b"[]", b"{", b'{"page":"one"}', b'{"page":"one","steps":[3]}',
     b'{"page":"one","steps":[-1]}', b'{"page":"one","steps":[true]}',
     b'{"page":"one","steps":[0,0]}', b'{"page":"one","steps":["0"]}', b'{"steps":' + b"[" * 900,
     b'{"page":"' + b"x" * 2000 + b'","steps":[0]}'],
)  # fmt: skip
def test_what_is_no_position_is_refused_in_one_sentence(content: bytes) -> None:
    page = Client()
    page.post(f"/{TOKEN}/open", json={"page": "one"})

    kind = {"Content-Type": "application/json"}
    answer = page.post(f"/{TOKEN}/turn", content=content, headers=kind)

    assert answer.status_code == 400
    assert "reload the page" in answer.json()["error"]


def test_a_form_of_another_page_cannot_send_json() -> None:
    """A simple request, which browsers send without asking, has no JSON type."""
    answer = Client().post(f"/{TOKEN}/open", content=b'{"page":"one"}')

    assert answer.status_code == 400


def test_the_newest_window_is_answered_and_the_other_told() -> None:
    page = Client()
    for name in ("one", "two"):
        page.post(f"/{TOKEN}/open", json={"page": name})

    old = page.post(f"/{TOKEN}/turn", json={"page": "one", "steps": [0]})
    new = page.post(f"/{TOKEN}/turn", json={"page": "two", "steps": [0]})

    assert (old.status_code, new.status_code) == (409, 200)
    assert "reload this page" in old.json()["error"]


def test_the_server_listens_on_this_machine_alone_and_a_used_port_is_told() -> None:
    with bound_socket(0) as first:
        host, port = first.getsockname()
        assert host == "127.0.0.1"
        with pytest.raises(ModelError, match=f"--port {port}: .*in use; give another port"):
            bound_socket(port)
    with pytest.raises(ModelError, match="out of range"):
        bound_socket(70000)


FOLDER = Path("build/nrel5mw")


@pytest.fixture
def book(turbine_design: TurbineDesign) -> Book:
    return turbine_book(replace(turbine_design, measured=NOTHING), FOLDER)


def test_each_cell_states_no_more_than_the_certificate(
    book: Book, turbine_design: TurbineDesign
) -> None:
    summary, law = claim_summary(turbine_design), turbine_design.effort_sharing_law
    assert summary is not None and law is not None
    assert len(book.cells) == len(summary.winds) == len(book.axes[0].words)

    for (k,), cell in book.cells.items():
        assert cell["proved"]
        error, rate = [
            float(text) for text in re.findall(r"\d+\.?\d*(?:e-\d+)?", cell["sentence"])
        ][:2]
        assert 0.99 * summary.wind_error[k] <= error <= summary.wind_error[k]
        assert 0.99 * summary.wind_rate[k] <= rate <= summary.wind_rate[k]
        pitch, torque, proportional = ([float(v) for v in row] for row in cell["gains"]["rows"][:3])
        assert [a + b for a, b in zip(pitch, torque, strict=True)] == pytest.approx(
            [1, 1], abs=1e-4
        )
        assert proportional == pytest.approx(law.gains.proportional[k : k + 2], rel=1e-4)


def test_what_is_not_proved_is_not_shown_as_proved(turbine_design: TurbineDesign) -> None:
    first, *others = turbine_design.checked.claims
    claims = [replace(first, verdict=Verdict.UNDECIDED), *others]
    checked = replace(turbine_design.checked, verdict=Verdict.UNDECIDED, claims=claims)
    book = turbine_book(replace(turbine_design, measured=NOTHING, checked=checked), FOLDER)

    assert "Proved wind limit" not in [panel["title"] for panel in book.panels]
    for cell in book.cells.values():
        assert not cell["proved"]
        assert cell["verdict"].startswith("UNDECIDED")
        assert "not proved" in cell["sentence"]
        assert "wind limits" not in [row["name"] for row in cell["rows"]]
        margins = [row for row in cell["rows"] if row["name"] == "margins"]
        assert [row["basis"] for row in margins] == ["linear loop that runs, not proved"]


def test_the_page_of_a_turbine_copies_its_check(book: Book) -> None:
    answer = book.nearest((3,))

    assert (answer["exact"], answer["command"]) == (True, "takagi check build/nrel5mw")
    assert book.progress() == (70, 70)


def test_a_law_without_cells_is_refused(turbine_design: TurbineDesign) -> None:
    document = {**turbine_design.document, "claims": []}
    checked = replace(turbine_design.checked, claims=[])
    with pytest.raises(ModelError, match="no wind cells to turn"):
        turbine_book(replace(turbine_design, document=document, checked=checked), FOLDER)


pytestmark = pytest.mark.slow


def test_a_newer_question_drops_the_older(tmp_path: Path) -> None:
    worker = Worker("cart_pole_2rules", plant_settings)

    async def ask() -> list[Any]:
        options = ({"settle": "3s"}, {"settle": "2s"}, {"settle": "4s"})
        asked = (worker.cell(o, tmp_path / o["settle"]) for o in options)
        return await asyncio.gather(*asked)

    try:
        *older, newest = asyncio.run(ask())
    finally:
        worker.end()
    assert older == [None, None]
    assert newest["proved"]
    assert not (tmp_path / "3s").exists() and not (tmp_path / "2s").exists()


def test_a_process_that_is_killed_is_replaced(tmp_path: Path) -> None:
    before = set(multiprocessing.active_children())
    worker = Worker("cart_pole_2rules", plant_settings)
    (process,) = set(multiprocessing.active_children()) - before
    process.kill()
    process.join()

    async def ask() -> list[Any]:
        first = await worker.cell({"settle": "3s"}, tmp_path / "one")
        return [first, await worker.cell({"settle": "3s"}, tmp_path / "two")]

    try:
        lost, found = asyncio.run(ask())
    finally:
        worker.end()
    assert lost["none"] == ENDED
    assert found["proved"]


def test_the_grid_is_filled_and_the_page_waits_for_what_runs(tmp_path: Path) -> None:
    from takagi.reports.explore.axes import Axis, command_of

    source = PlantFile.of("cart_pole_2rules")
    workers = [Worker("cart_pole_2rules", plant_settings) for _ in range(2)]
    axis = Axis("settle", "Settling time", ({}, {"settle": "3s"}), ("as the file says", "3 s"))
    cells: dict[tuple[int, ...], Any] = {}
    book = Book(
        "Plant",
        (axis,),
        cells,
        [(0,), (1,)],
        lambda at: command_of(source, axis.options[at[0]], at),
        folder=tmp_path,
        workers=workers,
    )

    async def ask() -> Any:
        filling = asyncio.ensure_future(book.fill())
        await asyncio.sleep(0)
        answer = await book.exact((0,))
        await filling
        return answer

    try:
        answer = asyncio.run(ask())
    finally:
        book.close()
    assert answer is not None and answer["exact"] and answer["origin"] == "precomputed"
    assert book.progress() == (2, 2)
    assert book.nearest((1,))["command"].startswith("takagi design cart_pole_2rules --settle 3s")
