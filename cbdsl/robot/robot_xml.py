"""XML files whose root is a robot: URDF and SRDF."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from cbdsl.documents.contents import contents
from cbdsl.robot.urdf import UrdfError

# The largest public models, of humanoids, have a tenth of it; meshes have files of their own.
_MOST_BYTES = 16_000_000


def robot_text(path: Path) -> bytes:
    """The contents of a file.

    Raises:
        UrdfError: there is no such file, or it is too large for one.
    """
    try:
        return contents(path, _MOST_BYTES)
    except OSError as error:
        raise UrdfError(f"{path}: {error.strerror}") from None


def xml_root(text: bytes | str, path: Path, kind: str) -> ElementTree.Element:
    """The root of an XML text.

    Args:
        text: of the file.
        path: names it in messages.
        kind: name of the format.

    Raises:
        UrdfError: it is no XML.
    """
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise UrdfError(f"{path}: it is no XML, of which {kind} is made: {error}") from None


def require_robot(root: ElementTree.Element, path: Path) -> None:
    """Check that a root is that of a robot.

    Raises:
        UrdfError: it is another one.
    """
    if root.tag != "robot":
        raise UrdfError(f"{path}: its root is <{root.tag}>, not <robot>")
