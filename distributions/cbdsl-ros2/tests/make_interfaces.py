"""Build the package ``cbdsl_msgs`` for rclpy without colcon, from the generators on PyPI.

It runs under the interpreter with rclpy, whose environment has ``ros-jazzy-test-msgs``:

    python make_interfaces.py ros/cbdsl_msgs FOLDER

FOLDER then belongs in ``PYTHONPATH`` and ``LD_LIBRARY_PATH``.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from importlib import import_module
from pathlib import Path

PACKAGE, INTERFACE = "cbdsl_msgs", "action/RunProgram.action"
PREFIX = Path(sys.prefix)
USED = ("action_msgs", "builtin_interfaces", "unique_identifier_msgs", "service_msgs", "std_msgs")
# Kinds of code, each by a generator of its own.
GENERATORS = (
    "rosidl_generator_c", "rosidl_generator_py", "rosidl_typesupport_c",
    "rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c",
)  # fmt: skip
# Libraries of the packages that the interfaces use.
LINKED = (
    "rosidl_generator_c", "rosidl_generator_py", "rosidl_typesupport_c",
    "rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c",
)  # fmt: skip


def extension(module: str, base: type) -> type:
    """Return the one class of a module that extends a class of ``rosidl_cli``."""
    found = [
        each for each in vars(import_module(module)).values()
        if isinstance(each, type) and issubclass(each, base) and each is not base
    ]  # fmt: skip
    return found[-1]


def generate(source: Path, out: Path) -> None:
    """Write the code of the action into a folder."""
    os.environ["AMENT_PREFIX_PATH"] = str(PREFIX)
    from rosidl_adapter.action import convert_action_to_idl
    from rosidl_cli.command.generate.extensions import GenerateCommandExtension
    from rosidl_generator_type_description.cli import HashTypeDescription

    paths = [str(PREFIX / "share" / name) for name in USED]
    os.chdir(out)
    idl, described = INTERFACE.replace(".action", ".idl"), INTERFACE.replace(".action", ".json")
    convert_action_to_idl(source, PACKAGE, Path(INTERFACE), out / "action")
    HashTypeDescription("hash").generate_type_hashes(PACKAGE, [idl], paths, out)
    for module in GENERATORS:
        kind = extension(f"{module}.cli", GenerateCommandExtension)(module)
        more = {"type_description_files": [described]} if module == GENERATORS[0] else {}
        # Two generators write a file of the same name.
        folder = out / "introspection" if module == GENERATORS[-1] else out
        kind.generate(PACKAGE, [idl], paths, folder / PACKAGE, **more)


def build(out: Path) -> None:
    """Compile the libraries and the extension module of the package."""
    code, action = out / PACKAGE, out / PACKAGE / "action"
    detail = action / "detail"
    import numpy

    includes = [
        out, out / "introspection",
        *(path for path in (PREFIX / "include").iterdir()), PREFIX / "include",
        sysconfig.get_path("include"), numpy.get_include(),
    ]  # fmt: skip
    libraries = [f"-l{package}__{kind}" for package in USED for kind in LINKED]
    libraries += [
        "-lrosidl_runtime_c", "-lrosidl_typesupport_c", "-lrosidl_typesupport_fastrtps_c",
        "-lrosidl_typesupport_fastrtps_cpp", "-lrosidl_typesupport_introspection_c",
        "-lrcutils", "-lrmw", "-lfastcdr",
    ]  # fmt: skip

    def link(name: str, sources: list[Path], *needed: str) -> None:
        compiler = "g++" if sources[0].suffix == ".cpp" else "gcc"
        command = [
            compiler, "-O1", "-fPIC", "-shared", "-w", "-o", name, *map(str, sources),
            *(f"-I{path}" for path in includes), "-L.", f"-L{PREFIX / 'lib'}",
            f"-Wl,-rpath,$ORIGIN:{PREFIX / 'lib'}", *needed, *libraries,
        ]  # fmt: skip
        subprocess.run(command, cwd=out, check=True)

    own = [f"-l{PACKAGE}__rosidl_generator_c"]
    link(f"lib{PACKAGE}__rosidl_generator_c.so", sorted(detail.glob("*.c")))
    seen = sorted((out / "introspection").rglob("*.c"))
    link(f"lib{PACKAGE}__rosidl_typesupport_introspection_c.so", seen, *own)
    fast = sorted(detail.glob("*.cpp"))
    link(f"lib{PACKAGE}__rosidl_typesupport_fastrtps_c.so", fast, *own)
    link(f"lib{PACKAGE}__rosidl_typesupport_c.so", sorted(action.glob("*.cpp")), *own)
    (entry,) = code.glob("*.ep.rosidl_typesupport_c.c")
    module = f"{PACKAGE}/{PACKAGE}_s__rosidl_typesupport_c.so"
    own.append(f"-l{PACKAGE}__rosidl_typesupport_c")
    link(module, [entry, *action.glob("_*_s.c")], *own)


if __name__ == "__main__":
    source, out = (Path(word).absolute() for word in sys.argv[1:])
    (out / PACKAGE).mkdir(parents=True)
    (out / PACKAGE / "__init__.py").touch()
    generate(source, out)
    build(out)
