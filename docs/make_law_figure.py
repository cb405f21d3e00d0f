"""Make the figure of docs/control.md: both orders of the law at an unreachable target.

Run ``python docs/make_law_figure.py`` after a change of the control law. It writes
docs/assets/second_order.svg; equal input gives equal files.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
FIGURE = ROOT / "docs" / "assets" / "second_order.svg"
sys.path.insert(0, str(ROOT / "benchmarks"))

LINKS = (0.3, 0.25, 0.2)  # m
TARGET, TURN = (0.9, 0.4), 0.52  # m, rad
START = (0.3, 0.4, 0.2)  # rad
SECONDS, STEP = 4.0, 1.5 / 60  # s, rad a tick
GAIN, SPEED = 8.0, 0.35  # 1/s, m/s
COLORS = {"first order": "#b3541e", "second order": "#1f6f8b"}


def main() -> None:
    """Write the figure."""
    curves = {"first order": settle(False), "second order": settle(True)}
    FIGURE.write_text(svg(curves), encoding="utf-8")


def settle(curved: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest joint motion, deg a tick, and the distance to the target, cm, by tick."""
    from ours import law_with_hessians

    fraction = 0.5 * GAIN / 60
    solve, q = law_with_hessians((2, 1, 3), fraction, curved=curved), np.array(START)
    motion, distance = [], []
    for _ in range(round(60 * SECONDS)):
        angles = np.cumsum(q)
        ends = np.array([LINKS * np.cos(angles), LINKS * np.sin(angles)])
        levers = np.cumsum(ends[:, ::-1], axis=1)[:, ::-1]
        away = np.array(TARGET) - levers[:, 0]
        rows = np.stack((-levers[1], levers[0]))
        bent = -levers[:, np.maximum.outer(range(3), range(3))]
        far = fraction * away
        far *= min(1.0, SPEED / 60 / np.linalg.norm(far))
        turn = np.clip(fraction * (TURN - angles[-1]), -STEP, STEP)
        posture = np.clip(-fraction * q, -0.8 / 60, 0.8 / 60)
        levels = [
            (rows, far, bent),
            (np.ones((1, 3)), np.array([turn]), np.zeros((1, 3, 3))),
            (np.eye(3), posture, np.zeros((3, 3, 3))),
        ]
        moved = solve(levels, q)
        q = q + moved
        motion.append(np.degrees(np.abs(moved).max()))
        distance.append(100 * np.linalg.norm(away))
    return np.array(motion), np.array(distance)


def svg(curves: dict[str, tuple[np.ndarray, np.ndarray]]) -> str:
    """Return both panels: motion above, distance below."""
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" width="720" height="412" '
        'font-family="system-ui, sans-serif" font-size="13" fill="#1b2733">',
        '<rect width="720" height="412" fill="#ffffff"/>',
        *panel(30, "largest motion of a joint, deg a tick", (0.0, 1.5), 0.5, {
            name: motion for name, (motion, _) in curves.items()
        }),
        *panel(220, "distance to the target, cm", (22.0, 30.0), 2.0, {
            name: distance for name, (_, distance) in curves.items()
        }),
        '<text x="395" y="406" text-anchor="middle">time, s</text>',
    ]  # fmt: skip
    for place, (name, color) in enumerate(COLORS.items()):
        parts.append(
            f'<path d="M{450 + 130 * place} 14 h22" stroke="{color}" stroke-width="2"/>'
            f'<text x="{478 + 130 * place}" y="18">{name}</text>'
        )
    return "\n".join([*parts, "</svg>", ""])


def panel(
    top: int, title: str, limits: tuple[float, float], step: float, curves: dict[str, np.ndarray]
) -> list[str]:
    """Return one panel of curves over time, 700 px wide and 150 px high, below ``top``."""
    low, high = limits

    def at(seconds: float, value: float) -> tuple[float, float]:
        height = (min(max(value, low), high) - low) / (high - low)
        return 60 + 640 * seconds / SECONDS, top + 150 - 140 * height

    parts = [f'<text x="60" y="{top + 2}">{title}</text>']
    for value in np.arange(low, high + step / 2, step):
        x, y = at(0.0, float(value))
        parts.append(f'<path d="M{x:.0f} {y:.1f} h640" stroke="#d5dde3"/>')
        parts.append(f'<text x="52" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
    for seconds in range(int(SECONDS) + 1):
        x, y = at(seconds, low)
        parts.append(f'<text x="{x:.0f}" y="{y + 16:.1f}" text-anchor="middle">{seconds}</text>')
    for name, values in curves.items():
        points = " ".join(
            "{:.1f},{:.1f}".format(*at(tick / 60, float(value)))
            for tick, value in enumerate(values)
        )
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{COLORS[name]}" stroke-width="1.6"/>'
        )
    return parts


if __name__ == "__main__":
    main()
