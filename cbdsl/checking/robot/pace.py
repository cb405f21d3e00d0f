"""Gains and windows compared with the control cycle."""

from __future__ import annotations

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.robot import RobotDocument
from cbdsl.yaml_text.source_map import SourceMap, Step

# A tick takes gain * period of the Newton step, which for half the square of a residual is half
# the residual: the residual is multiplied by 1 - gain * period / 2, and changes sign above 2.
_MOST_PER_TICK = 2.0


def check_gain(
    gain: float,
    robot: RobotDocument,
    source: SourceMap,
    steps: tuple[Step, ...],
    diagnostics: Diagnostics,
) -> None:
    """Warn of a gain that takes a residual past 0 within a tick.

    Args:
        gain: Gain κ, 1/s.
        robot: Robot with the control rate.
        source: Source map of the document.
        steps: Path of the section with the gain.
        diagnostics: Diagnostics so far.
    """
    if gain > _MOST_PER_TICK * robot.control.rate:
        most = f"{_MOST_PER_TICK * robot.control.rate:g}"
        place = source.place(*steps, "gain")
        diagnostics.add("CB712", place, gain=f"{gain:g}", most=most, rate=f"{robot.control.rate:g}")


def check_window(
    window: float,
    seen: bool,
    robot: RobotDocument,
    source: SourceMap,
    steps: tuple[Step, ...],
    diagnostics: Diagnostics,
) -> None:
    """Warn of a window of quiescence that contains less than two measurements.

    Args:
        window: Window, s.
        seen: True if the measured signal comes with the images.
        robot: Robot with the rates of control and images.
        source: Source map of the document.
        steps: Path of the section with the quiescence.
        diagnostics: Diagnostics so far.
    """
    rate, what = robot.control.rate, "ticks"
    if seen and robot.vision.rate < rate:
        rate, what = robot.vision.rate, "images"
    if window * rate < 2 - 1e-9:
        place = source.place(*steps, "quiescence", "window")
        diagnostics.add("CB713", place, window=f"{window:g}", what=what, least=f"{2 / rate:.2g}")
