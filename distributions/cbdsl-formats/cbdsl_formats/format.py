"""Format ``xacro`` of robot models."""

from cbdsl.extend.model import ModelFormat

XACRO = ModelFormat("macro language of robot models", "cbdsl_formats.expansion:expand_xacro")
