"""Live page in a real browser: it follows a run, pauses it, and contacts no other server.

Needs Chromium, which is no dependency: without it these tests are skipped.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.edit import EditTaken
from cbdsl.reporting.live.breakpoints import Breakpoints
from cbdsl.reporting.live.composed_program import Changes, ComposedProgram, composed_program
from cbdsl.reporting.live.feed import Feed, message
from cbdsl.reporting.live.live_page import live_page
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.page_server import LiveServer
from cbdsl.reporting.live.requests import Requests
from cbdsl.reporting.live.transport import Transport
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.program_composer import Composer
from tests.conftest import ROOT
from tests.reporting.browser import CHROMIUM, Page, browser
from tests.reporting.conftest import Shown
from tests.reporting.live.conftest import Watched

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]

NOW = "Number(document.body.dataset.time)"
LEVELS = "[...document.querySelectorAll('#levels tbody tr')].map(r => r.dataset.name)"
READY = "document.body.dataset.time"


class Run:
    """Run in a separate thread that starts paused, with its server."""

    def __init__(self, watched: Watched, robot: RobotDocument, urdf: Path) -> None:
        self.feed, self.transport = Feed(), Transport(math.inf)
        self.period = 1 / robot.control.rate
        self.composer = Composer()
        breakpoints = Breakpoints()
        self.view = LiveView(self.feed, self.transport, Shown, self.composer, breakpoints)

        def save(changes: Changes, name: str) -> ComposedProgram:
            file = ROOT / "programs" / "reachtouch.yaml"
            return composed_program(file, "table_right", {}, changes, name)

        self.server = LiveServer(
            self.feed,
            lambda token: live_page("reachtouch", robot, urdf, token, composes=True),
            Requests(self.transport, self.composer, save, breakpoints),
        )
        self.results: list[EpisodeResult] = []
        self.transport.pause()
        self._thread = Thread(target=lambda: self.results.append(watched(self.view)))
        self._thread.start()

    def step(self, ticks: int, shown: Page) -> None:
        """Advance by ticks, and wait until the page shows the last one and rests."""
        last = self.transport.ask(self._time) + ticks * self.period
        self.transport.step(ticks)
        shown.wait(f"{NOW} > {last - self.period / 2}")

    def _time(self) -> float:
        assert self.view._last is not None
        return self.view._last.observation.time

    def close(self) -> None:
        if self.composer.stack is not None:  # whose episode has no end
            self.transport.ask(lambda: self.composer.compose(None))
        self.transport.hasten(math.inf)
        self.transport.release()
        self._thread.join()
        self.server.close()


@pytest.fixture
def run(watched: Watched, dexter: RobotDocument, urdf: Path) -> Iterator[Run]:
    made = Run(watched, dexter, urdf)
    yield made
    made.close()


@pytest.fixture
def shown(run: Run) -> Iterator[Page]:
    with browser() as opened:
        opened.visit(run.server.url, 1400, 1300, READY)
        yield opened
        opened.wait("true")
        assert opened.errors == []
        assert {url.split("/")[2] for url in opened.requests if url.startswith("http")} == {
            run.server.url.split("/")[2]
        }


def test_live_page_follows_a_run_from_pause_to_end(
    run: Run, shown: Page, kinematics: Kinematics
) -> None:
    shown.wait("document.getElementById('pause').textContent.includes('Go on')")
    began = shown.value(NOW)
    shown.press("s")
    shown.wait(f"{NOW} > {began}")
    assert shown.value(NOW) == pytest.approx(began + 0.02, abs=0.02)
    first = shown.value("linkAt('right_palm')")
    assert "running" in shown.text("verdict")
    shown.click("#pause")
    shown.wait("document.getElementById('ending').textContent")
    result = run.results[0]
    assert shown.text("ending") == result.ending
    shown.wait(f"{NOW} >= {result.sim_seconds - 0.001}")
    assert shown.value("document.querySelectorAll('#transitions li').length") >= len(result.actions)
    assert "touch 1" in shown.text("state")
    last = shown.value("linkAt('right_palm')")
    assert np.linalg.norm(np.subtract(last, first)) > 0.1, "the robot moves on the page, too"
    assert shown.text("problem") == ""


def test_stack_is_in_the_order_of_priority(run: Run, shown: Page) -> None:
    run.step(60, shown)
    shown.wait(f"{LEVELS}.includes('approach')")
    names = shown.value(LEVELS)
    assert names.index("approach") < names.index("orient") < names.index("posture")


def test_when_the_server_ends_the_page_says_so(run: Run, shown: Page) -> None:
    run.close()
    shown.wait("document.getElementById('link').textContent.includes('over')")


def test_stack_is_composed_a_target_dragged_and_both_saved(run: Run, shown: Page) -> None:
    run.step(160, shown)
    shown.wait(f"{LEVELS}.includes('approach')")
    shown.click("#take-over")
    shown.wait("document.querySelectorAll('#composed li').length > 1")
    stack = run.composer.stack
    assert stack is not None and "approach" in stack and "home" not in stack
    shown.value(f"{button('approach')}.querySelector('[title$=away]').click()")
    shown.wait(f"!{button('approach')}")
    select(shown, "add", "approach")
    shown.wait(f"{button('approach')} === document.querySelector('#composed li')")
    assert run.composer.stack == ("approach", *(each for each in stack if each != "approach"))
    shown.value("document.querySelector('tr[data-name=approach] input').value = 3.5")
    shown.value(
        "document.querySelector('tr[data-name=approach] input').dispatchEvent(new Event('change'))"
    )
    shown.wait("document.querySelector('tr[data-name=approach] input').value === '3.5'")
    run.step(1, shown)
    shown.wait("targets.placeOfTarget('approach')[0] > 0")
    left, top = shown.value(
        "(() => { scrollTo(0, 0);"
        "const b = document.getElementById('view').getBoundingClientRect();"
        "const [x, y] = targets.placeOfTarget('approach'); return [b.left + x, b.top + y]; })()"
    )
    mouse(shown, "mousePressed", left, top)
    for step in range(1, 6):
        mouse(shown, "mouseMoved", left - 10 * step, top - 12 * step)
    mouse(shown, "mouseReleased", left - 50, top - 60)
    shown.wait("document.getElementById('held').textContent.includes('approach')")
    # The last mouse events may still be on their way.
    before = None
    while before != (target := tuple(run.composer.targets["approach"])):
        before = target
        time.sleep(0.5)
    height = target[2]
    assert height > -0.3, "dragged upwards from the ball on the table"
    shown.click("#save button")
    shown.wait("document.getElementById('save-text').textContent")
    text = shown.text("save-text")
    wanted = ", ".join(f"{value:.4f} m" for value in target)
    assert f"reference: [{wanted}]" in text and "gain: 3.5 /s" in text
    assert shown.text("problem") == ""


def button(name: str) -> str:
    """Return an expression for the line of a controller in the composed stack."""
    return (
        "[...document.querySelectorAll('#composed li')]"
        f".find(e => e.firstChild.textContent === '{name}')"
    )


def select(shown: Page, element: str, value: str) -> None:
    """Choose an option, as a person would."""
    shown.value(
        f"(() => {{ const e = document.getElementById('{element}'); e.value = '{value}';"
        "e.dispatchEvent(new Event('change')); })()"
    )


def mouse(shown: Page, kind: str, x: float, y: float) -> None:
    shown.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1,
               clickCount=1)  # fmt: skip


def test_page_shows_an_edit_with_its_findings_and_the_running_step(run: Run, shown: Page) -> None:
    run.step(3, shown)
    assert shown.text("step-now").startswith("searchtrack")
    lit = "[...document.querySelectorAll('#running .now')].map(e => e.dataset.node)"
    assert shown.value(lit)[0] == "searchtrack"
    assert "searchtrack running" in shown.text("running")
    finding = "own.yaml:3:1: CB201 unknown key 'stpes'"
    report = {"text": "the edit has 1 error", "findings": [finding]}
    run.transport.ask(lambda: run.view.keep(message("watch", report)))
    shown.wait("document.getElementById('findings').children.length === 1")
    assert shown.text("edit-text") == report["text"]
    assert shown.text("findings") == finding

    def edit() -> None:
        assert run.view._last is not None
        program = run.view._last.run.program
        run.view.note_edit(EditTaken(program, program.name, 0, 1.0, "its exits decide"))

    run.transport.ask(edit)
    run.step(3, shown)
    shown.wait("document.querySelector('#transitions .edit') !== null")
    assert "takes up the edited reachtouch" in shown.text("transitions")


def test_page_pauses_at_a_breakpoint_and_shows_earlier_states(run: Run, shown: Page) -> None:
    place = "searchtrack -> reach ◁ touch"
    boxes = "[...document.querySelectorAll('#places input')]"
    shown.value(f"{boxes}.find((each) => each.ariaLabel === '{place}').click()")
    shown.wait("document.getElementById('breaks-title').textContent === 'Breakpoints (1)'")
    shown.press(" ")
    shown.wait(f"document.getElementById('met').textContent === 'paused at {place}'")
    assert shown.text("step-now") == "reach ◁ touch"
    now = shown.value(NOW)
    slide = "const s = document.getElementById('past'); s.value = 0;"
    shown.value(f"(() => {{ {slide} s.dispatchEvent(new Event('input')); }})()")
    assert shown.value(NOW) < now
    assert shown.text("past-time").endswith("earlier")
    shown.click("#to-now")
    assert shown.value(NOW) == now
    run.transport.ask(lambda: None)
    assert run.transport.paused
