"""GPU memory account: every texture and buffer that `gl` made, and its bytes.

Bytes are those of the format that was asked for, all samples and mipmap levels included. The
driver's overhead (padding, compression data) and the runtime's swapchains are not counted.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import prod
from typing import Literal
from weakref import WeakKeyDictionary

import moderngl

Kind = Literal["target", "image", "buffer"]
"""Render targets, images of the scene, and everything that is no texture."""

_DTYPE_BYTES = {"f1": 1, "f2": 2, "f4": 4, "u4": 4}
_KINDS: tuple[Kind, ...] = ("target", "image", "buffer")


@dataclass(frozen=True)
class GpuAllocation:
    """One texture or buffer, with its size and format in words."""

    kind: Kind
    what: str
    bytes: int


class MemoryAccount:
    """Everything that was made in one context and still lives; entries go with their objects."""

    def __init__(self) -> None:
        self._made: WeakKeyDictionary[object, tuple[int, GpuAllocation]] = WeakKeyDictionary()
        self._count = 0

    def add(
        self,
        made: moderngl.Texture | moderngl.TextureArray | moderngl.Buffer,
        allocation: GpuAllocation,
    ) -> None:
        """Enter a new allocation."""
        self._made[made] = self._count, allocation
        self._count += 1

    def mark(self) -> int:
        """Return a mark; later entries lie after it."""
        return self._count

    def between(self, first: int, last: int) -> tuple[GpuAllocation, ...]:
        """Return the live entries between two marks, in order."""
        living = sorted(self._made.values(), key=lambda entry: entry[0])
        return tuple(entry for number, entry in living if first <= number < last)


def account(ctx: moderngl.Context) -> MemoryAccount:
    """Return the account of a context."""
    if not isinstance(ctx.extra, MemoryAccount):
        ctx.extra = MemoryAccount()
    found: MemoryAccount = ctx.extra
    return found


def texture_bytes(
    size_px: tuple[int, int], texel: int, *, samples: int = 0, mipmaps: bool = False
) -> int:
    """Return the bytes of a texture (`texel`: of one): all samples, or all mipmap levels."""
    levels = max(size_px).bit_length() if mipmaps else 1
    sizes = ([max(side >> level, 1) for side in size_px] for level in range(levels))
    return max(samples, 1) * texel * sum(map(prod, sizes))


def texel_bytes(components: int, dtype: str) -> int:
    """Return the bytes of a texel; `dtype` is moderngl's."""
    return components * _DTYPE_BYTES[dtype]


def texture(
    kind: Kind,
    size_px: tuple[int, int],
    components: int,
    dtype: str,
    *,
    samples: int = 0,
    mipmaps: bool = False,
    layers: int = 1,
) -> GpuAllocation:
    """Return the entry of a texture, or of an array of them; `dtype` is moderngl's."""
    words = [f"{size_px[0]}×{size_px[1]}", f"{components} × {8 * _DTYPE_BYTES[dtype]} bit"]
    words += [f"{samples} samples"] if samples else []
    words += ["mipmaps"] if mipmaps else []
    words += [f"{layers} layers"] if layers > 1 else []
    texel = texel_bytes(components, dtype)
    size = layers * texture_bytes(size_px, texel, samples=samples, mipmaps=mipmaps)
    return GpuAllocation(kind, ", ".join(words), size)


def megabytes(allocations: Iterable[GpuAllocation]) -> dict[str, float]:
    """Return 10⁶ bytes of each kind, and of all as ``total``."""
    found: dict[str, float] = dict.fromkeys(_KINDS, 0.0)
    for each in allocations:
        found[each.kind] += each.bytes / 1e6
    return {**found, "total": sum(found.values())}
