"""Stop watch: the buttons of the emergency stop, and the reasons not to rely on them."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.extend.backend import RobotDocument
from cbdsl.extend.driver import PublishersSample, StopSample

Button = tuple[str, int]
"""Driver and number of a publisher of its emergency stop."""

# Longest time until the first message of a new publisher that need not repeat it, s.
_FIRST = 1.0


class StopWatch:
    """Newest state of each button, a publisher of an emergency stop.

    Args:
        robot: Robot with drivers.
    """

    def __init__(self, robot: RobotDocument) -> None:
        self._drivers = robot.drivers
        # Names of living buttons, times of their appearance, and of their newest messages, s.
        self._names: dict[Button, str] = {}
        self._joined: dict[Button, float] = {}
        self._heard: dict[Button, float] = {}
        self._pressed: set[Button] = set()

    def note(self, sample: StopSample, now: float) -> str:
        """Take in a message; return the cause of a hold if it presses the stop."""
        button = sample.driver, sample.source
        self._heard[button] = now
        # Of several publishers, such as two buttons, each releases its own stop only.
        if not sample.pressed:
            self._pressed.discard(button)
            return ""
        self._pressed.add(button)
        return f"the emergency stop of driver '{sample.driver}' is pressed"

    def note_publishers(self, sample: PublishersSample, now: float) -> str:
        """Take in the living buttons; return the reason if one ended that had to repeat."""
        living = {(sample.driver, source): name for source, name in sample.names.items()}
        known = {button for button in self._heard | self._joined if button[0] == sample.driver}
        left = sorted(known - living.keys())
        names = [self._names.pop(button, "an unknown process") for button in left]
        for button in left:
            self._heard.pop(button, None)
            self._joined.pop(button, None)
        for button, name in living.items():
            self._names[button] = name
            self._joined.setdefault(button, now)
        driver = self._drivers[sample.driver]
        if not left or driver.stop_deadline is None:
            return ""
        return f"an emergency stop of driver '{sample.driver}' has ended ({names[0]})"

    def pressed(self) -> list[str]:
        """Return the drivers with a pressed stop."""
        return sorted({driver for driver, _ in self._pressed})

    def unheard(self) -> Iterator[tuple[str, str]]:
        """Yield the address of each emergency stop without a message, and a sentence."""
        heard = {driver for driver, _ in self._heard}
        for name, driver in self._drivers.items():
            if driver.stop and name not in heard:
                text = f"no state of the emergency stop from driver '{name}' at {driver.stop}"
                yield driver.stop, text

    def unsure(self, now: float, *, moves: bool = False) -> Iterator[str]:
        """Yield a sentence for each button whose state is unknown or too old.

        Args:
            now: Time by a monotonic clock, s.
            moves: True while the robot moves: a new button then has time for its first message.
        """
        for button in sorted(self._heard | self._joined):
            deadline = self._drivers[button[0]].stop_deadline
            where = f"the emergency stop of driver '{button[0]}'"
            if button in self._names:
                where += f" ({self._names[button]})"
            if button not in self._heard:
                first = (deadline or _FIRST) if moves else 0.0
                if now - self._joined[button] >= first:
                    yield (
                        f"{where} has sent no state: it has to repeat its message, or to keep it "
                        "for later readers (transient local)"
                    )
            elif deadline is not None and now - self._heard[button] > deadline:
                yield (
                    f"{where} is silent for {1e3 * (now - self._heard[button]):.0f} ms "
                    f"(stop_deadline {1e3 * deadline:.0f} ms)"
                )
