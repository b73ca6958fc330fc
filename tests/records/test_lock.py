"""One program at a time runs a participant."""

from __future__ import annotations

import errno
import os

import pytest

from tests.support.resume import go
from tests.support.study import AheadHeadset
from vrcomfort.errors import InputError
from vrcomfort.records import disk
from vrcomfort.records.participants import add_note, exclude
from vrcomfort.records.study import only_run


def test_two_programs_cannot_run_one_participant(tmp_path):
    class Meanwhile(AheadHeadset):
        def frames(self):
            with pytest.raises(InputError, match=f"P01 is being run by process {os.getpid()}"):
                go(tmp_path, resume=True)
            yield from super().frames()

    assert go(tmp_path, headset_for=lambda *_: Meanwhile()).status == "enrolled"


def test_a_lock_that_a_dead_program_left_locks_nobody_out(tmp_path):
    lock = tmp_path / "S" / "sub-P01" / "lock"
    lock.parent.mkdir(parents=True)
    lock.write_text('{"pid": 1, "host": "elsewhere"}\n')
    assert go(tmp_path).status == "enrolled"
    assert lock.read_text() == ""


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (errno.ENOLCK, "No locks available; put the study on a disk of this machine"),
        (errno.ENOTSUP, "not supported; put the study on a disk of this machine"),
        (errno.EDEADLK, r"lock is being held by another program; wait until it ends"),
    ],
)
def test_a_folder_that_cannot_be_locked_is_told_whoever_asks(tmp_path, monkeypatch, number, told):
    go(tmp_path, exposure_s=1.0)
    before = (tmp_path / "S/participants.csv").read_bytes()

    def refuse(*_, **__):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(disk, "_lock", refuse)
    with pytest.raises(InputError, match=told):
        add_note(tmp_path / "S", "P01", "left-handed")
    for act in (lambda: exclude(tmp_path / "S", "P01", "why"), lambda: go(tmp_path)):
        with pytest.raises(InputError, match=told.replace("lock is being held", "is being run")):
            act()
    assert (tmp_path / "S/participants.csv").read_bytes() == before


def test_the_lock_of_nobody_recorded_goes_with_the_program(tmp_path):
    (tmp_path / "S").mkdir()
    with only_run(tmp_path / "S", "P01"):
        assert (tmp_path / "S/sub-P01/lock").exists()
        with pytest.raises(InputError, match="is being run"), only_run(tmp_path / "S", "P01"):
            pass
        assert (tmp_path / "S/sub-P01/lock").exists(), "another program still holds it"
    assert not (tmp_path / "S/sub-P01").exists()


@pytest.mark.skipif(os.name == "nt", reason="no open file can be removed there")
def test_a_lock_file_that_was_removed_meanwhile_is_not_held(tmp_path, monkeypatch):
    """Else two programs could each hold a file of that name."""
    (tmp_path / "S").mkdir()
    lock = disk._lock

    def after_its_holder(stream, *, wait):
        lock(stream, wait=wait)
        (tmp_path / "S/sub-P01/lock").unlink()

    monkeypatch.setattr(disk, "_lock", after_its_holder)
    with (
        pytest.raises(InputError, match="P01 is being run by another program"),
        only_run(tmp_path / "S", "P01"),
    ):
        pytest.fail("the lock was held")
