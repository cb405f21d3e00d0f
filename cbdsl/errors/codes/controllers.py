"""CB5nn: the types of controllers."""

from __future__ import annotations

from cbdsl.errors.codes.example import HEAD, URDF, controller, robot
from cbdsl.errors.entry import Entry

_HEADING = "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
_REACH = (
    "potential: spring, reference: stereo.motion, feedback: right_arm.position, effector: right_arm"
)
_OWN = "gain: 2 /s, quiescence: {rate: 1e-3, window: 0.5 s}"

CONTROLLERS = (
    Entry(
        "CB501",
        "unknown resource",
        "robot '{robot}' has no resource '{name}'{hint}",
        "Resources follow from the robot's document: `right_arm`, `right_arm.position`, "
        "`right_hand.finger_1.force`, `left.hue_4`, `stereo.hue_4`; `left.red` where "
        "`vision: channels: aliases` calls a channel red. `cb show resources` lists them with "
        "their types.",
        controller("potential: spring, reference: 0, feedback: cyclopean.moton, effector: head"),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
        ),
    ),
    Entry(
        "CB502",
        "unknown potential",
        "there is no potential '{name}'",
        "The potentials are the artificial potential functions of the control basis.",
        controller("potential: sprong, reference: 0, feedback: cyclopean.motion, effector: head"),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
        ),
    ),
    Entry(
        "CB503",
        "potential that is not defined on this type",
        "the potential '{potential}' is defined on {wanted}, and '{name}' is {feedback}",
        "Each potential is a function of certain types only; joint limits, for example, mean "
        "nothing to a force.",
        controller("potential: range, feedback: cyclopean.motion, effector: head"),
        good=controller("potential: range, feedback: head, effector: head"),
    ),
    Entry(
        "CB504",
        "reference and feedback of different types",
        "types differ: the reference '{name}' is of type {reference_type}, the feedback "
        "'{feedback}' of type {feedback_type}",
        "Types are nominal: a force is not a position, although both have three components, "
        "and the configurations of two effectors with different joints cannot be compared.",
        controller(
            "potential: spring, reference: stereo.motion, feedback: right_arm, effector: right_arm"
        ),
        good=controller(
            "potential: spring, reference: stereo.motion, feedback: right_arm.position, "
            "effector: right_arm"
        ),
    ),
    Entry(
        "CB505",
        "wrong number of components",
        "{found} given for {feedback}, which has {wanted}",
        "A reference literal has one number per component of the feedback, or is a single 0.",
        controller("potential: spring, reference: [0, 0, 0], feedback: head, effector: head"),
        good=controller("potential: spring, reference: [0, 0], feedback: head, effector: head"),
    ),
    Entry(
        "CB506",
        "unit that does not fit",
        "{problem}",
        "The quantity has the unit of another type than the controller's feedback.",
        controller("potential: spring, reference: [0 cm, 0 cm], feedback: head, effector: head"),
        good=controller(
            "potential: spring, reference: [0 deg, 0 deg], feedback: head, effector: head"
        ),
    ),
    Entry(
        "CB507",
        "effector that cannot be moved",
        "'{name}' cannot be moved",
        "An effector is a configuration, or the position, orientation or pose of a tip, which "
        "move through the Jacobian of the forward kinematics (Eq 3.17).",
        controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: stereo.motion"
        ),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
        ),
    ),
    Entry(
        "CB508",
        "effector without influence",
        "moving '{name}' does not change '{feedback}'{why}",
        "A controller descends its potential by moving the effector, so the feedback has to "
        "depend on the effector's joints: a heading on those that carry the camera, a force on "
        "those of the hand and its arm. What is seen of the world moves only with an arm whose "
        "hand holds it.",
        controller("potential: spring, reference: 0, feedback: right_arm.position, effector: head"),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
        ),
    ),
    Entry(
        "CB509",
        "missing reference",
        "the potential '{potential}' needs a reference",
        "This potential is a function of the difference between reference and feedback.",
        controller("potential: spring, feedback: cyclopean.motion, effector: head"),
        good=controller(
            "potential: spring, reference: 0, feedback: cyclopean.motion, effector: head"
        ),
    ),
    Entry(
        "CB510",
        "reference that nothing reads",
        "the potential '{potential}' takes no reference",
        "This potential is a function of the feedback alone.",
        controller("potential: range, reference: 0, feedback: head, effector: head"),
        good=controller("potential: range, feedback: head, effector: head"),
    ),
    Entry(
        "CB511",
        "missing setting",
        "neither this controller nor 'control: tasks: {task}' of robot '{robot}' sets {setting}",
        "Settings come from the robot's `control.tasks`, by the type of the feedback, unless "
        "the controller has its own.",
        controller(
            "potential: spring, reference: 0, feedback: right_hand.net.torque, effector: right_hand"
        ),
        good=controller(
            "potential: spring, reference: 0, feedback: right_hand.net.torque, "
            "effector: right_hand, gain: 1 /s, quiescence: {rate: 0.1, window: 1 s}"
        ),
    ),
    Entry(
        "CB512",
        "force along normals that are not there",
        "'along normals' needs the forces of all fingers or hands, and '{name}' is {feedback}",
        "A reference along normals has a direction per finger or palm, so its feedback is "
        "`<hand>.finger_forces` or `<group>.net_forces`.",
        controller(
            "potential: spring, reference: 1 N along normals, feedback: right_arm.position, "
            "effector: right_arm"
        ),
        good=controller(
            "potential: spring, reference: 1 N along normals, feedback: right_hand.finger_forces, "
            "effector: right_hand"
        ),
    ),
    Entry(
        "CB513",
        "setting that means nothing here",
        "'{name}' means nothing for a feedback of type {feedback}",
        "`free_axis` is for orientations, `standoff` and `funnel` are for the position of a tip, "
        "`seek` is for the forces of fingers or hands, `manipulator` is for manipulability.",
        controller(_HEADING + ", free_axis: z"),
        good=controller(_HEADING),
    ),
    Entry(
        "CB514",
        "controller that never runs",
        "no action runs a controller '{name}'",
        "`seek.once` and `requires` name a controller of the same program that an action runs, with "
        "the arguments that the action calls it with.",
        controller(
            "potential: spring, reference: 1 N along normals, "
            "feedback: right_hand.finger_forces, effector: right_hand, "
            "seek: {once: reach}"
        ),
        good=controller(
            "potential: spring, reference: 1 N along normals, "
            "feedback: right_hand.finger_forces, effector: right_hand, "
            "seek: {until: 1 rad}"
        ),
    ),
    Entry(
        "CB515",
        "manipulability without a tip",
        "'{name}' has no tip whose Jacobian a manipulability could be of",
        "Manipulability is a function of the manipulator Jacobian, which belongs to the tip that "
        "the robot's document gives an effector, or each member of a group.",
        controller("potential: manipulability, feedback: head, effector: head"),
        good=controller("potential: manipulability, feedback: right_arm, effector: right_arm"),
    ),
    Entry(
        "CB516",
        "cameras that move apart",
        "the headings in both cameras of '{robot}' cannot be compared: a joint moves one of them",
        "The headings of two cameras give a position only where the cameras keep their distance "
        "and directions to each other.",
        f"{HEAD.replace('dexter', 'example')}controllers:\n  look: {{potential: localizability, "
        "feedback: cameras.motion, effector: head}\nactions: [look]\n",
        beside={
            "robots/example.urdf": URDF,
            "robots/example.yaml": robot(
                "  head: {joints: [pan, tilt]}\n",
                "cameras:\n"
                "  left: {link: neck, width: 320, height: 240, focal_length: 400}\n"
                "  right: {link: eye, width: 320, height: 240, focal_length: 400}\n",
            ),
        },
        good=f"{HEAD.replace('dexter', 'example')}controllers:\n  look: {{potential: spring, "
        "reference: 0, feedback: left.motion, effector: head, gain: 8 /s, "
        "quiescence: {rate: 1e-3, window: 0.5 s}}\nactions: [look]\n",
    ),
    Entry(
        "CB517",
        "reference outside the joint limits",
        "{angle} {unit} is outside the limits of joint '{joint}', {lower} to {upper} {unit}",
        "The effector can never get there, so the controller would push against its limits for "
        "ever. Limits are those of the robot's URDF model.",
        controller("potential: spring, reference: [0, 400 deg], feedback: head, effector: head"),
        good=controller(
            "potential: spring, reference: [0, 40 deg], feedback: head, effector: head"
        ),
    ),
    Entry(
        "CB518",
        "standoff that ends before it begins",
        "the least distance, {least} m, is more than the most, {most} m",
        "A standoff is a distance between `least` and `most`.",
        controller(f"{_REACH}, standoff: {{clearance: 1 cm, least: 14 cm, most: 9 cm}}"),
        good=controller(f"{_REACH}, standoff: {{clearance: 1 cm, least: 9 cm, most: 14 cm}}"),
    ),
    Entry(
        "CB519",
        "body that a potential is not made for",
        "{potential} cannot work here: {problem}",
        "A range needs the limits of the joints that are moved, manipulability as many joints as "
        "the tip's position or pose has components, and localizability two cameras with a distance "
        "between them.",
        f"{HEAD.replace('dexter', 'example')}controllers:\n  free: {{potential: manipulability, "
        f"feedback: head, effector: head, {_OWN}}}\nactions: [free]\n",
        beside={
            "robots/example.urdf": URDF,
            "robots/example.yaml": robot("  head: {joints: [pan, tilt], tip: {link: eye}}\n"),
        },
        good=f"{HEAD.replace('dexter', 'example')}controllers:\n  free: {{potential: range, "
        f"feedback: head, effector: head, {_OWN}}}\nactions: [free]\n",
    ),
    Entry(
        "CB530",
        "feedback that the rest of the controller does not suit",
        "'{name}' is {feedback}, and {number} of this controller suit another feedback",
        "Potential, reference, effector and options are held against the feedback. Where several "
        "of them do not suit it, it is the feedback that was not meant.",
        controller("potential: spring, reference: head.ahead, feedback: right_arm, effector: head"),
        good=controller("potential: spring, reference: head.ahead, feedback: head, effector: head"),
    ),
    Entry(
        "CB531",
        "modifier that does not fit",
        "modifier '{name}' cannot be used here: {problem}",
        "`modifiers` names kinds of changes of the reference that packages add, under the entry "
        "point group `cbdsl.modifiers`, each with its options; `cb show modifiers` lists them.",
        controller(_HEADING + ", modifiers: {sway: {height: 2 cm}}"),
        good=controller(_HEADING),
    ),
)
