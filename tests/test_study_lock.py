"""One program at a time runs a participant."""

from __future__ import annotations

import os

import pytest

from tests.support.resume import go
from tests.support.study import AheadHeadset
from vrcomfort.errors import InputError


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
