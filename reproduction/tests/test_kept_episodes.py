"""Kept episodes: not run again, unless the setup has changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl_reproduction.kept_episodes import KeptEpisodes, PlayedEpisode


class Counted:
    """Episode runner that counts its runs."""

    def __init__(self) -> None:
        self.count = 0

    def run(self) -> PlayedEpisode:
        self.count += 1
        head = ("reach", "table", "only", 7, True, ("X", "1"), ("move",))
        result = EpisodeResult(*head, 60, 1.0, 0.25, "nothing", "Done.", guards=("none",))
        return PlayedEpisode(result, done=True, slip=0.002)


def test_episode_is_run_once(tmp_path: Path) -> None:
    file, episodes = tmp_path / "kept.jsonl", Counted()
    first = KeptEpisodes(file).run("this", 7, episodes.run)
    assert KeptEpisodes(file).run("this", 7, episodes.run) == first
    assert episodes.count == 1


def test_episode_of_another_program_or_seed_is_run(tmp_path: Path) -> None:
    kept, episodes = KeptEpisodes(tmp_path / "kept.jsonl"), Counted()
    for what, seed in (("this", 7), ("that", 7), ("this", 8)):
        kept.run(what, seed, episodes.run)
    assert episodes.count == 3


def test_line_that_was_cut_off_does_not_count(tmp_path: Path) -> None:
    file, episodes = tmp_path / "kept.jsonl", Counted()
    KeptEpisodes(file).run("this", 7, episodes.run)
    file.write_text(file.read_text()[:-9])
    KeptEpisodes(file).run("this", 7, episodes.run)
    assert episodes.count == 2
    KeptEpisodes(file).run("this", 7, episodes.run)
    assert episodes.count == 2


@pytest.mark.parametrize("row", ["[1, 2]", "{}", '{"what": "this", "result": 3}', '{"result": {}}'])
def test_row_of_another_kind_is_skipped(tmp_path: Path, row: str) -> None:
    file, episodes = tmp_path / "kept.jsonl", Counted()
    KeptEpisodes(file).run("this", 7, episodes.run)
    file.write_text(f"{row}\n{file.read_text()}")
    KeptEpisodes(file).run("this", 7, episodes.run)
    assert episodes.count == 1
