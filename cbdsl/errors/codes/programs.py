"""CB6nn: programs, their parts, and policies."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, SEARCH, TRACK, program
from cbdsl.errors.entry import Entry

_TWO = f"{HEAD}controllers:\n  search: {SEARCH}\n  track: {TRACK}\n"
_SMALL_ROBOT = (
    "cbdsl: 1\nkind: robot\nname: other\nmodel: other.urdf\nbase: base\neffectors: {}\n"
    "control: {rate: 120 Hz, tasks: {}}\n"
)
_OTHER_STAGE = "cbdsl: 1\nkind: stage\nname: other\nrobot: other\ncontexts: {always: {}}\n"
_MODEL = (
    "cbdsl: 1\nkind: model\nname: example\nrobot: dexter\neffector: head\n"
    "density: {form: gaussian, mean: [0.1, 1], deviation: [0.3, 0.2]}\n"
)
_MODELS = {"knowledge/models/window.yaml": _MODEL.replace("example", "window")}
_LOOKING = program("actions: [track]\npolicy: {X: track}\n").replace("example", "looking")
_LOOKING_FOR = {
    "programs/looking.yaml": _LOOKING.replace("motion", "$feature")
    + "parameters: {feature: motion}\n"
}
_USING_IT = program(
    "use: {looking: {program: looking, with: {feature: hue_4}}}\nactions: [track, looking]\n"
)
_STEPS = {
    f"programs/step_{n}.yaml": program(
        f"use: {{next: {{program: step_{n + 1}}}}}\nactions: [track, next]\npolicy: {{XX: next}}\n"
    ).replace("example", f"step_{n}")
    for n in range(1, 70)
} | {"programs/step_70.yaml": _LOOKING.replace("looking", "step_70")}

PROGRAMS = (
    Entry(
        "CB601",
        "unknown robot",
        "there is no robot '{name}'{hint}",
        "A robot is `robots/<name>.yaml`, next to this document, here, or shipped.",
        program("actions: [track]\n", head=HEAD.replace("dexter", "dextre")),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB602",
        "unknown stage",
        "there is no stage '{name}'{hint}",
        "A stage is `programs/stages/<name>.yaml`, next to this document, here, or shipped.",
        program("stage: tabel\nactions: [track]\n"),
        good=program("stage: table_right\nactions: [track]\n"),
    ),
    Entry(
        "CB603",
        "document for another robot",
        "'{name}' is for robot '{other}', and this is for '{robot}'{hint}",
        "Resources, joints and places differ from robot to robot.",
        program("stage: other\nactions: [track]\n"),
        beside={"programs/stages/other.yaml": _OTHER_STAGE, "robots/other.yaml": _SMALL_ROBOT},
        good=program("stage: absent\nactions: [track]\n"),
    ),
    Entry(
        "CB604",
        "unknown program",
        "there is no program '{name}'{hint}",
        "A program is `programs/<name>.yaml`, next to this document, here, or shipped.",
        program("use: {looking: {program: loking}}\nactions: [track, looking]\n"),
        beside={"programs/looking.yaml": _LOOKING},
        good=program("use: {looking: {program: looking}}\nactions: [track, looking]\n"),
    ),
    Entry(
        "CB605",
        "program that uses itself",
        "'{name}' uses itself: {cycle}",
        "Running it would never begin.",
        program("use: {again: {program: example}}\nactions: [track, again]\n"),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB606",
        "value for an unknown parameter",
        "program '{program}' has no parameter '{name}'",
        "`with` gives values to parameters that the used program declares.",
        program(
            "use: {looking: {program: looking, with: {feture: hue_4}}}\nactions: [track, looking]\n"
        ),
        beside=_LOOKING_FOR,
        good=_USING_IT,
    ),
    Entry(
        "CB607",
        "action written twice",
        "the action '{name}' is already there",
        "A policy could not tell them apart.",
        program("actions: [track, track]\n"),
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB608",
        "controller that is no action by itself",
        "'{name}' occurs in compositions, but is no action by itself, so no state shows it; "
        "name it in 'actions', too",
        "A state has one predicate per action that is not a composition. Without one for this "
        "controller no policy could tell whether it has converged.",
        _TWO + "actions: [track, search ◁ track]\n",
        good=_TWO + "actions: [search, track, search ◁ track]\n",
    ),
    Entry(
        "CB609",
        "value that a used program cannot run with",
        "program '{program}' cannot run with this value of '{name}': {problem}",
        "With its own values of its parameters the used program has no faults; it has one with the "
        "values that `with` gives it.",
        program(
            "use: {looking: {program: looking, with: {feature: hue_44}}}\n"
            "actions: [track, looking]\n"
        ),
        beside=_LOOKING_FOR,
        good=_USING_IT,
    ),
    Entry(
        "CB610",
        "too many programs",
        "there are more than {depth} programs one within the other, or more than {bound} in all",
        "What one program uses, and what that uses in turn, counts with each set of parameters for "
        "itself. So many can neither be followed nor checked.",
        program("use: {next: {program: step_1}}\nactions: [track, next]\n"),
        beside=_STEPS,
        good=program("use: {next: {program: step_70}}\nactions: [track, next]\n"),
    ),
    Entry(
        "CB611",
        "state of the wrong length",
        "a state has {found} here, for {wanted} ({members})",
        "A state has one letter for each action that is not a composition, in their order.",
        program('actions: [track]\npolicy: {"X-": track}\n'),
        good=program("actions: [track]\npolicy: {X: track}\n"),
    ),
    Entry(
        "CB612",
        "letter that is no predicate",
        "'{letter}' is none of X, -, 0, 1 and *{meant}",
        "X: not activated; -: reference undefined; 0: transient; 1: quiescent (Eq 4.1); "
        "*: any of them.",
        program('actions: [track]\npolicy: {"2": track, X: track}\n'),
        good=program("actions: [track]\npolicy: {X: track}\n"),
    ),
    Entry(
        "CB613",
        "policy with an unknown action",
        "'{name}' is none of the actions",
        "A policy chooses from `actions`.",
        _TWO + 'actions: [search, track]\npolicy: {"**": search ◁ track}\n',
        good=_TWO + 'actions: [search, track, search ◁ track]\npolicy: {"**": search ◁ track}\n',
    ),
    Entry(
        "CB614",
        "states that contradict each other",
        "'{state}' and '{other}' both match {example}, equally closely, with different actions",
        "The pattern with the fewest `*` decides. Where two have equally many, add a pattern "
        "for the states that both match.",
        _TWO + 'actions: [search, track]\npolicy: {"1*": search, "*1": track, "**": track}\n',
        good=_TWO + "actions: [search, track]\n"
        'policy: {"1*": search, "*1": track, "11": track, "**": track}\n',
    ),
    Entry(
        "CB621",
        "policy for other predicates",
        "this policy is over {found}, and program '{program}' has {wanted}",
        "A policy fits a program whose states have the same predicates in the same order.",
        "cbdsl: 1\nkind: policy\nname: example\nprogram: looking\npredicates: [search]\n"
        'policy: {"*": track}\n',
        "knowledge/policies/example.yaml",
        {"programs/looking.yaml": _LOOKING},
        good="cbdsl: 1\nkind: policy\nname: example\nprogram: looking\npredicates: [track]\n"
        'policy: {"*": track}\n',
    ),
    Entry(
        "CB631",
        "model with the wrong number of angles",
        "{found} given, and '{name}' has {wanted}",
        "A model has one mean and one deviation, or one component of each sample and one "
        "bandwidth, for every joint of its effector.",
        _MODEL.replace("[0.3, 0.2]", "[0.3]"),
        "knowledge/models/example.yaml",
        good=_MODEL,
    ),
    Entry(
        "CB632",
        "unknown model",
        "there is no model '{name}'{hint}",
        "A model is `knowledge/models/<name>.yaml`, next to this document, here, or shipped.",
        program("models: {window: windw}\nactions: [track]\n"),
        beside=_MODELS,
        good=program("models: {window: window}\nactions: [track]\n"),
    ),
    Entry(
        "CB633",
        "model with the name of a resource",
        "robot '{robot}' has a resource '{name}' already",
        "A program names a model `<effector>.<name>`, next to the effector's postures.",
        program("models: {uniform: window}\nactions: [track]\n"),
        beside=_MODELS,
        good=program("models: {window: window}\nactions: [track]\n"),
    ),
)
