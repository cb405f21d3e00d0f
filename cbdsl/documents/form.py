"""Forms of things and fixtures: shape, size and what their surface shows."""

import hashlib
import math
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import (
    Field,
    FieldSerializationInfo,
    PrivateAttr,
    ValidationInfo,
    field_serializer,
    model_validator,
)

from cbdsl.documents.contents import contents, is_file
from cbdsl.documents.document import (
    Angle,
    Color,
    Point,
    Section,
    Size,
    SizeSpan,
)

Side = Literal["-x", "+x", "-y", "+y"]
"""Where a side looks while the thing's yaw is 0."""


_MOST_MESH_BYTES = 20_000_000

#: Most solids that something composed, or a mesh, is made of.
MOST_PIECES = 16


class Spot(Section):
    """A round spot of another colour on the middle of a side.

    It is all of the surface on that side that is within ``radius`` of the axis through its middle.
    """

    face: Side = "-x"
    """Side that it is on: where it looks while the thing's yaw is 0."""
    radius: Size
    """Radius, across the axis."""
    color: Color
    """Red, green and blue, each from 0 to 1."""


def _require_own_sides(spots: tuple[Spot, ...]) -> None:
    """Raise ``ValueError`` where a side has two spots."""
    faces = [spot.face for spot in spots]
    if len(set(faces)) < len(faces):
        raise ValueError("two spots are on the same side")


class BallForm(Section):
    """A sphere."""

    shape: Literal["ball"]
    """Which shape it is."""
    radius: SizeSpan
    """Radius, or the span that it is drawn from."""
    spot: Spot | None = None
    """Pattern that is painted on a side of it."""
    spots: tuple[Spot, ...] = ()
    """Several of them, each on a side of its own."""

    @property
    def all_spots(self) -> tuple[Spot, ...]:
        """The spots, one or several."""
        return (*([self.spot] if self.spot else []), *self.spots)

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        _require_own_sides(self.all_spots)
        if any(spot.radius >= self.radius[0] for spot in self.all_spots):
            raise ValueError("the spot is larger than the side of the ball")
        return self


class Pattern(Section):
    """Black bars printed on the middle of a box's side, upright and next to each other."""

    face: Side = "-x"
    """Side that is printed on: where it looks while the box's yaw is 0."""
    height: Size
    """Length of the bars."""
    stripes: Annotated[tuple[Size, ...], Field(min_length=1)]
    """Widths of bar, gap, ..., bar from left to right for a viewer of the side."""

    @model_validator(mode="after")
    def _ends_with_a_bar(self) -> Self:
        if len(self.stripes) % 2 == 0:
            raise ValueError("stripes begin and end with a bar, so that their number is odd")
        return self


class BoxForm(Section):
    """A cuboid; its edges lie along x, y and z while its yaw is 0."""

    shape: Literal["box"]
    """Which shape it is."""
    size: tuple[SizeSpan, SizeSpan, SizeSpan]
    """Edge lengths."""
    pattern: Pattern | None = None
    """Pattern that is printed on a side of it."""
    spot: Spot | None = None
    """Pattern that is painted on a side of it."""
    spots: tuple[Spot, ...] = ()
    """Several of them, each on a side of its own."""

    @property
    def all_spots(self) -> tuple[Spot, ...]:
        """The spots, one or several."""
        return (*([self.spot] if self.spot else []), *self.spots)

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        _require_own_sides(self.all_spots)
        (depth, _), (width, _), (height, _) = self.size
        for spot in self.all_spots:
            across = width if spot.face.endswith("x") else depth
            if 2 * spot.radius > min(across, height):
                raise ValueError("the spot is larger than the side of the box")
        return self

    @model_validator(mode="after")
    def _has_room_for_the_pattern(self) -> Self:
        if self.pattern is not None:
            (depth, _), (width, _), (height, _) = self.size
            across = width if self.pattern.face.endswith("x") else depth
            # Widths that add up to the edge's length may exceed it by a rounding error.
            if sum(self.pattern.stripes) > across + 1e-9 or self.pattern.height > height:
                raise ValueError("the pattern is larger than the side of the box")
        return self


class CylinderForm(Section):
    """A cylinder that stands upright."""

    shape: Literal["cylinder"]
    """Which shape it is."""
    radius: SizeSpan
    """Radius, or the span that it is drawn from."""
    height: SizeSpan
    """Height, or the span that it is drawn from."""


class TubeForm(Section):
    """A cylinder with a bore along its axis, which stands upright; its wall is made of 12 boxes."""

    shape: Literal["tube"]
    """Which shape it is."""
    radius: SizeSpan
    """Outer radius, or the span that it is drawn from."""
    height: SizeSpan
    """Height, or the span that it is drawn from."""
    wall: Size
    """Thickness of its wall."""

    @model_validator(mode="after")
    def _has_a_bore(self) -> Self:
        if self.wall >= self.radius[0]:
            raise ValueError("the wall leaves no bore")
        return self


class OpenBoxForm(Section):
    """A box without a lid, made of 5 boxes."""

    shape: Literal["open_box"]
    """Which shape it is."""
    size: tuple[SizeSpan, SizeSpan, SizeSpan]
    """Outer edge lengths."""
    wall: Size
    """Thickness of its walls and its bottom."""

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        (depth, _), (width, _), (height, _) = self.size
        if 2 * self.wall >= min(depth, width) or self.wall >= height:
            raise ValueError("the walls leave no inside")
        return self


class Piece(Section):
    """A solid that something composed is made of."""

    form: Annotated[BallForm | BoxForm | CylinderForm, Field(discriminator="shape")]
    """Its shape and size."""
    position: Point = (0.0, 0.0, 0.0)
    """Centre, in a frame that all pieces share."""
    yaw: Angle = 0.0
    """How it is turned about z."""

    @model_validator(mode="after")
    def _is_definite(self) -> Self:
        form = self.form
        spans = form.size if isinstance(form, BoxForm) else (form.radius,)
        if isinstance(form, CylinderForm):
            spans = (*spans, form.height)
        if any(first != last for first, last in spans):
            raise ValueError("a piece has one size, which is not drawn")
        if isinstance(form, (BallForm, BoxForm)) and form.all_spots:
            raise ValueError("a piece has no spot")
        if isinstance(form, BoxForm) and form.pattern is not None:
            raise ValueError("a piece has no pattern")
        return self

    @property
    def halves(self) -> tuple[float, float, float]:
        """Half its extents along its own axes, m."""
        form = self.form
        if isinstance(form, BallForm):
            return (form.radius[0],) * 3
        if isinstance(form, CylinderForm):
            return form.radius[0], form.radius[0], form.height[0] / 2
        (x, _), (y, _), (z, _) = form.size
        return x / 2, y / 2, z / 2

    @property
    def reach(self) -> tuple[float, float, float]:
        """Half its extents along the axes of the shared frame, m."""
        x, y, z = self.halves
        if not isinstance(self.form, BoxForm):
            return x, y, z
        c, s = abs(math.cos(self.yaw)), abs(math.sin(self.yaw))
        return c * x + s * y, s * x + c * y, z


class ComposedForm(Section):
    """Up to 16 solids that are one thing; its centre is the middle of the box around them."""

    shape: Literal["composed"]
    """Which shape it is."""
    pieces: Annotated[tuple[Piece, ...], Field(min_length=1, max_length=MOST_PIECES)]
    """Solids of the form. `cb show mesh FILE` writes the pieces that fill a mesh."""

    @property
    def box(self) -> tuple[tuple[float, float], ...]:
        """First and last value along each axis of the box around all pieces, m."""
        return tuple(
            (
                min(piece.position[axis] - piece.reach[axis] for piece in self.pieces),
                max(piece.position[axis] + piece.reach[axis] for piece in self.pieces),
            )
            for axis in range(3)
        )

    @property
    def size(self) -> tuple[tuple[float, float], ...]:
        """Edges of the box around all pieces as spans of one value each, m."""
        edges = [last - first for first, last in self.box]
        return tuple((edge, edge) for edge in edges)


class MeshForm(Section):
    """A closed mesh; its centre is the middle of the box around it."""

    shape: Literal["mesh"]
    """Which shape it is."""
    file: Annotated[str, Field(min_length=1)]
    """Its file, STL or OBJ, with the path from the stage's folder."""
    scale: Size = 1.0
    """Length of the file's unit: 1 mm where its numbers are millimetres."""
    solid: Literal["hull", "boxes", "ball", "box", "cylinder"] = "hull"
    """Touched form: the convex hull; up to 16 boxes that fill a hollow mesh; or the surrounding
    ball, box or upright cylinder."""

    _folder: Path = PrivateAttr(default=Path())

    @model_validator(mode="after")
    def _is_in_a_folder(self, info: ValidationInfo) -> Self:
        if info.context is not None:
            self._folder = info.context["folder"]
        return self

    @property
    def path(self) -> Path:
        """Its file."""
        return self._folder / self.file

    @field_serializer("file")
    def _by_its_content(self, file: str, info: FieldSerializationInfo) -> str:
        # What was learned with a mesh holds for this mesh, wherever it lies.
        if info.context is None or not is_file(self.path):
            return file
        try:
            return hashlib.sha256(contents(self.path, _MOST_MESH_BYTES)).hexdigest()
        except OSError:
            return file  # as readers of the mesh report

    # A document is what it says, wherever it lies.
    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeshForm) and self.model_dump() == other.model_dump()

    def __hash__(self) -> int:
        return hash((self.file, self.scale, self.solid))


Form = BallForm | BoxForm | CylinderForm | TubeForm | OpenBoxForm | ComposedForm | MeshForm
