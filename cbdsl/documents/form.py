"""Forms of objects and fixtures: shape, size and the pattern of their surface."""

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from cbdsl.documents.document import Angle, Color, Point, Section, Size, SizeSpan
from cbdsl.documents.file_section import FileName, FileSection

Side = Literal["-x", "+x", "-y", "+y"]
"""Where a side looks while the thing's yaw is 0."""


#: Most solids that something composed, or a mesh, is made of.
MOST_PIECES = 16


class Spot(Section):
    """Round spot of another colour in the middle of a side.

    It covers the surface of that side within ``radius`` of the axis through the middle.
    """

    face: Side = "-x"
    """Side with the spot, named by its direction while the yaw is 0."""
    radius: Size
    """Radius across the axis."""
    color: Color
    """Red, green and blue, each from 0 to 1."""


class SpottedForm(Section):
    """Form with spots on its sides; each kind declares both fields behind its sizes."""

    if TYPE_CHECKING:
        spot: Spot | None = None
        spots: tuple[Spot, ...] = ()

    @property
    def all_spots(self) -> tuple[Spot, ...]:
        """The spots, one or several."""
        return (*([self.spot] if self.spot else []), *self.spots)

    @model_validator(mode="after")
    def _has_spots_on_different_sides(self) -> Self:
        faces = [spot.face for spot in self.all_spots]
        if len(set(faces)) < len(faces):
            raise ValueError("two spots are on the same side")
        return self


class BallForm(SpottedForm):
    """Sphere."""

    shape: Literal["ball"]
    """Name of the shape."""
    radius: SizeSpan
    """Radius, or the range to draw it from."""
    spot: Spot | None = None
    """Spot painted on a side."""
    spots: tuple[Spot, ...] = ()
    """Several spots, each on another side."""

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        # The smallest ball that may be drawn has to have room as well.
        if any(spot.radius >= self.radius[0] for spot in self.all_spots):
            raise ValueError("the spot is larger than the side of the ball")
        return self


class Pattern(Section):
    """Upright black bars side by side, printed in the middle of a side of a box."""

    face: Side = "-x"
    """Printed side, named by its direction while the yaw of the box is 0."""
    height: Size
    """Length of the bars."""
    stripes: Annotated[tuple[Size, ...], Field(min_length=1)]
    """Widths of bar, gap, ..., bar from left to right, as a viewer of the side sees them."""

    @model_validator(mode="after")
    def _ends_with_a_bar(self) -> Self:
        if len(self.stripes) % 2 == 0:
            raise ValueError("stripes begin and end with a bar, so that their number is odd")
        return self


class BoxForm(SpottedForm):
    """Cuboid with edges along x, y and z while its yaw is 0."""

    shape: Literal["box"]
    """Name of the shape."""
    size: tuple[SizeSpan, SizeSpan, SizeSpan]
    """Edge lengths."""
    pattern: Pattern | None = None
    """Pattern printed on a side."""
    spot: Spot | None = None
    """Spot painted on a side."""
    spots: tuple[Spot, ...] = ()
    """Several spots, each on another side."""

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        (depth, _), (width, _), (height, _) = self.size
        # The least sizes count, since any size may be drawn. Sides -x and +x span the edges along y
        # and z; sides -y and +y span those along x and z.
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


class CylinderForm(SpottedForm):
    """Upright cylinder."""

    shape: Literal["cylinder"]
    """Name of the shape."""
    radius: SizeSpan
    """Radius, or the range to draw it from."""
    height: SizeSpan
    """Height, or the range to draw it from."""
    spot: Spot | None = None
    """Spot painted on a side."""
    spots: tuple[Spot, ...] = ()
    """Several spots, each on another side."""

    @model_validator(mode="after")
    def _has_room_for_the_spots(self) -> Self:
        # The smallest cylinder that may be drawn has to have room as well.
        for spot in self.all_spots:
            if spot.radius >= self.radius[0] or 2 * spot.radius > self.height[0]:
                raise ValueError("the spot is larger than the side of the cylinder")
        return self


# Engines collide convex solids, which have no bore. A hollow form is a union of boxes that leaves
# its inside free.
class TubeForm(Section):
    """Upright cylinder with a bore along its axis; 12 boxes make its wall."""

    shape: Literal["tube"]
    """Name of the shape."""
    radius: SizeSpan
    """Outer radius, or the range to draw it from."""
    height: SizeSpan
    """Height, or the range to draw it from."""
    wall: Size
    """Thickness of the wall."""

    @model_validator(mode="after")
    def _has_a_bore(self) -> Self:
        if self.wall >= self.radius[0]:
            raise ValueError("the wall leaves no bore")
        return self


class OpenBoxForm(Section):
    """Box without a lid, made of 5 boxes."""

    shape: Literal["open_box"]
    """Name of the shape."""
    size: tuple[SizeSpan, SizeSpan, SizeSpan]
    """Outer edge lengths."""
    wall: Size
    """Thickness of the walls and the bottom."""

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        (depth, _), (width, _), (height, _) = self.size
        if 2 * self.wall >= min(depth, width) or self.wall >= height:
            raise ValueError("the walls leave no inside")
        return self


class Piece(Section):
    """Solid that is part of a composed form."""

    form: Annotated[BallForm | BoxForm | CylinderForm, Field(discriminator="shape")]
    """Shape and size."""
    position: Point = (0.0, 0.0, 0.0)
    """Centre, in the frame common to all pieces."""
    yaw: Angle = 0.0
    """Rotation about z."""

    @model_validator(mode="after")
    def _is_definite(self) -> Self:
        form = self.form
        spans = form.size if isinstance(form, BoxForm) else (form.radius,)
        if isinstance(form, CylinderForm):
            spans = (*spans, form.height)
        # The box around a composed form is computed from one size per piece, before anything is
        # drawn.
        if any(first != last for first, last in spans):
            raise ValueError("a piece has one size, which is not drawn")
        if form.all_spots:
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
        # The box around a rectangle with half edges x and y, turned by psi, reaches |cos psi| x +
        # |sin psi| y along the first axis. Balls and upright cylinders look the same after a turn
        # about z.
        c, s = abs(math.cos(self.yaw)), abs(math.sin(self.yaw))
        return c * x + s * y, s * x + c * y, z


class ComposedForm(Section):
    """Object of up to 16 solids; its centre is the middle of their bounding box."""

    shape: Literal["composed"]
    """Name of the shape."""
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
        return tuple((last - first, last - first) for first, last in self.box)


class MeshForm(FileSection):
    """Closed mesh; its centre is the middle of its bounding box."""

    most_bytes: ClassVar[int] = 20_000_000

    shape: Literal["mesh"]
    """Name of the shape."""
    file: FileName
    """STL or OBJ file, relative to the stage's folder."""
    scale: Size = 1.0
    """Length of the unit of the file: 1 mm if its numbers are millimetres."""
    solid: Literal["hull", "boxes", "ball", "box", "cylinder"] = "hull"
    """Form for contacts: the convex hull; up to 16 boxes that fill a hollow mesh; or the bounding
    ball, box or upright cylinder."""

    # Documents are equal by content, regardless of their path.
    def __eq__(self, other: object) -> bool:
        return isinstance(other, MeshForm) and self.model_dump() == other.model_dump()

    def __hash__(self) -> int:
        return hash((self.file, self.scale, self.solid))


Form = BallForm | BoxForm | CylinderForm | TubeForm | OpenBoxForm | ComposedForm | MeshForm
