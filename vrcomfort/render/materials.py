"""Materials as tables: constants by index, images by layer, and what makes two draws differ.

Things whose materials differ in constants and in layers alone are drawn together: shaders find both
by the thing's index into a block of materials. No OpenGL.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.gpu import shaders
from vrcomfort.scene.data import Material, Scene, UvMap, Wrap

Features: TypeAlias = tuple[str, ...]
"""Defines of ``scene.frag``."""

BLOCK_BYTES = 16384
"""Every driver has uniform blocks of this size."""

MOST_LAYERS = 2048
"""Every driver has so many in a texture array."""


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
    """What the images of one texture array share."""

    size_px: tuple[int, int]
    wrap: tuple[Wrap, Wrap]
    srgb: bool
    part: int
    """Counts arrays that are alike: one has at most `MOST_LAYERS` images."""


class Place(NamedTuple):
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
    places: dict[tuple[int, bool], Place]

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
        places: dict[tuple[int, bool], Place] = {}
        alike: dict[ArrayKind, int] = {}
        for index, srgb in used:
            image = scene.images[index]
            height, width = image.pixels.shape[:2]
            first = ArrayKind((width, height), image.wrap, srgb, 0)
            count = alike[first] = alike.get(first, -1) + 1
            kind = first._replace(part=count // MOST_LAYERS)
            images = members.setdefault(kind, [])
            places[index, srgb] = Place(list(members).index(kind), len(images))
            images.append(index)
        return cls(tuple(members), tuple(map(tuple, members.values())), places)

    def place(self, material: Material, slot: Slot) -> Place | None:
        """Return where a material's image is, None where it has none."""
        image = slot.image(material)
        return None if image is None else self.places[image, slot.srgb]


class BatchKey(NamedTuple):
    """What one multi-draw shares: everything that needs a change of OpenGL state.

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
        """Whether what is behind shines through."""
        return "ALPHA_BLEND" in self.features

    @property
    def of_depth(self) -> BatchKey:
        """Return what matters of it where only depth is drawn: holes, and which way it faces."""
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
    """Return what a draw of one material needs."""
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
