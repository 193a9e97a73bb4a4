# Written by make_stubs.py from core.pyi.in and the described options; change those.

from os import PathLike
from typing import Any, Callable, Iterator, Literal, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

StrPath = str | PathLike[str]
Vector = Sequence[float] | NDArray[Any]
Numbers = Sequence[Any] | NDArray[Any]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]
BoxLike = Sequence[Sequence[float]] | NDArray[Any]
FloatArray = NDArray[np.float32]
DoubleArray = NDArray[np.float64]
IndexArray = NDArray[np.uint32]
Progress = Callable[[str, float], object]
Log = Callable[[str, str], object]
Sets = dict[str, Any] | Sequence[str]

__version__: str

class Error(Exception):
    """What volcaustic raises: one line that begins with the place and says what to try."""

class UsageError(Error, ValueError):
    """An argument is out of range or contradicts another."""

class InputError(Error):
    """The content of a file, a scene or a mesh is wrong."""

class FileError(Error, OSError):
    """A file cannot be opened, read or written."""

class DeviceError(Error):
    """There is no such device, or it ran out of memory."""

class Cancelled(Error):
    """The call was stopped (Session.cancel); Ctrl-C is KeyboardInterrupt."""

class InternalError(Error):
    """A defect of volcaustic itself."""

class Placement:
    """Where and how large something is: shear, then scale, then rotation about x, y and z, then translation."""

    def __init__(
        self, *, translate: Vector = ..., rotate: Vector = ..., scale: Vector = ..., shear: Vector = ...,
    ) -> None: ...
    translate: tuple[float, float, float]
    """applied last [world]; -1e+12 to 1e+12"""
    rotate: tuple[float, float, float]
    """about x, then y, then z [degrees]; -1e+09 to 1e+09"""
    scale: tuple[float, float, float]
    """applied before the rotation; negative mirrors; -1e+12 to 1e+12"""
    shear: tuple[float, float, float]
    """applied first: added to x for each y, to x for each z, to y for each z; -1e+12 to 1e+12"""
    def replace(
        self, *, translate: Vector = ..., rotate: Vector = ..., scale: Vector = ..., shear: Vector = ...,
    ) -> Placement: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Material:
    """What light meets inside a body. Spectra are linear Rec. 709 RGB."""

    def __init__(
        self, *, name: str = ..., index: float = ..., attenuation: Vector = ..., scattering: Vector = ...,
        asymmetry: float = ...,
    ) -> None: ...
    name: str
    """that objects refer to"""
    index: float
    """refractive index; 0.1 to 10"""
    attenuation: tuple[float, float, float]
    """extinction coefficient: absorption + out-scattering, RGB [1/world]; 0 to 1e+09"""
    scattering: tuple[float, float, float]
    """scattering coefficient, RGB; at most the attenuation [1/world]; 0 to 1e+09"""
    asymmetry: float
    """Henyey-Greenstein mean cosine g; -0.99 to 0.99"""
    def replace(
        self, *, name: str = ..., index: float = ..., attenuation: Vector = ..., scattering: Vector = ...,
        asymmetry: float = ...,
    ) -> Material: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Ambient:
    """What light meets outside of all bodies."""

    def __init__(
        self, *, index: float = ..., attenuation: Vector = ..., scattering: Vector = ..., asymmetry: float = ...,
    ) -> None: ...
    index: float
    """refractive index; 0.1 to 10"""
    attenuation: tuple[float, float, float]
    """extinction coefficient: absorption + out-scattering, RGB [1/world]; 0 to 1e+09"""
    scattering: tuple[float, float, float]
    """scattering coefficient, RGB; at most the attenuation [1/world]; 0 to 1e+09"""
    asymmetry: float
    """Henyey-Greenstein mean cosine g; -0.99 to 0.99"""
    def replace(
        self, *, index: float = ..., attenuation: Vector = ..., scattering: Vector = ..., asymmetry: float = ...,
    ) -> Ambient: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class VoxeliseOptions:
    """From surfaces to voxels."""

    def __init__(
        self, *, supersample: int = ..., blur: int = ..., fill: Literal["auto", "exact", "winding"] = ...,
    ) -> None: ...
    supersample: int
    """sub-voxels along a voxel's edge for the solid fraction; 1, 2, 4, 8"""
    blur: int
    """width of the Gaussian on the index; 1 is none [voxels]; 1, 3, 5, 7, 9, 11"""
    fill: Literal["auto", "exact", "winding"]
    """how inside is told from outside: exact needs closed meshes, winding takes any; 'auto', 'exact', 'winding'"""
    def replace(
        self, *, supersample: int = ..., blur: int = ..., fill: Literal["auto", "exact", "winding"] = ...,
    ) -> VoxeliseOptions: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class StepFieldOptions:
    """How far light may go in one step."""

    def __init__(
        self, *, index_tolerance: float = ..., index_tolerance2: float = ..., cap: float = ...,
        attenuation_tolerance: float = ...,
    ) -> None: ...
    index_tolerance: float
    """range of index in a cube crossed in one step; 0 to 1"""
    index_tolerance2: float
    """range of index in a cube crossed in capped steps; 0 to 1"""
    cap: float
    """longest step in a capped cube [voxels]; 0.1 to 4096"""
    attenuation_tolerance: float
    """range of attenuation times voxel edge in a cube crossed in one step; 0 to 1e+09"""
    def replace(
        self, *, index_tolerance: float = ..., index_tolerance2: float = ..., cap: float = ...,
        attenuation_tolerance: float = ...,
    ) -> StepFieldOptions: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Light:
    """A source of photons."""

    def __init__(
        self, *, name: str = ..., type: Literal["directional", "point", "spot", "environment", "area"] = ...,
        direction: Vector = ..., irradiance: Vector = ..., position: Vector = ..., intensity: Vector = ...,
        outer_angle: float = ..., inner_angle: float = ..., angle: float = ..., radius: float = ...,
        width: float = ..., height: float = ..., across: Vector = ..., round: bool = ..., scale: Vector = ...,
        samples: int = ...,
    ) -> None: ...
    name: str
    """for messages, and of its layers and grids where lights are separate"""
    type: Literal["directional", "point", "spot", "environment", "area"]
    """directional light, point light, a spot: a point light that shines into a cone, the environment: `background`
    from all directions, or an area light: a flat lamp that shines from its front; 'directional', 'point', 'spot',
    'environment', 'area'"""
    direction: tuple[float, float, float]
    """propagation of a directional light, axis of a spot, where an area light faces; any length; -1e+09 to 1e+09"""
    irradiance: tuple[float, float, float]
    """of a directional light, on a plane facing it, RGB [W/m2]; 0 to 1e+30"""
    position: tuple[float, float, float]
    """of a point light or a spot, the middle of an area light [world]; -1e+12 to 1e+12"""
    intensity: tuple[float, float, float]
    """of a point light; on its axis of a spot, and of an area light (its power by pi), RGB [W/sr]; 0 to 1e+30"""
    outer_angle: float
    """half the opening angle of a spot's cone [degrees]; 0.01 to 90"""
    inner_angle: float
    """angle from its axis within which a spot has its whole intensity; at most outerAngle [degrees]; 0 to 90"""
    angle: float
    """angular diameter of a directional light's disc (the sun's is 0.53); 0 gives sharp shadows [degrees]; 0 to 90"""
    radius: float
    """of the ball that a point light or a spot is; 0 gives sharp shadows [world]; 0 to 1e+09"""
    width: float
    """of an area light [world]; 0 to 1e+09"""
    height: float
    """of an area light [world]; 0 to 1e+09"""
    across: tuple[float, float, float]
    """where the width of an area light goes; any length, what is along `direction` is left out; -1e+09 to 1e+09"""
    round: bool
    """an area light is the ellipse in its rectangle"""
    scale: tuple[float, float, float]
    """multiplies the light of the environment, RGB; 0 to 1e+30"""
    samples: int
    """sharp lights that stand for one with an angle, a radius or an area, or for the environment; they share its
    photons; 0 takes 16, of the environment 64 [lights]; 0 to 1024"""
    def replace(
        self, *, name: str = ..., type: Literal["directional", "point", "spot", "environment", "area"] = ...,
        direction: Vector = ..., irradiance: Vector = ..., position: Vector = ..., intensity: Vector = ...,
        outer_angle: float = ..., inner_angle: float = ..., angle: float = ..., radius: float = ...,
        width: float = ..., height: float = ..., across: Vector = ..., round: bool = ..., scale: Vector = ...,
        samples: int = ...,
    ) -> Light: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class PhotonOptions:
    """The photon pass."""

    def __init__(
        self, *, grid: Sequence[int] = ..., scheme: Literal["driftKickDrift", "euler"] = ...,
        lookup: Literal["trilinear", "nearest"] = ..., min_step: float = ..., max_step: float = ...,
        max_steps: int = ..., cutoff: float = ..., roulette: bool = ..., jitter: bool = ..., smooth: bool = ...,
        separate: bool = ..., fresnel: bool = ...,
    ) -> None: ...
    grid: tuple[int, int]
    """photon raster of each light, columns and rows [photons]; 1 to 65536"""
    scheme: Literal["driftKickDrift", "euler"]
    """how a photon is carried: second order, or the paper's equations (6) and (7); 'driftKickDrift', 'euler'"""
    lookup: Literal["trilinear", "nearest"]
    """how n and its gradient are read between voxel centres; 'trilinear', 'nearest'"""
    min_step: float
    """shortest step [voxels]; 0.01 to 64"""
    max_step: float
    """longest step [voxels]; 0.01 to 4096"""
    max_steps: int
    """steps after which a photon is cut off and counted; 1 to 1e+09"""
    cutoff: float
    """fraction of its first power below which a photon is cut off; 0 to 1"""
    roulette: bool
    """Russian roulette below the cutoff instead of dropping"""
    jitter: bool
    """move each photon inside its raster cell, by a hash of seed and cell"""
    smooth: bool
    """3x3x3 Gaussian on the finished volume; keeps its total"""
    separate: bool
    """trace and view each light by itself: a grid and layers of each, beside those of all"""
    fresnel: bool
    """reflect photons, too, where the index changes within a few voxels, by the chance that Fresnel's equations give"""
    def replace(
        self, *, grid: Sequence[int] = ..., scheme: Literal["driftKickDrift", "euler"] = ...,
        lookup: Literal["trilinear", "nearest"] = ..., min_step: float = ..., max_step: float = ...,
        max_steps: int = ..., cutoff: float = ..., roulette: bool = ..., jitter: bool = ..., smooth: bool = ...,
        separate: bool = ..., fresnel: bool = ...,
    ) -> PhotonOptions: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Camera:
    """Where a picture is taken from."""

    def __init__(
        self, *, position: Vector = ..., target: Vector = ..., up: Vector = ..., field_of_view: float = ...,
        resolution: Sequence[int] = ...,
    ) -> None: ...
    position: tuple[float, float, float]
    """of the eye [world]; -1e+12 to 1e+12"""
    target: tuple[float, float, float]
    """point looked at [world]; -1e+12 to 1e+12"""
    up: tuple[float, float, float]
    """direction that is up in the picture; -1e+09 to 1e+09"""
    field_of_view: float
    """vertical [degrees]; 0.01 to 170"""
    resolution: tuple[int, int]
    """width and height of the picture [pixels]; 1 to 32768"""
    def replace(
        self, *, position: Vector = ..., target: Vector = ..., up: Vector = ..., field_of_view: float = ...,
        resolution: Sequence[int] = ...,
    ) -> Camera: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Background:
    """What is around the box, infinitely far away."""

    def __init__(
        self, *, bottom: Vector = ..., top: Vector = ..., up: Vector = ..., file: StrPath = ..., turn: float = ...,
        scale: Vector = ..., visible: bool = ..., image: Image | None = ...,
    ) -> None: ...
    bottom: tuple[float, float, float]
    """radiance seen looking down, RGB [W/(m2 sr)]; 0 to 1e+30"""
    top: tuple[float, float, float]
    """radiance seen looking up, RGB; equal to bottom it is one colour [W/(m2 sr)]; 0 to 1e+30"""
    up: tuple[float, float, float]
    """axis of the gradient, pole of the map; any length; -1e+09 to 1e+09"""
    file: str
    """map in latitude and longitude (.hdr, .exr, ...) that takes the gradient's place; relative to this file"""
    turn: float
    """of the map about `up`, counterclockwise seen from there [degrees]; -1e+09 to 1e+09"""
    scale: tuple[float, float, float]
    """multiplies the map, RGB; 0 to 1e+30"""
    visible: bool
    """false: the camera sees black; environment lights shine as before"""
    image: Image | None
    """the map in memory, which wins over `file`"""
    def replace(
        self, *, bottom: Vector = ..., top: Vector = ..., up: Vector = ..., file: StrPath = ..., turn: float = ...,
        scale: Vector = ..., visible: bool = ..., image: Image | None = ...,
    ) -> Background: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class ViewOptions:
    """The camera pass."""

    def __init__(
        self, *, step: float = ..., samples: int = ...,
        filter: Literal["box", "tent", "gaussian", "blackmanHarris"] = ..., noise: float = ..., max_steps: int = ...,
        fresnel: bool = ..., exposure: float = ...,
    ) -> None: ...
    step: float
    """step where the medium bends or scatters [voxels]; 0.05 to 64"""
    samples: int
    """rays along each side of a pixel; 1 to 16"""
    filter: Literal["box", "tent", "gaussian", "blackmanHarris"]
    """what weighs a pixel's rays, where there are several: by name, as wide as usual; 'box', 'tent', 'gaussian',
    'blackmanHarris'"""
    noise: float
    """standard error, relative to their mean, at which tiles of the picture are done; 0 takes all samples; 0 to 1"""
    max_steps: int
    """steps after which a ray is cut off and counted; 1 to 1e+09"""
    fresnel: bool
    """split rays where the index changes within a few voxels: reflections of background and light"""
    exposure: float
    """brightness of tone-mapped files [stops]; -40 to 40"""
    def replace(
        self, *, step: float = ..., samples: int = ...,
        filter: Literal["box", "tent", "gaussian", "blackmanHarris"] = ..., noise: float = ..., max_steps: int = ...,
        fresnel: bool = ..., exposure: float = ...,
    ) -> ViewOptions: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class GridMapping:
    """What a grid made by others means: offset + scale * grid."""

    def __init__(self, *, grid: str, scale: Vector = ..., offset: Vector = ...) -> None: ...
    grid: str
    """name of the grid in the file"""
    scale: tuple[float, float, float]
    """what one unit of the grid is, RGB; -1e+30 to 1e+30"""
    offset: tuple[float, float, float]
    """value where the grid is 0, RGB; -1e+30 to 1e+30"""
    def replace(self, *, grid: str = ..., scale: Vector = ..., offset: Vector = ...) -> GridMapping: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class PropertyGrid:
    """What one grid of a volume is in a medium: offset + scale * grid."""

    def __init__(
        self, *, name: str, property: Literal["index", "attenuation", "scattering", "asymmetry"], scale: Vector = ...,
        offset: Vector = ...,
    ) -> None: ...
    name: str
    """name of a grid in the file, as `density`"""
    property: Literal["index", "attenuation", "scattering", "asymmetry"]
    """what offset + scale * grid is; 'index', 'attenuation', 'scattering', 'asymmetry'"""
    scale: tuple[float, float, float]
    """what one unit of the grid is, RGB; -1e+30 to 1e+30"""
    offset: tuple[float, float, float]
    """value where the grid is 0, RGB; -1e+30 to 1e+30"""
    def replace(
        self, *, name: str = ..., property: Literal["index", "attenuation", "scattering", "asymmetry"] = ...,
        scale: Vector = ..., offset: Vector = ...,
    ) -> PropertyGrid: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Deformer:
    """One step of a deformation: a handle or a brush."""

    def __init__(
        self, *, type: Literal["handle", "push", "pull", "inflate", "twist", "smooth"], center: Vector = ...,
        radius: float = ..., direction: Vector = ..., strength: float = ..., translate: Vector = ...,
        rotate: Vector = ..., scale: Vector = ..., shear: Vector = ...,
    ) -> None: ...
    type: Literal["handle", "push", "pull", "inflate", "twist", "smooth"]
    """a handle, which places a part of the surface and lets the rest follow, or a brush; 'handle', 'push', 'pull',
    'inflate', 'twist', 'smooth'"""
    center: tuple[float, float, float]
    """of the ball of vertices, in the space of the mesh [mesh]; -1e+12 to 1e+12"""
    radius: float
    """of the ball; handles hold all in it alike, brushes fade from its centre [mesh]; 0 to 1e+12"""
    direction: tuple[float, float, float]
    """that push and pull move along, or the mean normal where it is 0; axis of twist; -1e+09 to 1e+09"""
    strength: float
    """how far push, pull and inflate move; degrees of twist; part of smooth, 0 to 1; -1e+12 to 1e+12"""
    translate: tuple[float, float, float]
    """applied last [world]; -1e+12 to 1e+12"""
    rotate: tuple[float, float, float]
    """about x, then y, then z [degrees]; -1e+09 to 1e+09"""
    scale: tuple[float, float, float]
    """applied before the rotation; negative mirrors; -1e+12 to 1e+12"""
    shear: tuple[float, float, float]
    """applied first: added to x for each y, to x for each z, to y for each z; -1e+12 to 1e+12"""
    def replace(
        self, *, type: Literal["handle", "push", "pull", "inflate", "twist", "smooth"] = ..., center: Vector = ...,
        radius: float = ..., direction: Vector = ..., strength: float = ..., translate: Vector = ...,
        rotate: Vector = ..., scale: Vector = ..., shear: Vector = ...,
    ) -> Deformer: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class SceneGroup:
    """What the triangles of one group of an object's mesh enclose."""

    def __init__(self, *, name: str, material: str, priority: int = ...) -> None: ...
    name: str
    """name of a group of the mesh: `usemtl`, else `g`, else `o` of an OBJ file, a solid of an STL file"""
    material: str
    """name in `materials`"""
    priority: int
    """added to the object's; of equal ones the group wins; -1e+06 to 1e+06"""
    def replace(self, *, name: str = ..., material: str = ..., priority: int = ...) -> SceneGroup: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class SceneVolume:
    """The box that light is computed in, and what fills it where no body is."""

    def __init__(
        self, *, bounds: BoxLike | Literal["auto"] = ..., margin: float = ..., resolution: int = ...,
        voxel_size: float = ..., file: StrPath = ..., index: float = ..., attenuation: Vector = ...,
        scattering: Vector = ..., asymmetry: float = ...,
    ) -> None: ...
    bounds: Box | Literal["auto"]
    """box that light is computed in, or 'auto': around the objects [world]; -1e+12 to 1e+12"""
    margin: float
    """added on every side of an automatic box, as a part of the objects' longest side; 0 to 100"""
    resolution: int
    """voxels along the longest side of the box [voxels]; 1 to 32768"""
    voxel_size: float
    """edge of a voxel; above 0 it replaces the resolution [world]; 0 to 1e+12"""
    file: str
    """a .vdb with an `index` grid that takes the place of objects and box"""
    index: float
    """refractive index; 0.1 to 10"""
    attenuation: tuple[float, float, float]
    """extinction coefficient: absorption + out-scattering, RGB [1/world]; 0 to 1e+09"""
    scattering: tuple[float, float, float]
    """scattering coefficient, RGB; at most the attenuation [1/world]; 0 to 1e+09"""
    asymmetry: float
    """Henyey-Greenstein mean cosine g; -0.99 to 0.99"""
    def replace(
        self, *, bounds: BoxLike | Literal["auto"] = ..., margin: float = ..., resolution: int = ...,
        voxel_size: float = ..., file: StrPath = ..., index: float = ..., attenuation: Vector = ...,
        scattering: Vector = ..., asymmetry: float = ...,
    ) -> SceneVolume: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class SceneObject:
    """A body (mesh or shape), or a volume made by others in the ambient medium."""

    def __init__(
        self, *, name: str = ..., mesh: Mesh | StrPath | None = ..., translate: Vector = ..., rotate: Vector = ...,
        scale: Vector = ..., shear: Vector = ..., material: str = ..., priority: int = ..., visible: bool = ...,
        groups: Sequence[SceneGroup] = ..., volume: StrPath = ..., grids: Sequence[PropertyGrid] = ...,
        shape: Shape | None = ..., triangulate: bool = ..., resolution: int = ..., cell_size: float = ...,
        tolerance: float = ..., triangles: int = ..., deform: Sequence[Deformer] = ...,
        deform_method: Literal["asRigidAsPossible", "laplacian"] = ..., deform_iterations: int = ...,
        topology: Literal["free", "keep", "merge", "split"] = ..., gap: float = ..., blend: float = ...,
        neck: float = ..., remesh_voxel: float = ...,
    ) -> None: ...
    name: str
    """for messages"""
    mesh: Mesh | str | None
    """OBJ, PLY, STL or OFF file, or a mesh of a glTF file as x.glb#/meshes/0; relative to this file"""
    translate: tuple[float, float, float]
    """applied last [world]; -1e+12 to 1e+12"""
    rotate: tuple[float, float, float]
    """about x, then y, then z [degrees]; -1e+09 to 1e+09"""
    scale: tuple[float, float, float]
    """applied before the rotation; negative mirrors; -1e+12 to 1e+12"""
    shear: tuple[float, float, float]
    """applied first: added to x for each y, to x for each z, to y for each z; -1e+12 to 1e+12"""
    material: str
    """a name in `materials`"""
    priority: int
    """where objects overlap the higher one wins; -1e+06 to 1e+06"""
    visible: bool
    """false leaves the object out"""
    groups: list[SceneGroup]
    """groups of the mesh that are made of another material: the wine of a glass"""
    volume: str
    """.vdb or .nvdb file in place of a mesh: smoke, hot air; relative to this file"""
    grids: list[PropertyGrid]
    """what grids of the volume are in the medium"""
    shape: Shape | None
    """functional object in place of a mesh: a node, or a shape file, relative to this file"""
    triangulate: bool
    """make voxels of triangles of the shape, not of the shape itself"""
    resolution: int
    """cells along the longest side of a shape, for its triangles; 128 where this and all that follows are 0; 0 to
    32768"""
    cell_size: float
    """edge of a cell of the triangles; above 0 it replaces the resolution [world]; 0 to 1e+12"""
    tolerance: float
    """greatest distance between triangles and the shape; 0 takes what the cells give [world]; 0 to 1e+12"""
    triangles: int
    """at most as many, and nearly as many where nothing else is given; 0 is no limit; 0 to 1e+09"""
    deform: list[Deformer]
    """steps of a deformation of the mesh, or of the shape's triangles, in their order"""
    deform_method: Literal["asRigidAsPossible", "laplacian"]
    """how the surface follows its handles; 'asRigidAsPossible', 'laplacian'"""
    deform_iterations: int
    """of local rotations and positions; 1 to 1000"""
    topology: Literal["free", "keep", "merge", "split"]
    """what becomes of parts of the mesh that meet: free to overlap, kept apart, merged; split cuts necks; 'free',
    'keep', 'merge', 'split'"""
    gap: float
    """between parts that are kept apart; 0 takes two remeshVoxels [mesh]; 0 to 1e+12"""
    blend: float
    """width of the blend where parts merge; 0 joins them sharply [mesh]; 0 to 1e+12"""
    neck: float
    """thickness below which split cuts; 0 takes four remeshVoxels [mesh]; 0 to 1e+12"""
    remesh_voxel: float
    """of the level set where surfaces change; 0 takes half the mean edge of the triangles [mesh]; 0 to 1e+12"""
    def replace(
        self, *, name: str = ..., mesh: Mesh | StrPath | None = ..., translate: Vector = ..., rotate: Vector = ...,
        scale: Vector = ..., shear: Vector = ..., material: str = ..., priority: int = ..., visible: bool = ...,
        groups: Sequence[SceneGroup] = ..., volume: StrPath = ..., grids: Sequence[PropertyGrid] = ...,
        shape: Shape | None = ..., triangulate: bool = ..., resolution: int = ..., cell_size: float = ...,
        tolerance: float = ..., triangles: int = ..., deform: Sequence[Deformer] = ...,
        deform_method: Literal["asRigidAsPossible", "laplacian"] = ..., deform_iterations: int = ...,
        topology: Literal["free", "keep", "merge", "split"] = ..., gap: float = ..., blend: float = ...,
        neck: float = ..., remesh_voxel: float = ...,
    ) -> SceneObject: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class SceneReceiver:
    """An opaque diffuse surface that light falls on; without a mesh, a square of edge 1."""

    def __init__(
        self, *, name: str = ..., mesh: Mesh | StrPath | None = ..., translate: Vector = ..., rotate: Vector = ...,
        scale: Vector = ..., shear: Vector = ..., albedo: Vector = ..., resolution: int = ..., visible: bool = ...,
    ) -> None: ...
    name: str
    """of its light map; receiver0, receiver1, ... where empty"""
    mesh: Mesh | str | None
    """a mesh, as of objects, whose outside collects light; empty: a square of edge 1 around the origin that faces +z"""
    translate: tuple[float, float, float]
    """applied last [world]; -1e+12 to 1e+12"""
    rotate: tuple[float, float, float]
    """about x, then y, then z [degrees]; -1e+09 to 1e+09"""
    scale: tuple[float, float, float]
    """applied before the rotation; negative mirrors; -1e+12 to 1e+12"""
    shear: tuple[float, float, float]
    """applied first: added to x for each y, to x for each z, to y for each z; -1e+12 to 1e+12"""
    albedo: tuple[float, float, float]
    """part of the light that it sends back, RGB; 0 to 1"""
    resolution: int
    """of its light map along the longer side; of the square map of a mesh [texels]; 8 to 16384"""
    visible: bool
    """to the camera; one that is not still collects light and casts shadows"""
    def replace(
        self, *, name: str = ..., mesh: Mesh | StrPath | None = ..., translate: Vector = ..., rotate: Vector = ...,
        scale: Vector = ..., shear: Vector = ..., albedo: Vector = ..., resolution: int = ..., visible: bool = ...,
    ) -> SceneReceiver: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class SceneFrames:
    """The frames of an animation."""

    def __init__(self, *, first: int = ..., last: int = ..., rate: float = ...) -> None: ...
    first: int
    """frame of the animation; -1e+06 to 1e+06"""
    last: int
    """frame of the animation; at least the first; -1e+06 to 1e+06"""
    rate: float
    """frames per second [1/s]; 0.01 to 10000"""
    def replace(self, *, first: int = ..., last: int = ..., rate: float = ...) -> SceneFrames: ...
    def to_dict(self) -> dict[str, Any]: ...
    __hash__ = None  # type: ignore[assignment]

class Shape:
    """A functional object: a function of space that is positive inside. Immutable. Made by the static methods below,
    by `|`, `&`, `-`, `~`, and by read_shape()."""

    @staticmethod
    def quadric(coefficients: Vector = ...) -> Shape: ...
    @staticmethod
    def plane(normal: Vector = ..., offset: float = ...) -> Shape: ...
    @staticmethod
    def slab(normal: Vector = ..., thickness: float = ...) -> Shape: ...
    @staticmethod
    def sphere(radius: float = ...) -> Shape: ...
    @staticmethod
    def ellipsoid(semi_axes: Vector = ...) -> Shape: ...
    @staticmethod
    def cylinder(radii: Vector = ..., height: float = ..., endless: bool = ...) -> Shape: ...
    @staticmethod
    def cone(radius: float = ..., height: float = ..., endless: bool = ...) -> Shape: ...
    @staticmethod
    def paraboloid(radius: float = ..., height: float = ..., endless: bool = ...) -> Shape: ...
    @staticmethod
    def hyperboloid(
        sheets: int = ..., waist: float = ..., rim: float = ..., height: float = ..., endless: bool = ...,
    ) -> Shape: ...
    @staticmethod
    def cuboid(size: Vector = ..., rounding: float = ...) -> Shape: ...
    @staticmethod
    def torus(major_radius: float = ..., minor_radius: float = ...) -> Shape: ...
    @staticmethod
    def capsule(from_: Vector = ..., to: Vector = ..., radius: float = ...) -> Shape: ...
    @staticmethod
    def revolution(points: Numbers, bulges: Vector = ..., smooth: bool = ...) -> Shape: ...
    @staticmethod
    def extrusion(points: Numbers, bulges: Vector = ..., smooth: bool = ..., height: float = ...) -> Shape: ...
    @staticmethod
    def union(*shapes: Shape, blend: float = ...) -> Shape: ...
    @staticmethod
    def intersection(*shapes: Shape, blend: float = ...) -> Shape: ...
    @staticmethod
    def difference(*shapes: Shape, blend: float = ...) -> Shape: ...
    def complement(self) -> Shape: ...
    def offset(self, distance: float = ...) -> Shape: ...
    def shell(self, thickness: float = ...) -> Shape: ...
    def noise(
        self, amplitude: float = ..., size: float = ..., octaves: int = ..., gain: float = ..., drift: Vector = ...,
        seed: int = ...,
    ) -> Shape: ...
    def waves(
        self, amplitude: float = ..., wavelength: float = ..., phase: float = ..., direction: Vector = ...,
        radial: bool = ...,
    ) -> Shape: ...
    def array(self, count: int = ..., step: Placement = ..., blend: float = ...) -> Shape: ...
    def instances(self, placements: Sequence[Placement], blend: float = ...) -> Shape: ...
    def bulge(self, region: Shape, weight: float = ...) -> Shape:
        """A quadric with weight * max(0, q)^3 added, q being the function of `region`, another quadric."""
    def placed(
        self, *, placement: Placement | None = ..., translate: Vector = ..., rotate: Vector = ..., scale: Vector = ...,
        shear: Vector = ...,
    ) -> Shape:
        """Moved: a `placement`, or its fields translate, rotate, scale and shear as keywords."""
    def named(self, name: str) -> Shape:
        """With a name, that of the group of its triangles."""
    def __or__(self, other: Shape) -> Shape: ...
    def __and__(self, other: Shape) -> Shape: ...
    def __sub__(self, other: Shape) -> Shape: ...
    def __invert__(self) -> Shape: ...
    def values(self, points: Numbers, *, out: DoubleArray | None = ...) -> DoubleArray:
        """The function at `points`, (N, 3) in world space: (N,) float64, positive inside, about a distance near the
        surface. Points that are float64 and contiguous are read where they are, results written to `out`."""
    def gradients(self, points: Numbers, *, out: DoubleArray | None = ...) -> DoubleArray:
        """Gradients of the function at `points`, (N, 3), per world unit: (N, 3) float64."""
    @property
    def bounds(self) -> Box:
        """Two corners of a box that holds the shape, world. Raises InputError for one without end."""
    def triangulate(
        self, *, resolution: int = ..., cell_size: float = ..., tolerance: float = ..., triangles: int = ...,
        threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
        progress: Progress | None = ..., log: Log | None = ...,
    ) -> Mesh:
        """A closed mesh with sharp edges kept. Keywords: resolution, cell_size, tolerance, triangles, and those of every
        long call. Raises InputError for a shape without end or inside."""
    @property
    def hash(self) -> int:
        """Of everything that decides its values and names."""
    def to_json(self) -> str:
        """The text of a shape file."""
    def __hash__(self) -> int: ...

class Mesh:
    """Triangles with shared vertices."""

    def __init__(
        self, positions: Numbers, triangles: Numbers, triangle_group: Numbers | None = ...,
        group_names: Sequence[str] = ...,
    ) -> None: ...
    positions: DoubleArray
    triangles: IndexArray
    triangle_group: IndexArray
    @property
    def group_names(self) -> tuple[str, ...]: ...
    @property
    def writable(self) -> bool:
        """False for meshes of results, whose arrays are read-only."""
    @property
    def bounds(self) -> Box:
        """Two corners of the box around all triangles."""
    def transformed(self, placement: Placement | Numbers) -> Mesh:
        """Another mesh, moved by a Placement or a matrix of 3x4 or 4x4; mirroring keeps outwards outwards."""
    def split_by_group(
        self, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
        progress: Progress | None = ..., log: Log | None = ...,
    ) -> list[Mesh]:
        """A mesh for each of group_names, or the mesh itself where there are none."""

class MeshShell:
    """Faces of a mesh that hang together over edges."""

    @property
    def triangles(self) -> int: ...
    @property
    def open_edges(self) -> int: ...
    @property
    def inconsistent_edges(self) -> int: ...
    @property
    def signed_volume(self) -> float:
        """World units cubed; negative when faces point inwards."""
    @property
    def area(self) -> float:
        """World units squared."""
    @property
    def depth(self) -> int:
        """Number of closed shells around it."""
    @property
    def bounds(self) -> Box: ...
    @property
    def closed(self) -> bool: ...
    @property
    def role(self) -> Literal["open", "flat", "body", "cavity", "immersed"]:
        """What it does to the space inside: open, flat, body, cavity or immersed."""
    @property
    def enclosed_by(self) -> int | None:
        """The innermost shell around it, as an index into MeshReport.shells, or None."""

class MeshReport:
    """What a voxeliser and a person want to know of a mesh."""

    @property
    def vertices(self) -> int: ...
    @property
    def triangles(self) -> int: ...
    @property
    def open_edges(self) -> int:
        """With exactly one face."""
    @property
    def non_manifold_edges(self) -> int:
        """With more than two faces."""
    @property
    def inconsistent_edges(self) -> int:
        """Whose faces are not wound against each other."""
    @property
    def flipped_faces(self) -> int:
        """To reverse, at least, until all are consistent."""
    @property
    def unorientable_patches(self) -> int: ...
    @property
    def duplicate_faces(self) -> int: ...
    @property
    def degenerate_faces(self) -> int: ...
    @property
    def components(self) -> int: ...
    @property
    def signed_volume(self) -> float:
        """World units cubed; negative when faces point inwards."""
    @property
    def area(self) -> float:
        """World units squared."""
    @property
    def bounds(self) -> Box: ...
    @property
    def shells(self) -> list[MeshShell]:
        """Those of most area, 64 at most."""
    @property
    def shell_count(self) -> int: ...
    @property
    def closed_shells(self) -> int: ...
    @property
    def closed_and_consistent(self) -> bool: ...
    @property
    def defects(self) -> str:
        """What is wrong, in words; empty for a flawless mesh."""
    @property
    def remarks(self) -> list[str]:
        """Sentences about what may surprise, with what to try."""

class Image:
    """Named planes of 32-bit floats, rows from the top, scene-linear Rec. 709. image['R'] is a view of a plane,
    (height, width)."""

    def __init__(self, width: int, height: int, planes: dict[str, Any] = ...) -> None: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def channels(self) -> tuple[str, ...]: ...
    @property
    def writable(self) -> bool:
        """False for pictures of results, whose planes are read-only."""
    metadata: dict[str, str]
    def __getitem__(self, channel: str) -> FloatArray: ...
    def __setitem__(self, channel: str, numbers: Numbers) -> None: ...
    def __contains__(self, channel: str) -> bool: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def stack(self, channels: Sequence[str] = ..., *, out: FloatArray | None = ...) -> FloatArray:
        """(height, width, channels) float32: one copy, into `out` where it is given."""
    def copy(self) -> Image:
        """A copy that can be written."""

class Difference:
    """Of one channel or grid that both sides have."""

    @property
    def name(self) -> str: ...
    @property
    def mean_absolute(self) -> float: ...
    @property
    def root_mean_square(self) -> float: ...
    @property
    def maximum(self) -> float: ...
    @property
    def mean_of_a(self) -> float: ...
    @property
    def mean_of_b(self) -> float: ...

class FlipDifference:
    """How different two pictures look when one flips between them."""

    @property
    def map(self) -> FloatArray:
        """(height, width) float32: 0, no difference is seen, to 1."""
    @property
    def mean(self) -> float: ...
    @property
    def maximum(self) -> float: ...
    @property
    def exposures(self) -> list[float]:
        """Stops that the map is the maximum over."""

class Scene:
    """Everything that a picture or a caustic volume depends on. Sections are attributes and keywords."""

    def __init__(
        self, *, volume: SceneVolume = ..., materials: Sequence[Material] = ..., objects: Sequence[SceneObject] = ...,
        lights: Sequence[Light] = ..., receivers: Sequence[SceneReceiver] = ..., voxelise: VoxeliseOptions = ...,
        step_field: StepFieldOptions = ..., photons: PhotonOptions = ..., camera: Camera = ...,
        background: Background = ..., view: ViewOptions = ..., frames: SceneFrames = ...,
    ) -> None: ...
    volume: SceneVolume
    materials: list[Material]
    objects: list[SceneObject]
    lights: list[Light]
    receivers: list[SceneReceiver]
    voxelise: VoxeliseOptions
    step_field: StepFieldOptions
    photons: PhotonOptions
    camera: Camera
    background: Background
    view: ViewOptions
    frames: SceneFrames
    @staticmethod
    def read(
        path: StrPath, *, sets: Sets | None = ..., frame: float = ..., camera: str = ..., fps: float = ...,
        threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
        progress: Progress | None = ..., log: Log | None = ...,
    ) -> Scene:
        """A scene file or a glTF file. Keywords: sets, {'photons.grid': (64, 64)}; frame of the animation; camera and
        fps of glTF files; those of every long call. Raises FileError, InputError with the place."""
    @staticmethod
    def parse(
        text: str, name: StrPath = ..., *, sets: Sets | None = ..., frame: float = ..., camera: str = ...,
        fps: float = ...,
    ) -> Scene:
        """A scene file's text. `name` stands for the file in messages; its folder resolves relative paths."""
    @staticmethod
    def template() -> str:
        """A commented scene file to start from."""
    @staticmethod
    def schema() -> str:
        """JSON Schema (2020-12) of the scene file."""
    def to_json(self) -> str:
        """Canonical JSON of all fields. Meshes and maps in memory are not in it."""
    @property
    def hash(self) -> str:
        """Of the canonical JSON, 16 hexadecimal digits."""
    def copy(self) -> Scene:
        """Shares nothing that can be changed."""

class MeshDeformer:
    """Deforms one mesh again and again: handles that stay where they are share their matrices."""

    def __init__(self, rest: Mesh) -> None: ...
    def deform(
        self, steps: Sequence[Deformer], *, deform_method: Literal["asRigidAsPossible", "laplacian"] = ...,
        deform_iterations: int = ..., threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
        progress: Progress | None = ..., log: Log | None = ...,
    ) -> Mesh:
        """As the function deform()."""

class TopologyResult:
    """A mesh whose parts meet no more, or as one."""

    @property
    def mesh(self) -> Mesh: ...
    @property
    def kept_triangles(self) -> int: ...
    @property
    def new_triangles(self) -> int: ...
    @property
    def parts_before(self) -> int: ...
    @property
    def parts_after(self) -> int: ...

class SelfIntersections:
    """Where a surface runs through itself."""

    @property
    def pairs(self) -> int:
        """Of triangles that share more than a vertex or an edge."""
    @property
    def examples(self) -> IndexArray:
        """(at most 64, 2) uint32: the first of them."""
    @property
    def bounds(self) -> Box: ...

class Domain:
    """A lattice of cubic voxels in world space."""

    def __init__(self, min_corner: Vector, voxel_size: float, dims: Sequence[int] | NDArray[Any]) -> None: ...
    @property
    def min_corner(self) -> tuple[float, float, float]: ...
    @property
    def max_corner(self) -> tuple[float, float, float]: ...
    @property
    def voxel_size(self) -> float:
        """Edge of a voxel, world."""
    @property
    def dims(self) -> tuple[int, int, int]:
        """Voxels along x, y, z."""
    @property
    def voxel_count(self) -> int: ...
    def centers(self) -> tuple[DoubleArray, DoubleArray, DoubleArray]:
        """Three float64 arrays: x, y and z of the voxels' centres, world."""

class Body:
    """A closed mesh or a shape in world space, and what it is made of."""

    def __init__(self, surface: Mesh | Shape, material: Material = ..., priority: int = ..., name: str = ...) -> None: ...
    @property
    def material(self) -> Material: ...
    @property
    def priority(self) -> int: ...
    @property
    def name(self) -> str: ...

class MediumVolume:
    """A volume made by others, as a part of the ambient medium."""

    def __init__(
        self, path: StrPath, grids: Sequence[PropertyGrid], placement: Placement | Numbers | None = ..., *,
        threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
        progress: Progress | None = ..., log: Log | None = ...,
    ) -> None: ...
    @property
    def bounds(self) -> Box | None:
        """Two corners around the active voxels, world; None where there are none."""

class Medium:
    """An immutable optical medium over a domain."""

    @property
    def domain(self) -> Domain: ...
    @property
    def ambient(self) -> Ambient:
        """A copy."""
    def index(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz) float32: refractive index. Voxels from `start` up to `stop` (the whole domain), one fill of `out`
        or of a new array."""
    def attenuation(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz, 3) float32: extinction coefficient, 1/world. Voxels from `start` up to `stop` (the whole domain),
        one fill of `out` or of a new array."""
    def scattering(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz, 3) float32: scattering coefficient, 1/world. Voxels from `start` up to `stop` (the whole domain),
        one fill of `out` or of a new array."""
    def coverage(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz) float32: solid fraction, 0 to 1. Voxels from `start` up to `stop` (the whole domain), one fill of
        `out` or of a new array."""
    def asymmetry(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz) float32: mean cosine g of scattering. Voxels from `start` up to `stop` (the whole domain), one
        fill of `out` or of a new array."""

class RadianceVolume:
    """Light in a domain. Immutable. Its numbers are read voxel by voxel into `out`, or a new array, from `start` up
    to `stop` (the whole domain)."""

    @property
    def domain(self) -> Domain: ...
    def fluence(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz, 3) float32: all light, W/m2."""
    def caustic_fluence(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz, 3) float32: light that was bent, W/m2."""
    def direct_fluence(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz, 3) float32: light that was not bent, W/m2."""
    def direction(
        self, *, start: Sequence[int] | NDArray[Any] | None = ..., stop: Sequence[int] | NDArray[Any] | None = ...,
        out: FloatArray | None = ...,
    ) -> FloatArray:
        """(nx, ny, nz, 3) float32: luminance-weighted mean direction of light, length at most 1."""

class EnergyBalance:
    """Where the power went, W, RGB."""

    @property
    def emitted(self) -> tuple[float, float, float]:
        """By all lights into the domain's box."""
    @property
    def absorbed(self) -> tuple[float, float, float]:
        """Turned to heat."""
    @property
    def scattered(self) -> tuple[float, float, float]:
        """Out of the photons' paths, which is what the view shows."""
    @property
    def escaped(self) -> tuple[float, float, float]:
        """Left the box."""
    @property
    def received(self) -> tuple[float, float, float]:
        """Landed on receivers."""
    @property
    def cut_off(self) -> tuple[float, float, float]:
        """Dropped at the power threshold or the step limit."""
    @property
    def traced_loss(self) -> tuple[float, float, float]:
        """Absorbed and scattered by traced photons."""
    @property
    def deposited_loss(self) -> tuple[float, float, float]:
        """The same from the volume."""
    @property
    def photons_emitted(self) -> int: ...
    @property
    def photons_traced(self) -> int: ...
    @property
    def photons_at_step_limit(self) -> int: ...
    @property
    def photons_not_finite(self) -> int: ...
    @property
    def steps(self) -> int: ...
    @property
    def voxels_crossed(self) -> int: ...
    @property
    def relative_imbalance(self) -> float:
        """|emitted - all others| / emitted, the worst channel."""

class ReceiverMap:
    """What a receiver has collected."""

    @property
    def name(self) -> str: ...
    @property
    def image(self) -> Image:
        """Irradiance, W/m2: R, G, B, caustic.* and direct.*; read-only."""
    @property
    def mesh(self) -> Mesh:
        """The surface, world space; read-only."""
    @property
    def is_mesh(self) -> bool:
        """False for a rectangle, whose map lies on it edge to edge."""
    @property
    def texture_coordinates(self) -> FloatArray:
        """(M, 3, 2) float32, a view: u and v of the corners of each triangle."""

class PhotonResult:
    """What a photon pass gave. Immutable."""

    @property
    def radiance(self) -> RadianceVolume:
        """The RadianceVolume."""
    @property
    def balance(self) -> EnergyBalance:
        """The EnergyBalance."""
    def receiver_maps(self) -> list[ReceiverMap]:
        """A ReceiverMap for each receiver, in their order; made anew by each call."""
    @property
    def lights(self) -> list[PhotonResult]:
        """With `separate`: a PhotonResult of each light by itself."""
    @property
    def light(self) -> str:
        """The name of the light, of one by itself."""
    @property
    def parts(self) -> list[tuple[str, float]]:
        """[(name, milliseconds)] of the parts of the pass."""

class ViewResult:
    """What the camera saw. Immutable."""

    @property
    def image(self) -> Image:
        """R G B A, caustic.*, direct.*, background.*, receiver.*, transmittance.*, depth.Z, steps.Y; read-only."""
    @property
    def steps(self) -> int: ...
    @property
    def rays_not_finite(self) -> int: ...
    @property
    def rays_at_step_limit(self) -> int: ...
    @property
    def samples(self) -> int:
        """Rays from the camera."""
    @property
    def passes(self) -> int: ...

class GridInfo:
    """One grid of a volume file."""

    @property
    def name(self) -> str: ...
    @property
    def type(self) -> str: ...
    @property
    def grid_class(self) -> str: ...
    @property
    def vector_type(self) -> str: ...
    @property
    def active_voxels(self) -> int: ...
    @property
    def leaf_nodes(self) -> int: ...
    @property
    def active_tiles(self) -> int: ...
    @property
    def memory_bytes(self) -> int: ...
    @property
    def index_min(self) -> tuple[int, int, int]: ...
    @property
    def index_max(self) -> tuple[int, int, int]: ...
    @property
    def world(self) -> Box:
        """Two corners of the box of the active voxels' faces."""
    @property
    def voxel_size(self) -> tuple[float, float, float]: ...
    @property
    def minimum(self) -> float:
        """Over active values; of the length for vectors."""
    @property
    def maximum(self) -> float: ...
    @property
    def mean(self) -> float: ...
    @property
    def metadata(self) -> dict[str, str]: ...
    @property
    def mirrored(self) -> bool: ...

class VdbInfo:
    """What is in a volume file."""

    @property
    def grids(self) -> list[GridInfo]: ...
    @property
    def metadata(self) -> dict[str, str]: ...

class DeviceInfo:
    """What can run here, or why it cannot."""

    @property
    def id(self) -> str:
        """What the keyword `device` takes."""
    @property
    def name(self) -> str: ...
    @property
    def usable(self) -> bool: ...
    @property
    def reason(self) -> str:
        """Why it is not usable."""
    @property
    def memory_bytes(self) -> int: ...
    @property
    def parallel_units(self) -> int: ...

class StageRun:
    """One run of one stage."""

    @property
    def stage(self) -> str:
        """surface, medium, stepField, photons or view."""
    @property
    def key(self) -> str:
        """Hash of all that it depends on."""
    @property
    def milliseconds(self) -> float: ...
    @property
    def because(self) -> list[str]:
        """Places of the scene that differ from the run before."""
    @property
    def from_disk(self) -> bool:
        """Read from the cache instead of computed."""

class StagePlan:
    """Whether a stage would run, were view() called now."""

    @property
    def stage(self) -> str: ...
    @property
    def runs(self) -> bool: ...
    @property
    def because(self) -> list[str]: ...

class VolumeSlice:
    """One layer of voxels."""

    @property
    def values(self) -> FloatArray:
        """(rows, columns, 3) float32, rows from the greatest coordinate; numbers are in all three channels."""
    @property
    def least(self) -> float: ...
    @property
    def greatest(self) -> float: ...
    @property
    def corners(self) -> tuple[tuple[float, float, float], ...]:
        """World: top left, top right, bottom right, bottom left."""

class Session:
    """A scene and the latest results of each stage; only stages that a change touches run again. Change the scene in
    place, or assign another. Calls from several threads take turns; results outlive the session."""

    def __init__(
        self, scene: Scene, *, results: int = ..., cache: StrPath | None = ..., threads: int = ..., seed: int = ...,
        device: str = ..., memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
    ) -> None: ...
    scene: Scene
    def medium(self) -> Medium:
        """The Medium of the scene as it is now."""
    def photons(self) -> PhotonResult:
        """The PhotonResult of the scene as it is now."""
    def view(self, *, on_pass: Callable[[ViewResult], object] | None = ...) -> ViewResult:
        """The ViewResult of the scene as it is now. on_pass is called with a copy of it after each pass."""
    def surface(self, index: int) -> Mesh:
        """The triangles of an object as they stand in the world: a read-only Mesh."""
    def content_box(self) -> Box | None:
        """Two corners around everything visible; None where there is nothing."""
    def slice(
        self,
        layer: Literal["radiance", "caustic", "direct", "direction", "index", "attenuation", "step", "energy"] = ...,
        *, axis: int = ..., position: float = ...,
    ) -> VolumeSlice:
        """A VolumeSlice across an axis (0, 1, 2), at a part of the domain along it: radiance, caustic, direct (W/(m2
        sr)), direction, index, attenuation (1/world), step (voxels) or energy (W/m3)."""
    def view_channels(self) -> list[str]:
        """Channels of view()'s picture, known before anything has run."""
    def set_radiance(self, radiance: RadianceVolume) -> None:
        """Takes light from elsewhere in place of the photon stage."""
    def plan(self) -> list[StagePlan]:
        """What view() would run, stage by stage, and why."""
    @property
    def runs(self) -> list[StageRun]:
        """Every StageRun up to the end of the latest call."""
    def cancel(self) -> None:
        """Ends the call that another thread is in: it raises Cancelled. Results stay as they were."""
    @property
    def seed(self) -> int: ...
    @property
    def device(self) -> str: ...
    @property
    def threads(self) -> int: ...
def read_shape(path: StrPath, *, sets: Sets | None = ..., frame: float = ...) -> Shape:
    """A shape file. Raises FileError, InputError with the place."""
def parse_shape(text: str, name: StrPath = ..., *, sets: Sets | None = ..., frame: float = ...) -> Shape:
    """A shape file's text; `name` stands for the file in messages."""
def shape_schema() -> str:
    """JSON Schema (2020-12) of the shape file."""
def read_mesh(
    path: StrPath, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Mesh:
    """An OBJ, PLY, STL or OFF file. Raises FileError, InputError with the line. Keywords of every long call."""
def write_mesh(
    path: StrPath, mesh: Mesh, *, binary: bool = ..., threads: int = ..., seed: int = ..., device: str = ...,
    memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> None:
    """Writes OBJ, PLY, STL or OFF by extension: whole or not at all. Keyword: binary, and those of every long call."""
def check_mesh(
    mesh: Mesh, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> MeshReport:
    """Counts what is not as in a closed, consistently wound surface. Keywords of every long call."""
def deform(
    mesh: Mesh, steps: Sequence[Deformer], *, deform_method: Literal["asRigidAsPossible", "laplacian"] = ...,
    deform_iterations: int = ..., threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Mesh:
    """The mesh after Deformers, in their order. Keywords: deform_method, deform_iterations, and those of every long
    call. Raises UsageError 'deform[i]: ...'."""
def control_topology(
    mesh: Mesh, *, topology: Literal["free", "keep", "merge", "split"] = ..., gap: float = ..., blend: float = ...,
    neck: float = ..., remesh_voxel: float = ..., threads: int = ..., seed: int = ..., device: str = ...,
    memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> TopologyResult:
    """What becomes of parts that meet. Keywords: topology (keep, merge, split), gap, blend, neck, remesh_voxel, and
    those of every long call. Raises InputError for a mesh that is not closed."""
def find_self_intersections(
    mesh: Mesh, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> SelfIntersections:
    """Exact in its decisions. Keywords of every long call."""
def read_image(
    path: StrPath, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Image:
    """Any image that OpenImageIO opens, as linear floats. Raises FileError, InputError."""
def write_image(
    path: StrPath, image: Image, *, layers: Sequence[str] = ..., half: bool = ...,
    compression: Literal["none", "zips", "zip", "piz", "dwaa"] = ..., tiles: int = ..., exposure: float = ...,
    tone: Literal["plain", "aces"] = ..., bits: int = ..., alpha: bool = ..., threads: int = ..., seed: int = ...,
    device: str = ..., memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> None:
    """Writes by extension: .exr keeps the channels, everything else is a picture for a screen. Keywords: layers,
    half, compression, tiles, exposure, tone, bits, alpha, and those of every long call."""
def compare_images(a: Image, b: Image) -> list[Difference]:
    """A Difference for each channel. Raises InputError when sizes or channels differ."""
def flip_difference(
    reference: Image, test: Image, *, pixels_per_degree: float = ..., high_dynamic_range: bool = ...,
    threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> FlipDifference:
    """FLIP (Andersson et al. 2020, 2021). Keywords: pixels_per_degree, high_dynamic_range, and those of every long
    call. Raises InputError when sizes differ or there is no colour."""
def difference_picture(map: Numbers) -> Image:
    """A map of differences, 0 to 1, in the colours 'magma'."""
def domain_around(box: BoxLike, *, resolution: int = ..., voxel_size: float = ..., padding: int = ...) -> Domain:
    """Around two corners: `resolution` voxels along the longest side, or voxels of voxel_size, plus `padding` on
    every side. Raises UsageError."""
def build_medium(
    bodies: Sequence[Body], domain: Domain, *, ambient: Ambient | None = ...,
    volumes: Sequence[MediumVolume] = ..., options: VoxeliseOptions | None = ..., supersample: int = ...,
    blur: int = ..., fill: Literal["auto", "exact", "winding"] = ..., threads: int = ..., seed: int = ...,
    device: str = ..., memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> Medium:
    """Voxelises Bodies onto a Domain. Keywords: ambient, volumes (MediumVolumes), options (VoxeliseOptions) or its
    fields supersample, blur, fill, and those of every long call. Raises UsageError, InputError."""
def read_medium(
    path: StrPath, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Medium:
    """The medium that write_vdb wrote, or any .vdb with a grid `index`."""
def import_medium(
    path: StrPath, *, index: GridMapping | str | None = ..., attenuation: GridMapping | str | None = ...,
    scattering: GridMapping | str | None = ..., asymmetry: GridMapping | str | None = ...,
    coverage: GridMapping | str | None = ..., body: str = ..., material: Material | None = ...,
    ambient: Ambient | None = ..., voxel_size: float = ..., padding: int = ..., blur: int = ...,
    threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Medium:
    """A medium from grids of any .vdb or .nvdb. Keywords: index, attenuation, scattering, asymmetry, coverage
    (GridMappings or names of grids); body (a level set's name) and material; ambient; voxel_size, padding, blur;
    those of every long call. Raises UsageError, InputError naming the grids that the file holds."""
def medium_from_arrays(
    domain: Domain, index: Numbers, *, ambient: Ambient | None = ..., attenuation: Numbers | None = ...,
    scattering: Numbers | None = ..., coverage: Numbers | None = ..., asymmetry: Numbers | None = ...,
    threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Medium:
    """A medium of numbers at the voxels' centres: index, coverage and asymmetry (nx, ny, nz), attenuation and
    scattering (nx, ny, nz, 3); what is not given is that of `ambient`. Numbers are copied once, into sparse
    voxels. Keywords of every long call. Raises UsageError for shapes and numbers that cannot be."""
def surface_from_medium(
    medium: Medium, *, grid: str = ..., isovalue: float | None = ..., adaptivity: float = ..., sharpen: bool = ...,
    threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Mesh:
    """Iso-surface of the coverage. Keywords: isovalue, adaptivity, sharpen, and those of every long call."""
def surface_from_vdb(
    path: StrPath, *, grid: str = ..., isovalue: float | None = ..., adaptivity: float = ..., sharpen: bool = ...,
    threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> Mesh:
    """Iso-surface of a grid of a file. Keywords: grid, isovalue, adaptivity, sharpen, and those of every long call."""
def trace_photons(
    medium: Medium, lights: Sequence[Light], *, step_field: StepFieldOptions | None = ...,
    receivers: Sequence[SceneReceiver] = ..., background: Background | None = ...,
    options: PhotonOptions | None = ..., grid: Sequence[int] = ...,
    scheme: Literal["driftKickDrift", "euler"] = ..., lookup: Literal["trilinear", "nearest"] = ...,
    min_step: float = ..., max_step: float = ..., max_steps: int = ..., cutoff: float = ..., roulette: bool = ...,
    jitter: bool = ..., smooth: bool = ..., separate: bool = ..., fresnel: bool = ..., threads: int = ...,
    seed: int = ..., device: str = ..., memory_limit: int = ..., progress: Progress | None = ...,
    log: Log | None = ...,
) -> PhotonResult:
    """Sends photons from Lights through a Medium. Keywords: step_field (StepFieldOptions), receivers
    (SceneReceivers), background (what lights of the type environment shine with), options (PhotonOptions) or its
    fields, and those of every long call. Raises UsageError, DeviceError."""
def trace_rays(
    medium: Medium, positions: Numbers, directions: Numbers, *, length: float | Numbers | None = ...,
    step_field: StepFieldOptions | None = ..., options: PhotonOptions | None = ..., grid: Sequence[int] = ...,
    scheme: Literal["driftKickDrift", "euler"] = ..., lookup: Literal["trilinear", "nearest"] = ...,
    min_step: float = ..., max_step: float = ..., max_steps: int = ..., cutoff: float = ..., roulette: bool = ...,
    jitter: bool = ..., smooth: bool = ..., separate: bool = ..., fresnel: bool = ..., threads: int = ...,
    seed: int = ..., device: str = ..., memory_limit: int = ..., progress: Progress | None = ...,
    log: Log | None = ...,
) -> dict[str, NDArray[Any]]:
    """Carries rays that start inside the domain through the medium: positions and unit directions (N, 3), world.
    Returns arrays: position and direction (N, 3) at the end, optical_momentum, length, steps, left (N,).
    Keywords: length (after which a ray stops, a number or (N,); 0 is none), step_field, options (PhotonOptions)
    or its fields, and those of every long call."""
def write_receiver_map(
    path: StrPath, map: ReceiverMap, *, layers: Sequence[str] = ..., half: bool = ...,
    compression: Literal["none", "zips", "zip", "piz", "dwaa"] = ..., tiles: int = ..., exposure: float = ...,
    tone: Literal["plain", "aces"] = ..., bits: int = ..., alpha: bool = ..., threads: int = ..., seed: int = ...,
    device: str = ..., memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> None:
    """The picture, and for a mesh an .obj with texture coordinates beside it. Keywords as of write_image."""
def render_view(
    medium: Medium, light: PhotonResult | RadianceVolume, camera: Camera, *, background: Background | None = ...,
    step_field: StepFieldOptions | None = ..., on_pass: Callable[[ViewResult], object] | None = ...,
    options: ViewOptions | None = ..., step: float = ..., samples: int = ...,
    filter: Literal["box", "tent", "gaussian", "blackmanHarris"] = ..., noise: float = ..., max_steps: int = ...,
    fresnel: bool = ..., exposure: float = ..., threads: int = ..., seed: int = ..., device: str = ...,
    memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> ViewResult:
    """What a Camera sees of a Medium and light (a PhotonResult with its receivers, or a RadianceVolume). Keywords:
    background (Background), step_field (StepFieldOptions), on_pass (called with a copy of the ViewResult after
    each pass), options (ViewOptions) or its fields, and those of every long call. Raises UsageError."""
def write_vdb(
    path: StrPath, what: Medium | PhotonResult | RadianceVolume, medium: Medium | None = ..., *,
    preset: Literal["none", "blender", "houdini", "arnold", "unreal", "renderman"] = ..., half: bool = ...,
    parts: bool = ..., exposure: float = ..., metadata: dict[str, str] = ..., threads: int = ..., seed: int = ...,
    device: str = ..., memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> None:
    """Writes a Medium, or light (PhotonResult, RadianceVolume) with its medium, as .vdb or .nvdb: whole or not at
    all. Keywords: preset, half, parts, exposure, metadata, and those of every long call. Raises FileError,
    UsageError."""
def write_usd(
    path: StrPath, files: StrPath | Mapping[int, StrPath], *, meters_per_unit: float = ...,
    up_axis: Literal["y", "z"] = ..., rate: float = ..., threads: int = ..., seed: int = ..., device: str = ...,
    memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> None:
    """Writes an OpenUSD stage (.usda) of one Volume beside its .vdb files: a path, or a dict of paths by frame,
    which become time samples. Keywords: meters_per_unit, up_axis, rate, and those of every long call. Raises
    FileError, InputError, UsageError."""
def read_radiance(
    path: StrPath, domain: Domain, *, threads: int = ..., seed: int = ..., device: str = ...,
    memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> RadianceVolume:
    """The light that write_vdb wrote, on a Domain."""
def inspect_vdb(
    path: StrPath, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> VdbInfo:
    """The grids of a .vdb or .nvdb file. Raises FileError, InputError for a damaged one."""
def compare_vdb(
    a: StrPath, b: StrPath, *, threads: int = ..., seed: int = ..., device: str = ..., memory_limit: int = ...,
    progress: Progress | None = ..., log: Log | None = ...,
) -> list[Difference]:
    """A Difference for each grid. Raises InputError where grids are missing or differ in type."""
def convert_vdb(
    source: StrPath, target: StrPath, *,
    preset: Literal["none", "blender", "houdini", "arnold", "unreal", "renderman"] = ..., half: bool = ...,
    parts: bool = ..., exposure: float = ..., metadata: dict[str, str] = ..., threads: int = ..., seed: int = ...,
    device: str = ..., memory_limit: int = ..., progress: Progress | None = ..., log: Log | None = ...,
) -> None:
    """.vdb to .nvdb or back. Keywords as of write_vdb."""
def list_devices() -> list[DeviceInfo]:
    """The CPU, then every CUDA device, or one unusable entry that says why there is none."""
def selected_device(device: str = ...) -> str:
    """What a word selects on this machine. Raises UsageError for no device, DeviceError for one that cannot be used."""
def has_frame_place(path: str) -> bool:
    """Whether a name has a place for a frame: #### or %04d."""
def with_frame(path: str, frame: int) -> str:
    """'a.####.vdb', 12 -> 'a.0012.vdb'."""
