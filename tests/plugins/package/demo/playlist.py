"""Playlists: programs of one robot in the order of their execution."""

from typing import Annotated, Literal

from pydantic import Field

from cbdsl.extend.document import Document, Duration, Entry, Kind, Name


class PlaylistDocument(Document):
    """Programs that run one after another."""

    kind: Literal["playlist"]
    """Kind of this document: a playlist."""
    robot: Name
    """Robot that runs the programs."""
    programs: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Programs in their order."""
    after: Name | None = None
    """Playlist that runs before this one."""
    pause: Duration = 1.0
    """Time between one program and the next."""


def _playlist(programs: str, more: str = "") -> str:
    head = "cbdsl: 1\nkind: playlist\nname: example\nrobot: dexter\n"
    return f"{head}programs: {programs}\n{more}"


UNKNOWN_PLAYLIST = Entry(
    "DEMO100",
    "unknown playlist",
    "there is no playlist '{name}'",
    "A playlist comes after another one that a file has.",
    _playlist("[posture]", "after: morning\n"),
    "playlists/example.yaml",
    good=_playlist("[posture]"),
)
REPEATED = Entry(
    "DEMO101",
    "program twice in a row",
    "'{name}' follows itself",
    "A program that has just ended has nothing left to do.",
    _playlist("[posture, posture]"),
    "playlists/example.yaml",
    good=_playlist("[posture, reach]"),
)

PLAYLIST = Kind(
    PlaylistDocument,
    folder="playlists",
    checker="demo.playlist_checker:check",
    unknown=UNKNOWN_PLAYLIST,
    references={"robot": "robot", "after": "playlist"},
    stand_ins={"robot": "unknown", "programs": ["unknown"]},
    entries=(UNKNOWN_PLAYLIST, REPEATED),
)
