"""Robot models in xacro and MJCF, converted to URDF."""
