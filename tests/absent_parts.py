"""Skip tests of parts that this machine cannot have, such as Bullet from Python 3.14 on."""

from __future__ import annotations

from collections.abc import Generator
from ctypes.util import find_library
from importlib.util import find_spec

import pytest

#: Messages that name an absent part, by the package or the library that it needs.
_PACKAGES = {
    "pybullet": ("No module named 'pybullet", "backend 'bullet' cannot be loaded"),
    "cyclonedds": ("No module named 'cyclonedds",),
}
# Only MuJoCo needs OpenGL: where Bullet is installed, its software renderer takes over.
_LIBRARIES = {"GL": ("OpenGL cannot make the images", "libGL.so not loaded")}

MESSAGES = tuple(
    message
    for parts, is_absent in (
        (_PACKAGES, lambda name: find_spec(name) is None),
        (_LIBRARIES, lambda name: not (find_library(name) or find_spec("pybullet"))),
    )
    for name, messages in parts.items()
    if is_absent(name)
    for message in messages
)


def absent_part(text: str) -> str | None:
    """Return the message of a failure that is due to an absent part."""
    return next((message for message in MESSAGES if message in text), None)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip cases of Bullet where it is not installed."""
    for item in [] if find_spec("pybullet") else items:
        values = getattr(item, "callspec", None)
        if values is not None and "bullet" in {str(value) for value in values.params.values()}:
            item.add_marker(pytest.mark.skip(reason="needs Bullet"))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Skip a file that cannot be imported without an absent part."""
    report = yield
    if report.failed and (message := absent_part(str(report.longrepr))):
        report.outcome = "skipped"
        report.longrepr = (str(collector.path), 0, f"Skipped: {message}")
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Skip a test that fails without an absent part."""
    report = yield
    if report.failed and (message := absent_part(report.longreprtext)):
        report.outcome = "skipped"
        report.longrepr = (str(item.path), 0, f"Skipped: {message}")
    return report
