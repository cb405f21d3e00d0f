"""The feed: required messages arrive in order; of the others only the newest is sent."""

from __future__ import annotations

import json
from threading import Thread

import pytest

from cbdsl.reporting.live.feed import Feed, FullError, Message, PageCursor, message


def kinds(cursor: PageCursor) -> list[str]:
    return [each.kind for each in cursor.take(0.0)]


def contents(cursor: PageCursor) -> list[object]:
    events = [each.event.decode() for each in cursor.take(0.0)]
    return [json.loads(each.split("data: ", 1)[1]) for each in events]


def test_page_that_comes_late_gets_the_episode_from_its_beginning() -> None:
    feed = Feed()
    feed.begin(message("episode", 1))
    feed.append(message("transition", 2))
    feed.renew(message("frame", 3))
    feed.append(message("transition", 4))
    with feed.page() as cursor:
        assert contents(cursor) == [1, 2, 4, 3]
        assert contents(cursor) == []


def test_slow_page_gets_only_the_newest_frame_and_every_transition() -> None:
    feed = Feed()
    feed.begin(message("episode", "first"))
    with feed.page() as cursor:
        assert contents(cursor) == ["first"]
        for number in range(100):
            feed.renew(message("frame", number))
            feed.append(message("transition", -number))
        assert contents(cursor) == [*(-n for n in range(100)), 99]


def test_new_episode_leaves_nothing_of_the_one_before() -> None:
    feed = Feed()
    feed.begin(message("episode", 1))
    with feed.page() as cursor:
        feed.renew(message("frame", 2))
        assert contents(cursor) == [1, 2]
        feed.append(message("ending", 3))
        feed.renew(message("frame", 4))
        feed.begin(message("episode", 5))
        assert contents(cursor) == [5]


def test_messages_are_packed_when_a_page_needs_them_and_once() -> None:
    made = []
    feed = Feed()
    feed.begin(message("episode", 0))
    for number in range(10):
        feed.renew(Message("images", lambda number=number: made.append(number)))
    assert made == []
    for _ in range(2):
        with feed.page() as cursor:
            assert [each.event[:13] for each in cursor.take(0.0)][1] == b"event: images"
    assert made == [9]


def test_page_waits_until_there_is_something() -> None:
    feed = Feed()
    with feed.page() as cursor:
        assert kinds(cursor) == []
        late = Thread(target=lambda: feed.begin(message("episode", 1)))
        late.start()
        assert [each.kind for each in cursor.take(20.0)] == ["episode"]
        late.join()


def test_closing_lets_pages_go() -> None:
    feed = Feed()
    with feed.page() as cursor:
        late = Thread(target=feed.close)
        late.start()
        assert cursor.take(20.0) == []
        late.join()
    assert feed.closed
    feed.wait_for_page()


def test_only_so_many_pages_are_served_and_places_become_free() -> None:
    feed = Feed(most=1)
    with feed.page():
        assert feed.watched
        with pytest.raises(FullError, match="1 pages"), feed.page():
            pass
    assert not feed.watched
    with feed.page():
        assert feed.watched
