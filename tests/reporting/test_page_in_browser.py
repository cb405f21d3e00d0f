"""Page in a real browser: it renders, plays, obeys the keyboard, and loads nothing.

Needs Chromium, which is no dependency: without it these tests are skipped.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import Recorded, read_recording
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.recording import Recording
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT
from tests.reporting.browser import CHROMIUM, Page, browser
from tests.runtime.synthetic import SyntheticBackend

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")

NOW = "Number(document.getElementById('scrub').value)"


@pytest.fixture(scope="module")
def file(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("page") / "episode.html"
    file.write_text(page(recorded), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def shown(file: Path) -> Iterator[Page]:
    """Open the page of a rewarded reachtouch."""
    with browser() as opened:
        opened.open(file, "#t=1")
        yield opened


@pytest.fixture(autouse=True)
def sound(shown: Page) -> Iterator[None]:
    """Check after each test that the page has no errors and requested nothing."""
    go_to(shown, 1.0)
    yield
    assert shown.errors == []
    assert shown.text("problem") == ""
    assert [url for url in shown.requests if not url.startswith(("file:", "blob:"))] == []


def go_to(shown: Page, time: float) -> None:
    """Move the slider, as a mouse would."""
    shown.value(
        f"(() => {{ const s = document.getElementById('scrub'); s.value = {time};"
        "s.dispatchEvent(new Event('input')); })()"
    )


def pixels(shown: Page, element: str) -> np.ndarray:
    """Return the visible pixels of an element."""
    box = shown.value(
        f"(() => {{ scrollTo(0, 0); const r = document.querySelector('{element}')"
        ".getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; })()"
    )
    left, top, right, bottom = (round(side) for side in box)
    image = cv2.imdecode(np.frombuffer(shown.picture(), np.uint8), cv2.IMREAD_COLOR)
    return image[top:bottom, left:right].astype(int)


def test_page_opens_at_the_time_in_its_address(shown: Page) -> None:
    assert shown.text("clock").startswith("1.00 / ")
    assert shown.text("program") == "reachtouch"


def test_page_states_the_ending_of_the_episode(shown: Page, recorded: Recorded) -> None:
    assert shown.text("ending") == recorded.summary["result"]["ending"]
    assert shown.text("verdict") == "rewarded"


def test_robot_and_the_ball_are_to_be_seen_and_move(shown: Page) -> None:
    before = pixels(shown, "#view")
    colors = np.unique((before // 8).reshape(-1, 3), axis=0)
    assert len(colors) > 50
    blue, green, red = np.moveaxis(before, -1, 0)
    assert ((red > 120) & (green < 60) & (blue < 60)).sum() > 100  # the ball
    shown.press("End")
    assert (np.abs(pixels(shown, "#view") - before).max(axis=-1) > 30).mean() > 0.005


def test_drawn_links_agree_with_the_kinematics(
    shown: Page, recorded: Recorded, dexter: RobotDocument, urdf: Path
) -> None:
    kinematics = Kinematics(dexter, urdf)
    tips = [cell.link for cells in dexter.load_cells.values() for cell in cells.values()]
    for tick in (0, 60, len(recorded.arrays["time"]) - 1):
        time = recorded.arrays["time"][tick]
        go_to(shown, time + 1e-6)
        kinematics.update(recorded.arrays["positions"][tick])
        for link in [*tips, *(camera.link for camera in dexter.cameras.values())]:
            found = shown.value(f"linkAt('{link}')")
            assert found == pytest.approx(kinematics.frame(link).position, abs=1e-5)


def test_space_plays_and_pauses(shown: Page) -> None:
    shown.press(" ")
    shown.wait(f"{NOW} > 1.1")
    assert "Pause" in shown.text("play")
    shown.press(" ")
    stopped = shown.value(NOW)
    assert "Play" in shown.text("play")
    shown.value("new Promise((done) => setTimeout(done, 200))")
    assert shown.value(NOW) == stopped


def test_playback_stops_at_the_end_and_restarts(shown: Page, recorded: Recorded) -> None:
    last = float(recorded.arrays["time"][-1])
    shown.value("document.getElementById('speed').value = '10'")
    shown.click("#play")
    shown.wait(f"{NOW} >= {last} - 1e-3")
    shown.wait("document.getElementById('play').textContent.includes('Play')")
    shown.click("#play")
    shown.wait(f"{NOW} < {last / 2}")
    shown.click("#play")
    shown.value("document.getElementById('speed').value = '1'")


def test_current_step_is_lit_with_the_values_of_its_exits(shown: Page, recorded: Recorded) -> None:
    made = [each for each in recorded.summary["transitions"] if not each["depth"]]
    last = made[-1]
    go_to(shown, last["time"] - 0.02)
    lit = "[...document.querySelectorAll('#running .now')].map(e => e.dataset.node)"
    assert shown.value(lit) == [last["action"]]
    assert f"reachtouch \u203a {last['action']}" in shown.text("running")
    chips = "[...document.querySelectorAll('#running .letter')].map(e => e.textContent)"
    told = " ".join(shown.value(chips))
    assert re.search(r"touch moving \d\S* N", told) and "reach at rest" in told
    shown.press("End")
    assert shown.value(lit) == []


def test_transitions_are_listed_in_words_and_the_last_one_is_marked(
    shown: Page, recorded: Recorded
) -> None:
    made = recorded.summary["transitions"]
    go_to(shown, made[-1]["time"])
    items = shown.value("[...document.querySelectorAll('#transitions li')].map(e => e.textContent)")
    assert len(items) == len(made)
    assert items[-1].endswith("reach ◁ touch -> the end, since touch is at rest  ★ 1")
    marked = "document.querySelector('#transitions .now').textContent"
    assert shown.value(marked) == items[-1]


def test_page_of_a_recording_without_automata_shows_letters_alone(
    recorded: Recorded, tmp_path: Path
) -> None:
    summary = {key: own for key, own in recorded.summary.items() if key != "automata"}
    file = tmp_path / "old.html"
    file.write_text(page(replace(recorded, summary=summary)), encoding="utf-8")
    with browser() as opened:
        opened.open(file, "#t=1")
        assert opened.errors == [] and opened.text("problem") == ""
        assert opened.text("running") == ""
        assert "searchtrack" in opened.text("transitions")


def test_keys_step_and_go_to_transitions(shown: Page, recorded: Recorded) -> None:
    shown.press("ArrowRight")
    assert shown.value(NOW) == pytest.approx(1 + 1 / 60)
    shown.press("ArrowLeft")
    assert shown.value(NOW) == pytest.approx(1)
    times = sorted({each["time"] for each in recorded.summary["transitions"]})
    shown.press("n")
    assert shown.value(NOW) == pytest.approx(next(time for time in times if time > 1))
    shown.press("Home")
    assert shown.value(NOW) == 0
    shown.press("End")
    shown.press("p")
    assert shown.value(NOW) == pytest.approx(times[-1] if times[-1] < recorded.arrays["time"][-1]
                                             else times[-2])  # fmt: skip


def test_click_on_a_time_line_goes_there(shown: Page, recorded: Recorded) -> None:
    last = float(recorded.arrays["time"][-1])
    for line in (".row .track", ".u-over"):
        shown.click(line, across=0.25)
        assert shown.value(NOW) == pytest.approx(0.25 * 1.02 * last, abs=0.01 * last)
        cursor, left, width = shown.value(
            f"(() => {{ const r = document.querySelector('{line}').getBoundingClientRect();"
            "const c = document.getElementById('cursor').getBoundingClientRect();"
            "return [c.left + 1, r.left, r.width]; })()"
        )
        assert (cursor - left) / width == pytest.approx(0.25, abs=0.01)


def test_zoom_applies_to_all_charts_and_can_be_reset(shown: Page) -> None:
    whole = [pixels(shown, chart) for chart in (".chart canvas", ".chart + .chart canvas")]
    widths = "[...document.querySelectorAll('.row b')].map((e) => e.style.width).join()"
    before = shown.value(widths)
    shown.press("+")
    assert shown.value(widths) != before
    for chart, image in zip((".chart canvas", ".chart + .chart canvas"), whole, strict=True):
        assert (pixels(shown, chart) != image).any()
    shown.press("-")
    shown.press("-")
    assert shown.value(widths) == before
    for chart, image in zip((".chart canvas", ".chart + .chart canvas"), whole, strict=True):
        assert (pixels(shown, chart) == image).all()


def test_time_at_the_right_edge_of_a_chart_has_room(shown: Page) -> None:
    rim = shown.value(
        "document.querySelector('.uplot').getBoundingClientRect().right"
        " - document.querySelector('.u-over').getBoundingClientRect().right"
    )
    longest = shown.value(
        "(() => { const c = document.createElement('canvas').getContext('2d');"
        "c.font = '12px system-ui'; return c.measureText('88.88 s').width; })()"
    )
    assert rim >= longest / 2


def test_rows_name_every_letter_of_the_state(shown: Page, recorded: Recorded) -> None:
    names = shown.value("[...document.querySelectorAll('.row > span')].map((e) => e.textContent)")
    members = recorded.summary["members"]
    assert names == [name for program, own in members.items() for name in (program, *own)]
    last = shown.value("[...document.querySelectorAll('.row.member .track')].slice(0, 3)"
                       ".map((e) => e.lastChild.textContent).join('')")  # fmt: skip
    assert last == recorded.summary["result"]["predicates"][-1]


def test_table_is_the_stack(shown: Page, recorded: Recorded) -> None:
    shown.press("End")
    names = shown.value("[...document.querySelectorAll('#levels tbody tr')]"
                        ".map((row) => row.cells[0].textContent)")  # fmt: skip
    priority = recorded.arrays["level_priority"][-1]
    order = [index for index in np.argsort(priority) if priority[index] >= 0]
    assert names == [recorded.controllers[index] for index in order] and len(names) > 3


def test_cameras_show_the_image_of_the_time(shown: Page, recorded: Recorded) -> None:
    seen = pixels(shown, "#cameras canvas")
    assert ((seen[..., 2] > 180) & (seen[..., 1] < 60)).sum() > 20
    size = shown.value("(() => { const c = document.querySelector('#cameras canvas');"
                       "return [c.height, c.width]; })()")  # fmt: skip
    assert tuple(size) == recorded.arrays["image_left"].shape[1:3]


def test_potentials_have_two_scales(shown: Page) -> None:
    before = pixels(shown, ".chart canvas")
    shown.value("(() => { const s = document.querySelector('.chart select');"
                "s.selectedIndex = 1; s.dispatchEvent(new Event('change')); })()")  # fmt: skip
    assert (pixels(shown, ".chart canvas") != before).any()


def test_page_is_dark_with_a_dark_preference(shown: Page) -> None:
    light = pixels(shown, "header").mean()
    shown.dark()
    shown.wait("getComputedStyle(document.body).backgroundColor === 'rgb(21, 24, 28)'")
    assert pixels(shown, "header").mean() < light - 100


def test_page_without_webgl_shows_all_other_parts(file: Path) -> None:
    with browser() as opened:
        opened.before = (
            "const own = HTMLCanvasElement.prototype.getContext;"
            "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
            "return kind.startsWith('webgl') ? null : own.call(this, kind, ...more); };"
        )
        opened.open(file, "#t=1")
        assert "WebGL" in opened.text("problem")
        opened.press("ArrowRight")
        assert opened.value(NOW) == pytest.approx(1 + 1 / 60)
        assert opened.value("document.querySelectorAll('#levels tbody tr').length") > 0


def test_page_of_a_robot_without_cameras_and_hands_has_no_errors(tmp_path: Path) -> None:
    library = Library(ROOT)
    robot = library.read(library.locate(RobotDocument, "sixaxis"), RobotDocument).document
    urdf = ROOT / "robots" / robot.model
    program = check_program("poise", {"robot": "sixaxis"}, library)
    made = {"cbdsl": 1, "kind": "stage", "name": "bare", "robot": "sixaxis"}
    stage = StageDocument.model_validate({**made, "contexts": {"only": {}}})
    recording = Recording(program, robot, urdf)
    runner = Runner(robot, Kinematics(robot, urdf), program, SyntheticBackend(robot, urdf))
    result = runner.run(stage, 0, observer=recording)
    recorded = read_recording(recording.write(tmp_path, result))
    file = tmp_path / "bare.html"
    file.write_text(page(recorded), encoding="utf-8")
    with browser() as opened:
        opened.open(file)
        opened.press("End")
        assert opened.text("program") == "poise"
        assert opened.errors == [] and opened.text("problem") == ""
        assert opened.value("document.querySelectorAll('#cameras canvas').length") == 0
        assert opened.value("document.querySelectorAll('.chart').length") == 2


@pytest.mark.parametrize(
    ("share", "text"),
    [
        ("NaN", "\u2013"),
        ("-262545361338368", "< \u221299"),
        ("1e9", "> 99"),
        ("0.5", "0.50"),
        ("-0.001", "0.00"),
    ],
)
def test_share_text_of_any_share_fits_its_column(shown: Page, share: str, text: str) -> None:
    assert shown.value(f"shareText({share})") == text


def test_bar_of_a_level_that_requests_nothing_is_empty(shown: Page) -> None:
    shown.press("Home")
    rows = shown.value(
        "Array.from(byId('levels').tBodies[0].rows, (row) => ["
        " row.cells[4].textContent, row.cells[4].querySelector('i').style.width])"
    )
    widths = {text == "\u2013": {w for t, w in rows if t == text} for text, _ in rows}
    assert widths[True] == {"0%"} and widths[False] != {"0%"}


@pytest.mark.parametrize("width", [900, 1024, 1280, 1600])
def test_every_column_of_the_stack_is_in_view_with_long_names(shown: Page, width: int) -> None:
    shown.size(width, 800)
    fits = shown.value(
        "(() => { for (const row of byId('levels').tBodies[0].rows) {"
        "  row.cells[0].textContent = 'searchtrack_of_both_hands.orientation_of_the_left_palm';"
        "  row.cells[4].lastChild.textContent = shareText(-262545361338368);"
        "  row.cells[6].textContent = 'searchtrack_of_both_hands.approach'; }"
        " const aside = document.querySelector('aside');"
        " const rows = byId('levels').tBodies[0].rows.length;"
        " return [rows, aside.scrollWidth - aside.clientWidth]; })()"
    )
    shown.size(1280, 800)
    assert fits[0] > 0 and fits[1] <= 1


def test_every_column_has_a_name_of_more_than_a_letter() -> None:
    for file in (ROOT / "cbdsl" / "reporting" / "assets").glob("*.html"):
        names = re.findall(r"<th[^>]*>([^<]*)</th>", file.read_text("utf-8"))
        assert all(len(name) > 1 or name == "φ" for name in names), file.name
