"""Stages for any robot, with the measures of one: its reach, its span, and its bench."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from pydantic import ValidationError

from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.bench import measures_of
from cbdsl.types.relative import ANY_ROBOT, replaced, with_measures
from cbdsl.types.unit import QuantityError
from cbdsl.yaml_text.loaded import Loaded


class UnfitStageError(ValueError):
    """Error of a stage for any robot that a robot does not suit; see its message."""


def fitted_stage(
    loaded: Loaded[StageDocument], robot: RobotDocument, file: Path, parts: Collection[str] = ()
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
    try:
        measures = measures_of(robot, file, parts)
        data = replaced(
            loaded.source.root.plain(), lambda text: with_measures(text, lambda: measures)
        )
        context = {"folder": loaded.path.parent}
        return StageDocument.model_validate({**data, "robot": robot.name}, context=context)
    except QuantityError as error:
        raise UnfitStageError(
            f"stage '{loaded.document.name}' does not suit robot '{robot.name}': {error}"
        ) from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise UnfitStageError(
            f"stage '{loaded.document.name}' on robot '{robot.name}', {where}: {first['msg']}"
        ) from None
