"""Files and folders of a study: their permissions, syncs and locks."""

from __future__ import annotations

import errno
import json
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.files import read_text, refuse_special
from vrcomfort.json_text import parse_json


class Access(NamedTuple):
    """Permission bits of files and folders; Windows does not have them."""

    file_mode: int
    folder_mode: int


OWNER = Access(0o600, 0o700)
GROUP = Access(0o640, 0o750)

_NEW = os.O_CREAT | getattr(os, "O_BINARY", 0)
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_CANNOT_SYNC = {errno.EINVAL, errno.ENOTSUP}
"""What pipes, devices and some network folders say, which have nothing to sync."""


def access_like(file: Path) -> Access:
    """Return the permissions of files like one that is there."""
    return GROUP if file.stat().st_mode & 0o040 else OWNER


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
    """Open a file, making it with its permissions where it is missing; return its descriptor.

    Raises
    ------
    InputError
        If it is a symbolic link, a pipe or a device.
    OSError
        If the disk refuses.
    """
    refuse_links(file.parent, file)
    made = not file.exists()
    if not made:
        refuse_special(file)
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
    """Return the error for a disk that refuses a write."""
    reason = error.strerror or type(error).__name__
    return InputError(f"cannot write: {reason}; what was written before is kept", file=file)


if sys.platform == "win32":
    import msvcrt

    _FAR = 1 << 30  # a locked byte cannot be read, so it lies behind the text

    def _lock(stream: IO[str], *, wait: bool) -> None:
        os.lseek(stream.fileno(), _FAR, os.SEEK_SET)
        msvcrt.locking(stream.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
        os.lseek(stream.fileno(), 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(stream: IO[str], *, wait: bool) -> None:
        fcntl.flock(stream, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))


_HELD = {errno.EAGAIN, errno.EACCES, errno.EDEADLK}
"""What a lock says that another program holds."""


@contextmanager
def only_program(file: Path, access: Access, *, doing: str) -> Iterator[None]:
    """Hold the lock of a file, or refuse where another program holds it.

    Parameters
    ----------
    doing
        What the message says is being done: "P01 is being run".

    Raises
    ------
    InputError
        If another program holds the lock; names its process. Or if it cannot be locked: some
        network folders cannot.
    """
    with _open(file, access) as stream:
        _take(stream, file, wait=False, doing=doing)
        if not _is_in_place(stream, file):
            raise InputError(f"{doing} by another program; wait until it ends")
        _sign(stream)
        try:
            yield
        finally:
            _wipe(stream)


@contextmanager
def in_turn(file: Path, access: Access) -> Iterator[None]:
    """Hold the lock of a file, after waiting for its holder.

    Raises
    ------
    InputError
        If it cannot be locked.
    """
    with _open(file, access) as stream:
        _take(stream, file, wait=True, doing=f"{file.name} is being held")
        yield


def _take(stream: IO[str], file: Path, *, wait: bool, doing: str) -> None:
    try:
        _lock(stream, wait=wait)
    except OSError as error:
        if error.errno in _HELD:
            raise InputError(f"{doing} by {_holder(file)}; wait until it ends") from error
        message = f"cannot lock: {error.strerror}; put the study on a disk of this machine"
        raise InputError(message, file=file) from error


def _open(file: Path, access: Access) -> IO[str]:
    try:
        return os.fdopen(open_new(file, access, os.O_RDWR), "r+", encoding="utf-8")
    except OSError as error:
        message = f"cannot make this file: {error.strerror}"
        hint = "make the folder writable, or work on a copy of the study"
        raise InputError(f"{message}; {hint}", file=file) from error


def _is_in_place(stream: IO[str], file: Path) -> bool:
    """Return whether a file that was opened is the one of that name; its last holder removes it."""
    if sys.platform == "win32":
        return True  # where no open file is removed
    try:
        return os.path.samestat(os.fstat(stream.fileno()), file.stat())
    except FileNotFoundError:
        return False


def _sign(stream: IO[str]) -> None:
    _wipe(stream)
    stream.write(json.dumps({"pid": os.getpid(), "host": socket.gethostname()}) + "\n")
    stream.flush()


def _wipe(stream: IO[str]) -> None:
    """Empty the file. Only its holder may remove it: else two could hold files of one name."""
    stream.seek(0)
    stream.truncate()
    stream.flush()


def _holder(file: Path) -> str:
    try:
        said = parse_json(read_text(file, "lock"), file)
        return f"process {said['pid']} on {said['host']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another program"
