"""A simulated robot behind the topics of its drivers."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    """Return the description that ``ros2 launch`` asks for."""
    arguments = [
        DeclareLaunchArgument("robot", description="Robot: file or name."),
        DeclareLaunchArgument("backend", default_value="mujoco", description="Physics engine."),
        DeclareLaunchArgument("cameras", default_value="ideal", description="rendered or ideal."),
        DeclareLaunchArgument("cb", default_value="cb", description="Command of cbdsl."),
        DeclareLaunchArgument("interface", default_value="lo", description="Network interface."),
    ]
    command = [
        LaunchConfiguration("cb"), "drive", "serve", LaunchConfiguration("robot"),
        "--backend", LaunchConfiguration("backend"),
        "--cameras", LaunchConfiguration("cameras"),
        "--interface", LaunchConfiguration("interface"),
    ]  # fmt: skip
    return LaunchDescription([*arguments, ExecuteProcess(cmd=command, output="screen")])
