"""Checks of stage documents, alone and against their robots."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.checking.controller.reach import farthest_tip
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.robot.limits import limit_details
from cbdsl.checking.session import Session
from cbdsl.checking.stage.fitted_stage import UnfitStageError, fitted_stage
from cbdsl.checking.stage.mesh_files import check_meshes, extents_of
from cbdsl.checking.stage.presentation import check_presentations, idle_keys
from cbdsl.checking.stage.scene import check_scenes
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.form import BallForm, BoxForm, ComposedForm, Form, MeshForm, OpenBoxForm
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.types.relative import ANY_ROBOT
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.node import Node

# Plausible masses of objects that a hand handles, kg.
_LIGHTEST, _HEAVIEST = 1e-4, 50.0
# Rubber on rubber has 1.2; a clay ball has less than a centimetre of rolling friction.
_MOST_FRICTION = {"friction": 3.0, "rolling_friction": 0.05, "spinning_friction": 0.05}


def examine_stage(
    loaded: Loaded[StageDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check a stage document against itself and its robot, or the first one that suits it."""
    name, place = loaded.document.robot, loaded.source.root.place
    if name != ANY_ROBOT:
        where = loaded.source.place("robot")
        path = find_document(RobotDocument, name, where, session.library, diagnostics)
        _examine(loaded, session.body(path, diagnostics), diagnostics)
        return
    problems = ["there is no robot without errors"]
    trials: list[Diagnostics] = []
    for fitted, body in _before_robots(loaded, session, problems):
        trials.append(Diagnostics())
        _examine(fitted, body, trials[-1])
        if not trials[-1].failed:
            break
    if trials:
        best = trials[0] if trials[-1].failed else trials[-1]
        diagnostics.extend(best.sorted())
    else:
        diagnostics.add("CB358", place, problem=problems[:2][-1])


def _examine(
    loaded: Loaded[StageDocument], body: Outcome[CheckedRobot], diagnostics: Diagnostics
) -> None:
    """Check a stage before one robot."""
    for node, (first, last) in _reversed_spans(loaded.document, loaded.source.root):
        diagnostics.add("CB352", node.place, first=f"{first:g}", last=f"{last:g}")
    for key, context in loaded.document.contexts.items():
        check_presentations(loaded, diagnostics, key, context, body)
    _names(loaded, diagnostics)
    check_meshes(loaded, diagnostics)
    _matter(loaded, diagnostics)
    check_scenes(loaded, body, diagnostics)
    if not isinstance(body, Unknown):
        _joints(loaded, body, diagnostics)
        _sizes(loaded, body, diagnostics)


def _before_robots(
    loaded: Loaded[StageDocument], session: Session, problems: list[str]
) -> Iterator[tuple[Loaded[StageDocument], CheckedRobot]]:
    """Yield a stage for any robot before each one at hand, and note why it does not suit others."""
    library = session.library
    for name in library.names(RobotDocument, loaded.path):
        file = library.find(RobotDocument, name, loaded.path)
        body = session.body(file or UNKNOWN, Diagnostics())
        if file is None or isinstance(body, Unknown):
            continue
        try:
            yield loaded._replace(document=fitted_stage(loaded, body.document, file)), body
        except UnfitStageError as error:
            problems.append(str(error))


def _sizes(loaded: Loaded[StageDocument], body: CheckedRobot, diagnostics: Diagnostics) -> None:
    """Warn of things that are, in any orientation, wider than the reach of any tip."""
    farthest = farthest_tip(body)
    for name, thing in loaded.document.things.items():
        width = _narrowest(thing.form)
        if farthest is not None and width > farthest:
            place = loaded.source.place("things", name, "form", _size_key(thing.form))
            ends = {"width": f"{width:.4g}", "farthest": f"{farthest:.3g}"}
            diagnostics.add("CB721", place, name=name, robot=body.document.name, **ends)


def _size_key(form: Form) -> str:
    """Return the key of a form that determines the width of a thing."""
    if isinstance(form, ComposedForm):
        return "pieces"
    if isinstance(form, MeshForm):
        return "file"
    return "size" if isinstance(form, (BoxForm, OpenBoxForm)) else "radius"


def _matter(loaded: Loaded[StageDocument], diagnostics: Diagnostics) -> None:
    """Warn of implausible masses and friction."""
    stage = loaded.document
    for name, thing in stage.things.items():
        beyond = next((mass for mass in thing.mass if not _LIGHTEST <= mass <= _HEAVIEST), None)
        if beyond is not None:
            place = loaded.source.place("things", name, "mass")
            limits = {"least": f"{1000 * _LIGHTEST:g}", "most": f"{_HEAVIEST:g}"}
            diagnostics.add("CB760", place, name=name, mass=f"{beyond:g}", **limits)
    for section, items in (("fixtures", stage.fixtures), ("things", stage.things)):
        for name, item in items.items():
            for key, most in _MOST_FRICTION.items():
                value = getattr(item, key)
                if value is not None and value > most:
                    place = loaded.source.place(section, name, key)
                    details = {"value": f"{value:g}", "most": f"{most:g}", "key": key}
                    diagnostics.add("CB761", place, name=name, **details)


def _narrowest(form: Form) -> float:
    """Return the least extent of a thing, at its smallest, m."""
    if isinstance(form, (BoxForm, OpenBoxForm, ComposedForm)):
        return min(size[0] for size in form.size)
    if isinstance(form, MeshForm):
        return min(extents_of(form) or (0.0,))
    across = 2 * form.radius[0]
    return across if isinstance(form, BallForm) else min(across, form.height[0])


def _names(loaded: Loaded[StageDocument], diagnostics: Diagnostics) -> None:
    """Check that fixtures and things have different names, and that each thing is shown."""
    stage, source = loaded.document, loaded.source
    contexts = source.known(stage.contexts, "contexts")
    shows = [each for context in stage.contexts.values() for each in context.presentations.values()]
    shown = {name for show in shows for name in show.things}
    # A context with a place and without things most likely lacks the thing that seems unused.
    is_forgotten = any(idle_keys(show) and not show.things for show in shows)
    are_known = shown.issubset(stage.things) and contexts is not UNKNOWN
    for name in stage.things:
        place = source.key("things", name)
        if name in stage.fixtures:
            _shared(name, place, loaded, diagnostics)
        elif name not in shown and are_known and not is_forgotten:
            diagnostics.add("CB715", place, name=name)
    for key, context in stage.contexts.items():
        for name in context.placed:
            if name in stage.fixtures:
                place = source.key("contexts", key, "placed", name)
                _shared(name, place, loaded, diagnostics)


def _shared(
    name: str, place: Place, loaded: Loaded[StageDocument], diagnostics: Diagnostics
) -> None:
    """Report a thing with the name of a fixture."""
    related = [(loaded.source.key("fixtures", name), "the fixture")]
    diagnostics.add("CB354", place, related=related, name=name)


def _joints(loaded: Loaded[StageDocument], body: CheckedRobot, diagnostics: Diagnostics) -> None:
    """Check that contexts start actuated joints of the robot within their limits."""
    known = [joint for each in body.document.effectors.values() for joint in each.joints]
    for key, context in loaded.document.contexts.items():
        starts = context.joints
        for joint in starts:
            if joint not in known:
                place = loaded.source.key("contexts", key, "joints", joint)
                diagnostics.add("CB351", place, names=known, name=joint, what="actuated joint")
        for (joint, span), limits in zip(starts.items(), body.limits(starts), strict=True):
            beyond = [i for i, a in enumerate(span) if limits and not limits[0] <= a <= limits[1]]
            if limits is not None and beyond:
                node = loaded.source.node(("contexts", key, "joints", joint, beyond[0]))
                limits_text = limit_details(node.value, span[beyond[0]], limits)
                diagnostics.add("CB355", node.place, joint=joint, **limits_text)


def _reversed_spans(value: object, node: Node) -> Iterator[tuple[Node, tuple[float, float]]]:
    """Yield the spans in a part of a stage whose upper end is written first."""
    written = node.value
    if isinstance(written, dict):
        for key, child in written.items():
            inner = value[key] if isinstance(value, dict) else getattr(value, key)
            yield from _reversed_spans(inner, child)
    elif isinstance(written, list) and isinstance(value, tuple):
        if len(value) == 2 and isinstance(value[0], float) and value[0] > value[1]:
            yield node, value
        for inner, child in zip(value, written, strict=True):
            yield from _reversed_spans(inner, child)
