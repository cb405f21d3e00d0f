"""The action server that runs programs."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

# Parameters of the node, with their defaults and descriptions.
_PARAMETERS = {
    "python": ("python3", "Interpreter with cbdsl and cbdsl-ros2."),
    "backend": ("ros2", "Backend: ros2 for the robot behind topics, or a simulator."),
    "cameras": ("", "Cameras: rendered or ideal; empty for the choice of the backend."),
    "interface": ("lo", "Network interface of the backend ros2."),
    "released": ("false", "true if the stage is set up and the robot may move."),
}


def generate_launch_description() -> LaunchDescription:
    """Return the description that ``ros2 launch`` asks for."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in _PARAMETERS.items()
    ]
    node = Node(
        package="cbdsl_ros",
        executable="run_program",
        parameters=[{name: LaunchConfiguration(name) for name in _PARAMETERS}],
        output="screen",
    )
    return LaunchDescription([*arguments, node])
