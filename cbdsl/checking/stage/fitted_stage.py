"""Stages for any robot, with the measures of one: its reach, its span, and its bench."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from pydantic import ValidationError

from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.bench import bench
from cbdsl.types.relative import ANY_ROBOT, replaced, with_measures
from cbdsl.types.unit import QuantityError, read_quantity
from cbdsl.yaml_text.loaded import Loaded


class UnfitStageError(ValueError):
    """Error of a stage for any robot that a robot does not suit; see its message."""


def fitted_stage(
    loaded: Loaded[StageDocument],
    robot: RobotDocument,
    file: Path,
    parts: Collection[str] = (),
) -> StageDocument:
    """Return a stage in metres before a robot; a stage of one robot as it is.

    Args:
        loaded: Stage.
        robot: Robot before which its objects stand.
        file: Document of the robot.
        parts: Effectors that act on the stage, whose span counts; the first hand's if empty.

    Raises:
        UnfitStageError: The robot lacks a measure, or a sum of measures is no length.
    """
    if loaded.document.robot != ANY_ROBOT:
        return loaded.document
    measures = {**bench(robot, file).measures, **dict(_spans(robot, parts))}
    try:
        data = replaced(loaded.source.root.plain(), lambda text: with_measures(text, measures))
        context = {"folder": loaded.path.parent}
        return StageDocument.model_validate({**data, "robot": robot.name}, context=context)
    except KeyError as error:
        missing = error.args[0]
        raise UnfitStageError(
            f"robot '{robot.name}' states no '{missing}', which stage '{loaded.document.name}' "
            f"needs; write {missing}: WIDTH in 'values' of its hand"
        ) from None
    except QuantityError as error:
        raise UnfitStageError(f"stage '{loaded.document.name}': {error}") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise UnfitStageError(
            f"stage '{loaded.document.name}' on robot '{robot.name}', {where}: {first['msg']}"
        ) from None


def _spans(robot: RobotDocument, parts: Collection[str]) -> Iterator[tuple[str, float]]:
    """Yield the width between the fingers of the hand that acts, or of the first hand."""
    names = [name for name in (*parts, *robot.effectors) if name in robot.effectors]
    widths = [robot.effectors[name].values.get("span") for name in names]
    for width in [width for width in widths if width is not None][:1]:
        yield "span", read_quantity(width, ("length",))
