"""CB2nn: the keys and values of documents."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, SEARCH, TRACK, controller, program
from cbdsl.errors.entry import Entry


def _requiring(key: str) -> str:
    """A program with a controller that acts only beside another one; the key says so."""
    nod = f"{SEARCH[:-1]}, {key}: track}}"
    return program(f"  nod: {nod}\n  both: nod ◁ track\nactions: [both, track]\n")


SHAPE = (
    Entry(
        "CB201",
        "document of the wrong kind",
        "this is a {found}, and a {wanted} is needed here",
        "`robot:` wants the name of a robot document, `use:` that of a program, and so on.",
        program("actions: [track]\nstage: wrong\n"),
        beside={"programs/stages/wrong.yaml": program("actions: [track]\n")},
        good=program("actions: [track]\nstage: absent\n"),
    ),
    Entry(
        "CB202",
        "unknown key",
        "there is no key '{key}' here",
        "Documents are strict, because a misspelt key that is passed over changes behaviour "
        "without a word.",
        program("actions: [track]\nstgae: table_right\n"),
        good=program("actions: [track]\nstage: table_right\n"),
    ),
    Entry(
        "CB203",
        "missing key",
        "the key '{key}' is missing",
        "This part of the document is incomplete without it.",
        f"{HEAD}controllers:\n  track: {TRACK}\n",
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB204",
        "value of the wrong kind",
        "expected {expected}, found {found}",
        "The value has another shape than its key wants.",
        program("actions: [track]\nlimits: 100\n"),
        good=program("actions: [track]\nlimits: {transitions: 100}\n"),
    ),
    Entry(
        "CB205",
        "not the quantity that is wanted",
        "{problem}",
        "A quantity is a number in SI units, or a number with a unit of the right dimension, "
        "such as `30 deg`, `2 cm` or `0.2 N`.",
        program("actions: [track]\nlimits: {transition_time: 20 cm}\n"),
        good=program("actions: [track]\nlimits: {transition_time: 20 s}\n"),
    ),
    Entry(
        "CB206",
        "not one of the values that are allowed",
        "'{name}' is not allowed here",
        "Only a few values are possible here.",
        program("actions: [track]\n", head=HEAD.replace("kind: program", "kind: programme")),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB207",
        "not a name",
        "'{name}' is not a name: a letter, then letters, digits and '_'{hint}",
        "Names appear in compositions and in resources, where other characters have a meaning.",
        HEAD + f"controllers:\n  track-it: {TRACK}\nactions: [track-it]\n",
        good=HEAD + f"controllers:\n  track_it: {TRACK}\nactions: [track_it]\n",
    ),
    Entry(
        "CB208",
        "value outside its range",
        "this value cannot be used: {problem}",
        "The value is of the right kind, but too small, too large, too short or too long.",
        controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head, gain: -1"
        ),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head, gain: 1"
        ),
    ),
    Entry(
        "CB209",
        "key on the wrong level",
        "{problem}",
        "A key belongs to the nearest line above that is indented less. One that is a level too "
        "high or too low says something of another part of the document, or of none.",
        program("actions: [track]\nlimits:\ntransitions: 100\n"),
        good=program("actions: [track]\nlimits:\n  transitions: 100\n"),
    ),
    Entry(
        "CB210",
        "kind that the rest contradicts",
        "'kind' says '{said}', and the keys are those of a {found} ({keys}); write 'kind: {found}'",
        "Each kind of document has keys of its own. This one is checked as what its keys say.",
        "cbdsl: 1\nkind: stage\nname: example\nrobot: dexter\n"
        f"controllers:\n  track: {TRACK}\nactions: [track]\n",
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB211",
        "key of an older document",
        "the key '{old}' was renamed; write '{new}'",
        "The meaning is the same under the new name. The old one is no longer read.",
        _requiring("given"),
        good=_requiring("requires"),
    ),
)
