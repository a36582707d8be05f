"""The server of the page: on this machine only, three files and three questions about one model of a rod."""

from __future__ import annotations

import json
from fractions import Fraction
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from threading import Lock
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from rodwnl.errors import ComputationError, InputError
from rodwnl.explore.state import about, orbits, state
from rodwnl.parameters import PLAIN, RodParameters, exact

HOST = "127.0.0.1"
FILES = {
    "/": ("index.html", "text/html; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
}
ROD = ("k1", "k2", "gamma3", "gamma1")
Own = tuple[tuple[str, Fraction], ...]
# Nothing from elsewhere, and nobody else may show the page.
HEADERS = {
    "Content-Security-Policy": "default-src 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


class Handler(BaseHTTPRequestHandler):
    """GET /, /page.js, /page.css; /about; /state?k1=…&k2=…&gamma3=…&gamma1=…&force=…; /orbits?…&threshold=0.

    model, own: the rod, and the parameters that only it has, with the values to begin with. newest: the
    number of the newest question of every page; a branch of orbits that an older one asked for is given up.
    alone: questions are answered one at a time, for the working precision of mpmath and Arb is everybody's.
    """

    protocol_version = "HTTP/1.1"
    server_version = "rodwnl"

    def __init__(self, *arguments: Any, model: str, own: Own, newest: dict[str, int], alone: Lock) -> None:
        self.model, self.own, self.newest, self.alone = model, own, newest, alone
        super().__init__(*arguments)

    def do_GET(self) -> None:
        # A page from elsewhere may reach this port by a name of its own for 127.0.0.1: answer only to ours.
        port = cast(ThreadingHTTPServer, self.server).server_port
        if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):
            self._json(HTTPStatus.FORBIDDEN, {"error": "this server answers only to this machine"})
            return
        address = urlsplit(self.path)
        if address.path in FILES:
            name, kind = FILES[address.path]
            self._send(HTTPStatus.OK, kind, files("rodwnl.explore").joinpath(name).read_bytes())
            return
        questions = {"/about": self._about, "/state": self._state, "/orbits": self._orbits}
        question = questions.get(address.path)
        if question is None:
            self._json(HTTPStatus.NOT_FOUND, {"error": f"there is no {address.path}"})
            return
        try:
            given = {name: values[-1] for name, values in parse_qs(address.query).items()}
            page, asked = given.get("page", ""), _whole("question", given.get("question", "0"))
            self.newest[page] = max(asked, self.newest.get(page, 0))
            with self.alone:
                answer = question(given)
            self._json(HTTPStatus.OK, answer)
        except (InputError, ComputationError) as error:
            self._json(HTTPStatus.BAD_REQUEST, {"error": str(error)})

    def _json(self, status: HTTPStatus, document: Any) -> None:
        self._send(status, "application/json", json.dumps(document, allow_nan=False).encode())

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        for name, value in {"Content-Type": kind, "Content-Length": str(len(body)), **HEADERS}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        """The page asks many times a second; nothing is logged."""

    def _about(self, given: dict[str, str]) -> Any:
        return about(self.model, self.own)

    def _state(self, given: dict[str, str]) -> Any:
        return state(self._rod(given), given.get("force", "0"))

    def _orbits(self, given: dict[str, str]) -> Any:
        page, asked = given.get("page", ""), _whole("question", given.get("question", "0"))

        def watch(point: Any) -> None:
            if self.newest[page] > asked:
                raise ComputationError("the page has asked for something else since")

        return orbits(self._rod(given), _whole("threshold", given.get("threshold", "0")), watch)

    def _rod(self, given: dict[str, str]) -> RodParameters:
        if missing := [name for name in ROD if name not in given]:
            raise InputError(f"the rod also needs {', '.join(missing)}")
        own: dict[str, Any] = {name: given.get(name, value) for name, value in self.own}
        return RodParameters(*(given[name] for name in ROD), model=self.model, **own)


def _whole(name: str, text: str) -> int:
    number = exact(name, text)
    if number.denominator != 1:
        raise InputError(f"{name} is {number}, but it must be a whole number")
    return int(number)


def serve(port: int = 0, model: str = PLAIN, own: Own = ()) -> ThreadingHTTPServer:
    """A server bound to 127.0.0.1 and this port (0: any free one). Raises InputError if it is taken."""
    try:
        handler = partial(Handler, model=model, own=own, newest={}, alone=Lock())
        server = ThreadingHTTPServer((HOST, port), handler)
    except OSError as error:
        raise InputError(f"cannot listen on {HOST}:{port}: {error.strerror}; give another --port") from None
    server.daemon_threads = True
    return server
