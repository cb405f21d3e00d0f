"""CB7nn: warnings about what has no effect."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, SEARCH, TRACK, controller, program, stage
from cbdsl.errors.diagnostic import Severity
from cbdsl.errors.entry import Entry

_ALWAYS = stage("  always: {things: [ball], place: {z: 0}}\n")
_LOOK = "potential: spring, reference: 0, feedback: cyclopean.$feature, effector: head"
_LOOKING = program("actions: [track]\n").replace("example", "looking")
_POLICY = "policy: {X: track}\n"
_STAY = (
    f"{HEAD}controllers:\n  search: {SEARCH}\n"
    "  stay: {potential: spring, reference: head.ahead, feedback: head, effector: head}\n"
)
_TOUCH = (
    f"{HEAD}controllers:\n  reach: {{potential: spring, reference: stereo.motion, "
    "feedback: right_arm.position, effector: right_arm}\n"
    "  touch: {potential: spring, reference: 1 N along normals, "
    "feedback: right_hand.finger_forces, effector: right_hand, seek: SEEK}\n"
)
_LIGHT = (
    "potential: spring, reference: 0, feedback: right_hand.finger_1.force, effector: right_hand"
)
_PLACE = "potential: spring, feedback: right_arm.position, effector: right_arm"
_FACE = "potential: spring, feedback: right_arm.orientation, effector: right_arm"
_QUIESCENCE = ", quiescence: {{rate: 1e-3, window: {}}}"

UNUSED = (
    Entry(
        "CB701",
        "unused controller or program",
        "'{name}' is never used",
        "No action and no background runs it.",
        f"{HEAD}controllers:\n  search: {SEARCH}\n  track: {TRACK}\nactions: [track]\n",
        severity=Severity.WARNING,
        good=f"{HEAD}controllers:\n  search: {SEARCH}\n  track: {TRACK}\n"
        "actions: [search, track]\n",
    ),
    Entry(
        "CB702",
        "unused parameter",
        "the parameter '{name}' is never used",
        "Setting it would change nothing.",
        program("parameters: {feature: motion}\nactions: [track]\n"),
        severity=Severity.WARNING,
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB703",
        "name with two meanings",
        "'{name}' hides the {other} of the same name",
        "The nearer meaning wins, which is easily misread.",
        f"{HEAD}parameters: {{feature: motion}}\ncontrollers:\n"
        f"  watch: {{parameters: [feature], {_LOOK}}}\n  look: {{{_LOOK}}}\n"
        "actions: [watch(motion), look]\n",
        severity=Severity.WARNING,
        good=f"{HEAD}parameters: {{feature: motion}}\ncontrollers:\n"
        f"  watch: {{parameters: [channel], {_LOOK.replace('feature', 'channel')}}}\n"
        f"  look: {{{_LOOK}}}\nactions: [watch(motion), look]\n",
    ),
    Entry(
        "CB704",
        "name that differs from the file's",
        "the document is named '{name}', and its file '{file}'",
        "Other documents find this one by the name of its file, and what is recorded tells its "
        "own name.",
        program("actions: [track]\n", head=HEAD.replace("example", "sample")),
        severity=Severity.WARNING,
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB705",
        "program that does nothing",
        "program '{name}' has no policy, so as an action it ends at once",
        "A program that is run by itself can be given a policy document, or learn one. Used as an "
        "action, it follows the policy of its own document, or the one that `use` gives it.",
        program("use: {looking: {program: looking}}\nactions: [track, looking]\n"),
        beside={
            "programs/looking.yaml": _LOOKING,
            "programs/peering.yaml": _LOOKING.replace("looking", "peering") + _POLICY,
        },
        severity=Severity.WARNING,
        good=program("use: {looking: {program: peering}}\nactions: [track, looking]\n"),
    ),
    Entry(
        "CB706",
        "policy that does not begin",
        "no state of this policy is {state}, in which the program starts",
        "Nothing has run yet when a program starts, so that all predicates are X. Where the policy "
        "has no action, the program ends.",
        program('actions: [track]\npolicy: {"0": track}\n'),
        severity=Severity.WARNING,
        good=program('actions: [track]\npolicy: {"0": track, X: track}\n'),
    ),
    Entry(
        "CB707",
        "state that never decides",
        "'{state}' never decides: states with fewer '*' match whatever it matches",
        "The pattern with the fewest `*` decides.",
        program(
            'actions: [track]\npolicy: {"*": track, X: track, "-": track, "0": track, "1": track}\n'
        ),
        severity=Severity.WARNING,
        good=program('actions: [track]\npolicy: {"*": track, X: track}\n'),
    ),
    Entry(
        "CB708",
        "reference that is the feedback",
        "the reference '{name}' is what the feedback is, so they never differ",
        "A controller brings its feedback to its reference.",
        controller("potential: spring, reference: head, feedback: head, effector: head"),
        severity=Severity.WARNING,
        good=controller("potential: spring, reference: head.ahead, feedback: head, effector: head"),
    ),
    Entry(
        "CB709",
        "controller to which nothing is left",
        "'{above}' always fixes all joints of {names_below}, and has priority",
        "A controller moves what those with priority, further to the right, leave free. A posture "
        "leaves none of its joints free, at any time.",
        f"{_STAY}actions: [search, stay, search ◁ stay]\npolicy: {{'**': search ◁ stay}}\n",
        severity=Severity.WARNING,
        good=f"{_STAY}actions: [search, stay]\npolicy: {{'**': stay, '*1': search}}\n",
    ),
    Entry(
        "CB710",
        "controller that waits for itself",
        "'{name}' waits for itself, and so for ever",
        "`seek.once` names the controller that has to come near its reference before this one acts "
        "without feedback, `requires` the one without which it does not act at all.",
        f"{_TOUCH.replace('SEEK', '{once: touch}')}actions: [reach, touch]\n",
        severity=Severity.WARNING,
        good=f"{_TOUCH.replace('SEEK', '{once: reach}')}actions: [reach, touch]\n",
    ),
    Entry(
        "CB711",
        "reward that cannot be earned",
        "'{name}' is rewarded within a share of its reference, and that is 0",
        "`quiescence.within` is a share of the reference's norm: for a reference of 0 give a "
        "`tolerance` instead.",
        controller(_LIGHT + ", quiescence: {rate: 0.5, window: 0.25 s, within: 0.5}"),
        severity=Severity.WARNING,
        good=controller(_LIGHT + ", quiescence: {rate: 0.5, window: 0.25 s, tolerance: 0.2 N}"),
    ),
    Entry(
        "CB712",
        "gain that no tick can use",
        "a gain of {gain}/s is taken for {most}/s, which leads to the reference in one tick at "
        "{rate} Hz",
        "In each tick a controller takes its gain times the period of a Newton step, which is half "
        "the error: more than two steps a tick would go past the reference, and are not taken.",
        controller(_LOOK.replace("$feature", "motion") + ", gain: 200 /s"),
        severity=Severity.WARNING,
        good=controller(_LOOK.replace("$feature", "motion") + ", gain: 20 /s"),
    ),
    Entry(
        "CB713",
        "window without a motion in it",
        "there are less than two {what} in {window} s; at least {least} s are needed",
        "A controller is at rest when its potential has hardly changed over the window, which "
        "takes two measurements: ticks of the control, or images of what is seen.",
        controller(_LOOK.replace("$feature", "motion") + _QUIESCENCE.format("0.1 s")),
        severity=Severity.WARNING,
        good=controller(_LOOK.replace("$feature", "motion") + _QUIESCENCE.format("0.2 s")),
    ),
    Entry(
        "CB714",
        "controller that has no time to come to rest",
        "'{name}' is watched for {window} s before it is at rest, and an action ends after "
        "{longest} s",
        "`limits.transition_time` ends an action in which no predicate changes.",
        program("actions: [track]\nlimits: {transition_time: 0.1 s}\n"),
        severity=Severity.WARNING,
        good=program("actions: [track]\nlimits: {transition_time: 10 s}\n"),
    ),
    Entry(
        "CB715",
        "thing that is never shown",
        "no context shows the thing '{name}'",
        "Each context lists under `things` what it draws from.",
        stage("  always: {things: []}\n"),
        "programs/stages/example.yaml",
        severity=Severity.WARNING,
        good=stage("  always: {things: [ball], place: {z: 0}}\n"),
    ),
    Entry(
        "CB716",
        "background that is an action",
        "'{name}' runs below every action already, and is an action itself",
        "The background uses what freedom an action leaves. Chosen as an action it changes nothing "
        "but the state.",
        program("background: track\nactions: [track]\n"),
        severity=Severity.WARNING,
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB717",
        "state that cannot occur",
        "no state has '-' for '{name}': what that reads is known at any time",
        "A predicate is '-' while the reference or the feedback is undefined. Joint angles, the "
        "kinematics of a tip, postures and draws are always there; what is seen or felt is not.",
        program('actions: [track]\npolicy: {X: track, "-": track, "0": track}\n', track=SEARCH),
        severity=Severity.WARNING,
        good=program('actions: [track]\npolicy: {X: track, "0": track}\n', track=SEARCH),
    ),
    Entry(
        "CB718",
        "reference out of reach",
        "this is {distance} m away, and '{name}' never gets farther than {farthest} m",
        "The links of the robot's model, stretched out, are not that long. A number without a unit "
        "is in metres: write `50 cm` for half a metre.",
        controller(f"{_PLACE}, reference: [50, -10, 20]"),
        severity=Severity.WARNING,
        good=controller(f"{_PLACE}, reference: [50 cm, -10 cm, 20 cm]"),
    ),
    Entry(
        "CB719",
        "angle of more than a turn",
        "{angle} rad is more than a whole turn; an angle in degrees is written '{angle} deg'",
        "A number without a unit is in radians. Orientations and headings repeat themselves after "
        "a turn.",
        controller(f"{_FACE}, reference: [180, 0, 0]"),
        severity=Severity.WARNING,
        good=controller(f"{_FACE}, reference: [180 deg, 0 deg, 0 deg]"),
    ),
    Entry(
        "CB720",
        "program that nothing rewards",
        "program '{name}' cannot be rewarded, so that nothing can be learned of it: {why}",
        "A reward is earned when a controller whose feedback comes from the environment, a heading "
        "or a force, newly comes to rest (Eq 4.2 to 4.4). It has to be an action by itself: what "
        "is composed into one controller, and what a used program does, is rewarded elsewhere. "
        "`cb learn` tells before it begins; a program that is only run needs no reward.",
        program("actions: [track]\n", track=SEARCH),
        severity=Severity.WARNING,
        good=program("actions: [track]\n"),
    ),
    Entry(
        "CB721",
        "thing too large for its robot",
        "'{name}' is {width} m wide at least, and no tip of '{robot}' gets farther than "
        "{farthest} m",
        "No robot handles what is wider, whichever way it is turned, than its links are long. A "
        "number without a unit is in metres: write `4 cm`.",
        _ALWAYS.replace("radius: 4 cm", "radius: 4"),
        "programs/stages/example.yaml",
        severity=Severity.WARNING,
        good=_ALWAYS,
    ),
)
