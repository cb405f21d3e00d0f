"""Server of a live page, local to this machine: one page, its events, and its requests."""

from __future__ import annotations

import errno
import hmac
import json
import secrets
import socket
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.reporting.live.feed import Feed, FullError

#: Only address that the server listens on.
HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")
# Ports nearer than this to a port in use are tried as alternatives.
_NEAR = 100
# Timeout for a client that accepts no data, s.
_PATIENCE = 10.0
# Maximum time between two writes to a page, s; without news, a comment is sent.
_SILENCE = 1.0
# Time for pages to receive the closing event, s.
_FAREWELL = 1.0
_LARGEST = 1 << 16
_DIGITS = 9
#: Header by which the page proves that it comes from this server.
TOKEN = "X-Cbdsl-Token"

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]
"""Answer to a request, both as JSON.

Raises:
    RequestError: The request cannot be executed.
"""


class RequestError(Exception):
    """Request of a page that cannot be executed; the message states the reason."""


class LiveServer:
    """Server of one live page; it listens until it is closed.

    Args:
        feed: Feed of messages to the pages.
        page: Function that makes the page, given the token that its requests have to contain.
        answer: Function that executes requests of pages.
        port: Port to listen on; any free port for 0.

    Attributes:
        url: URL of the page, whose path is a secret.

    Raises:
        UsageError: It cannot listen there; the message states the reason and a free port.
    """

    def __init__(
        self, feed: Feed, page: Callable[[str], str], answer: Answer, port: int = 0
    ) -> None:
        self._feed = feed
        self._http = _listen(port)
        token, key = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        port = self._http.server_port
        self._http.site = _Site(feed, page(token).encode(), token, key, answer, port)
        self.url = f"http://{HOST}:{port}/{key}/"
        self._thread = Thread(target=self._http.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Release pages and port; no thread is left."""
        self._feed.close()
        # Pages that receive the closing event end by themselves. All others are cut off afterwards.
        self._feed.wait_for_nobody(_FAREWELL)
        self._http.shutdown()
        self._thread.join()
        self._http.hang_up()
        self._http.server_close()


# Security: other machines cannot connect, because the server listens on the loopback address. Pages
# of other sites in the same browser can. `Host` must name this machine, against DNS rebinding, and
# `Origin`, if it is sent, must be this server. Requests that change the run need the token as well,
# which only the page contains. Other users of this machine can connect, too. They do not know the
# key in the path of the page, its events and its requests, so that they see neither.
class _Site:
    """Live page, with all data that handlers of requests need.

    Attributes:
        feed, answer: Feed and answer, as given to ``LiveServer``.
        page: Bytes of the page.
        token: Token that requests have to contain.
        key: First part of all paths.
        hosts: Host names by which clients of this machine address it.
    """

    def __init__(
        self, feed: Feed, page: bytes, token: str, key: str, answer: Answer, port: int
    ) -> None:
        self.feed, self.page, self.token, self.answer = feed, page, token, answer
        self.key = key
        self.hosts = frozenset(f"{name}:{port}" for name in _NAMES)


class _Http(ThreadingHTTPServer):
    """HTTP server that keeps track of its connections, to end them."""

    site: _Site
    # Closing the server waits for their threads.
    daemon_threads = False

    def __init__(self, port: int) -> None:
        super().__init__((HOST, port), _Handler)
        self._open: set[socket.socket] = set()

    def process_request(self, request: Any, client_address: Any) -> None:
        """Note a connection, and serve it in a thread of its own."""
        self._open.add(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """End a connection."""
        self._open.discard(request)
        super().shutdown_request(request)

    def hang_up(self) -> None:
        """End all connections, regardless of their clients."""
        for each in list(self._open):
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                continue  # the connection has already ended

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a client that has disconnected; this is no error."""


class _Handler(BaseHTTPRequestHandler):
    """One request of a client."""

    server: _Http
    timeout = _PATIENCE
    server_version, sys_version = "cbdsl", ""

    def do_GET(self) -> None:
        """Send the page, or its events while it is connected."""
        if not self._is_from_here():
            self._refuse(HTTPStatus.FORBIDDEN, "this page is for browsers of this machine")
        elif self._place() == "":
            self._send(HTTPStatus.OK, "text/html; charset=utf-8", self.server.site.page)
        elif self._place() == "events":
            self._send_events()
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "the page is at the whole address that cb prints")

    def do_POST(self) -> None:
        """Execute a request of the page."""
        site = self.server.site
        token = self.headers.get(TOKEN, "")
        if not self._is_from_here() or not hmac.compare_digest(token.encode(), site.token.encode()):
            self._refuse(HTTPStatus.FORBIDDEN, "only the page itself may ask for something")
            return
        if self._place() != "request":
            self._refuse(HTTPStatus.NOT_FOUND, "requests go to 'request' beside the page")
            return
        try:
            answer = json.dumps(site.answer(self._content()))
        except RequestError as error:
            self._refuse(HTTPStatus.CONFLICT, str(error))
            return
        except (ValueError, TypeError, ArithmeticError, LookupError, RecursionError) as error:
            # Even floats out of range and lone surrogates get an answer.
            reason = f"the request has a value that cannot be used ({type(error).__name__})"
            self._refuse(HTTPStatus.BAD_REQUEST, reason)
            return
        self._send(HTTPStatus.OK, "application/json", answer.encode())

    def _place(self) -> str | None:
        """Return the path below the key; ``None`` if the path has another key or none."""
        key, slash, place = self.path.removeprefix("/").partition("/")
        is_own = hmac.compare_digest(key.encode(), self.server.site.key.encode())
        return place if slash and is_own else None

    def _content(self) -> Mapping[str, Any]:
        """Return the JSON object of a request.

        Raises:
            RequestError: The content is no JSON object, or too large.
        """
        length = self.headers.get("Content-Length", "")
        # The number of digits is bounded first, because `int` is slow for very long texts.
        if not length.isdecimal() or len(length) > _DIGITS or int(length) > _LARGEST:
            raise RequestError(f"a request has at most {_LARGEST} bytes, and says how many")
        try:
            content = json.loads(self.rfile.read(int(length)))
        except TimeoutError as error:
            raise RequestError("a request is shorter than it says") from error
        except (ValueError, RecursionError) as error:
            raise RequestError("a request is a JSON object") from error
        if not isinstance(content, dict):
            raise RequestError("a request is a JSON object")
        return content

    def _is_from_here(self) -> bool:
        """Return whether the client addresses this machine by one of its own names.

        A site whose name is made to lead here (DNS rebinding) does not, nor does a page of another
        origin.
        """
        hosts = self.server.site.hosts
        origin = self.headers.get("Origin")
        is_own = origin is None or origin in {f"http://{host}" for host in hosts}
        return is_own and self.headers.get("Host", "").lower() in hosts

    def _send_events(self) -> None:
        feed = self.server.site.feed
        try:
            with feed.page() as cursor:
                self._begin(HTTPStatus.OK, "text/event-stream")
                while not feed.closed:
                    events = b"".join([each.event for each in cursor.take(_SILENCE)])
                    self.wfile.write(events or b": nothing new\n\n")
                self.wfile.write(b"event: closed\ndata: {}\n\n")
        except FullError as error:
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
        except OSError:
            self.close_connection = True  # the client has disconnected, or accepts no data

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self._send_json(status, {"problem": why})

    def _send_json(self, status: HTTPStatus, content: Mapping[str, Any]) -> None:
        text = json.dumps(content).encode()
        self._send(status, "application/json", text)

    def _send(self, status: HTTPStatus, kind: str, content: bytes) -> None:
        self._begin(status, kind, {"Content-Length": str(len(content))})
        self.wfile.write(content)

    def _begin(
        self, status: HTTPStatus, kind: str, headers: Mapping[str, str] | None = None
    ) -> None:
        self.send_response(status)
        fixed = {
            "Content-Type": kind,
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
        }
        for name, value in {**fixed, **(headers or {})}.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *values: object) -> None:
        """Print nothing, because the terminal belongs to the program."""


def _listen(port: int) -> _Http:
    try:
        return _Http(port)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            free = _free_near(port)
            remedy = f"; {free} is free" if free else "; without --live-port a free one is taken"
            raise UsageError(
                f"--live-port {port}: another program listens there{remedy}"
            ) from error
        raise UsageError(f"--live-port {port}: {reason(error)}") from error


def _free_near(port: int) -> int | None:
    """Return the nearest free port."""
    for distance in range(1, _NEAR):
        for candidate in (port + distance, port - distance):
            if 1024 <= candidate <= 65535 and _is_free(candidate):
                return candidate
    return None


def _is_free(port: int) -> bool:
    with socket.socket() as trial:
        # The server binds with this option, too. Without it, ports of recently closed servers seem
        # to be in use.
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HOST, port))
        except OSError:
            return False
    return True
