"""Held-out injections, with which explanations of ``cb why`` are judged once.

No program and no mechanism of them served the development. Comments state why an expert who sees
the recording would name the kind, where this is not obvious.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import MappingProxyType
from typing import Any

from injected_causes import Edits, Injection
from injected_faults import ChangedModel, WorldFault
from judged_faults import (
    DroppedFrames,
    HiddenFrom,
    Jam,
    Kick,
    LaterDistortion,
    Limp,
    NoisyLoads,
    NoisyRegions,
    ObjectForce,
    Pull,
    ShuffledTicks,
    SlippingEncoder,
    Tared,
    TiltingTable,
    TimedRemoval,
    TurnedCells,
    Unplugged,
    balloon,
    broken_loads,
    changed_joint,
    coarse,
    coarse_encoders,
    coarse_loads,
    crossed_fingers,
    displaced_body,
    distorted,
    each_region,
    flipped,
    glue,
    inverted_loads,
    magnet,
    mirrored,
    shaking,
    spongy,
    springy,
    squeezed,
    stateful,
    swapped_cameras,
    swapped_encoders,
    tether,
    viscous,
    zoomed,
)

from cbdsl.backends.simulated_backend import SimulatedBackend

_PANDA, _DEXTER = "panda", "dexter"
_TAKE, _PLACE, _SET, _STACK = "take_and_put_down", "pick_and_place", "set_on", "stack"
_GIVE, _TOUCH_TABLE, _ROUND, _FIND = "handover", "touch_table", "transport_hand", "searchtrack"
_BOTH, _PROBE = "bimanualgrab", "tactileprobe"
_REACH, _GRASP = "reachtouch", "grasp"
_BENCH_STACK, _BENCH_PAD, _BENCH = "cubes_to_stack", "cube_and_pad", "cube_on_bench"

_SEEN = "    reference: $eyes.$feature\n"
_WEAK = ("hold($hand, $hand.hold, $hand.shut)", "hold($hand, {}, $hand.shut)")
_DOWN = "    reference: [180 deg, 0 deg, 0 deg]\n"
_TABLE_DOWN = "  down: point_down($arm)\n"


def _weak(force: str) -> tuple[str, str]:
    return _WEAK[0], _WEAK[1].format(force)


# Fingers that the search stops before they are together.
_SHUT = ("until: $hand.shut", "until: 33 mm")
_NO_GRASP = (
    Injection(
        "no_grasp", _TAKE, {_REACH: [("until: $hand.shut", "until: 0.6 rad")]}, robot=_DEXTER
    ),
    Injection(
        "no_grasp",
        _STACK,
        {
            _REACH: [_SHUT],
            _GRASP: [_SHUT],
            _SET: [("$hand.hold, $hand.shut)", "$hand.hold, 33 mm)")],
        },
        robot=_PANDA,
    ),
)
_SLIP = (
    Injection("slip", _STACK, fault=partial(Pull, 30.0), robot=_PANDA),
    Injection("slip", _SET, {_SET: [_weak("0.3 N")]}, robot=_DEXTER),
    Injection(
        "slip",
        _PLACE,
        {
            "things_and_a_pad": [
                *3 * [("mass: 250 g,", "mass: 0.25 kg, friction: 0.04,")],
                ("mass: 300 g,", "mass: 0.3 kg, friction: 0.04,"),
            ]
        },
        robot=_DEXTER,
    ),
)
_TRANSLATION = (
    Injection(
        "translation",
        _TAKE,
        {_REACH: [(_SEEN, '    reference: "stereo.$feature + [16 cm, 0 cm, 0 cm]"\n')]},
        robot=_DEXTER,
    ),
    # The place above the goal is wrong, not that of the object.
    Injection(
        "translation",
        _STACK,
        {_SET: [("[0 cm, 0 cm, $above]", "[-9 cm, 0 cm, $above]")]},
        robot=_PANDA,
    ),
    Injection(
        "translation",
        _STACK,
        {_SET: [("[0 cm, 0 cm, $above]", "[0 cm, -12 cm, $above]")]},
        robot=_DEXTER,
    ),
)
_ROTATION = (
    Injection(
        "rotation",
        _TAKE,
        {_REACH: [(_DOWN, "    reference: [0 deg, 110 deg, 0 deg]\n")]},
        robot=_DEXTER,
    ),
    Injection(
        "rotation",
        _TOUCH_TABLE,
        {
            _TOUCH_TABLE: [
                (
                    _TABLE_DOWN,
                    "  down: {potential: spring, reference: [110 deg, 0 deg, 0 deg], feedback:"
                    " $arm.orientation, effector: $arm.orientation, free_axis: z}\n",
                )
            ]
        },
    ),
    # The left palm faces away from the other one.
    Injection(
        "rotation",
        _BOTH,
        {
            _BOTH: [
                ("face_left, face_right", "face_right"),
                ("◁ face_left ◁", "◁ turned ◁"),
                (
                    "controllers:\n",
                    "controllers:\n  turned: {potential: spring, reference: [0 deg, 90 deg, 0 deg],"
                    " feedback: left_arm.orientation, effector: left_arm.orientation}\n",
                ),
            ]
        },
    ),
)
_NO_ROTATION = (
    # Both palms stay as they were: they do not face each other.
    Injection(
        "no_rotation",
        _GIVE,
        {_GIVE: [("hold ◁ meet ◁ face_back ◁ face ◁ carry", "hold ◁ meet ◁ carry")]},
    ),
    Injection(
        "no_rotation",
        _BOTH,
        {
            _BOTH: [
                ("face_left, face_right, ", ""),
                (
                    "apart(50 cm) ◁ centre($feature) ◁ face_left ◁ face_right",
                    "apart(50 cm) ◁ centre($feature)",
                ),
            ]
        },
    ),
)
_WRONG_ORDER = (
    Injection(
        "wrong_order",
        _SET,
        {
            _SET: [
                ("  grasp: {then: lift, failed: fail}\n", ""),
                (
                    "  lift: {exits: [lift at rest: over], failed: fail}\n",
                    "  lift: {exits: [lift at rest: grasp], failed: fail}\n"
                    "  grasp: {then: over, failed: fail}\n",
                ),
            ]
        },
        robot=_PANDA,
    ),
    # The hand goes home before it lets go.
    Injection(
        "wrong_order",
        _STACK,
        {
            _STACK: [
                ("set_on: {then: release,", "set_on: {then: retreat,"),
                ("[release at rest: retreat]", "[release at rest: on_top]"),
                ("[home at rest: on_top]", "[home at rest: release]"),
            ]
        },
        robot=_PANDA,
    ),
    # The object is put down before it is lifted.
    Injection(
        "wrong_order",
        _TAKE,
        {
            _TAKE: [
                ("  XXX1: lift\n", "  XXX1: put_down\n"),
                ("  X1XX: put_down\n", ""),
                ("  XX0X: put_down\n", "  XX0X: put_down\n  XX1X: lift\n"),
                ("success: [XX1X]", "success: [X1XX]"),
                ('failure: ["-XXX", XX-X]', 'failure: ["-XXX", "XX-X"]'),
            ]
        },
        robot=_PANDA,
    ),
)
_GRASP_FEATURE = "{program: grasp, with: {feature: $feature,"
_WRONG_OBJECT = (
    # The hand takes the block on which the cube is to be set.
    Injection(
        "wrong_object",
        _SET,
        {_SET: [(_GRASP_FEATURE, _GRASP_FEATURE.replace("$feature", "$goal"))]},
        robot=_PANDA,
    ),
    # A blue cube stands beside the red one, and the hand takes it.
    Injection(
        "wrong_object",
        _PLACE,
        {
            _PLACE: [(_GRASP_FEATURE, _GRASP_FEATURE.replace("$feature", "blue"))],
            _BENCH_PAD: [
                (
                    "contexts:\n",
                    "  decoy: {form: {shape: box, size: [0.58 span, 0.58 span, 0.58 span]},"
                    " mass: 100 g, color: [0, 0.4, 1]}\n\ncontexts:\n",
                ),
                (
                    "    placed:\n",
                    "    placed:\n      decoy:\n        things: [decoy]\n        place:"
                    " {on: bench, x: [bench.x - 0.05 reach, bench.x + 0.05 reach],"
                    " y: [bench.y - 0.3 reach, bench.y - 0.24 reach]}\n",
                ),
            ],
        },
        robot=_PANDA,
    ),
)
_NEVER_SEEN = (
    # The goal is as grey as a stone.
    Injection(
        "never_seen",
        _SET,
        {_BENCH_STACK: [("color: [0, 0.4, 1]", "color: [0.4, 0.4, 0.4]")]},
        robot=_PANDA,
    ),
    Injection(
        "never_seen", _ROUND, {"wall_right": [("color: [1, 0, 0]", "color: [0.7, 0.7, 0.7]")]}
    ),
)
_LOST = (
    # The object flies off the bench.
    Injection("lost", _TAKE, fault=partial(Kick, 2.0, [0.0, -5.0, 2.0]), robot=_PANDA),
    # The goal is taken away while the object is fetched.
    Injection("lost", _STACK, fault=partial(TimedRemoval, 4.0, "base"), robot=_DEXTER),
    Injection("lost", _PLACE, fault=partial(Kick, 2.0, [3.0, -1.0, 2.5]), robot=_DEXTER),
)
_OCCLUDED = (
    # One camera alone does not see the goal.
    Injection("occluded", _SET, fault=distorted(HiddenFrom("left", "blue")), robot=_DEXTER),
    # A board stands before one camera.
    Injection(
        "occluded",
        _STACK,
        {
            _BENCH_STACK: [
                (
                    "fixtures:\n",
                    "fixtures:\n  board:\n    form: {shape: box, size: [2 cm, 40 cm, 40 cm]}\n"
                    "    position: [115 cm, 20 cm, 66 cm]\n    color: [0.3, 0.3, 0.3]\n",
                )
            ]
        },
        robot=_PANDA,
    ),
    Injection("occluded", _PLACE, fault=distorted(HiddenFrom("right", "red")), robot=_PANDA),
)
_FAR_TABLE = [
    ("size: [60 cm, 120 cm, 4 cm]", "size: [160 cm, 120 cm, 4 cm]"),
    ("position: [60 cm, 0 cm, -44 cm]", "position: [110 cm, 0 cm, -44 cm]"),
]
_OUT_OF_REACH = (
    Injection(
        "out_of_reach",
        _TAKE,
        {"table_right": [*_FAR_TABLE, ("x: [35 cm, 75 cm]", "x: [125 cm, 140 cm]")]},
        robot=_DEXTER,
    ),
    Injection("out_of_reach", "press_and_slide", {"press_and_slide": [("x: 45 cm", "x: 125 cm")]}),
    Injection("out_of_reach", "poise", {"poise": [('"5 cm"', '"140 cm"')]}, robot="sixaxis"),
)
_HELD = (
    # The posture of the whole arm has priority over its way to the table.
    Injection(
        "held",
        _TOUCH_TABLE,
        {
            _TOUCH_TABLE: [
                (
                    _TABLE_DOWN,
                    "  down: {potential: spring, reference: $arm.ready, feedback: $arm,"
                    " effector: $arm}\n",
                ),
                ("moving: [point_down, ready]", "moving: [ready]"),
            ]
        },
    ),
    # The arm keeps its posture on the way to the goal.
    Injection(
        "held",
        _SET,
        {
            _SET: [
                ("  over: {then: press,", "  over: {do: over ◁ still, then: press,"),
                (
                    "controllers:\n",
                    "controllers:\n  still: {potential: spring, reference: here, feedback: $arm,"
                    " effector: $arm}\n",
                ),
            ]
        },
        robot=_PANDA,
    ),
)
_NO_ACTION = (
    Injection("no_action", _TAKE, {_TAKE: [("  XXX1: lift\n", "")]}, robot=_PANDA),
    Injection("no_action", _PLACE, {_PLACE: [("  1XX: transport ◁ place\n", "")]}, robot=_DEXTER),
    Injection("no_action", _TAKE, {"put_down": [("  XX1X: retreat\n", "")]}, robot=_DEXTER),
)
_TIME = (
    Injection(
        "time",
        _STACK,
        {_STACK: [("transition_time: 10 s", "transition_time: 0.7 s")]},
        robot=_PANDA,
    ),
    # The way to the goal would take longer than the program allows.
    Injection(
        "time", _PLACE, {_PLACE: [("    speed: 4 cm/s\n", "    speed: 4 mm/s\n")]}, robot=_PANDA
    ),
)
_NOT_FOLLOWED = (
    Injection("not_followed", _TAKE, fault=partial(Jam, 2.5, "panda_joint2"), robot=_PANDA),
    Injection("not_followed", _SET, fault=partial(Jam, 2.0, "right_arm_2"), robot=_DEXTER),
    Injection("not_followed", _STACK, fault=partial(Limp, 8.0, "panda_joint6"), robot=_PANDA),
)
_BACKEND = (
    Injection("backend", _SET, fault=partial(Unplugged, 6.0), robot=_PANDA),
    Injection("backend", _TAKE, fault=partial(LaterDistortion, 4.0, broken_loads), robot=_DEXTER),
)
_GUARD = (
    Injection(
        "guard",
        _TOUCH_TABLE,
        {_TOUCH_TABLE: [("limits: {", "guards: {hand_force: 0.6 N}\nlimits: {")]},
    ),
    Injection(
        "guard",
        _SET,
        {_SET: [("limits: {", "guards: {finger_force: 1.2 N}\nlimits: {")]},
        robot=_PANDA,
    ),
)
_CYCLE = (
    Injection(
        "cycle",
        _STACK,
        {_STACK: [("[home at rest: on_top]", "[home at rest: retreat]")]},
        robot=_PANDA,
    ),
    Injection(
        "cycle", _SET, {_SET: [("press at rest: succeed", "press at rest: over")]}, robot=_PANDA
    ),
    Injection("cycle", _ROUND, {_ROUND: [("  1*: move\n", "  1*: searchtrack\n")]}),
)

LISTED = (
    *_NO_GRASP, *_SLIP, *_TRANSLATION, *_ROTATION, *_NO_ROTATION, *_WRONG_ORDER, *_WRONG_OBJECT,
    *_NEVER_SEEN, *_HELD, *_NO_ACTION, *_TIME, *_BACKEND, *_GUARD, *_CYCLE,
    *_NOT_FOLLOWED, *_OUT_OF_REACH, *_LOST, *_OCCLUDED,
)  # fmt: skip


def _unlisted(
    name: str,
    program: str,
    robot: str,
    fault: Callable[[SimulatedBackend[Any]], WorldFault] | None = None,
    edits: Edits = MappingProxyType({}),
) -> Injection:
    """Return an injection of a cause that is not on the list of ``cb why``."""
    return Injection("", program, edits, fault, name=name, robot=robot)


UNLISTED = (
    _unlisted("swapped cameras", _TAKE, _PANDA, distorted(swapped_cameras)),
    _unlisted("mirrored images", _TAKE, _PANDA, distorted(each_region(mirrored))),
    _unlisted("image upside down", _SET, _PANDA, distorted(each_region(flipped, "left"))),
    _unlisted("wrong focal length", _STACK, _PANDA, distorted(each_region(partial(zoomed, 1.3)))),
    _unlisted("wrong pixel aspect", _PLACE, _PANDA, distorted(each_region(squeezed))),
    _unlisted("coarse images", _TAKE, _DEXTER, distorted(each_region(coarse))),
    _unlisted("noisy images", _SET, _DEXTER, stateful(NoisyRegions, 12.0)),
    _unlisted("dropped frames", _TAKE, _DEXTER, stateful(DroppedFrames, 60)),
    _unlisted("inverted loads", _SET, _PANDA, distorted(inverted_loads)),
    _unlisted("crossed fingers", _SET, _DEXTER, distorted(crossed_fingers)),
    _unlisted("turned load cells", _TAKE, _PANDA, stateful(TurnedCells)),
    _unlisted("tared under load", _STACK, _DEXTER, stateful(Tared, [0, 0, 4.0, 0, 0, 0], 0.5)),
    _unlisted("noisy loads", _TAKE, _PANDA, stateful(NoisyLoads, 1.5)),
    _unlisted("coarse loads", _SET, _DEXTER, distorted(coarse_loads)),
    _unlisted("inverted encoder", _TAKE, _PANDA, distorted(changed_joint(2, lambda q: -q - 0.2))),
    _unlisted("coarse encoders", _STACK, _PANDA, distorted(coarse_encoders)),
    _unlisted("swapped encoders", _SET, _PANDA, distorted(swapped_encoders(0, 4))),
    _unlisted("slipping encoder", _PLACE, _PANDA, stateful(SlippingEncoder, 1, 0.8)),
    _unlisted("shuffled readings", _TAKE, _DEXTER, stateful(ShuffledTicks, 15)),
    _unlisted("long tool", _TAKE, _PANDA, displaced_body("panda_hand", [0.0, 0.0, 0.05])),
    _unlisted("long forearm", _SET, _PANDA, displaced_body("panda_link5", [0.0, 0.06, 0.0])),
    _unlisted("shifted base", _PLACE, _PANDA, displaced_body("panda_link1", [0.0, 0.07, 0.0])),
    _unlisted("bouncing contacts", _STACK, _DEXTER, partial(ChangedModel, springy)),
    _unlisted("soft contacts", _TAKE, _PANDA, partial(ChangedModel, spongy)),
    _unlisted("syrup", _STACK, _PANDA, partial(ChangedModel, viscous)),
    _unlisted("glue", _SET, _PANDA, partial(ObjectForce, glue)),
    _unlisted("magnet", _STACK, _PANDA, partial(ObjectForce, magnet)),
    _unlisted("tether", _STACK, _DEXTER, partial(ObjectForce, tether)),
    _unlisted("shaking", _TAKE, _PANDA, partial(ObjectForce, shaking)),
    _unlisted("balloon", _TAKE, _PANDA, partial(ObjectForce, balloon)),
    _unlisted("tilting table", _STACK, _PANDA, partial(TiltingTable, 0.06)),
)

#: Injections into programs that were not used for the development.
JUDGED = (*LISTED, *UNLISTED)
