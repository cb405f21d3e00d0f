"""Mutated documents: shipped and bad ones with bytes cut, doubled, swapped or inserted."""

from __future__ import annotations

from pathlib import Path

from hypothesis import strategies as st

from cbdsl.yaml_text.library import shipped

BAD = Path(__file__).parents[1] / "checking" / "bad"
SEEDS = [
    path.read_bytes()
    for folder in (shipped() / "robots", shipped() / "programs", BAD)
    for path in sorted(folder.rglob("*.yaml"))
]
#: Bytes that the reader, the checker or a terminal may mishandle.
SPIKES = [
    *(b"[", b"]", b"{", b"}", b": ", b"- ", b"? ", b"| ", b"> ", b'"', b"'", b"#", b"&a ", b"*a"),
    *(b"!!python/object:x ", b"<<: ", b"---\n", b"...\n", b"%YAML 1.1\n", b"\t", b"\n", b"\r"),
    *(b".inf", b".nan", b"1e999", b"9" * 40, b"-1", b"0", b"1e-3", b"0755", b"NO", b"~", b"1:30"),
    *(b"\xff\xfe", b"\xef\xbb\xbf", b"\x00", b"\x1b[31m", b"\xc2\x85", b"\xe2\x80\xa8", b"\xf0"),
    *(" ◁ ".encode(), b" <| ", b"<<", "⊲".encode(), "◀".encode(), b"$", b"$arm", b"(", b",", b")"),
    *(b"deg", b" N along normals", b"right_arm", b"stereo.sat_10", b"head.uniform", b".", b"*"),
    *(b'"\\ud800"', b'"\\x1b"', b'"\\n"', b"null", b"true", b"[]", b"{}", b'""', b"cb: ignore "),
]
_WHERE = st.floats(0, 1, exclude_max=True)


@st.composite
def documents(draw: st.DrawFn) -> bytes:
    """Draw a document with a few mutations."""
    data = draw(st.sampled_from(SEEDS))
    for _ in range(draw(st.integers(1, 6))):
        mutate = draw(st.sampled_from([_spike, _cut, _double, _swap]))
        data = mutate(draw, data)
    return data


def _spike(draw: st.DrawFn, data: bytes) -> bytes:
    at = int(draw(_WHERE) * (len(data) + 1))
    spike = draw(st.sampled_from(SPIKES) | st.binary(max_size=4))
    over = draw(st.sampled_from([0, 0, 1, 4]))
    return data[:at] + spike + data[at + over :]


def _cut(draw: st.DrawFn, data: bytes) -> bytes:
    at = int(draw(_WHERE) * len(data))
    return data[:at] + data[at + draw(st.integers(1, 200)) :]


def _double(draw: st.DrawFn, data: bytes) -> bytes:
    lines = data.split(b"\n")
    at = int(draw(_WHERE) * len(lines))
    several = draw(st.sampled_from([2, 2, 2, 50]))
    return b"\n".join([*lines[:at], *[lines[at]] * several, *lines[at + 1 :]])


def _swap(draw: st.DrawFn, data: bytes) -> bytes:
    lines = data.split(b"\n")
    one, other = (int(draw(_WHERE) * len(lines)) for _ in range(2))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)
