"""CB4nn: compositions, calls and parameters."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, SEARCH, TRACK, controller, program
from cbdsl.errors.entry import Entry

_TWO = f"{HEAD}controllers:\n  search: {SEARCH}\n  track: {TRACK}\n"

COMPOSITIONS = (
    Entry(
        "CB401",
        "not a composition",
        "this is no composition: {problem}",
        "A composition is `c2 ◁ c1`, read 'c2 subject to c1': the rightmost controller has "
        "priority. `<|` is accepted for `◁`. A controller with parameters is called with "
        "arguments, as in `reach(sat_10, right_arm)`.",
        program("actions: [track, track ◁ ]\n"),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB402",
        "unknown parameter",
        "there is no parameter '{name}'{hint}",
        "`$name` stands for the value of a parameter of the program or of the controller.",
        controller("potential: spring, reference: 0, feedback: cyclopean.$feature, effector: head"),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
        ),
    ),
    Entry(
        "CB403",
        "wrong number of arguments",
        "'{name}' takes {wanted}, and {found} given",
        "A call binds each of a controller's `parameters` in order. Programs and compositions "
        "take none; a program's parameters are set under `use`.",
        program("actions: [track(motion)]\n"),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB404",
        "unknown controller or program",
        "there is no controller or program '{name}'",
        "A composition names entries of `controllers`; an action can also be an entry of `use`.",
        program("actions: [trak]\n"),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB405",
        "controller made of itself",
        "'{name}' is made of itself: {cycle}",
        "A composition that contains itself never ends.",
        _TWO + "  look: search ◁ watch\n  watch: look ◁ track\nactions: [watch, search, track]\n",
        good=_TWO + "  watch: search ◁ track\nactions: [watch, search, track]\n",
    ),
    Entry(
        "CB406",
        "program in a composition",
        "'{name}' is a program, and a program cannot be composed",
        "A program chooses its own actions over time, so it has no single control law whose "
        "nullspace a controller could use. Make it an action by itself.",
        program("actions: [track, looking, track ◁ looking]\nuse: {looking: {program: looking}}\n"),
        beside={
            "programs/looking.yaml": program("actions: [track]\npolicy: {X: track}\n").replace(
                "example", "looking"
            )
        },
        good=program("actions: [track, looking]\nuse: {looking: {program: looking}}\n"),
    ),
    Entry(
        "CB407",
        "controller twice in a composition",
        "'{name}' occurs twice in this composition",
        "The second occurrence has nothing left to do in the nullspace of the first.",
        _TWO + "actions: [search, track, track ◁ search ◁ track]\n",
        good=_TWO + "actions: [search, track, search ◁ track]\n",
    ),
    Entry(
        "CB408",
        "sign that looks like the operator",
        "'{sign}' is not the operator: {suggestion}",
        "The operator is `◁` (U+25C1), or `<|` in ASCII. What points the other way has to be "
        "turned round: the controller with priority is written last.",
        _TWO + "actions: [search, track, search ⊲ track]\n",
        good=_TWO + "actions: [search, track, search ◁ track]\n",
    ),
    Entry(
        "CB409",
        "value that is too long",
        "with its parameters replaced, this has more than {bound} characters",
        "Nothing has a name of that length. Programs that pass on their values twice to others, "
        "which do the same, would never end.",
        controller(
            "potential: spring, reference: 0, feedback: cyclopean.$feature, effector: head"
        ).replace("actions", f"parameters: {{feature: {'hue_1' * 220}}}\nactions"),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.hue_1, effector: head"
        ),
    ),
)
