"""The server of `takagi explore`: for this machine alone, and for who knows its address.

Every request is refused unless it names this host (a page elsewhere that rebinds its name to
127.0.0.1 does not), comes from this page or from none, has the token in its path, and is a GET or
POST.  No answer may be read by, or framed in, another page, and nothing is loaded from elsewhere.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import socket
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from importlib import resources
from typing import TYPE_CHECKING, Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

    from takagi.reports.explore.books import Book

HOST = "127.0.0.1"
LONGEST_BODY = 1000  # bytes
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
SHEETS = (("page", "style.css"), ("explore", "explore.css"))
ELSEWHERE = (
    "Another window explores this design. Close that one, or reload this page to go on here."
)


def bound_socket(port: int) -> socket.socket:
    """Return a socket of this machine alone; port 0 takes any that is free.

    Raises ModelError: the port is in use, or not allowed.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen()
    except (OSError, OverflowError) as error:
        listening.close()
        why = getattr(error, "strerror", None) or "out of range"
        raise ModelError(
            f"--port {port}: {why}; give another port above 1023, or leave --port out for a free "
            "one"
        ) from error
    return listening


def serve(
    book: Book, listening: socket.socket, *, ready: Callable[[str], None], seconds: float | None
) -> None:
    """Serve the page until Ctrl-C, or for so many seconds.

    ready : called with the page's address once it answers.
    """
    token, port = secrets.token_urlsafe(24), listening.getsockname()[1]
    application = guarded_application(book, token, port)
    config = uvicorn.Config(
        application,
        access_log=False,
        log_level="error",
        server_header=False,
        lifespan="on",
        timeout_graceful_shutdown=1,
    )
    server = uvicorn.Server(config)

    async def run() -> None:
        serving = asyncio.ensure_future(server.serve(sockets=[listening]))
        while not server.started and not serving.done():
            await asyncio.sleep(0.02)
        ready(f"http://{HOST}:{port}/{token}/")
        await asyncio.wait([serving], timeout=seconds)
        server.should_exit = True
        await serving

    try:
        # uvicorn ends in good order, and passes the interrupt on.
        with suppress(KeyboardInterrupt):
            asyncio.run(run())
    finally:
        book.close()


def guarded_application(book: Book, token: str, port: int) -> ASGIApp:
    """Return the application behind its guard."""
    return _Guard(_application(book, token), token, {f"{HOST}:{port}", f"localhost:{port}"})


class _Guard:
    """Refuses what does not come from the page itself; see the module."""

    def __init__(self, application: ASGIApp, token: str, hosts: set[str]) -> None:
        self._application, self._token, self._hosts = application, token, hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def with_headers(message: Any) -> None:
            if message["type"] == "http.response.start":
                added = [(k.lower().encode(), v.encode()) for k, v in HEADERS.items()]
                message = {**message, "headers": [*message["headers"], *added]}
            await send(message)

        if scope["type"] == "lifespan":
            await self._application(scope, receive, send)
        elif scope["type"] == "http":
            refused = self._refusal(Request(scope))
            await (refused or self._application)(scope, receive, with_headers)

    def _refusal(self, request: Request) -> Response | None:
        headers = request.headers
        host, origin = headers.get("host", ""), headers.get("origin")
        if headers.getlist("host") != [host] or host not in self._hosts:
            words = "This page answers to this machine alone; open the address from the terminal."
            return Response(words, 421, media_type="text/plain")
        site = headers.get("sec-fetch-site", "none")
        if origin not in (None, f"http://{host}") or site not in ("none", "same-origin"):
            words = "This page takes nothing from other pages; open the address from the terminal."
            return Response(words, 403, media_type="text/plain")
        parts = request.url.path.split("/", 2)
        if len(parts) < 3 or not secrets.compare_digest(parts[1].encode(), self._token.encode()):
            words = "The address lacks its random word; open the whole address from the terminal."
            return Response(words, 403, media_type="text/plain")
        if request.method not in ("GET", "POST"):
            return Response("Only GET and POST are answered.", 405, media_type="text/plain")
        return None


def _application(book: Book, token: str) -> Starlette:
    """Return the routes: three files of the page, its state, and the design at a position."""
    newest = ""

    def file(name: str, kind: str, content: bytes) -> Route:
        async def answer(_: Request) -> Response:
            return Response(content, media_type=kind)

        return Route(f"/{token}/{name}", answer, methods=["GET"])

    async def opened(request: Request) -> Response:
        nonlocal newest
        body = await _body(request)
        if body is None or not isinstance(body.get("page"), str):
            return _refused("a page's name is needed")
        newest = body["page"]
        axes = [{"label": axis.label, "words": axis.words, "name": axis.name} for axis in book.axes]
        return _answer({"title": book.title, "axes": axes, "panels": book.panels})

    async def progress(_: Request) -> Response:
        ready, total = book.progress()
        return _answer({"ready": ready, "total": total})

    async def turned(request: Request) -> Response:
        body = await _body(request)
        steps = None if body is None else body.get("steps")
        ends = [len(axis.words) for axis in book.axes]
        if (
            body is None
            or not isinstance(steps, list)
            or len(steps) != len(ends)
            or not all(type(k) is int and 0 <= k < end for k, end in zip(steps, ends, strict=True))
        ):
            return _refused("a position of every slider is needed; reload the page")
        if body.get("page") != newest:
            return _answer({"error": ELSEWHERE}, 409)
        if not body.get("exact"):
            return _answer(book.nearest(tuple(steps)))
        return _answer(await book.exact(tuple(steps)) or {"stale": True})

    @asynccontextmanager
    async def running(_: Starlette) -> AsyncIterator[None]:
        filling = asyncio.ensure_future(book.fill())
        try:
            yield
        finally:
            filling.cancel()
            book.close()

    templates = "takagi.reports.{}.templates"
    sheets = b"".join(_template(templates.format(room), name) for room, name in SHEETS)
    own = templates.format("explore")
    routes = [
        file("", "text/html", _template(own, "explore.html")),
        file("explore.js", "text/javascript", _template(own, "explore.js")),
        file("explore.css", "text/css", sheets),
        Route(f"/{token}/progress", progress, methods=["GET"]),
        Route(f"/{token}/open", opened, methods=["POST"]),
        Route(f"/{token}/turn", turned, methods=["POST"]),
    ]
    return Starlette(routes=routes, lifespan=running)


async def _body(request: Request) -> Mapping[str, Any] | None:
    """Return the JSON object of a request; None for anything else, or for too much."""
    if request.headers.get("content-type") != "application/json":
        return None
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > LONGEST_BODY:
            return None
    try:
        value = json.loads(body)
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None


def _template(package: str, name: str) -> bytes:
    return resources.files(package).joinpath(name).read_bytes()


def _answer(value: Any, status: int = 200) -> Response:
    return JSONResponse(value, status)


def _refused(why: str) -> Response:
    return _answer({"error": f"This request is not understood: {why}."}, 400)
