"""``--watch``: edits of files are checked, offered once, and reported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cbdsl.api.load import load
from cbdsl.api.requests.run_request import RunRequest
from cbdsl.cli.episodes.program_watch import ProgramWatch
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.edit import EditTaken
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.tick import Tick
from tests.cli.arm_program import TEXT
from tests.cli.test_main import cb


class Watched:
    """Watch of a copy of a program, with its offers and reports."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "raise_arm.yaml"
        self.file.write_text(TEXT, "utf-8")
        self.offers: list[CheckedProgram] = []
        self.reports: list[tuple[str, tuple[str, ...]]] = []
        self.time = 0.0
        self.request = self.read()
        self.watch = ProgramWatch(
            self.request, self.read, self.offers.append, self.tell, clock=lambda: self.time
        )

    def read(self) -> RunRequest:
        return load(str(self.file))

    def tell(self, text: str, findings: tuple[str, ...] = ()) -> None:
        self.reports.append((text, tuple(findings)))

    def edit(self, old: str, new: str) -> None:
        """Edit the file, and look twice: a file counts once it stays the same."""
        text = self.file.read_text("utf-8")
        assert old in text
        self.file.write_text(text.replace(old, new), "utf-8")
        self.look()
        self.look()

    def look(self) -> None:
        self.time += 1.0
        self.watch.look()


@pytest.fixture
def watched(tmp_path: Path) -> Watched:
    return Watched(tmp_path)


def test_watch_offers_an_edit_once(watched: Watched) -> None:
    watched.look()
    assert watched.offers == []
    watched.edit("gain: 20 /s", "gain: 10 /s")
    watched.look()
    assert watched.offers == [watched.read().program]
    assert watched.reports == [("the edit waits for the next change of state", ())]
    assert watched.watch.is_pending


def test_watch_between_episodes_reports_an_edit_once_it_is_active(watched: Watched) -> None:
    watched.watch.note_end(EpisodeResult("", "", "", 0, False, (), (), 0, 1.0, 1.0, "", ""))
    watched.edit("gain: 20 /s", "gain: 10 /s")
    assert watched.reports == [], "no state can change"
    (program,) = watched.offers
    watched.watch.note_edit(
        EditTaken(program, "raise_arm", 0, 9.0, "it begins with its first step")
    )
    text = "takes up the edited raise_arm: it begins with its first step"
    assert watched.reports == [(text, ())], "9.0 s is the time of the last episode"
    assert not watched.watch.is_pending


def test_watch_reports_an_edit_that_does_not_check_and_offers_its_correction(
    watched: Watched,
) -> None:
    watched.edit("controllers:", "controlers:")
    ((text, findings),) = watched.reports
    assert text == "the edit has 1 error; the program stays"
    assert "controlers" in findings[0]
    assert watched.offers == []
    watched.edit("controlers:", "controllers:")
    assert watched.reports[-1][0] == "the edit checks, and changes nothing that runs"
    watched.file.unlink()
    watched.look()
    watched.look()
    assert watched.reports[-1][0].startswith("the edit ")
    assert watched.offers == []


def test_watch_ignores_comments_and_a_file_that_is_being_written(watched: Watched) -> None:
    watched.edit("controllers:", "# a comment\ncontrollers:")
    text = watched.file.read_text("utf-8")
    for end in range(0, len(text), len(text) // 5):
        watched.file.write_text(text[:end], "utf-8")
        watched.look()
    watched.file.write_text(text, "utf-8")
    watched.look()
    assert not watched.offers
    assert not watched.reports


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--record", "out"), "a recording holds one program"),
        (("--page", "out.html"), "a recording holds one program"),
        (("--schema", "any"), "--watch takes up no edits under a schema"),
    ],
)
def test_run_refuses_outputs_that_an_edit_would_break(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    message: str,
) -> None:
    assert cb(monkeypatch, "run", "posture", "--watch", *words) == 2
    assert message in capsys.readouterr().err


def test_run_takes_up_an_edit_and_prints_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    watched = Watched(tmp_path)
    ticks: list[int] = []
    look: Callable[[ProgramWatch], None] = ProgramWatch.look

    def note_tick(watch: ProgramWatch, _: Tick) -> None:
        ticks.append(len(ticks))
        if len(ticks) == 3:
            text = watched.file.read_text("utf-8")
            watched.file.write_text(text.replace("gain: 20 /s", "gain: 10 /s"), "utf-8")
        watch._looked = -1.0
        look(watch)

    monkeypatch.setattr(ProgramWatch, "note_tick", note_tick)
    words = ("--watch", "--backend", "kinematic", "--seed", "25", "--json")
    assert cb(monkeypatch, "run", str(watched.file), *words) == 0
    printed = capsys.readouterr()
    assert len(printed.out.splitlines()) == 1, "the standard output is for scripts"
    assert "the edit waits for the next change of state" in printed.err
    assert "takes up the edited raise_arm" in printed.err
