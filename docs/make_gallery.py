"""Makes the replays of the gallery: runs programs, records them, and writes their pages.

Run ``python docs/make_gallery.py`` before the site is built for readers; the pages go to
docs/gallery/ and are not kept under version control. A page that is there is not made again.
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
    """A replay of the gallery.

    Attributes:
        name: of its page.
        arguments: of ``cb run``.
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
    Exhibit("panda_pick", ("panda_pick",)),
)


def main() -> None:
    """Make the pages that are not there yet."""
    FOLDER.mkdir(exist_ok=True)
    for exhibit in EXHIBITS:
        page = FOLDER / f"{exhibit.name}.html"
        if not page.exists():
            _make(exhibit, page)


def _make(exhibit: Exhibit, page: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        _cb("run", *exhibit.arguments, "--backend", "mujoco", "--seed", "1", "--record", folder)
        (recording,) = Path(folder).glob("episode_*.json")
        _cb("replay", str(recording), "--out", str(page), "--no-open")


def _cb(*arguments: str) -> None:
    program = Path(sys.executable).with_name("cb")
    subprocess.run([program, *arguments], cwd=ROOT, check=True)


if __name__ == "__main__":
    main()
