"""The feed of a live page: what has to arrive, and what only the newest of is worth sending."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Condition

from cbdsl.reporting.live.message import Message


class FullError(Exception):
    """As many pages look as a feed serves."""


class Feed:
    """Messages of the current episode, from one thread to any number of pages.

    Whoever publishes never waits for a page: a page that is slow finds only the newest of what may
    be dropped.

    Args:
        most: how many pages may look at once.
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
        """Whether a page looks now."""
        return self._pages > 0

    @property
    def closed(self) -> bool:
        """Whether nothing will come any more."""
        return self._closed

    def begin(self, first: Message) -> None:
        """Begin an episode: nothing of the one before is left."""
        with self._changed:
            self._episode += 1
            self._log, self._newest = [first], {}
            self._changed.notify_all()

    def append(self, message: Message) -> None:
        """Publish what every page has to get."""
        with self._changed:
            self._log.append(message)
            self._changed.notify_all()

    def renew(self, message: Message) -> None:
        """Publish what replaces the message of this kind before."""
        with self._changed:
            self._count += 1
            self._newest[message.kind] = self._count, message
            self._changed.notify_all()

    def close(self) -> None:
        """Let all pages go."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def wait_for_nobody(self, patience: float) -> None:
        """Wait until no page looks any more, for ``patience``, s, at most."""
        with self._changed:
            self._changed.wait_for(lambda: not self._pages, patience)

    def wait_for_page(self) -> None:
        """Wait until a page looks, or the feed is closed."""
        with self._changed:
            while not self._pages and not self._closed:
                self._changed.wait(0.5)

    @contextmanager
    def page(self) -> Iterator[PageCursor]:
        """A page looks, from the beginning of the current episode.

        Raises:
            FullError: too many do.
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
    """Place of one page in a feed."""

    def __init__(self, feed: Feed) -> None:
        self._feed = feed
        self._episode = self._place = self._seen = 0

    def take(self, patience: float) -> list[Message]:
        """Messages that are new to the page, in their order; none when ``patience``, s, is over."""
        feed = self._feed
        with feed._changed:
            if not self._is_behind() and not feed._closed:
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
        log, self._place = feed._log[self._place :], len(feed._log)
        newest = sorted(
            (each for each in feed._newest.values() if each[0] > self._seen), key=lambda e: e[0]
        )
        self._seen = max([self._seen, *(number for number, _ in newest)])
        return [*log, *(each for _, each in newest)]
