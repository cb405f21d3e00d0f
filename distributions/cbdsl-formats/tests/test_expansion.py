"""Expansion of hostile and of large xacro files: refused in a sentence, within bounds."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest
import xacro

from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.urdf import UrdfError
from cbdsl_formats.expansion import expand_xacro
from cbdsl_formats.library_parts import LibraryParts

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
BOMB = "".join(f'<xacro:property name="p{n + 1}" value="${{p{n}}}${{p{n}}}"/>' for n in range(40))
CALLS = "".join(
    f'<xacro:macro name="m{n + 1}"><xacro:m{n}/><xacro:m{n}/></xacro:macro>' for n in range(60)
)


def expand(folder: Path, body: str, **arguments: str) -> str:
    file = folder / "any.xacro"
    file.write_text(f"{HEAD}{body}</robot>")
    return expand_xacro(file, "any", arguments, PackageFolders({}, [], file)).text


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
        expand_xacro(file, "any", {}, PackageFolders({}, [], file))


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


def test_expand_names_the_included_file_and_line_of_an_error(tmp_path: Path) -> None:
    for fault, place in (
        ("<link>", "part.xacro:5:2: .*mismatched tag"),
        ('<link name="${absent}"/>', "part.xacro:4: expression 'absent'"),
        ('<xacro:absent name="a"/>', "part.xacro:4: .*unknown macro"),
        ('<xacro:if value="perhaps"/>', "part.xacro:4: .*not a boolean"),
        ('<xacro:property name="p" value="$(arg absent)" lazy_eval="no"/>', "part.xacro:4: "),
        ('<a><b c="$(find absent)"/></a>', "part.xacro:4: "),
    ):
        (tmp_path / "part.xacro").write_text(f'{HEAD}\n<link name="foot"/>\n\n{fault}\n</robot>')
        with pytest.raises(UrdfError, match=place):
            expand(tmp_path, '<link/><xacro:include filename="part.xacro"/>\n<link/>')


def test_expand_names_the_line_within_a_macro(tmp_path: Path) -> None:
    body = '\n<xacro:macro name="m" params="a">\n<b>\n<c d="${a}${absent}"/></b></xacro:macro>\n\n'
    with pytest.raises(UrdfError, match=r"any\.xacro:4: expression 'absent'"):
        expand(tmp_path, f'{body}<xacro:m a="1"/>')


def test_expand_element_and_attribute_with_computed_names(tmp_path: Path) -> None:
    body = (
        '<xacro:property name="kind" value="link"/><xacro:element xacro:name="${kind}" name="a">'
        '<xacro:attribute name="b${1 + 1}" value="c"/></xacro:element>'
    )
    assert '<link b2="c" name="a"/>' in expand(tmp_path, body)


def test_library_parts_take_the_arguments_by_the_names_of_the_library(tmp_path: Path) -> None:
    originals = dict(vars(xacro))
    with LibraryParts({}, PackageFolders({}, [], tmp_path)).installed():
        replaced = {name: part for name, part in vars(xacro).items() if part != originals[name]}
    assert len(replaced) > 5
    for name, part in replaced.items():
        if callable(part) and part.__name__ != "placed":
            own, library = (inspect.signature(each).parameters for each in (part, originals[name]))
            assert list(own) == list(library), name
