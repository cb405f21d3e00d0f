"""Feed of a live page: messages that must arrive, and messages superseded by newer ones."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from threading import Condition


class Message:
    """Message of the event stream of a live page.

    Args:
        kind: Name of the event.
        make: Function that returns the event's content, in JSON types. The first sender of the
            message calls it, so that the simulation does not wait for images to be packed.
    """

    def __init__(self, kind: str, make: Callable[[], object]) -> None:
        self.kind = kind
        self._make = make

    @cached_property
    def event(self) -> bytes:
        """Message as a server-sent event."""
        text = json.dumps(self._make(), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        return f"event: {self.kind}\ndata: {text}\n\n".encode()


def message(kind: str, content: object) -> Message:
    """Return a message with constant content."""
    return Message(kind, lambda: content)


class FullError(Exception):
    """Error of a page that exceeds the maximum number of pages."""


# The log holds messages that every page needs, such as transitions and shapes of objects. Of all
# other kinds, only the newest message is kept, numbered by a common counter. A page remembers its
# place in the log and the highest number that it received. The publisher therefore keeps nothing
# per page, and no slow page delays the control loop. A page that connects late receives the log
# from the beginning of the episode.
class Feed:
    """Messages of the current episode, from one thread to any number of pages.

    A publisher never waits for a page: of the messages that may be dropped, a slow page receives
    only the newest.

    Args:
        most: Maximum number of connected pages.
    """

    def __init__(self, most: int = 16) -> None:
        self._changed = Condition()
        self._most = most
        self._pages = 0
        self._closed = False
        self._episode = 0
        self._log: list[Message] = []
        self._newest: dict[str, tuple[int, Message]] = {}
        self._count = 0

    @property
    def watched(self) -> bool:
        """True if a page is connected."""
        return self._pages > 0

    @property
    def closed(self) -> bool:
        """True if no further message will come."""
        return self._closed

    def begin(self, first: Message) -> None:
        """Begin an episode, and drop the messages of the previous one."""
        with self._changed:
            self._episode += 1
            self._log, self._newest = [first], {}
            self._changed.notify_all()

    def append(self, message: Message) -> None:
        """Publish a message that every page has to receive."""
        with self._changed:
            self._log.append(message)
            self._changed.notify_all()

    def renew(self, message: Message) -> None:
        """Publish a message that replaces the previous one of its kind."""
        with self._changed:
            self._count += 1
            self._newest[message.kind] = self._count, message
            self._changed.notify_all()

    def close(self) -> None:
        """Release all pages."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def wait_for_nobody(self, patience: float) -> None:
        """Wait until no page is connected, for at most ``patience``, s."""
        with self._changed:
            self._changed.wait_for(lambda: not self._pages, patience)

    def wait_for_page(self) -> None:
        """Wait until a page connects, or the feed is closed."""
        with self._changed:
            while not self._pages and not self._closed:
                self._changed.wait(0.5)

    @contextmanager
    def page(self) -> Iterator[PageCursor]:
        """Connect a page, from the beginning of the current episode.

        Raises:
            FullError: Too many pages are connected.
        """
        with self._changed:
            if self._pages >= self._most:
                raise FullError(f"{self._most} pages look already")
            self._pages += 1
            self._changed.notify_all()
        try:
            yield PageCursor(self)
        finally:
            with self._changed:
                self._pages -= 1
                self._changed.notify_all()


class PageCursor:
    """Position of one page in a feed."""

    def __init__(self, feed: Feed) -> None:
        self._feed = feed
        self._episode = self._place = self._seen = 0

    def take(self, patience: float) -> list[Message]:
        """Return messages that are new to the page, in order, after at most ``patience``, s."""
        feed = self._feed
        with feed._changed:
            if not self._is_behind() and not feed._closed:
                # A wake-up without news returns an empty list, which the caller allows.
                feed._changed.wait(patience)
            return self._take()

    def _is_behind(self) -> bool:
        feed = self._feed
        is_older = self._episode != feed._episode or self._place < len(feed._log)
        return is_older or any(number > self._seen for number, _ in feed._newest.values())

    def _take(self) -> list[Message]:
        feed = self._feed
        if self._episode != feed._episode:
            self._episode, self._place = feed._episode, 0
        # The log comes first, because frames refer to controllers and objects that it introduces.
        log, self._place = feed._log[self._place :], len(feed._log)
        newest = sorted(
            (each for each in feed._newest.values() if each[0] > self._seen), key=lambda e: e[0]
        )
        self._seen = max([self._seen, *(number for number, _ in newest)])
        return [*log, *(each for _, each in newest)]
