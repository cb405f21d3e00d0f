"""Package of ROS 2: colcon builds it by setuptools."""

from glob import glob

from setuptools import setup

NAME = "cbdsl_ros"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", glob("launch/*.launch.py")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="The authors of cbdsl",
    maintainer_email="maintainers@cbdsl.invalid",
    description="Checked programs of cbdsl as an action server, and launch files for its robots.",
    license="MIT",
    entry_points={"console_scripts": [f"run_program = {NAME}.run_program:main"]},
)
