"""Who may read a study, where its files may not lead, and what its people may be called."""

from __future__ import annotations

import os
import stat
import sys
from functools import partial
from pathlib import Path

import pytest

from tests.support import resume
from tests.support.resume import folder
from tests.support.study import tiny_protocol
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.records import enrol, only_run, open_study

go = partial(resume.go, exposure_s=1.0)

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no permission bits")


def modes(study: Path) -> dict[str, set[int]]:
    found: dict[str, set[int]] = {"files": set(), "folders": {stat.S_IMODE(study.stat().st_mode)}}
    for path in study.rglob("*"):
        kind = "folders" if path.is_dir() else "files"
        found[kind].add(stat.S_IMODE(path.stat().st_mode))
    return found


def half_a_row(file: Path) -> None:
    with file.open("a", encoding="utf-8") as stream:
        stream.write("1,2")


@posix
def test_a_study_is_for_its_owner_alone(tmp_path):
    go(tmp_path, interrupt=(2, 3))
    half_a_row(folder(tmp_path) / "frames.csv")
    go(tmp_path, resume=True)
    assert (folder(tmp_path) / "frames.csv.cut").exists()
    assert modes(tmp_path / "S") == {"files": {0o600}, "folders": {0o700}}


@posix
def test_a_study_can_be_opened_to_a_group_when_it_is_begun_and_keeps_that(tmp_path):
    before = os.umask(0o077)
    try:
        go(tmp_path, interrupt=(2, 3), group_readable=True)
        go(tmp_path, resume=True)
    finally:
        os.umask(before)
    assert modes(tmp_path / "S") == {"files": {0o640}, "folders": {0o750}}
    go(tmp_path, study="T", interrupt=(1, 3))
    with pytest.raises(InputError, match="leave --group-readable out"):
        go(tmp_path, study="T", group_readable=True, resume=True)


@pytest.mark.parametrize("name", ["frames.csv", "frames.csv.cut", "trials.csv", "manifest.json"])
def test_no_record_is_written_through_a_link(tmp_path, name):
    go(tmp_path, interrupt=(2, 3))
    half_a_row(folder(tmp_path) / "frames.csv")
    file, elsewhere = folder(tmp_path) / name, tmp_path / "elsewhere"
    elsewhere.write_bytes(file.read_bytes() if file.exists() else b"precious")
    before = elsewhere.read_bytes()
    file.unlink(missing_ok=True)
    file.symlink_to(elsewhere)
    with pytest.raises(InputError, match="is a symbolic link") as caught:
        go(tmp_path, resume=True)
    assert caught.value.file == file
    assert elsewhere.read_bytes() == before


@pytest.mark.parametrize("name", ["sub-P01", "sub-P01/ses-1", "sub-P01/lock", "participants.csv"])
def test_no_folder_of_a_study_leads_out_of_it(tmp_path, name):
    open_study(tmp_path / "S", tiny_protocol(tmp_path))
    outside = tmp_path / "outside"
    outside.mkdir()
    link = tmp_path / "S" / name
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(outside if "." not in name and "lock" not in name else outside / "file")
    with pytest.raises(InputError, match="is a symbolic link") as caught:
        go(tmp_path)
    assert caught.value.file == link
    assert not any(outside.iterdir())


def test_a_draft_that_is_a_link_is_not_followed(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text("precious")
    (tmp_path / "S").mkdir()
    (tmp_path / "S" / ".dataset_description.json.new").symlink_to(elsewhere)
    go(tmp_path)
    assert elsewhere.read_text() == "precious"


def test_the_study_itself_may_be_a_link(tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "S").symlink_to(tmp_path / "disk")
    assert go(tmp_path).status == "enrolled"
    assert (tmp_path / "disk" / "sub-P01" / "ses-1" / "trials.csv").exists()


def test_ids_that_differ_only_in_case_are_refused_before_a_folder_is_made(tmp_path):
    protocol = tiny_protocol(tmp_path)
    study = tmp_path / "S"
    open_study(study, protocol)
    enrol(study, build_design(protocol), "P01")
    says = "`p01` differs only in case from the enrolled `P01`; write P01"
    with pytest.raises(InputError, match=says):
        enrol(study, build_design(protocol), "p01")
    with pytest.raises(InputError, match=says), only_run(study, "p01"):
        pass
    assert not (study / "sub-p01").exists()


@pytest.mark.parametrize("name", ["CON", "nul", "lpt9"])
def test_names_that_windows_keeps_are_refused(tmp_path, name):
    protocol = tiny_protocol(tmp_path)
    open_study(tmp_path / "S", protocol)
    with pytest.raises(InputError, match=f"`{name}`: Windows keeps this name"):
        enrol(tmp_path / "S", build_design(protocol), name)
    with pytest.raises(InputError, match=f"study `{name}`: Windows keeps this name"):
        open_study(tmp_path / name, protocol)
    with pytest.raises(InputError, match="Windows keeps this name"):
        open_study(tmp_path / f"{name}.2026", protocol)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("name", ["study.", "study "])
def test_a_study_that_could_not_be_copied_to_windows_is_refused(tmp_path, name):
    with pytest.raises(InputError, match="ends in a point or a space"):
        open_study(tmp_path / name, tiny_protocol(tmp_path))
