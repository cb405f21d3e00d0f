"""Expansion of hostile and of large xacro files: refused in a sentence, within bounds."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.urdf import UrdfError
from cbdsl.robot.xacro.expansion import expand_xacro

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
BOMB = "".join(f'<xacro:property name="p{n + 1}" value="${{p{n}}}${{p{n}}}"/>' for n in range(40))
CALLS = "".join(
    f'<xacro:macro name="m{n + 1}"><xacro:m{n}/><xacro:m{n}/></xacro:macro>' for n in range(60)
)


def expand(folder: Path, body: str, **arguments: str) -> str:
    file = folder / "any.xacro"
    file.write_text(f"{HEAD}{body}</robot>")
    return expand_xacro(file, arguments, PackageFolders({}, [], file))


@pytest.mark.parametrize(
    "expression",
    [
        "${(lambda: load_yaml)().__globals__['os'].system('touch ran')}",
        "${(lambda: xacro.load_yaml)().__globals__['os'].system('touch ran')}",
        "${[g for g in [load_yaml.__globals__]][0]['os'].system('touch ran')}",
        "$(eval find.__globals__)",
        "$(eval [f for f in [arg]][0].__globals__)",
    ],
)
@pytest.mark.parametrize("place", ['<link name="{}"/>', "<a>{}</a>", '<xacro:if value="{}"/>'])
def test_expand_expression_that_reaches_python_is_refused(
    expression: str, place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UrdfError, match=r"not allowed|not a function|not defined"):
        expand(tmp_path, place.format(expression))
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    "body",
    [
        '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
        f'<xacro:macro name="m0"><a/></xacro:macro>{CALLS}<xacro:m60/>',
        f'<xacro:property name="p0" value="xy"/>{BOMB}<a b="${{p40}}"/>',
        '<xacro:include filename="any.xacro"/>',
        "<a b=\"${'x' * 10**9}\"/>",
        '<a b="${10**10**10}"/>',
        '<xacro:include filename="/dev/zero"/>',
        '<xacro:property name="y" value="${load_yaml(\'/dev/zero\')}"/><a b="${y}"/>',
        '<xacro:property name="y" value="${load_yaml(\'/etc/passwd\')}"/><a b="${y}"/>',
        '<a b="$(env HOME)"/>',
    ],
)
def test_expand_unbounded_model_is_refused(body: str, tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match=r"any\.xacro"):
        expand(tmp_path, body)


def test_expand_file_with_a_circular_include_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="a macro, or a file that it includes, uses itself"):
        expand(tmp_path, '<xacro:include filename="any.xacro"/>')


@pytest.mark.parametrize("text", ["a: &a [x]\nb: [*a, *a]", "a: &a {}\nb: {<<: *a}"])
def test_load_yaml_with_aliases_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "bomb.yaml").write_text(text)
    with pytest.raises(UrdfError, match="aliases and merge keys"):
        expand(tmp_path, "<a b=\"${xacro.load_yaml('bomb.yaml')}\"/>")


def test_expand_yaml_with_units_returns_its_entries(tmp_path: Path) -> None:
    (tmp_path / "limits.yaml").write_text("elbow: {lower: !degrees -90, names: [a, b]}\n")
    body = (
        '<xacro:property name="y" value="${xacro.load_yaml(\'limits.yaml\')}"/>'
        '<a b="${y.elbow.lower}" c="${y[\'elbow\'].names[1]}"/>'
    )
    assert 'b="-1.57079' in expand(tmp_path, body) and 'c="b"' in expand(tmp_path, body)


def test_expand_entities_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "any.xacro"
    file.write_text(f'<!DOCTYPE r [<!ENTITY a "x">]>{HEAD}<a b="&a;"/></robot>')
    with pytest.raises(UrdfError, match="entities"):
        expand_xacro(file, {}, PackageFolders({}, [], file))


def test_expand_substitutions_return_arguments_and_defaults(tmp_path: Path) -> None:
    body = (
        '<xacro:arg name="n" default="2"/>'
        '<a b="$(arg n)" c="$(eval n * 3)" d="$(optenv HOME no where)" e="$${x}"/>'
    )
    text = expand(tmp_path, body, n="3")
    assert 'b="3" c="9" d="no where" e="${x}"' in text


def test_expand_pattern_includes_files_in_order(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    for name in "ba":
        (tmp_path / "parts" / f"{name}.xml").write_text(f'<r><link name="{name}"/></r>')
    text = expand(tmp_path, '<xacro:include filename="parts/*.xml"/>')
    assert text.index('"a"') < text.index('"b"')
