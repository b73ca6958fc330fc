"""The parts of a glTF file's JSON that are read here: types, lengths, ranges and indices.

Source: Khronos glTF 2.0 specification, §5. Keys that are not read here may be anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationInfo,
    model_validator,
)
from pydantic.alias_generators import to_camel
from pydantic_core import PydanticCustomError

FARTHEST = 1e9
"""Numbers that place things are at most this: products of several stay in single precision."""
SHORTEST_QUATERNION = 1e-6
"""A shorter one has no direction that a file could have meant."""

Size: TypeAlias = Annotated[int, Field(ge=0, lt=2**53)]
Number: TypeAlias = Annotated[float, Field(ge=-3e38, le=3e38, allow_inf_nan=False)]
NotNegative: TypeAlias = Annotated[float, Field(ge=0, le=3e38, allow_inf_nan=False)]
Placing: TypeAlias = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST, allow_inf_nan=False)]
Light: TypeAlias = Annotated[float, Field(ge=0, le=1e18, allow_inf_nan=False)]
Color: TypeAlias = Annotated[list[NotNegative], Field(min_length=3, max_length=3)]
Triple: TypeAlias = Annotated[list[Placing], Field(min_length=3, max_length=3)]
Extensions: TypeAlias = dict[str, dict[str, Any]]


def _in_list(key: str) -> Callable[[int, ValidationInfo], int]:
    def check(index: int, info: ValidationInfo) -> int:
        count: int = (info.context or {}).get(key, 0)
        if not 0 <= index < count:
            message = "refers to number {index} of its {key}, but has {count}"
            raise PydanticCustomError(
                "index", message, {"index": index, "key": key, "count": count}
            )
        return index

    return check


def _turns(quaternion: list[float]) -> list[float]:
    if math.hypot(*quaternion) < SHORTEST_QUATERNION:
        raise PydanticCustomError("quaternion", "has length 0; a rotation needs length 1")
    return quaternion


Accessor: TypeAlias = Annotated[int, AfterValidator(_in_list("accessors"))]
Buffer: TypeAlias = Annotated[int, AfterValidator(_in_list("buffers"))]
View: TypeAlias = Annotated[int, AfterValidator(_in_list("bufferViews"))]
ImageIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("images"))]
MaterialIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("materials"))]
MeshIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("meshes"))]
NodeIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("nodes"))]
SamplerIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("samplers"))]
SceneIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("scenes"))]
TextureIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("textures"))]
SkinIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("skins"))]
LampIndex: TypeAlias = Annotated[int, AfterValidator(_in_list("lights"))]
Quaternion: TypeAlias = Annotated[
    list[Placing], Field(min_length=4, max_length=4), AfterValidator(_turns)
]

ABSENT: Any = None
"""What a key has that the file does not; a null in the file is refused."""


def _key(name: str) -> str:
    return name if name.startswith("KHR_") else to_camel(name)


class _Part(BaseModel):
    """A JSON object with the keys that are read here; it may have others."""

    model_config = ConfigDict(strict=True, extra="ignore", alias_generator=_key)


class _Buffer(_Part):
    uri: str = ABSENT
    byte_length: Size


class _View(_Part):
    buffer: Buffer
    byte_offset: Size = ABSENT
    byte_length: Size
    byte_stride: Annotated[int, Field(ge=0, le=252)] = ABSENT


class _SparseIndices(_Part):
    buffer_view: View
    byte_offset: Size = ABSENT
    component_type: Literal[5121, 5123, 5125]


class _SparseValues(_Part):
    buffer_view: View
    byte_offset: Size = ABSENT


class _Sparse(_Part):
    count: Annotated[int, Field(ge=1, lt=2**53)]
    indices: _SparseIndices
    values: _SparseValues


class _Accessor(_Part):
    buffer_view: View = ABSENT
    byte_offset: Size = ABSENT
    component_type: Literal[5120, 5121, 5122, 5123, 5125, 5126]
    normalized: bool = ABSENT
    count: Annotated[int, Field(ge=1, lt=2**53)]
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    sparse: _Sparse = ABSENT


class _Image(_Part):
    name: str = ABSENT
    uri: str = ABSENT
    buffer_view: View = ABSENT

    @model_validator(mode="after")
    def _has_data(self) -> Self:
        if not {"uri", "buffer_view"} & self.model_fields_set:
            raise PydanticCustomError("image", "has neither uri nor bufferView")
        return self


class _Sampler(_Part):
    wrap_s: Literal[10497, 33071, 33648] = ABSENT
    wrap_t: Literal[10497, 33071, 33648] = ABSENT


class _Texture(_Part):
    source: ImageIndex = ABSENT
    sampler: SamplerIndex = ABSENT
    extensions: Extensions = ABSENT


UvSet: TypeAlias = Literal[0, 1]
Pair: TypeAlias = Annotated[list[Placing], Field(min_length=2, max_length=2)]


class _TextureTransform(_Part):
    offset: Pair = ABSENT
    rotation: Placing = ABSENT
    scale: Pair = ABSENT
    tex_coord: UvSet = ABSENT


class _TextureInfoExtensions(_Part):
    KHR_texture_transform: _TextureTransform = ABSENT


class _TextureInfo(_Part):
    index: TextureIndex
    tex_coord: UvSet = ABSENT
    scale: Number = ABSENT
    extensions: _TextureInfoExtensions = ABSENT


class _Surface(_Part):
    base_color_factor: Annotated[list[NotNegative], Field(min_length=4, max_length=4)] = ABSENT
    base_color_texture: _TextureInfo = ABSENT
    metallic_factor: NotNegative = ABSENT
    roughness_factor: NotNegative = ABSENT
    metallic_roughness_texture: _TextureInfo = ABSENT


class _Glow(_Part):
    emissive_strength: Light = ABSENT


class _MaterialExtensions(_Part):
    KHR_materials_emissive_strength: _Glow = ABSENT
    KHR_materials_unlit: dict[str, Any] = ABSENT


class _Material(_Part):
    name: str = ABSENT
    pbr_metallic_roughness: _Surface = ABSENT
    normal_texture: _TextureInfo = ABSENT
    emissive_texture: _TextureInfo = ABSENT
    emissive_factor: Annotated[list[Light], Field(min_length=3, max_length=3)] = ABSENT
    alpha_mode: Literal["OPAQUE", "MASK", "BLEND"] = ABSENT
    alpha_cutoff: NotNegative = ABSENT
    double_sided: bool = ABSENT
    extensions: _MaterialExtensions = ABSENT


class _Primitive(_Part):
    attributes: dict[str, Accessor]
    indices: Accessor = ABSENT
    material: MaterialIndex = ABSENT
    mode: Annotated[int, Field(ge=0, le=6)] = ABSENT
    extensions: Extensions = ABSENT


class _Mesh(_Part):
    name: str = ABSENT
    primitives: list[_Primitive]


class _LampOfNode(_Part):
    light: LampIndex


class _NodeExtensions(_Part):
    KHR_lights_punctual: _LampOfNode = ABSENT


class _Node(_Part):
    name: str = ABSENT
    children: list[NodeIndex] = ABSENT
    mesh: MeshIndex = ABSENT
    skin: SkinIndex = ABSENT
    matrix: Annotated[list[Placing], Field(min_length=16, max_length=16)] = ABSENT
    translation: Triple = ABSENT
    rotation: Quaternion = ABSENT
    scale: Triple = ABSENT
    extensions: _NodeExtensions = ABSENT


class _Skin(_Part):
    name: str = ABSENT
    inverse_bind_matrices: Accessor = ABSENT
    joints: Annotated[list[NodeIndex], Field(min_length=1)]


class _Scene(_Part):
    nodes: list[NodeIndex] = ABSENT


class _AnimationSampler(_Part):
    input: Accessor
    output: Accessor
    interpolation: Literal["STEP", "LINEAR", "CUBICSPLINE"] = ABSENT


class _Target(_Part):
    node: NodeIndex = ABSENT
    path: str


class _Channel(_Part):
    sampler: Size
    target: _Target


class _Animation(_Part):
    name: str = ABSENT
    channels: list[_Channel]
    samplers: list[_AnimationSampler]

    @model_validator(mode="after")
    def _has_the_samplers(self) -> Self:
        for number, channel in enumerate(self.channels):
            if channel.sampler >= len(self.samplers):
                what = {"number": number, "sampler": channel.sampler, "count": len(self.samplers)}
                message = "has sampler {sampler} in channel {number}, but {count} samplers"
                raise PydanticCustomError("sampler", message, what)
        return self


class _Cone(_Part):
    inner_cone_angle: Annotated[float, Field(ge=0, le=math.pi / 2)] = 0.0
    outer_cone_angle: Annotated[float, Field(gt=0, le=math.pi / 2 + 1e-6)] = math.pi / 4

    @model_validator(mode="after")
    def _opens(self) -> Self:
        if self.inner_cone_angle >= self.outer_cone_angle:
            raise PydanticCustomError("cone", "has an inner cone that is not within its outer one")
        return self


class _Lamp(_Part):
    type: str
    spot: _Cone = ABSENT
    color: Color = ABSENT
    intensity: Light = ABSENT
    range: Annotated[float, Field(gt=0, le=1e18, allow_inf_nan=False)] = ABSENT


class _Lamps(_Part):
    lights: list[_Lamp]


class _FileExtensions(_Part):
    KHR_lights_punctual: _Lamps = ABSENT


class Root(_Part):
    """The whole JSON of a file."""

    accessors: list[_Accessor] = ABSENT
    animations: list[_Animation] = ABSENT
    buffers: list[_Buffer] = ABSENT
    buffer_views: list[_View] = ABSENT
    cameras: list[dict[str, Any]] = ABSENT
    extensions: _FileExtensions = ABSENT
    extensions_required: list[str] = ABSENT
    images: list[_Image] = ABSENT
    materials: list[_Material] = ABSENT
    meshes: list[_Mesh] = ABSENT
    nodes: list[_Node] = ABSENT
    samplers: list[_Sampler] = ABSENT
    scene: SceneIndex = ABSENT
    scenes: list[_Scene] = ABSENT
    skins: list[_Skin] = ABSENT
    textures: list[_Texture] = ABSENT
