"""Materials, their textures and their programs: everything a draw call has to bind.

Materials are tables: constants by index, images by layer. Instances whose materials differ in
constants and in layers alone are drawn together: shaders find both by the instance's index into a
block of materials.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.gpu import gl, passes, shaders
from vrcomfort.gpu.gl import is_software
from vrcomfort.optics.focus import RAYS
from vrcomfort.scene.data import Image, Material, Scene, UvMap, Wrap

Features: TypeAlias = tuple[str, ...]
"""Defines of ``scene.frag``."""

BLOCK_BYTES = 16384
"""Every driver has uniform blocks of this size (least GL_MAX_UNIFORM_BLOCK_SIZE)."""

MOST_LAYERS = 2048
"""Every driver has as many layers in a texture array (least GL_MAX_ARRAY_TEXTURE_LAYERS)."""


class Slot(NamedTuple):
    """A use that a material has for an image."""

    name: str
    define: str
    sampler: str
    srgb: bool

    def image(self, material: Material) -> int | None:
        """Return the image, None where there is none."""
        found: int | None = getattr(material, f"{self.name}_image")
        return found

    def uv_map(self, material: Material) -> UvMap:
        """Return where on the image a vertex is."""
        found: UvMap = getattr(material, f"{self.name}_uv")
        return found


SLOTS = (
    Slot("base_color", "BASE_COLOR_IMAGE", "base_color_images", srgb=True),
    Slot("normal", "NORMAL_IMAGE", "normal_images", srgb=False),
    Slot(
        "metallic_roughness",
        "METALLIC_ROUGHNESS_IMAGE",
        "metallic_roughness_images",
        srgb=False,
    ),
    Slot("emissive", "EMISSIVE_IMAGE", "emissive_images", srgb=True),
)
"""In the order of ``Material.layers`` (material.glsl)."""


class ArrayKind(NamedTuple):
    """Size and sampling that the images of one texture array share."""

    size_px: tuple[int, int]
    wrap: tuple[Wrap, Wrap]
    srgb: bool
    part: int
    """Counts arrays that are alike: one has at most `MOST_LAYERS` images."""


class TextureLayer(NamedTuple):
    """Where an image is."""

    array: int
    layer: int


@dataclass(frozen=True, eq=False)
class ImageArrays:
    """Which images lie in which texture array.

    Parameters
    ----------
    layers
        Images of each array, by index into `Scene.images`.
    places
        By (image, is sRGB): one image may be used either way.
    """

    kinds: tuple[ArrayKind, ...]
    layers: tuple[tuple[int, ...], ...]
    places: dict[tuple[int, bool], TextureLayer]

    @classmethod
    def of(cls, scene: Scene) -> ImageArrays:
        """Gather the images that the scene's materials use."""
        used = dict.fromkeys(
            (image, slot.srgb)
            for material in scene.materials
            for slot in SLOTS
            for image in [slot.image(material)]
            if image is not None
        )
        members: dict[ArrayKind, list[int]] = {}
        places: dict[tuple[int, bool], TextureLayer] = {}
        alike: dict[ArrayKind, int] = {}
        for index, srgb in used:
            image = scene.images[index]
            height, width = image.pixels.shape[:2]
            first = ArrayKind((width, height), image.wrap, srgb, 0)
            count = alike[first] = alike.get(first, -1) + 1
            kind = first._replace(part=count // MOST_LAYERS)
            images = members.setdefault(kind, [])
            places[index, srgb] = TextureLayer(list(members).index(kind), len(images))
            images.append(index)
        return cls(tuple(members), tuple(map(tuple, members.values())), places)

    def place(self, material: Material, slot: Slot) -> TextureLayer | None:
        """Return where a material's image is, None where it has none."""
        image = slot.image(material)
        return None if image is None else self.places[image, slot.srgb]


class BatchKey(NamedTuple):
    """OpenGL state of one multi-draw.

    Parameters
    ----------
    features
        The variant of the shaders.
    arrays
        The texture array of each slot, None where there is none.
    double_sided, mirrored
        Whether back faces are seen; whether front faces are clockwise.
    block
        Which block of materials; None where they do not matter.
    """

    features: Features
    arrays: tuple[int | None, ...]
    double_sided: bool
    mirrored: bool
    block: int | None

    @property
    def masked(self) -> bool:
        """Whether alpha cuts holes."""
        return "ALPHA_MASK" in self.features

    @property
    def blended(self) -> bool:
        """Whether the background shows through."""
        return "ALPHA_BLEND" in self.features

    @property
    def of_depth(self) -> BatchKey:
        """Return the state for drawing depth alone: alpha masks and faces."""
        plain: tuple[int | None, ...] = (None,) * len(self.arrays)
        if not self.masked:
            skin = ("SKIN",) if "SKIN" in self.features else ()
            return BatchKey(skin, plain, self.double_sided, self.mirrored, None)
        of_alpha = ("ALPHA_MASK", "BASE_COLOR_IMAGE", "UV_MAPS", "UV_1", "SKIN")
        kept = [name for name in of_alpha if name in self.features]
        return self._replace(features=tuple(kept), arrays=(self.arrays[0], *plain[1:]))


def batch_key(
    scene: Scene,
    images: ImageArrays,
    material: int,
    *,
    vertex_colors: bool,
    skinned: bool,
    mirrored: bool,
) -> BatchKey:
    """Return the OpenGL state of a material."""
    surface = scene.materials[material]
    places = [images.place(surface, slot) for slot in SLOTS]
    maps = [slot.uv_map(surface) for slot in SLOTS if slot.image(surface) is not None]
    ambient = scene.environment.ambient_in_vertex_alpha and surface.alpha_mode == "OPAQUE"
    present = {
        **{slot.define: slot.image(surface) is not None for slot in SLOTS},
        "UV_MAPS": any(uv_map != UvMap() for uv_map in maps),
        "UV_1": any(uv_map.uv_set == 1 for uv_map in maps),
        "UNLIT": surface.unlit,
        "ALPHA_MASK": surface.alpha_mode == "MASK",
        "ALPHA_BLEND": surface.alpha_mode == "BLEND",
        "DOUBLE_SIDED": surface.double_sided,
        "VERTEX_COLORS": vertex_colors,
        "SKIN": skinned,
        "AMBIENT_IN_ALPHA": vertex_colors and ambient,
    }
    return BatchKey(
        tuple(name for name, needed in present.items() if needed),
        tuple(None if place is None else place.array for place in places),
        surface.double_sided,
        mirrored,
        material // materials_per_block(),
    )


def materials_per_block() -> int:
    """Return the number of materials in a uniform block."""
    return BLOCK_BYTES // layout().itemsize


def layout() -> np.dtype[np.void]:
    """Return the memory layout of a material, as ``material.glsl`` declares it."""
    return shaders.struct_dtype("material.glsl", "Material")


def material_blocks(scene: Scene, images: ImageArrays) -> NDArray[np.void]:
    """Return (blocks, materials per block) constants of all materials."""
    each = materials_per_block()
    blocks = max(-(-len(scene.materials) // each), 1)
    rows = np.zeros(blocks * each, layout())
    for row, material in zip(rows, scene.materials, strict=False):
        row["base_color"] = material.base_color
        row["emissive"] = (*material.emissive, material.normal_scale)
        row["reflection"] = (material.metallic, material.roughness, material.alpha_cutoff, 0)
        places = [images.place(material, slot) for slot in SLOTS]
        row["layers"] = [0 if place is None else place.layer for place in places]
        maps = [slot.uv_map(material) for slot in SLOTS]
        matrices = np.array([uv_map.matrix() for uv_map in maps])
        row["uv_u"], row["uv_v"] = (np.pad(matrices[:, axis], ((0, 0), (0, 1))) for axis in (0, 1))
        row["uv_u"][:, 3] = [uv_map.uv_set for uv_map in maps]
    return rows.reshape(blocks, each)


ANISOTROPY = 8.0
"""Samples along the steep axis of a slanted surface, at most, where the hardware does it."""

SHADOW_UNIT = 32
"""Textures of the scene lie on units that no other pass binds anything to: they are bound once a
frame. Below are those of passes (OpenGL 4.5 promises 16 to each shader) and moderngl's own, the
32nd at most."""

NEAREST_UNIT = SHADOW_UNIT + 1
"""Of how near things may be in a picture of what lies behind others."""

FIRST_UNIT = NEAREST_UNIT + 1
UNITS = 96
"""Least GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS of OpenGL 4.5."""


class TextureStore:
    """Uploads the images of a scene.

    Raises
    ------
    InputError
        If the scene's images have more different sizes than there are texture units.
    """

    def __init__(self, ctx: moderngl.Context, scene: Scene, arrays: ImageArrays) -> None:
        if len(arrays.kinds) > UNITS - FIRST_UNIT:
            raise InputError(
                f"scene {scene.name!r} has images of {len(arrays.kinds)} kinds (sizes, repetition, "
                f"colour spaces); at most {UNITS - FIRST_UNIT} are drawn: give them equal sizes"
            )
        most = anisotropy(ctx)
        uploaded = [
            _upload(ctx, kind, [scene.images[index] for index in images], anisotropy=most)
            for kind, images in zip(arrays.kinds, arrays.layers, strict=True)
        ]

        self.images = tuple(
            passes.PassImage.of(each, mipmaps=True, of_surface=True) for each in uploaded
        )
        """What surfaces may read."""
        self._ctx = ctx
        beside: list[moderngl.Texture | moderngl.TextureArray | None]
        beside = [None] * (FIRST_UNIT - SHADOW_UNIT)
        self._textures = [*beside, *uploaded]
        self.bind = gl.binder(ctx, self._textures, SHADOW_UNIT)
        """Puts every texture on its unit."""

    def add(self, unit: int, texture: passes.AnyTexture) -> None:
        """Add a texture that surfaces read, at `SHADOW_UNIT` or `NEAREST_UNIT`."""
        self._textures[unit - SHADOW_UNIT] = texture
        self.bind = gl.binder(self._ctx, self._textures, SHADOW_UNIT)


def unit(array: int) -> int:
    """Return the texture unit of an array."""
    return FIRST_UNIT + array


def anisotropy(ctx: moderngl.Context) -> float:
    """Return the anisotropy that textures get on this driver; 1 is none, as without a GPU."""
    return 1.0 if is_software(ctx) else min(ANISOTROPY, float(ctx.max_anisotropy))


def _upload(
    ctx: moderngl.Context, kind: ArrayKind, images: list[Image], *, anisotropy: float
) -> moderngl.TextureArray:
    pixels = [image.pixels.tobytes() for image in images]
    texture = gl.image_array(ctx, kind.size_px, pixels, srgb=kind.srgb)
    texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    gl.wrap(ctx, texture, kind.wrap)
    texture.anisotropy = anisotropy
    return texture


MATERIAL_BINDING = 2

MakeVertexArray = Callable[[moderngl.Program], moderngl.VertexArray]


class BatchState(NamedTuple):
    """OpenGL state of a batch: vertex array with its program, block of materials, culling."""

    array: moderngl.VertexArray
    block: int | None
    faces: str | None
    """Winding of front faces (mirrored instances turn it round); None where both sides are seen."""
    covers: bool
    """Whether alpha says how many samples of a pixel are covered."""


class MaterialBuffer:
    """All materials as ranges of one uniform buffer."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, images: ImageArrays) -> None:
        blocks = material_blocks(scene, images)
        size, stride = blocks[0].nbytes, gl.uniform_stride(blocks[0].nbytes)
        data = b"".join(block.tobytes().ljust(stride, b"\0") for block in blocks)
        bind = partial(gl.buffer(ctx, data).bind_to_uniform_block, MATERIAL_BINDING, size=size)
        self.bind = [partial(bind, offset=block * stride) for block in range(len(blocks))]
        """Makes a block of materials the one that shaders see, by its number."""


class BatchStateFactory:
    """Makes the states of a scene's batches; equal variants share a program and a vertex array."""

    def __init__(
        self,
        ctx: moderngl.Context,
        color_array: MakeVertexArray,
        depth_array: MakeVertexArray,
        *,
        scene_features: shaders.Defines,
    ) -> None:
        self._ctx = ctx
        self._color_array, self._depth_array = color_array, depth_array
        self._scene_features = dict(scene_features)
        self._made: dict[tuple[object, ...], moderngl.VertexArray] = {}

    def color(self, key: BatchKey, defines: shaders.Defines | None = None) -> BatchState:
        """Return the state that draws a batch in colour; `defines` besides those of the scene."""
        features = {**self._scene_features, **(defines or {})}
        return self._surface(key, ("scene/scene.frag", "scene/scene.vert"), features)

    def depth(self, key: BatchKey) -> BatchState:
        """Return the state that draws a batch's depth alone; `key` is one `of_depth`."""
        fragment = "scene/depth.frag" if key.masked else None
        return self._surface(key, (fragment, "scene/depth.vert"), {"VIEWS": RAYS})

    def semantic(self, key: BatchKey) -> BatchState:
        """Return the state that draws depth and semantic weights; `key` is one `of_depth`."""
        return self._surface(
            key, ("scene/depth.frag", "scene/depth.vert"), {"SEMANTIC": 1, "VIEWS": RAYS}
        )

    def _surface(
        self, key: BatchKey, files: tuple[str | None, str], defines: shaders.Defines
    ) -> BatchState:
        fragment, vertex = files
        variant = (files, key.features, key.arrays, *defines)
        if variant not in self._made:
            named = {
                **defines,
                **dict.fromkeys(key.features, 1),
                "MATERIALS": materials_per_block(),
            }
            program = shaders.program(self._ctx, fragment, vertex, named)
            _name_units(program, key)
            make = self._color_array if vertex == "scene/scene.vert" else self._depth_array
            self._made[variant] = make(program)
        faces = None if key.double_sided else "cw" if key.mirrored else "ccw"
        # What lies behind near things has one sample a pixel.
        covers = key.masked and fragment == "scene/scene.frag" and "BEHIND_NEAR" not in defines
        return BatchState(self._made[variant], key.block, faces, covers)


def _name_units(program: moderngl.Program, key: BatchKey) -> None:
    """Tell samplers where their arrays are."""
    for slot, array in zip(SLOTS, key.arrays, strict=True):
        if array is not None and slot.sampler in program:
            program[slot.sampler] = unit(array)
    if "shadow_map" in program:
        program["shadow_map"] = SHADOW_UNIT
    if "nearest" in program:
        program["nearest"] = NEAREST_UNIT
