"""The watchdog of forward controllers; start it on the computer of the robot."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    """Return the description that ``ros2 launch`` asks for."""
    arguments = [
        DeclareLaunchArgument("robot", description="Robot: file or name."),
        DeclareLaunchArgument("cb", default_value="cb", description="Command of cbdsl."),
        DeclareLaunchArgument("interface", default_value="lo", description="Network interface."),
    ]
    command = [
        LaunchConfiguration("cb"), "drive", "watchdog", LaunchConfiguration("robot"),
        "--interface", LaunchConfiguration("interface"),
    ]  # fmt: skip
    return LaunchDescription([*arguments, ExecuteProcess(cmd=command, output="screen")])
