"""Formats ``xacro`` and ``mjcf`` of robot models."""

from cbdsl.extend.model import ModelFormat

XACRO = ModelFormat("macro language of robot models", "cbdsl_formats.expansion:expand_xacro")
MJCF_SCENE = ModelFormat(
    "scenes of MuJoCo", "cbdsl_formats.mjcf.bounded_conversion:convert_scene_bounded"
)
MJCF = ModelFormat("models of MuJoCo", "cbdsl_formats.mjcf.bounded_conversion:convert_bounded")
