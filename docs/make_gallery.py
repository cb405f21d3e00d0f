"""Make the replays of the gallery.

Run ``python docs/make_gallery.py`` before the site is built for readers. It records each run and
writes its replay to docs/gallery/, which is not under version control. An existing replay is kept.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "gallery"


class Exhibit(NamedTuple):
    """Replay of the gallery.

    Attributes:
        name: File name of the replay, without suffix.
        arguments: Arguments of ``cb run``.
    """

    name: str
    arguments: tuple[str, ...]


EXHIBITS = (
    Exhibit("reachtouch", ("reachtouch",)),
    Exhibit("bimanualtouch", ("bimanualtouch",)),
    Exhibit("pick_and_place", ("pick_and_place", "--policy", "pick_and_place")),
    Exhibit("handover", ("handover",)),
    Exhibit("press_and_slide", ("press_and_slide",)),
    Exhibit("hover_follow", ("hover_follow",)),
    Exhibit("find_the_other", ("find_the_other",)),
    Exhibit("pick", ("pick", "--robot", "panda")),
)
#: Options of every run.
OPTIONS = ("--backend", "mujoco", "--seed", "1")


def main() -> None:
    """Make the replays that do not exist."""
    FOLDER.mkdir(exist_ok=True)
    for exhibit in EXHIBITS:
        page = FOLDER / f"{exhibit.name}.html"
        if not page.exists():
            make_replay(exhibit, page)


def make_replay(exhibit: Exhibit, page: Path) -> None:
    """Record a run and write its replay.

    Args:
        exhibit: Run to record.
        page: File of the replay.
    """
    with tempfile.TemporaryDirectory() as folder:
        _cb("run", *exhibit.arguments, *OPTIONS, "--record", folder)
        (recording,) = Path(folder).glob("episode_*.json")
        _cb("replay", str(recording), "--out", str(page), "--no-open")


def _cb(*arguments: str) -> None:
    program = Path(sys.executable).with_name("cb")
    subprocess.run([program, *arguments], cwd=ROOT, check=True)


if __name__ == "__main__":
    main()
