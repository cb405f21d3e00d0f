"""CB1nn: from bytes to values."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, program
from cbdsl.errors.entry import Entry

_TRACKING = program("actions: [track]\n")
_BOMB = "".join(f"l{i}: &l{i} [{', '.join([f'*l{i - 1}'] * 10)}]\n" for i in range(1, 7))

READING = (
    Entry(
        "CB101",
        "file cannot be read",
        "this file cannot be read: {reason}",
        "The file does not exist, is a directory, or may not be read by this user.",
        None,
    ),
    Entry(
        "CB102",
        "not UTF-8",
        "byte {byte} is not UTF-8",
        "Documents are text in UTF-8. Save the file in that encoding.",
        b"cbdsl: 1\nkind: program\nname: caf\xe9\n",
    ),
    Entry(
        "CB103",
        "control character",
        "{character} is a control character, which no document may hold",
        "Control characters mean that this is a binary file or a damaged one.",
        b"\x7fELF\x02\x01\x01\x00\x00",
    ),
    Entry(
        "CB104",
        "not YAML",
        "this is not YAML: {problem}",
        "The text breaks the rules of YAML. Often a bracket or a quote is not closed, or lines "
        "of one mapping are not indented alike. Quote keys and values that begin with `*`, `@`, "
        "`%` or a bracket.",
        HEAD + "controllers: {track: [\n",
    ),
    Entry(
        "CB105",
        "empty file",
        "this file holds no document",
        "Every document begins with `cbdsl: 1` and its `kind`.",
        "# nothing but a comment\n",
    ),
    Entry(
        "CB106",
        "several documents in one file",
        "a second document begins here; a file holds one",
        "Documents are found by their file's name, so each has a file of its own.",
        _TRACKING + "---\n" + _TRACKING,
    ),
    Entry(
        "CB107",
        "key written twice",
        "the key '{key}' is written twice",
        "YAML readers silently keep the last of two values, which hides mistakes.",
        HEAD + "robot: dexter\n",
    ),
    Entry(
        "CB108",
        "too large",
        "this document is larger than {bound}",
        "Aliases are written out before a document is read, so a few lines can stand for "
        "billions of values. A document may have 100000 values and 64 levels of nesting.",
        "l0: &l0 [a, a, a, a, a, a, a, a, a, a]\n" + _BOMB,
    ),
    Entry(
        "CB109",
        "number that is not finite",
        "'{text}' is not a finite number",
        "No quantity of a robot is infinite or undefined. Leave a limit out to have none.",
        program("actions: [track]\nlimits: {transition_time: .inf}\n"),
    ),
    Entry(
        "CB110",
        "number with a leading zero",
        "'{text}' reads as an octal number in some readers and as a decimal one in others",
        "Write the decimal number without the zero in front, or put a name in quotes.",
        program("actions: [track]\nlimits: {transitions: 0100}\n"),
    ),
    Entry(
        "CB111",
        "unknown alias",
        "no complete value is anchored as '&{name}' before this",
        "`*name` repeats the value that was marked `&name` earlier. Text that begins with `*`, "
        "such as a state of any predicates, has to be quoted. A value cannot contain itself.",
        program("actions: [track]\ndescription: *missing\n"),
    ),
    Entry(
        "CB112",
        "tag",
        "'{tag}' is a tag, and documents have none",
        "Types follow from the kind of document, never from tags in the text.",
        program("actions: [track]\ndescription: !!python/name:os.system x\n"),
    ),
    Entry(
        "CB113",
        "key that is no text",
        "this key is a list or a mapping; keys are text",
        "Quote a key that begins with a bracket or a brace.",
        HEAD + "? [a, b]\n: 1\n",
    ),
)
