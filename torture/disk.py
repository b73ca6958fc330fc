"""Disks that can be cut off or are small: images and memory that root mounts, or stand-ins."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Protocol

from torture import shim

IMAGE_MB = 32
_BLOCK = 1 << 16
_STABLE_TIMEOUT_S = 120.0


class Disk(Protocol):
    """A disk that loses its power."""

    study: Path
    """Where a session records."""
    options: list[str]
    """What its victim needs to be told."""

    def cut(self) -> None:
        """Keep what has reached the disk; its victim stands still meanwhile."""

    def remains(self) -> Path:
        """Return the study as it is when the power is back."""

    def close(self) -> None:
        """Put everything away."""


class LoopImage:
    """An ext4 file system in an image.

    A copy of the image is what the file system had sent to its disk: what it holds back in memory
    (rows that were written, not synced) is not in it. Mounting the copy replays its journal.
    """

    def __init__(self, folder: Path) -> None:
        self._image, self._copy = folder / "disk.img", folder / "cut.img"
        self._mounted: list[Path] = []
        self.options: list[str] = []
        with self._image.open("wb") as image:
            image.truncate(IMAGE_MB << 20)
        # Nothing may be written to it later by a kernel thread that still makes the file system.
        lazy = "lazy_itable_init=0,lazy_journal_init=0"
        call("mkfs.ext4", "-q", "-F", "-E", lazy, self._image)
        self.study = self._mount(self._image, folder / "disk") / "study"

    def cut(self) -> None:
        """Copy the image when nothing is being written to it: two copies that are the same."""
        deadline = time.monotonic() + _STABLE_TIMEOUT_S
        before, now = b"", self._image.read_bytes()
        while before != now:
            if time.monotonic() > deadline:
                raise TimeoutError("the image does not come to rest")
            before, now = now, self._image.read_bytes()
        with self._copy.open("wb") as copy:
            for start in range(0, len(now), _BLOCK):
                if any(block := now[start : start + _BLOCK]):
                    copy.seek(start)
                    copy.write(block)
            copy.truncate(len(now))

    def remains(self) -> Path:
        """Mount the copy."""
        return self._mount(self._copy, self._copy.with_name("after")) / "study"

    def close(self) -> None:
        """Unmount, and remove the images."""
        while self._mounted:
            call("umount", "--lazy", self._mounted.pop())
        self._image.unlink(missing_ok=True)
        self._copy.unlink(missing_ok=True)

    def _mount(self, image: Path, place: Path) -> Path:
        place.mkdir()
        call("mount", "-o", "loop", image, place)
        self._mounted.append(place)
        return place


class ShimDisk:
    """A folder, and beside it what was synced of it; see `torture.shim`."""

    def __init__(self, folder: Path) -> None:
        self.study, self._disk, self._after = folder / "study", folder / "disk", folder / "after"
        self.options = ["--shim", str(self.study), str(self._disk)]

    def cut(self) -> None:
        """Keep nothing but what was kept at each sync."""

    def remains(self) -> Path:
        """Make the folder that is left."""
        shim.remains(self._disk, self._after)
        return self._after

    def close(self) -> None:
        """Leave everything to who removes the folder."""


def can_mount(folder: Path) -> bool:
    """Return whether images can be mounted here."""
    if os.geteuid() or not shutil.which("mkfs.ext4"):
        return False
    place = folder / "probe"
    place.mkdir(parents=True)
    try:
        LoopImage(place).close()
    except (OSError, subprocess.CalledProcessError):
        return False
    finally:
        shutil.rmtree(place, ignore_errors=True)
    return True


def mount_memory(place: Path, size_bytes: int) -> None:
    """Mount so much memory and no more, as a disk."""
    place.mkdir(parents=True)
    call("mount", "-t", "tmpfs", "-o", f"size={size_bytes}", "tmpfs", place)


def unmount(place: Path) -> None:
    """Take a disk away."""
    call("umount", "--lazy", place)


def call(*words: str | Path) -> None:
    """Run a program of the system; raise where it fails."""
    subprocess.run([str(word) for word in words], check=True, capture_output=True, timeout=60)
