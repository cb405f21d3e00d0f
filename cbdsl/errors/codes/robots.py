"""CB3nn: robot documents and their URDF models."""

from __future__ import annotations

from cbdsl.errors.codes.example import URDF, robot
from cbdsl.errors.entry import Entry

_PATH = "robots/example.yaml"
_MODEL = {"robots/example.urdf": URDF}
_WHEEL = """  <link name="rim"/>
  <joint name="wheel" type="continuous">
    <parent link="base"/><child link="rim"/>
  </joint>
</robot>"""
_ROLLING = {"robots/example.urdf": URDF.replace("</robot>", _WHEEL)}
_TWO = "  neck: {joints: [pan]}\n  eye: {joints: [tilt]}\n"

ROBOTS = (
    Entry(
        "CB301",
        "no URDF model",
        "the URDF model cannot be read: {problem}",
        "`model` is the path of a URDF file, relative to the robot's document.",
        robot().replace("example.urdf", "exmaple.urdf"),
        _PATH,
        _MODEL,
        good=robot(),
    ),
    Entry(
        "CB302",
        "joint that the model lacks",
        "the model {model} has no joint '{name}'",
        "Effectors, couplings and load cells name joints of the URDF model, as its <joint> "
        "elements are named.",
        robot("  head: {joints: [pam]}\n"),
        _PATH,
        _MODEL,
        good=robot(),
    ),
    Entry(
        "CB303",
        "link that the model lacks",
        "the model {model} has no link '{name}'",
        "Tips, cameras, load cells, surfaces and the base name links of the URDF model. In "
        "`simulation`, a trailing * stands for any ending.",
        robot("  head: {joints: [pan], tip: {link: eyes}}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan], tip: {link: eye}}\n"),
    ),
    Entry(
        "CB304",
        "posture of the wrong length",
        "posture '{name}' has {found} for {wanted}",
        "A posture has one angle for each joint of its effector, in their order.",
        robot("  head: {joints: [pan], postures: {ahead: [0, 0]}}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan], postures: {ahead: [0]}}\n"),
    ),
    Entry(
        "CB305",
        "posture outside the joint limits",
        "{angle} {unit} is outside the limits of joint '{joint}', {lower} to {upper} {unit}{hint}",
        "The robot can never take this posture. Limits are those of the URDF model.",
        robot("  head: {joints: [pan], postures: {aside: [100 deg]}}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan], postures: {aside: [50 deg]}}\n"),
    ),
    Entry(
        "CB306",
        "unknown posture",
        "effector '{effector}' has no posture '{name}'",
        "`start` names one of the effector's postures.",
        robot("  head: {joints: [pan], postures: {ahead: [0]}, start: ahed}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan], postures: {ahead: [0]}, start: ahead}\n"),
    ),
    Entry(
        "CB307",
        "joint with two masters",
        "joint '{name}' is already moved by {other}",
        "Each joint belongs to one effector, or follows one joint as a coupling.",
        robot("  head: {joints: [pan]}\n  neck: {joints: [pan]}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan]}\n"),
    ),
    Entry(
        "CB308",
        "unknown effector or joint",
        "'{name}' is no {what}",
        "Load cells belong to an effector and name a joint of it; couplings follow an actuated "
        "joint; a channel's alias names a channel.",
        robot(more="vision: {channels: {aliases: {green: hue_11}}}\n"),
        _PATH,
        _MODEL,
        good=robot(more="vision: {channels: {aliases: {green: hue_4}}}\n"),
    ),
    Entry(
        "CB309",
        "setting for an unknown type",
        "'{name}' is no type of resource",
        "`control.tasks` has settings by the type of a controller's feedback.",
        robot().replace(
            "tasks: {}", "tasks: {heding: {gain: 8, quiescence: {rate: 1, window: 1 s}}}"
        ),
        _PATH,
        _MODEL,
        good=robot().replace(
            "tasks: {}", "tasks: {heading: {gain: 8, quiescence: {rate: 1, window: 1 s}}}"
        ),
    ),
    Entry(
        "CB310",
        "base that is not the root",
        "link '{name}' cannot be the base: joint '{joint}' moves it",
        "The base is the root of the URDF model: the one link that is no joint's child.",
        robot(base="cbdsl: 1\nkind: robot\nname: example\nmodel: example.urdf\nbase: eye\n"),
        _PATH,
        _MODEL,
        good=robot(),
    ),
    Entry(
        "CB311",
        "group with the name of an effector",
        "'{name}' is the name of an effector already",
        "Groups and effectors are named alike in programs, so no name may mean both.",
        robot(_TWO, more="groups: {eye: {members: [neck, eye]}}\n"),
        _PATH,
        _MODEL,
        good=robot(_TWO, more="groups: {head: {members: [neck, eye]}}\n"),
    ),
    Entry(
        "CB312",
        "member named twice",
        "'{name}' is a member of group '{group}' already",
        "A group lists each of its effectors once.",
        robot(_TWO, more="groups: {head: {members: [neck, eye, neck]}}\n"),
        _PATH,
        _MODEL,
        good=robot(_TWO, more="groups: {head: {members: [neck, eye]}}\n"),
    ),
    Entry(
        "CB313",
        "rates that do not fit",
        "{problem}",
        "The simulator takes a whole number of physics steps in each tick of the control, and an "
        "image is read in a tick: `simulation.physics_rate` is a multiple of `control.rate`, and "
        "`vision.rate` is no higher.",
        robot(more="simulation: {physics_rate: 200 Hz}\n"),
        _PATH,
        _MODEL,
        good=robot(more="simulation: {physics_rate: 360 Hz}\n"),
    ),
    Entry(
        "CB314",
        "name that means something else",
        "'{name}' already means {meaning}",
        "Programs name a robot's resources by dots, as in `stereo.hue_4`, `right_arm.uniform` or "
        "`right_hand.net.force`. A name of the document's own that reads the same would hide one "
        "of them.",
        robot("  head: {joints: [pan], postures: {uniform: [0]}}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan], postures: {ahead: [0]}}\n"),
    ),
    Entry(
        "CB315",
        "alias that hides a channel",
        "'{name}' is a channel already",
        "An alias is a further name of a channel, so it cannot be the name of another.",
        robot(more="vision: {channels: {aliases: {hue_1: hue_4}}}\n"),
        _PATH,
        _MODEL,
        good=robot(more="vision: {channels: {aliases: {green: hue_4}}}\n"),
    ),
    Entry(
        "CB316",
        "joint without room to move",
        "joint '{name}' goes from {lower} to {upper} rad, and the margin of {margin} rad at both "
        "ends leaves nothing",
        "Joints are kept `control.limit_margin` from their limits in the URDF model. A joint that "
        "the model gives no limits has 0 for both.",
        robot().replace("tasks: {}", "limit_margin: 1.5, tasks: {}"),
        _PATH,
        _MODEL,
        good=robot(),
    ),
    Entry(
        "CB317",
        "joint that cannot be moved",
        "{problem}",
        "Programs move joints that are revolute and have limits. Joints that are fixed, slide "
        "(prismatic) or move in several ways (floating, planar) are none. A continuous joint "
        "becomes one when the URDF model has `revolute` for it and a <limit> with `lower` and "
        "`upper`, in rad. A joint that mimics another is passive: it belongs to `couplings`, and "
        "to no effector.",
        robot("  head: {joints: [pan, wheel]}\n"),
        _PATH,
        _ROLLING,
        good=robot(),
    ),
    Entry(
        "CB318",
        "tip that its joints do not move",
        "link '{name}' is moved by none of the joints of '{effector}', so it cannot be its tip",
        "A tip is what an effector moves: its link comes after one of the effector's joints in "
        "the URDF model. Those that do are listed.",
        robot("  eyes: {joints: [tilt], tip: {link: neck}}\n"),
        _PATH,
        _MODEL,
        good=robot("  eyes: {joints: [tilt], tip: {link: eye}}\n"),
    ),
    Entry(
        "CB319",
        "link where a joint belongs",
        "'{name}' is a link; the joint that moves it is '{joint}'",
        "A URDF model has links, which are bodies, and joints, which move them. Effectors and "
        "couplings name joints, as its <joint> elements are named; tips and cameras name links.",
        robot("  head: {joints: [neck]}\n"),
        _PATH,
        _MODEL,
        good=robot("  head: {joints: [pan]}\n"),
    ),
    Entry(
        "CB320",
        "unknown kind of sensor",
        "there is no kind of sensor '{name}'",
        "Kinds of sensors below `sensors` come from packages that are installed beside this one, "
        "under the entry point group `cbdsl.sources`; `cb show sources` lists them. Load cells and "
        "cameras have sections of their own.",
        robot(more="sensors: {wrist: {kind: wrist_force}}\n"),
        _PATH,
        _MODEL,
        good=robot(),
    ),
)
