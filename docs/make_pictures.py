"""Make the pictures of README and gallery from recorded runs.

Run ``python docs/make_pictures.py [NAME ...]`` to record all runs of the gallery or the named ones.
It draws their replays and writes docs/assets/reachtouch.gif and, with a film of each run,
docs/assets/gallery. It needs Chromium and ffmpeg.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from make_gallery import EXHIBITS, ROOT, Exhibit, make_replay

sys.path.insert(0, str(ROOT))

from tests.reporting.browser import Page, browser

ASSETS = ROOT / "docs" / "assets"
#: The run of the README's moving picture.
MOVING = "reachtouch"
#: Frames per second of films; they play at real time, or faster where a run is longer than this.
RATE, LONGEST = 6, 30.0
#: Time for which the last frame of the moving picture stays, s.
PAUSE = 2.0
#: Size of a picture, px.
WIDTH, HEIGHT = 800, 542
#: Compression of films, which begin before they are loaded.
FILM = ("-c:v", "libx264", "-crf", "30", "-preset", "slow", "-movflags", "+faststart")
#: Time of a still picture, as a share of the run.
STILL = 0.8
#: Layout: the scene beside the camera images, the strip of predicates below, and nothing else.
STYLE = """
header, footer, figcaption, #why, #views, #points, #levels, #limits, #transport, #charts
  { display: none !important }
#stage { grid-template-columns: 520px 1fr !important } #world, #view { height: 355px !important }
#cameras { display: block !important }
#cameras canvas { width: 100% !important; height: auto !important }
figure { margin: 0 0 6px !important } body { overflow: hidden }
"""


def main() -> None:
    """Make the pictures and films of all exhibits, or of the named ones."""
    (ASSETS / "gallery").mkdir(parents=True, exist_ok=True)
    chosen = sys.argv[1:]
    for exhibit in [each for each in EXHIBITS if not chosen or each.name in chosen]:
        with tempfile.TemporaryDirectory() as folder:
            _make(exhibit, Path(folder))


def _make(exhibit: Exhibit, folder: Path) -> None:
    replay = folder / "page.html"
    make_replay(exhibit, replay)
    with browser() as page:
        page.open(replay, width=WIDTH, height=HEIGHT)
        page.value(f"document.head.insertAdjacentHTML('beforeend', `<style>{STYLE}</style>`)")
        page.value("dispatchEvent(new Event('resize'))")
        last = float(page.value("document.getElementById('scrub').max"))
        _draw(page, STILL * last, folder / "still.png")
        step = max(1.0, last / LONGEST) / RATE
        for number in range(int(last / step) + 1):
            _draw(page, number * step, folder / f"frame_{number:03d}.png")
    gallery = ASSETS / "gallery"
    _encode(folder / "still.png", "scale=640:-1", gallery / f"{exhibit.name}.jpg")
    _encode(folder / "frame_%03d.png", "format=yuv420p", gallery / f"{exhibit.name}.mp4", *FILM)
    if exhibit.name == MOVING:
        _encode(folder / "frame_%03d.png", _palette(), ASSETS / f"{MOVING}.gif")


def _draw(page: Page, time: float, picture: Path) -> None:
    page.value(f"location.hash = 't={time:.3f}'")
    page.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    picture.write_bytes(page.picture())


def _palette() -> str:
    hold = f"tpad=stop_mode=clone:stop_duration={PAUSE}"
    return (
        f"{hold},split[a][b];[a]palettegen=max_colors=96:stats_mode=full[p];"
        "[b][p]paletteuse=dither=none:diff_mode=rectangle"
    )


def _encode(source: Path, filters: str, target: Path, *options: str) -> None:
    command = ["ffmpeg", "-loglevel", "error", "-y", "-framerate", str(RATE), "-i", str(source)]
    subprocess.run([*command, "-filter_complex", filters, *options, str(target)], check=True)


if __name__ == "__main__":
    main()
