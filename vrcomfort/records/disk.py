"""Files and folders of a study: who may read them, that no link leads out, when they are safe."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import NamedTuple

from vrcomfort.errors import InputError


class Access(NamedTuple):
    """Who may read what is written: permission bits, which Windows does not have."""

    file_mode: int
    folder_mode: int


OWNER = Access(0o600, 0o700)
GROUP = Access(0o640, 0o750)

_NEW = os.O_CREAT | getattr(os, "O_BINARY", 0)
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_CANNOT_SYNC = {errno.EINVAL, errno.ENOTSUP}
"""What pipes, devices and some network folders say, which have nothing to sync."""


def make_folders(study: Path, folder: Path, access: Access) -> None:
    """Make a study's folder, and one inside it; their names are on the disk at return.

    Raises
    ------
    InputError
        If one inside the study is a symbolic link.
    OSError
        If the disk refuses.
    """
    refuse_links(study, folder)
    for each in reversed([folder, *folder.parents]):
        if each.is_dir():
            continue
        private = each == study or study in each.parents
        each.mkdir(mode=access.folder_mode if private else 0o777, exist_ok=True)
        if private and access != OWNER:
            each.chmod(access.folder_mode)  # past the umask: the user has asked for it
        sync_folder(each.parent)


def refuse_links(study: Path, path: Path) -> None:
    """Raise `InputError` if a file or folder inside a study is a symbolic link, or lies in one."""
    for each in (path, *path.parents):
        if each == study:
            return
        if each.is_symlink():
            message = "is a symbolic link, and no record is written through one"
            raise InputError(f"{message}; put the file or folder itself here", file=each)


def open_new(file: Path, access: Access, flags: int) -> int:
    """Open a file, made for those who may read it where it is not there; return its descriptor.

    Raises
    ------
    InputError
        If it is a symbolic link.
    OSError
        If the disk refuses.
    """
    refuse_links(file.parent, file)
    made = not file.exists()
    descriptor = os.open(file, _NEW | _NO_LINK | flags, access.file_mode)
    if made and access != OWNER and sys.platform != "win32":
        os.fchmod(descriptor, access.file_mode)
    return descriptor


def sync_data(descriptor: int) -> None:
    """Wait until a file's content is on the disk.

    Raises
    ------
    OSError
        If the disk refuses.
    """
    try:
        getattr(os, "fdatasync", os.fsync)(descriptor)  # Windows and macOS have fsync alone
    except OSError as error:
        if error.errno not in _CANNOT_SYNC:
            raise


def sync_folder(folder: Path) -> None:
    """Wait until the names in a folder are on the disk.

    Raises
    ------
    OSError
        If the disk refuses.
    """
    if sys.platform == "win32":
        return  # which opens no folder, and writes names through a journal
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _CANNOT_SYNC:
            raise
    finally:
        os.close(descriptor)


def replace_text(file: Path, text: str, access: Access = OWNER, *, sync: bool = True) -> None:
    """Replace a file as a whole: readers see the old text or the new, never half of it.

    Parameters
    ----------
    sync
        Whether it is on the disk at return; else only the end of the program cannot harm it.

    Raises
    ------
    InputError
        If the disk is full or refuses, or the file is a symbolic link; the old file stays.
    """
    draft = file.with_name(f".{file.name}.new")
    try:
        refuse_links(file.parent, file)
        draft.unlink(missing_ok=True)  # that of a program that was killed
        descriptor = open_new(draft, access, os.O_WRONLY | os.O_EXCL)
        with os.fdopen(
            descriptor, "w", encoding="utf-8", errors="replace", newline=""
        ) as stream:  # what made the text has left nothing to replace
            stream.write(text)
            stream.flush()
            if sync:
                os.fsync(stream.fileno())
        draft.replace(file)
        if sync:
            sync_folder(file.parent)
    except OSError as error:
        raise refused(file, error) from error


def refused(file: Path, error: OSError) -> InputError:
    """Return the error for a disk that does not take what is written."""
    reason = error.strerror or type(error).__name__
    return InputError(f"cannot write: {reason}; what was written before is kept", file=file)
