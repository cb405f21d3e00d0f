"""Make the pictures of README and gallery from recorded runs.

Run ``python docs/make_pictures.py`` to record each run of the gallery, to draw its replay and to
write docs/assets/reachtouch.gif and docs/assets/gallery. It needs Chromium and ffmpeg.
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
#: The run of the moving picture.
MOVING = "reachtouch"
#: Frames per second of the moving picture, which plays at real time.
RATE = 6
#: Time for which its last frame stays, s.
PAUSE = 2.0
#: Size of a picture, px.
WIDTH, HEIGHT = 800, 542
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
    """Make all pictures."""
    (ASSETS / "gallery").mkdir(parents=True, exist_ok=True)
    for exhibit in EXHIBITS:
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
        if exhibit.name == MOVING:
            for number in range(int(last * RATE) + 1):
                _draw(page, number / RATE, folder / f"frame_{number:03d}.png")
    _encode(folder / "still.png", "scale=640:-1", ASSETS / "gallery" / f"{exhibit.name}.jpg")
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


def _encode(source: Path, filters: str, target: Path) -> None:
    command = ["ffmpeg", "-loglevel", "error", "-y", "-framerate", str(RATE), "-i", str(source)]
    subprocess.run([*command, "-filter_complex", filters, str(target)], check=True)


if __name__ == "__main__":
    main()
