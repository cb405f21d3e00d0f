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
        good=_TRACKING,
    ),
    Entry(
        "CB102",
        "not UTF-8",
        "byte {byte} is not UTF-8",
        "Documents are text in UTF-8. Save the file in that encoding.",
        _TRACKING.replace("name: example", "name: example # café").encode("latin-1"),
        good=_TRACKING.replace("name: example", "name: example # café"),
    ),
    Entry(
        "CB103",
        "control character",
        "{character} is a control character, which no document may hold",
        "Control characters mean that this is a binary file or a damaged one.",
        b"\x7fELF\x02\x01\x01\x00\x00",
        good=_TRACKING,
    ),
    Entry(
        "CB104",
        "not YAML",
        "this is not YAML: {problem}",
        "The text breaks the rules of YAML. Often a bracket or a quote is not closed, or lines "
        "of one mapping are not indented alike. Quote keys and values that begin with `*`, `@`, "
        "`%` or a bracket.",
        _TRACKING.replace("[track]", "[track"),
        good=_TRACKING,
    ),
    Entry(
        "CB105",
        "empty file",
        "this file holds no document",
        "Every document begins with `cbdsl: 1` and its `kind`.",
        "# nothing but a comment\n",
        good=_TRACKING,
    ),
    Entry(
        "CB106",
        "several documents in one file",
        "a second document begins here; a file holds one",
        "Documents are found by their file's name, so each has a file of its own.",
        _TRACKING + "---\n" + _TRACKING,
        good=_TRACKING,
    ),
    Entry(
        "CB107",
        "key written twice",
        "the key '{key}' is written twice",
        "YAML readers silently keep the last of two values, which hides mistakes.",
        program("actions: [track]\nrobot: dexter\n"),
        good=_TRACKING,
    ),
    Entry(
        "CB108",
        "too large",
        "this document is larger than {bound}",
        "A document may have 256000 characters, 10000 of them in one text, 10000 values, and 2000 "
        "entries in one list or mapping. Aliases are written out before they are counted, so a "
        "few lines can stand for billions of values.",
        "l0: &l0 [a, a, a, a, a, a, a, a, a, a]\n" + _BOMB,
        good=_TRACKING + "description: &text a few words\n",
    ),
    Entry(
        "CB109",
        "number that is not finite",
        "'{text}' is not a finite number",
        "No quantity of a robot is infinite or undefined. Leave a limit out to have none.",
        program("actions: [track]\nlimits: {transition_time: .inf}\n"),
        good=program("actions: [track]\nlimits: {transition_time: 60 s}\n"),
    ),
    Entry(
        "CB110",
        "number with a leading zero",
        "'{text}' reads as an octal number in some readers and as a decimal one in others",
        "Write the decimal number without the zero in front, or put a name in quotes.",
        program("actions: [track]\nlimits: {transitions: 0100}\n"),
        good=program("actions: [track]\nlimits: {transitions: 100}\n"),
    ),
    Entry(
        "CB111",
        "unknown alias",
        "no complete value is anchored as '&{name}' before this; a text that begins with '*' has "
        "to be quoted",
        "`*name` repeats the value that was marked `&name` earlier. Text that begins with `*`, "
        "such as a state of any predicates, has to be quoted. A value cannot contain itself.",
        program("actions: [track]\ndescription: *missing\n"),
        good=program('actions: [track]\ndescription: "*missing"\n'),
    ),
    Entry(
        "CB112",
        "tag",
        "'{tag}' is a tag, and documents have none",
        "Types follow from the kind of document, never from tags in the text.",
        program("actions: [track]\ndescription: !!python/name:os.system x\n"),
        good=program("actions: [track]\ndescription: x\n"),
    ),
    Entry(
        "CB113",
        "key that is no text",
        "this key is a list or a mapping; a key is text, such as the state 'X10*', and a parameter "
        "is written $name",
        "Quote a key that begins with a bracket or a brace.",
        program("actions: [track]\npolicy: {[X]: track}\n"),
        good=program('actions: [track]\npolicy: {"X": track}\n'),
    ),
    Entry(
        "CB114",
        "word that some readers take for true or false",
        "'{text}' is true or false to some readers of YAML and text to others; write \"{text}\" if "
        "the word is meant",
        "In YAML 1.1 `NO` is false, and a country is lost. Write `true` or `false`, or quotes "
        "where the word is meant.",
        program("actions: [track]\ndescription: NO\n"),
        good=program('actions: [track]\ndescription: "NO"\n'),
    ),
    Entry(
        "CB115",
        "number in base 60",
        "'{text}' is a number in base 60 to some readers of YAML and text to others",
        "In YAML 1.1 `12:30:45` is 45045. Write the number with its unit, or quotes where text is "
        "meant.",
        program("actions: [track]\nlimits: {transition_time: 1:30}\n"),
        good=program("actions: [track]\nlimits: {transition_time: 90 s}\n"),
    ),
    Entry(
        "CB116",
        "number of another base, or with '_'",
        "'{text}' is a number to some readers of YAML and text to others",
        "Write decimal digits and nothing between them, or quotes where text is meant.",
        program("actions: [track]\nlimits: {transitions: 1_000}\n"),
        good=program("actions: [track]\nlimits: {transitions: 1000}\n"),
    ),
    Entry(
        "CB117",
        "tab where spaces are wanted",
        "a tab; lines are indented with spaces",
        "YAML forbids tabs in front of a line, because they are as wide as each editor likes.",
        program("actions: [track]\nlimits:\n\ttransitions: 100\n"),
        good=program("actions: [track]\nlimits:\n  transitions: 100\n"),
    ),
    Entry(
        "CB118",
        "invisible character",
        "{character} is invisible; delete it, and others like it",
        "Characters without width, byte order marks within a text, and those that turn the "
        "direction of writing make names differ that look the same. They come from web pages and "
        "from files that were joined.",
        program("actions: [track\u200b]\n"),
        good=_TRACKING,
    ),
    Entry(
        "CB119",
        "nested too deeply",
        "this is nested more than {bound} levels deep",
        "No document needs a fraction of it: brackets are not closed, or the text was made to "
        "exhaust its reader.",
        HEAD + "controllers: " + "[" * 70 + "]" * 70 + "\n",
        good=_TRACKING,
    ),
    Entry(
        "CB120",
        "number that a computer does not hold",
        "'{text}' has more digits, or is larger or smaller, than numbers are kept with",
        "Numbers are 64-bit floats: integers are exact up to 2**53, and sizes go from 1e-308 to "
        "1e308. Write fewer digits, or quotes where text is meant.",
        program("actions: [track]\nlimits: {transitions: 100000000000000000000}\n"),
        good=program("actions: [track]\nlimits: {transitions: 100}\n"),
    ),
    Entry(
        "CB121",
        "line that is out of line",
        "this line is not where it belongs: {problem}",
        "The keys of one mapping, and the items of one list, have the same number of spaces in "
        "front. What belongs to a key that has nothing behind its `:` stands below it with more.",
        program("actions: [track]\nlimits:\n  transitions: 100\n   transition_time: 20 s\n"),
        good=program("actions: [track]\nlimits:\n  transitions: 100\n  transition_time: 20 s\n"),
    ),
    Entry(
        "CB122",
        "merge conflict",
        "{problem}",
        "Git writes both versions into the file where it cannot tell which is wanted. The rest of "
        "the document is checked with the first of them. Lines copied from a comparison (a diff) "
        "begin with '-' or '+'; it is checked with what is newer.",
        program("<<<<<<< HEAD\nactions: [track]\n=======\nactions: []\n>>>>>>> other\n"),
        good=_TRACKING,
    ),
    Entry(
        "CB123",
        "character that looks like another",
        "{problem}",
        "Word processors, web pages and PDF files put minus signs, dashes, typographic quotes and "
        "spaces of their own where documents need the ones of the keyboard.",
        program("actions: [track]\nlimits: {transition_time: 20\u00a0s}\n"),
        good=program("actions: [track]\nlimits: {transition_time: 20 s}\n"),
    ),
    Entry(
        "CB124",
        "text that has to be quoted",
        "{problem}",
        "A text that begins with `*`, `&`, `!`, `@`, `%`, a backquote or a bracket means something "
        "else to YAML. A state such as `'*10'` is a key, and quoted as one.",
        program("actions: [track]\npolicy:\n  X: track\n  *: track\n"),
        good=program("actions: [track]\npolicy:\n  X: track\n  '*': track\n"),
    ),
)
