"""XML files whose root is a robot: URDF and SRDF."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from cbdsl.robot.urdf import UrdfError
from cbdsl.storage.contents import contents

# The largest public models, of humanoids, have 1.6 MB; meshes have files of their own.
MOST_BYTES = 4_000_000
_ENCODING = re.compile(rb"""\s*<\?xml[^>]*?encoding=["']([\w.:-]+)""")
_READ_BY_ENGINES = ("utf-8", "utf8", "ascii", "us-ascii")


def robot_text(path: Path) -> bytes:
    """Return the contents of a file.

    Raises:
        UrdfError: If there is no such file, or it is too large.
    """
    try:
        return contents(path, MOST_BYTES)
    except OSError as error:
        raise UrdfError(f"{path}: {error.strerror}") from None


def xml_root(text: bytes | str, path: Path, kind: str) -> ElementTree.Element:
    """Return the root of an XML text, whose names keep their prefixes.

    Namespaces are not resolved, because no engine does: exporters write ``xmlns`` on ``<robot>``,
    and prefixes of extensions, such as ``drake:acceleration``, without a declaration.

    Args:
        text: Text of the file.
        path: Path of the file, for messages.
        kind: Name of the format.

    Raises:
        UrdfError: If it is not XML.
    """
    # This check has to precede the reader, which expands entities while it reads.
    refuse_entities(text, path)
    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    parser.CharacterDataHandler, parser.buffer_text = builder.data, True
    try:
        # Engines read a declaration behind empty lines, too.
        parser.Parse(text.lstrip(), True)
        return builder.close()
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise UrdfError(f"{path}: it is not XML, the format of {kind}: {error}") from None


def require_names_for_engines(root: ElementTree.Element, text: bytes, path: Path) -> None:
    """Refuse names that engines read otherwise: they take every model for UTF-8.

    Comments and descriptions may have any encoding whose letters A to Z are those of ASCII.

    Raises:
        UrdfError: If the text declares another encoding, and has names beyond ASCII or no ASCII.
    """
    declared = _ENCODING.match(text)
    encoding = declared[1].decode("ascii") if declared else "utf-8"
    # A byte order mark states UTF-16 without any declaration.
    if text.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    elif encoding.lower() in _READ_BY_ENGINES or _has_plain_names(root):
        return
    raise UrdfError(f"{path}: it is encoded in {encoding}, and engines read UTF-8; convert it")


def _has_plain_names(root: ElementTree.Element) -> bool:
    return all(value.isascii() for each in root.iter() for value in each.attrib.values())


def require_robot(root: ElementTree.Element, path: Path) -> None:
    """Check that a root element is ``<robot>``.

    Raises:
        UrdfError: If it is another one.
    """
    if root.tag != "robot":
        raise UrdfError(f"{path}: its root is <{root.tag}>, not <robot>")


def refuse_macros(root: ElementTree.Element, path: Path) -> None:
    """Refuse a model with elements of xacro that is not declared as xacro.

    Raises:
        UrdfError: If it has one.
    """
    if any("xacro" in element.tag for element in root.iter()):
        raise UrdfError(
            f"{path}: it is xacro, and its name does not end in .xacro; cb new robot NAME --xacro "
            "--urdf MODEL expands it, with the extra formats: pip install 'cbdsl[formats]'"
        )


def refuse_entities(text: bytes | str, path: Path) -> None:
    """Refuse a text that declares entities, because a few bytes can expand to gigabytes.

    They are declared before the root element, where this check stops reading.

    Raises:
        UrdfError: If it declares one.
    """
    declared = []

    def stop(*_: object) -> None:
        raise StopIteration

    def refuse(*_: object) -> None:
        declared.append(True)
        raise StopIteration

    parser = expat.ParserCreate()
    parser.EntityDeclHandler, parser.StartElementHandler = refuse, stop
    # Syntax errors are reported by the reader.
    with suppress(StopIteration, expat.ExpatError, ValueError, LookupError):
        parser.Parse(text, True)
    if declared:
        raise UrdfError(f"{path}: it declares XML entities, which models may not; write them out")
