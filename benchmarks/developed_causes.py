"""Injected causes with which the explanations of ``cb why`` were developed."""

from __future__ import annotations

from functools import partial

from injected_causes import Injection, late, noisy, unlisted
from injected_faults import (
    ChangedModel,
    Distortion,
    Drift,
    FrozenJoint,
    Halt,
    InjectedSlip,
    LateCommands,
    OneEye,
    Removal,
    StaleImages,
    Wind,
    cropped_loads,
    drifting_loads,
    heavy_world,
    offset_joint,
    rolled_camera,
    scaled_joint,
    scaled_loads,
    shifted_rows,
    sideways_world,
    stuck_fingers,
    tough_joint,
    weak_drives,
)

_PICK, _TOUCH, _PANDA = "pick_and_lift", "reachtouch", "pick"
_STAGE = "cube_on_bench"
_STEPS = (
    "  reachtouch: {then: ease, failed: back_off}\n  ease: {then: grip}\n"
    "  grip: {exits: [grip at rest: lift], failed: back_off}\n"
)
_SWAPPED = (
    "  grip: {exits: [grip at rest: ease], failed: back_off}\n  ease: {then: reachtouch}\n"
    "  reachtouch: {then: lift, failed: back_off}\n"
)
_RETRY, _AGAIN = "[back_off at rest: reachtouch]", "[back_off at rest: grip]"
_SEEN = "    reference: $eyes.$feature\n"
_OFF = '    reference: "stereo.$feature + [0 cm, {} cm, 0 cm]"\n'
_DOWN = "    reference: [180 deg, 0 deg, 0 deg]\n"
_TILTED = "    reference: [130 deg, 0 deg, 0 deg]\n"
# A taller block close beside the cube, on which fingers close as well.
_GRASP, _TABLE, _SIDE = "grasp", "things_on_table", "take_from_side"
_BLOCK = "  block: {form: {shape: box, size: [8 cm, 8 cm, 13 cm]}, mass: 2 kg, color: [0, 0, 1]}\n"
_BESIDE = (
    "  cube:\n    joints: {pan: [-0.65 rad, -0.25 rad], tilt: 1 rad}\n    placed:\n"
    "      cube: {things: [cube], place: {on: table, x: [45 cm, 60 cm], y: [-30 cm, -15 cm]}}\n"
    "      block: {things: [block], place: {beside: {name: cube, by: 9 cm}}}\n"
)
_APPROACH, _SIZE = (
    "    effector: $arm.position\n",
    "size: [0.58 span, 0.58 span, 0.58 span]",
)
_TOP = "  reach: posture ◁ orient ◁ approach\n"
_SHORT = ("episode_time: 90 s", "episode_time: 30 s")
# A post on the way of the fingers.
_POST = (
    (
        "contexts:\n",
        "  post: {form: {shape: box, size: [4 cm, 4 cm, 18 cm]}, mass: 3 kg, color: [0, 0, 0.5]}\n"
        "contexts:\n",
    ),
    (
        "    things: [ball]\n    place: &half_of_table {on: table, x: [40 cm, 70 cm],"
        " y: [-38 cm, -6 cm], yaw: [-90 deg, 90 deg]}\n    joints: &looking",
        "    placed:\n      ball:\n        things: [ball]\n"
        "        place: &half_of_table {on: table, x: [45 cm, 60 cm], y: [-30 cm, -15 cm]}\n"
        "      post: {things: [post], place: {beside: {name: ball, by: 9 cm}}}\n"
        "    joints: &looking",
    ),
)
_ONLY = tuple(
    (f"  {name}: {{things: [{name}], place: *half_of_table, joints: *looking}}\n", "")
    for name in ("cube", "cylinder", "light_box")
)
_ACROSS = "    reference: [100 deg, 0 deg, 0 deg]\n"
_WIDE = "size: [0.58 span, 0.58 span, 0.9 span]"
_ALONG = "    reference: stereo.$feature.on.$goal.beside.$arm\n"
_LEVEL = "    reference: [-90 deg, 0 deg, 0 deg]\n"
_BETWEEN = "    potential: spring\n    reference: stereo.$feature\n    feedback: $hand.centre\n"
_ASIDE = _BETWEEN.replace("stereo.$feature", '"stereo.$feature + [0 cm, 12 cm, 0 cm]"')
# A block as high as the cube, close to it, in the color of nothing sought.
_CLOSE = (
    (
        "contexts:\n",
        "  block: {form: {shape: box, size: [0.5 span, 0.5 span, 1.2 span]}, mass: 2 kg,"
        " color: [0, 0, 1]}\ncontexts:\n",
    ),
    (
        "    things: [cube]\n    place:\n      on: bench\n",
        "    placed:\n      block: {things: [block], place: {beside: {name: cube, by: 6 cm}}}\n"
        "      cube:\n        things: [cube]\n        place:\n          on: bench\n",
    ),
    *(
        (f"\n      {key}: [{value}", f"\n          {key}: [{value}")
        for key, value in (("x", "bench.x"), ("y", "bench.y"), ("yaw", "-45"))
    ),
)
_BELOW = "  reach: orient ◁ approach ◁ posture\n"

# Programs that take from above, with both hands, between two fingers, and place.
_TAKE, _BOTH, _PINCH, _BRING = "take", "take_with_both", "pinch", "bring"
_PAD, _LARGE = "things_and_a_pad", "large_things"
_OVER, _ABOVE = '"stereo.$feature - [0 cm, 0 cm, 2 cm]"', "stereo.$feature.on.$goal.above"
_CLOSES_EARLY = (
    "touch($hand, 2 N)",
    "{potential: spring, reference: 2 N along normals, feedback: $hand.finger_forces,"
    " effector: $hand, seek: {until: 0.4 rad}, quiescence: {rate: 0.5, window: 0.6 s,"
    " within: 0.2}}",
)
_BOUND = ("reward_ends: false}", "reward_ends: false, episode_time: 30 s}")
_FACING = (
    ("face_left, face_right, squeeze", "face_left, squeeze"),
    (
        "  # The hands face each other, level with each other.\n",
        "  face_right: {potential: spring, reference: [180 deg, 0 deg, 0 deg],"
        " feedback: right_arm.orientation, effector: right_arm.orientation}\n",
    ),
)
_PLACED = '"stereo.$feature.on.$goal.placed + [0 cm, 0 cm, 6 cm]"'
_TURNED_PALM = (
    "  transport: level ◁ carry\n",
    "  over: {requires: hold, potential: spring, reference: [120 deg, 0 deg, 0 deg],"
    " feedback: $arm.orientation, effector: $arm.orientation, speed: 1 rad/s}\n"
    "  transport: over ◁ carry\n",
)

_SIZES = (
    "radius: [5 cm, 7 cm]",
    "size: [8 cm, 8 cm, 8 cm]",
    "radius: 4 cm, height: 12 cm",
    "size: [10 cm, 10 cm, 10 cm]",
)
_SMALL = tuple(
    zip(
        _SIZES,
        (
            "radius: 2.1 cm",
            "size: [4 cm, 4 cm, 4 cm]",
            "radius: 2 cm, height: 4 cm",
            "size: [3 cm, 3 cm, 3 cm]",
        ),
        strict=True,
    )
) + 3 * (("mass: 250 g", "mass: 40 g"),)
_HUGE = (
    *zip(
        _SIZES,
        (
            "radius: 12 cm",
            "size: [24 cm, 24 cm, 24 cm]",
            "radius: 12 cm, height: 22 cm",
            "size: [20 cm, 28 cm, 28 cm]",
        ),
        strict=True,
    ),
    ("by: [15 cm, 25 cm]", "by: [24 cm, 28 cm]"),
    ("[-20 cm, 4 cm]", "[0 cm, 14 cm]"),
)
_NO_OTHERS = (
    "  cube:\n    placed: {cube: {things: [cube], place: *right_of_it}}\n    joints:"
    " *looking\n  cylinder:\n    placed: {cylinder: {things: [cylinder], place:"
    " *right_of_it}}\n    joints: *looking\n  box:\n    placed: {box: {things: [box],"
    " place: *right_of_it}}\n    joints: *looking\n",
    "",
)
_MEET = "bimanualtouch"
_IDLE = ("idle_time: 1 s}", "idle_time: 1 s, episode_time: 30 s}")
_AROUND = "carry: carry_around($arm, hold, $feature, $goal"
_AWAY = (
    'carry: {requires: hold, potential: spring, reference: "stereo.$goal + [0 cm, 16 cm, 12 cm]",'
    " feedback: stereo.$feature, effector: $arm.position, speed: 12 cm/s,"
    " quiescence: {rate: 1e-2, window: 0.3 s, tolerance: 3 cm}}  #"
)

#: Injections with which explanations were developed.
DEVELOPED = (
    Injection("no_grasp", _PICK, {_TOUCH: [("2 cm, until: $hand.shut", "2 cm, until: 0.4 rad")]}),
    Injection("slip", _PICK, fault=InjectedSlip),
    Injection("translation", _PICK, {_TOUCH: [(_SEEN, _OFF.format(14))]}),
    Injection("rotation", _PICK, {_TOUCH: [(_DOWN, _TILTED)]}),
    Injection(
        "no_rotation",
        _PICK,
        {_TOUCH: [("posture ◁ orient ◁ approach", "posture ◁ approach")], _PICK: [_SHORT]},
    ),
    Injection("wrong_object", _PICK, {_TABLE: [*_POST, *_ONLY], _PICK: [_SHORT]}),
    Injection("wrong_order", _PICK, {_PICK: [(_STEPS, _SWAPPED), (_RETRY, _AGAIN)]}),
    Injection("never_seen", "reach", stage="absent"),
    Injection("lost", _PICK, fault=Removal),
    Injection("occluded", _PICK, fault=OneEye),
    Injection("out_of_reach", "reach", stage="out_of_reach"),
    Injection("no_action", _PICK, {_TOUCH: [("  X0*: reach ◁ touch\n", "")]}),
    Injection("time", _PICK, {_PICK: [("episode_time: 90 s", "episode_time: 4 s")]}),
    Injection("not_followed", _PICK, fault=FrozenJoint),
    Injection("backend", _PICK, fault=Halt),
    unlisted(
        "no rest",
        _PICK,
        {_TOUCH: [("rate: 5e-4, window: 0.5 s", "rate: 1e-15, window: 0.5 s")]},
    ),
    unlisted(
        "cameras off",
        _PICK,
        {_TABLE: [("contexts:\n", "disturbance: {camera_position: 6 cm}\ncontexts:\n")]},
    ),
    unlisted(
        "mass",
        _PICK,
        {_TABLE: [*3 * [("mass: 250 g", "mass: 8 kg")], ("mass: 80 g", "mass: 8 kg")]},
    ),
    unlisted("no loads", _PICK, fault=partial(Distortion, scaled_loads(0.0))),
    unlisted("small loads", _PICK, fault=partial(Distortion, scaled_loads(0.1))),
    unlisted("drifting loads", _PICK, fault=partial(Distortion, drifting_loads)),
    unlisted("encoder offset", _PICK, fault=partial(Distortion, offset_joint)),
    unlisted("shifted rows", _PICK, fault=partial(Distortion, shifted_rows)),
    unlisted("drift", _PICK, {_PICK: [_SHORT]}, Drift),
    unlisted("stale images", _PICK, fault=lambda backend: Distortion(StaleImages(), backend)),
    Injection("no_grasp", _PANDA, {_TOUCH: [("until: $hand.shut", "until: 30 mm")]}),
    Injection("slip", _PANDA, fault=InjectedSlip),
    Injection("slip", _PANDA, {_STAGE: [("mass: 100 g", "mass: 100 g, friction: 0.02")]}),
    Injection("translation", _PANDA, {_TOUCH: [(_SEEN, _OFF.format(12))]}),
    Injection("rotation", _PANDA, {_TOUCH: [(_DOWN, _TILTED)]}),
    Injection(
        "rotation",
        _SIDE,
        {_SIDE: [("    reference: stereo.$feature.on.$goal.beside.$arm\n", _DOWN)]},
    ),
    Injection(
        "no_rotation", _PANDA, {_TOUCH: [("posture ◁ orient ◁ approach", "posture ◁ approach")]}
    ),
    Injection(
        "no_rotation",
        _SIDE,
        {
            _SIDE: [
                ("◁ turn ◁ between", "◁ between"),
                ("approach ◁ turn ◁ aloft", "approach ◁ aloft"),
                ("approach at rest and turn at rest", "approach at rest"),
            ]
        },
    ),
    Injection(
        "wrong_object",
        _GRASP,
        {
            _TABLE: [
                ("contexts:\n", f"{_BLOCK}\ncontexts:\n{_BESIDE}"),
                ("  cube: {things: [cube], place: *half_of_table, joints: *looking}\n", ""),
            ]
        },
    ),
    Injection(
        "wrong_order",
        _PANDA,
        {
            _PANDA: [
                ("  grasp: {then: hold}\n", ""),
                ("retreat: {then: succeed}", "retreat: {then: grasp}\n  grasp: {then: succeed}"),
                ("hold undefined: grasp", "hold undefined: end"),
            ]
        },
    ),
    Injection("never_seen", _PANDA, {_STAGE: [("color: [1, 0, 0]", "color: [0.5, 0.5, 0.5]")]}),
    Injection("lost", _PANDA, fault=Removal),
    Injection("occluded", _PANDA, fault=OneEye),
    Injection(
        "out_of_reach",
        _PANDA,
        {
            _STAGE: [
                ("size: [0.6 reach,", "size: [1.3 reach,"),
                ("position: [bench.x,", "position: [bench.x + 0.45 reach,"),
                ("x: [bench.x - 0.08 reach, bench.x + 0.08 reach]", "x: [86 cm, 90 cm]"),
            ]
        },
    ),
    Injection("held", _PANDA, {_TOUCH: [(_TOP, _BELOW)]}),
    Injection("no_action", _PANDA, {_TOUCH: [("  X10: reach ◁ touch\n", "")]}),
    Injection("time", _PANDA, {_PANDA: [("episode_time: 90 s", "episode_time: 3 s")]}),
    Injection("not_followed", _PANDA, fault=FrozenJoint),
    Injection("backend", _PANDA, fault=Halt),
    unlisted("gravity", _PANDA, fault=partial(ChangedModel, heavy_world)),
    unlisted("askew", _PANDA, fault=partial(ChangedModel, sideways_world)),
    unlisted("friction of a joint", _PANDA, fault=partial(ChangedModel, tough_joint)),
    unlisted("weak drives", _PANDA, fault=partial(ChangedModel, weak_drives)),
    unlisted("wind", _PANDA, fault=Wind),
    unlisted("late commands", _PANDA, fault=partial(LateCommands, 20)),
    unlisted("late loads", _PANDA, fault=late("loads", 40)),
    unlisted("late encoders", _PANDA, fault=late("positions", 12)),
    unlisted("late images", _PANDA, fault=late("regions", 40)),
    unlisted("jittering clock", _PANDA, fault=noisy("time", 0.003)),
    unlisted("noisy encoders", _PANDA, fault=noisy("positions", 0.05)),
    unlisted("scaled encoder", _PANDA, fault=partial(Distortion, scaled_joint)),
    unlisted("stuck encoder", _PANDA, fault=partial(Distortion, stuck_fingers)),
    unlisted("saturated loads", _PANDA, fault=partial(Distortion, cropped_loads)),
    unlisted("rolled camera", _PANDA, fault=partial(Distortion, rolled_camera)),
    unlisted("gain", _PANDA, {_TOUCH: [(_APPROACH, f"{_APPROACH}    gain: 200 /s\n")]}),
    unlisted("unit of size", _PANDA, {_STAGE: [(_SIZE, "size: [4 cm, 4 cm, 4 mm]")]}),
    unlisted("unit of mass", _PANDA, {_STAGE: [("mass: 100 g", "mass: 100 kg")]}),
    # Variants that fail on the Panda, whose gripper takes a small cube with a tilted hand.
    Injection("no_grasp", _PANDA, {_TOUCH: [("until: $hand.shut", "until: 60 mm")]}),
    Injection("translation", _PANDA, {_TOUCH: [(_SEEN, _OFF.format(7))]}),
    Injection("rotation", _PANDA, {_TOUCH: [(_DOWN, _ACROSS)], _STAGE: [(_SIZE, _WIDE)]}),
    Injection("rotation", _GRASP, {_TOUCH: [(_DOWN, "    reference: [90 deg, 0 deg, 0 deg]\n")]}),
    Injection("no_rotation", _GRASP, {_TOUCH: [(_TOP, "  reach: approach\n")]}),
    Injection("no_rotation", _PICK, {_TOUCH: [(_TOP, "  reach: approach\n")], _PICK: [_SHORT]}),
    Injection("no_rotation", _PANDA, {_TOUCH: [(_TOP, "  reach: approach\n")]}),
    Injection("rotation", _SIDE, {_SIDE: [(_ALONG, _LEVEL)]}),
    Injection("translation", _SIDE, {_SIDE: [(_BETWEEN, _ASIDE)]}),
    Injection("no_grasp", _SIDE, {_SIDE: [("touch($hand, 4 N)", "touch($hand, 60 N)")]}),
    Injection("slip", _SIDE, fault=InjectedSlip),
    Injection(
        "wrong_order",
        _SIDE,
        {
            _SIDE: [
                (
                    "approach at rest and turn at rest: aloft",
                    "approach at rest and turn at rest: touch",
                )
            ]
        },
    ),
    Injection("wrong_object", _PANDA, {_STAGE: _CLOSE}),
    unlisted("gravity", _PICK, fault=partial(ChangedModel, heavy_world)),
    unlisted("wind", _PICK, {_PICK: [_SHORT]}, Wind),
    unlisted("late commands", _PICK, {_PICK: [_SHORT]}, partial(LateCommands, 20)),
    unlisted("late loads", _PICK, {_PICK: [_SHORT]}, late("loads", 40)),
    unlisted("late images", _PICK, {_PICK: [_SHORT]}, late("regions", 40)),
    unlisted("weak drives", _PICK, {_PICK: [_SHORT]}, partial(ChangedModel, weak_drives)),
    unlisted("rolled camera", _GRASP, fault=partial(Distortion, rolled_camera)),
    unlisted("encoder offset", _PANDA, fault=partial(Distortion, offset_joint)),
    unlisted("shifted rows", _PANDA, fault=partial(Distortion, shifted_rows)),
    unlisted("drifting loads", _PANDA, fault=partial(Distortion, drifting_loads)),
    unlisted("no loads", _PANDA, fault=partial(Distortion, scaled_loads(0.0))),
    unlisted("stale images", _PANDA, fault=lambda backend: Distortion(StaleImages(), backend)),
    unlisted("drift", _PANDA, {}, Drift),
    # Other programs: from above, with both hands, between two fingers, and placing.
    Injection("no_grasp", _TAKE, {_TAKE: [_CLOSES_EARLY, _BOUND]}, stage=_PAD),
    Injection(
        "translation",
        _TAKE,
        {_TAKE: [(_OVER, _OVER.replace("- [0 cm, 0", "- [0 cm, 12")), _BOUND]},
        stage=_PAD,
    ),
    Injection("rotation", _TAKE, {_TAKE: [(_ABOVE, "[95 deg, 0 deg, 0 deg]"), _BOUND]}, stage=_PAD),
    Injection(
        "no_rotation",
        _TAKE,
        {_TAKE: [("◁ ready($arm) ◁ turn ◁ over", "◁ over"), _BOUND]},
        stage=_PAD,
    ),
    Injection(
        "wrong_order",
        _TAKE,
        {_TAKE: [("survey: {then: rise", "survey: {then: touch"), _BOUND]},
        stage=_PAD,
    ),
    Injection(
        "held",
        _TAKE,
        {_TAKE: [("ready($arm) ◁ turn ◁ over", "turn ◁ over ◁ ready($arm)"), _BOUND]},
        stage=_PAD,
    ),
    Injection("never_seen", _TAKE, {_TAKE: [("goal: green", "goal: yellow"), _BOUND]}, stage=_PAD),
    Injection("lost", _TAKE, {_TAKE: [_BOUND]}, Removal, _PAD),
    Injection("occluded", _TAKE, {_TAKE: [_BOUND]}, OneEye, _PAD),
    Injection("slip", _BRING, {_BRING: [_BOUND]}, InjectedSlip, _PAD),
    Injection(
        "wrong_order",
        _MEET,
        {
            _MEET: [
                (
                    "  XXX: reachtouch\n  0XX: reachtouch",
                    "  XXX: conditionedhold ◁ touch\n  0XX: reachtouch",
                ),
                ("  X--: reachtouch", "  X--: conditionedhold ◁ touch"),
                _IDLE,
            ]
        },
    ),
    Injection("rotation", _BRING, {_BRING: [_TURNED_PALM, _BOUND]}, stage=_PAD),
    Injection(
        "translation",
        _BRING,
        {
            _BRING: [
                (
                    "carry: carry_around($arm, hold, $feature, $goal",
                    'carry: {requires: hold, potential: spring, reference: "stereo.$goal +'
                    ' [0 cm, 16 cm, 12 cm]", feedback: stereo.$feature, effector:'
                    " $arm.position, speed: 12 cm/s, quiescence: {rate: 1e-2, window: 0.3"
                    " s, tolerance: 3 cm}}  #",
                ),
                (
                    "$feature.on.$goal.placed - [0 cm, 0 cm",
                    "$feature.on.$goal.placed - [0 cm, -16 cm",
                ),
                (" ◁ near ◁ place", " ◁ place"),
                ("place at rest and near at rest and clear", "place at rest and clear"),
                ("place at rest and near at rest and clear", "place at rest and clear"),
                _BOUND,
            ]
        },
        stage=_PAD,
    ),
    Injection(
        "wrong_object",
        _BRING,
        {
            _BRING: [
                (
                    "take: {program: take, with: {feature: $feature",
                    "take: {program: take, with: {feature: yellow",
                ),
                _BOUND,
            ],
            _PAD: [
                (
                    "    joints: &looking",
                    "      other: {things: [other], place: {beside: {name: pad, by: [15 cm,"
                    " 20 cm], direction: [45 deg, 120 deg]}}}\n    joints: &looking",
                ),
                (
                    "things:\n  ball",
                    "things:\n  other: {form: {shape: box, size: [8 cm, 8 cm, 8 cm]}, mass:"
                    " 250 g, color: [1, 1, 0]}\n  ball",
                ),
                _NO_OTHERS,
            ],
        },
        stage=_PAD,
    ),
    Injection(
        "translation",
        _BOTH,
        {
            _BOTH: [
                (
                    "reference: stereo.$feature\n    feedback: arms.centroid",
                    'reference: "stereo.$feature + [0 cm, 0 cm, 24 cm]"\n    feedback:'
                    " arms.centroid",
                ),
                ('"stereo.$feature - [3 mm, 8 mm]"', '"stereo.$feature + [0 cm, 24 cm]"'),
                _BOUND,
            ]
        },
        stage=_LARGE,
    ),
    Injection("rotation", _BOTH, {_BOTH: [*_FACING, _BOUND]}, stage=_LARGE),
    Injection(
        "no_rotation",
        _BOTH,
        {
            _BOTH: [
                ("surround: face_left ◁ face_right ◁ apart", "surround: apart"),
                ("stay ◁ face_left ◁ face_right", "stay"),
                ("still ◁ face_left ◁ face_right", "still"),
                _BOUND,
            ]
        },
        stage=_LARGE,
    ),
    Injection(
        "wrong_order",
        _BOTH,
        {_BOTH: [("searchtrack: {then: surround", "searchtrack: {then: squeeze"), _BOUND]},
        stage=_LARGE,
    ),
    Injection(
        "slip",
        _BOTH,
        {
            _BOTH: [_BOUND],
            _LARGE: [
                ("mass: 300 g", "mass: 300 g, friction: 0.05"),
                ("mass: 400 g", "mass: 400 g, friction: 0.05"),
            ],
        },
        stage=_LARGE,
    ),
    Injection(
        "translation",
        "bring_with_both",
        {
            "bring_with_both": [
                (_PLACED, '"stereo.$feature.on.$goal.placed + [-16 cm, 0 cm, 6 cm]"'),
                _BOUND,
            ],
            _PAD: _HUGE,
        },
        stage=_PAD,
    ),
    Injection(
        "wrong_order",
        _PINCH,
        {_PINCH: [("approach at rest: descend", "approach at rest: right"), _BOUND], _PAD: _SMALL},
        stage=_PAD,
    ),
    Injection(
        "translation",
        _PINCH,
        {
            _PINCH: [
                ("[0 mm, 6 mm, 20 cm]", "[0 mm, 90 mm, 20 cm]"),
                ("[0 mm, 6 mm, 8.8 cm]", "[0 mm, 90 mm, 8.8 cm]"),
                _BOUND,
            ],
            _PAD: _SMALL,
        },
        stage=_PAD,
    ),
    Injection(
        "no_rotation",
        _PINCH,
        {
            _PINCH: [("ready(right_arm) ◁ turn ◁ above", "ready(right_arm) ◁ above"), _BOUND],
            _PAD: _SMALL,
        },
        stage=_PAD,
    ),
    Injection("out_of_reach", "reachtouch", stage="out_of_reach"),
    Injection("wrong_order", "put_down", {"put_down": [_BOUND]}),
    Injection(
        "no_action",
        "bring_from_side",
        {"put_down_from_side": [("  XX1X: retreat\n", "")], "bring_from_side": [_BOUND]},
    ),
    Injection("translation", "bring_from_side", {"bring_from_side": [(_AROUND, _AWAY), _BOUND]}),
    Injection(
        "translation",
        _MEET,
        {
            _MEET: [
                (
                    "    reference: stereo.$feature\n",
                    '    reference: "stereo.$feature + [0 cm, 25 cm, 0 cm]"\n',
                ),
                _IDLE,
            ]
        },
    ),
    Injection(
        "no_rotation",
        _MEET,
        {_MEET: [("meet ◁ face_left ◁ face_right ◁ carry", "meet ◁ carry"), _IDLE]},
    ),
    Injection(
        "slip",
        _MEET,
        {
            _MEET: [_IDLE],
            "table_right": 2 * [("mass: 300 g, color", "mass: 300 g, friction: 0.05, color")]
            + [("mass: [200 g, 300 g], color", "mass: 300 g, friction: 0.05, color")],
        },
    ),
    Injection(
        "no_grasp",
        "visualinspect",
        {
            "visualinspect": [_IDLE, ("policy: reachtouch, ", "")],
            _TOUCH: [("2 cm, until: $hand.shut", "2 cm, until: 0.4 rad")],
        },
    ),
    Injection("slip", "bring_from_side", {"bring_from_side": [_BOUND]}, InjectedSlip),
    Injection(
        "slip", "bring_with_both", {"bring_with_both": [_BOUND], _PAD: _HUGE}, InjectedSlip, _PAD
    ),
    Injection("no_grasp", "tactileprobe", stage="absent"),
    Injection(
        "time",
        _BRING,
        {_BRING: [("reward_ends: false}", "reward_ends: false, episode_time: 12 s}")]},
        stage=_PAD,
    ),
    Injection("wrong_order", "push", stage="cube_on_bench"),
    Injection(
        "translation",
        "visualinspect",
        {
            "visualinspect": [_IDLE, ("policy: reachtouch, ", "")],
            _TOUCH: [(_SEEN, _OFF.format(14))],
        },
    ),
    Injection(
        "held",
        "bring_from_side",
        {
            "take_from_side": [("ready($arm) ◁ behind", "behind ◁ ready($arm)")],
            "bring_from_side": [_BOUND],
        },
    ),
    Injection(
        "wrong_object",
        _TAKE,
        {
            _TAKE: [_BOUND],
            _PAD: [
                (
                    "    joints: &looking",
                    "      block: {things: [block], place: {beside: {name: ball, by: 10"
                    " cm}}}\n    joints: &looking",
                ),
                (
                    "things:\n  ball",
                    "things:\n  block: {form: {shape: box, size: [6 cm, 6 cm, 13 cm]},"
                    " mass: 2 kg, color: [0, 0, 1]}\n  ball",
                ),
                _NO_OTHERS,
            ],
        },
        stage=_PAD,
    ),
)
