"""Headless browser controlled over a pipe (the DevTools protocol)."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

#: Chromium is no dependency: tests that need it are skipped where it is not installed.
CHROMIUM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome", "chrome")
     if (found := shutil.which(name))), None,
)  # fmt: skip
_FLAGS = (
    "--headless", "--no-sandbox", "--remote-debugging-pipe", "--disable-background-networking",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run", "--hide-scrollbars",
)  # fmt: skip
_PATIENCE = 20.0


class Page:
    """Open page, with all its errors and all URLs that it requested."""

    def __init__(self, write: int, read: int) -> None:
        self._write, self._read = write, read
        self._rest = b""
        self._number = 0
        self._session: str | None = None
        #: Script that runs before the page's own.
        self.before = ""
        self.errors: list[str] = []
        self.requests: list[str] = []

    def open(
        self,
        file: Path,
        hash_: str = "",
        width: int = 1400,
        height: int = 1500,
        ready: str = "document.getElementById('clock')?.textContent",
    ) -> None:
        """Show a file, and wait until ``ready`` is true, which it is once the page is unpacked."""
        self.visit(f"{file.resolve().as_uri()}{hash_}", width, height, ready)

    def visit(self, url: str, width: int, height: int, ready: str) -> None:
        """Open an address in a new page, and wait until ``ready`` is true."""
        self._session = None
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        session = self.send("Target.attachToTarget", targetId=target, flatten=True)
        self._session = session["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")
        self.send("Page.addScriptToEvaluateOnNewDocument", source=self.before)
        self.size(width, height)
        self.send("Page.navigate", url=url)
        self.wait(ready)

    def size(self, width: int, height: int) -> None:
        """Set the size of the page, px."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)  # fmt: skip

    def wait(self, condition: str, seconds: float = _PATIENCE) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + seconds
        while not self.value(condition):
            assert time.monotonic() < end, f"{condition}; {self.errors}"
            time.sleep(0.05)

    def value(self, expression: str) -> Any:
        """Return the value of an expression in the page."""
        answer = self.send(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        return answer["result"].get("value")

    def text(self, element: str) -> str:
        """Return the text of an element."""
        return str(self.value(f"document.getElementById('{element}').textContent"))

    def press(self, key: str) -> None:
        """Press and release a key."""
        letter = {"text": key} if len(key) == 1 else {}
        self.send("Input.dispatchKeyEvent", type="keyDown", key=key, **letter)
        self.send("Input.dispatchKeyEvent", type="keyUp", key=key)

    def click(self, selector: str, across: float = 0.5) -> None:
        """Click on the first matching element, at a fraction of its width."""
        place = self.value(
            f"(() => {{ const e = document.querySelector('{selector}');"
            "e.scrollIntoView({block: 'center'}); const r = e.getBoundingClientRect();"
            f"return [r.left + {across} * r.width, r.top + r.height / 2]; }})()"
        )
        for kind in ("mousePressed", "mouseReleased"):
            self.send("Input.dispatchMouseEvent", type=kind, x=place[0], y=place[1],
                      button="left", clickCount=1)  # fmt: skip

    def dark(self) -> None:
        """Prefer dark colours."""
        feature = {"name": "prefers-color-scheme", "value": "dark"}
        self.send("Emulation.setEmulatedMedia", features=[feature])

    def picture(self) -> bytes:
        """Return a screenshot as PNG."""
        return base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])

    def send(self, method: str, **parameters: Any) -> Any:
        """Send a command and return its answer, noting other events meanwhile."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _receive(self) -> Any:
        while b"\0" not in self._rest:
            more = os.read(self._read, 1 << 20)
            assert more, "the browser has ended"
            self._rest += more
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def _note(self, event: Any) -> None:
        parameters = event.get("params", {})
        match event.get("method"):
            case "Runtime.exceptionThrown":
                self.errors.append(str(parameters["exceptionDetails"]))
            case "Runtime.consoleAPICalled" if parameters["type"] in ("error", "assert"):
                self.errors.append(str(parameters["args"]))
            case "Log.entryAdded" if parameters["entry"]["level"] == "error":
                self.errors.append(str(parameters["entry"]))
            case "Network.requestWillBeSent":
                self.requests.append(parameters["request"]["url"])


@contextmanager
def browser() -> Iterator[Page]:
    """Run a browser, and end it at exit."""
    assert CHROMIUM is not None
    (read_in, write_in), (read_out, write_out) = os.pipe(), os.pipe()

    def hand_over() -> None:
        # The browser reads from descriptor 3 and writes to 4; they must not overwrite each other.
        first, second = os.dup(read_in), os.dup(write_out)
        os.dup2(first, 3)
        os.dup2(second, 4)

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [CHROMIUM, *_FLAGS, f"--user-data-dir={profile}"],
            preexec_fn=hand_over,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(read_in)
        os.close(write_out)
        try:
            page = Page(write_in, read_out)
            yield page
            page._session = None
            page.send("Browser.close")
            process.wait(10)
        finally:
            process.kill()
            process.wait()
            os.close(write_in)
            os.close(read_out)
