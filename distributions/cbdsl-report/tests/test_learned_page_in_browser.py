"""Page of learned policies in a real browser: it renders, obeys keys, and loads nothing.

Needs Chromium, which is no dependency: without it these tests are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from cbdsl_report.learned_files import Learned, read_learned
from cbdsl_report.learned_page import learned_page
from tests.reporting.browser import CHROMIUM, Page, browser
from tests.reporting.trials import write_trial

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]

READY = "document.getElementById('ready')?.dataset.done"
DARK = "rgb(21, 24, 28)"


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> list[Learned]:
    """Write two trial groups: three trials of one, one of the other."""
    folder = tmp_path_factory.mktemp("knowledge")
    files = [write_trial(folder, f"walked_{seed}", seed) for seed in range(3)]
    files.append(write_trial(folder, "other", alpha=0.5))
    return [read_learned(file) for file in files]


@pytest.fixture(scope="module")
def file(learned: list[Learned], tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_text(learned_page(learned, 0.2), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def shown(file: Path) -> Iterator[Page]:
    with browser() as opened:
        opened.open(file, ready=READY)
        yield opened


@pytest.fixture(autouse=True)
def sound(shown: Page) -> Iterator[None]:
    """Check after each test that the page has no errors and requested nothing."""
    yield
    assert shown.errors == []
    assert shown.text("problem") == ""
    assert [url for url in shown.requests if not url.startswith(("file:", "data:"))] == []


def legend(shown: Page) -> dict[str, str]:
    """Return the visible legend of the first chart, by label."""
    rows = shown.value(
        "[...document.querySelector('.chart').querySelectorAll('.u-series')]"
        ".filter((row) => row.offsetParent)"
        ".map((row) => ['.u-label', '.u-value'].map((part) => row.querySelector(part).textContent))"
    )
    return dict(rows)


def test_curves_of_all_groups_are_drawn(shown: Page, learned: list[Learned]) -> None:
    shown.wait("document.querySelector('.u-value').textContent === '20'")
    assert list(legend(shown)) == ["episode", "walked", "other"]
    # Several trials have an interval, a single one has none.
    assert "[" in legend(shown)["walked"] and "[" not in legend(shown)["other"]
    shown.value("scrollTo(0, 0)")
    picture = cv2.imdecode(np.frombuffer(shown.picture(), np.uint8), cv2.IMREAD_COLOR)
    for blue, green, red in ((178, 114, 0), (0, 94, 213)):
        near = np.abs(picture.astype(int) - (blue, green, red)).max(axis=-1) < 12
        assert near.sum() > 300


def test_keys_report_the_values_of_each_episode(shown: Page, learned: list[Learned]) -> None:
    shown.value("document.querySelector('.plot').focus()")
    rates = [each.reward / len(each.transitions) for each in learned[3].experiences]
    for key, place in (("Home", 0), ("ArrowRight", 1), ("ArrowRight", 2), ("End", 19),
                       ("ArrowLeft", 18)):  # fmt: skip
        shown.press(key)
        shown.wait(f"document.querySelector('.u-value').textContent === '{place + 1}'")
        own = rates[max(0, place - 9) : place + 1]
        assert float(legend(shown)["other"]) == pytest.approx(sum(own) / len(own), abs=6e-4)


def test_how_far_curves_are_smoothed_can_be_chosen(shown: Page) -> None:
    numbers = "document.querySelector('#numbers tbody').textContent"
    before = shown.value(numbers)
    shown.value(
        "(() => { const s = document.getElementById('window'); s.value = '1';"
        "s.dispatchEvent(new Event('change')); })()"
    )
    assert shown.value(numbers) != before
    assert "Each episode" in shown.value("document.querySelector('#numbers caption').textContent")


def test_selected_trial_is_shown_alone_and_has_an_address(
    shown: Page, learned: list[Learned]
) -> None:
    visible = "[...document.querySelectorAll('.trial')].filter((e) => e.offsetParent)"
    names = f"{visible}.map((e) => e.querySelector('h2').textContent).join()"
    assert shown.value(names) == learned[0].policy.name
    shown.value(
        "(() => { const s = document.getElementById('trial'); s.selectedIndex = 3;"
        "s.dispatchEvent(new Event('change')); })()"
    )
    assert shown.value(names) == "other"
    assert shown.value("location.hash") == "#trial-3"


def test_episodes_are_listed_once_their_section_opens(shown: Page, learned: list[Learned]) -> None:
    rows = "document.querySelector('#trial-0 .episodes tbody')?.rows"
    assert not shown.value(f"{rows}?.length")
    shown.value("document.querySelector('#trial-0 .episodes').open = true")
    shown.wait(f"{rows}?.length === {len(learned[0].experiences)}")
    cells = shown.value(f"[...{rows}].map((row) => [...row.cells].map((c) => c.textContent))")
    contexts = learned[0].curve.context
    for told, context, episode in zip(cells, contexts, learned[0].experiences, strict=True):
        assert (told[1], told[3]) == (context, str(episode.seed))
        assert (told[4], told[5]) == (str(episode.reward), str(len(episode.transitions)))


def test_text_can_be_read_in_light_and_in_dark(shown: Page) -> None:
    def contrast() -> float:
        """Return the lowest contrast of texts in drawings and tables against the page."""
        colors = shown.value(
            "[...document.querySelectorAll('.policy text, .density text, td, th, figcaption')]"
            ".map((e) => getComputedStyle(e)[e.tagName === 'text' ? 'fill' : 'color'])"
        )
        paper = shown.value("getComputedStyle(document.body).backgroundColor")
        return min(ratio(color, paper) for color in set(colors))

    assert contrast() > 4.5
    shown.dark()
    shown.wait(f"getComputedStyle(document.body).backgroundColor === '{DARK}'")
    assert contrast() > 4.5


def ratio(one: str, other: str) -> float:
    """Return the contrast of two colours (WCAG 2)."""

    def luminance(color: str) -> float:
        parts = [int(part) / 255 for part in color.strip("rgb()").split(", ")]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return sum(w * part for w, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("width", [360, 768, 1400])
def test_page_is_as_wide_as_the_window(shown: Page, width: int) -> None:
    shown.size(width, 900)
    shown.wait(f"innerWidth === {width}")
    shown.wait("document.documentElement.scrollWidth <= innerWidth")
    shown.wait(
        "[...document.querySelectorAll('.u-wrap')].every((e) => e.clientWidth <= innerWidth)"
    )
