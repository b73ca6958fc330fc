"""`vrcomfort verify`: a study that is whole passes, and each damage is told with its place."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.questionnaire.test_answers import Corrects
from tests.support.exchange import cell, edit, with_gaze
from tests.support.resume import go
from tests.support.study import Scripted
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import moments, verify_study
from vrcomfort.exchange.verifying import session as session_of_study
from vrcomfort.exchange.verifying import study as verifying
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.records import checksums, read_participants, undo_withdrawal
from vrcomfort.records.checksums import CHECKSUMS, read_checksums, write_checksums
from vrcomfort.records.disk import replace_text
from vrcomfort.records.participants import add_note

SESSION = "sub-P01/ses-1"
Damage = Callable[[Path], None]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_gaze(tmp_path_factory.mktemp("whole"))


@pytest.fixture
def study(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "S"))


def told(study: Path) -> list[str]:
    return [str(each) for each in verify_study(study).faults]


def sealed(study: Path) -> list[str]:
    """Return the faults after the checksums were made to fit: what the files themselves tell."""
    from vrcomfort.records.disk import OWNER

    for folder in study.glob("sub-*/ses-*"):
        write_checksums(folder, OWNER)
    return told(study)


@pytest.mark.smoke
def test_a_whole_study_passes_with_counts(whole: Path) -> None:
    found = verify_study(whole)
    assert found.findings == []
    assert found.counts["participants"] == 1
    assert found.counts["sessions completed"] == 2
    frames = (whole / SESSION / "frames.csv").read_text().count("\n") - 1
    assert found.counts["rows of frames.csv"] == found.counts["rows of gaze.csv"] == 2 * frames
    assert found.counts["files unchanged since the session ended"] == 2 * 8


@pytest.mark.parametrize(
    "respondent",
    [Corrects(), Scripted(withdraw_at_s=1.0), Scripted(withdraw_at_item="fatigue"),
     Scripted(rates=15), Scripted(rates=None)],
)  # fmt: skip
def test_whatever_a_participant_does_is_whole(tmp_path: Path, respondent: Scripted) -> None:
    go(tmp_path, respondent)
    assert told(tmp_path / "S") == []


@pytest.mark.parametrize("interrupt", [(1, 5), (2, 30), None])
def test_an_interrupted_session_is_whole_before_and_after_it_goes_on(tmp_path, interrupt):
    respondent = Scripted(interrupt_at_item="fatigue" if interrupt is None else None)
    go(tmp_path, respondent, interrupt=interrupt)
    found = verify_study(tmp_path / "S")
    assert found.faults == []
    assert any("interrupted" in note.message for note in found.notes)
    go(tmp_path, Scripted(), resume=True)
    assert told(tmp_path / "S") == []
    assert (tmp_path / "S" / SESSION / CHECKSUMS).exists()


def test_an_undone_withdrawal_keeps_the_checksums_of_the_other_files(tmp_path: Path) -> None:
    go(tmp_path, Scripted(withdraw_at_s=1.0))
    study = tmp_path / "S"
    undo_withdrawal(study, "P01", "a slip")
    assert told(study) == []
    edit(study / SESSION / "ratings.csv", 1, lambda line: line)  # nothing
    with (study / SESSION / "events.csv").open("a") as stream:
        stream.write("99.0,0.0,note,,0\n")
    assert any("events.csv: has changed since" in each for each in told(study))


def test_a_killed_session_is_told_and_not_wrong(study: Path) -> None:
    file = study / SESSION / "manifest.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps(content | {"status": "running", "finished_at": None}, indent=2))
    (study / SESSION / CHECKSUMS).unlink()
    row = (study / "participants.csv").read_text().replace("completed", "enrolled")
    (study / "participants.csv").write_text(row)
    found = verify_study(study)
    assert found.faults == []
    assert any("killed" in str(note) for note in found.notes)


def cut_last(name: str) -> Damage:
    def damage(study: Path) -> None:
        file = study / SESSION / name
        file.write_bytes(file.read_bytes()[:-4])

    return damage


def drop_row(name: str, line: int) -> Damage:
    return lambda study: edit(study / SESSION / name, line, lambda _: "")


def set_cell(name: str, line: int, column: str, value: str) -> Damage:
    return lambda study: cell(study / SESSION / name, line, column, value)


def in_manifest(**changes: object) -> Damage:
    def damage(study: Path) -> None:
        file = study / SESSION / "manifest.json"
        content = json.loads(file.read_text())
        file.write_text(json.dumps(content | changes, indent=2))

    return damage


def remove(name: str) -> Damage:
    return lambda study: (study / name).unlink()


def write(name: str, text: str) -> Damage:
    return lambda study: (study / name).write_text(text)


DAMAGES: dict[str, tuple[Damage, str]] = {
    "no frames": (remove(f"{SESSION}/frames.csv"), "frames.csv: is missing; restore"),
    "no manifest": (remove(f"{SESSION}/manifest.json"), "manifest.json: "),
    "no participants": (remove("participants.csv"), "participants.csv: is missing"),
    "no description": (remove("dataset_description.json"), "dataset_description.json: is missing"),
    "half a row": (cut_last("frames.csv"), r"frames.csv, line \d+: this row is half-written"),
    "half an event": (cut_last("events.csv"), r"events.csv, line \d+: this row is half-written"),
    "a stranger": (write(f"{SESSION}/notes.txt", "x"), "notes.txt: is no file of a session"),
    "a frame lost": (drop_row("frames.csv", 40), r"had \d+ frames, and frames.csv has \d+ rows"),
    "a gaze row lost": (drop_row("gaze.csv", 40), r"gaze.csv, line \d+: has \d+ rows, and frames"),
    "an answer lost": (drop_row("questionnaires.csv", 20), "questionnaires.csv has no row of this"),
    "an event lost": (drop_row("events.csv", 4), "events.csv has no such answer"),
    "a trial lost": (drop_row("trials.csv", 3), "trials.csv has no row of this exposure"),
    "a timing row lost": (drop_row("timing.csv", 2), "timing.csv has no row of trial 1, attempt 1"),
    "a response": (
        set_cell("questionnaires.csv", 5, "response", "3"),
        r"questionnaires.csv, line 5: the response is 3, and events.csv, line \d+, says 1",
    ),
    "no number": (set_cell("ratings.csv", 2, "onset_s", "soon"), "column onset_s: 'soon' is not"),
    "a pose": (set_cell("frames.csv", 9, "head_x_m", "left"), "line 9: column head_x_m: 'left'"),
    "another person": (
        set_cell("trials.csv", 2, "participant", "P02"),
        "line 2: participant is P02, and this folder is of participant P01",
    ),
    "another condition": (
        set_cell("trials.csv", 2, "condition", "blur"),
        "trial 1 is planned with condition plain, not blur",
    ),
    "another rating": (
        set_cell("ratings.csv", 2, "condition", "blur"),
        "ratings.csv, line 2: condition is blur, and trials.csv, line 2, says plain",
    ),
    "a late rating": (set_cell("ratings.csv", 2, "onset_s", "9999"), "when trial 1 was not shown"),
    "time goes back": (
        set_cell("frames.csv", 9, "xr_time_ns", "1"),
        r"frames.csv, line 9: xr_time_ns 1 is not after",
    ),
    "a frame elsewhere": (
        set_cell("frames.csv", 30, "trial", "2"),
        "line 30: belongs to no attempt at trial 2",
    ),
    "an early answer": (
        set_cell("questionnaires.csv", 20, "asked_s", "9999"),
        "line 20: was answered before it was asked",
    ),
    "a dropped frame": (set_cell("trials.csv", 2, "dropped", "3"), "dropped 3 frames, and frames"),
    "resumed before": (set_cell("events.csv", 2, "resumed", "1"), "stands after rows of the next"),
    "header": (
        lambda study: edit(study / SESSION / "trials.csv", 1, lambda line: line.replace("sc", "k")),
        "trials.csv, line 1: the header lacks scene",
    ),
    "newer schema": (in_manifest(schema_version=99), "install a newer vrcomfort"),
    "sequence": (in_manifest(sequence="ba"), "`sequence` is ba, and participants.csv says ab"),
    "seed": (in_manifest(seed=5), "`seed` is 5, and dataset_description.json says 0"),
    "status": (in_manifest(status="withdrawn"), "has no event `withdrawn`"),
    "protocol": (
        in_manifest(protocol={"name": "tiny", "sha256": "0" * 64, "text": "x"}),
        "`protocol.sha256` is not that of `protocol.text`",
    ),
    "no finish": (in_manifest(finished_at=None), r"says completed and not when"),
    "session gone": (
        lambda study: shutil.rmtree(study / "sub-P01/ses-2"),
        "P01 is completed, with 1 of 2 sessions completed",
    ),
    "unknown person": (
        lambda study: (study / "sub-P01").rename(study / "sub-P07"),
        "sub-P07: participants.csv does not list this participant",
    ),
    "half a participant": (
        lambda study: edit(study / "participants.csv", 2, lambda line: line[:-5]),
        "participants.csv, line 2: this row is half-written",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGES)
def test_each_damage_is_told_with_its_place(study: Path, name: str) -> None:
    damage, words = DAMAGES[name]
    damage(study)
    faults = sealed(study)
    assert any(re.search(words, each) for each in faults), faults


def test_what_only_the_checksums_see(study: Path) -> None:
    file = study / SESSION / "frames.csv"
    edit(file, 20, lambda line: line.replace("0.03,", "0.04,", 1))
    line = read_checksums(file.parent)["frames.csv"].line
    words = f"has changed since the session ended ({CHECKSUMS}, line {line})"
    assert told(study) == [
        f"{SESSION}/frames.csv: {words}; restore it from a copy, or write down why"
    ]


def test_a_link_is_told(study: Path, tmp_path: Path) -> None:
    file = study / SESSION / "ratings.csv"
    file.rename(tmp_path / "elsewhere.csv")
    file.symlink_to(tmp_path / "elsewhere.csv")
    assert f"{SESSION}/ratings.csv: is a symbolic link; put the file itself here" in told(study)


def test_packed_copies_belong_to_a_session(run, study: Path) -> None:
    assert run("pack", study)[0] == 0
    assert verify_study(study).findings == []
    edit(study / SESSION / "gaze.csv", 2, lambda line: line.replace("0.0,", "0.00,", 1))
    (fault,) = verify_study(study).findings
    assert fault.file == f"{SESSION}/gaze.csv"
    (study / SESSION / CHECKSUMS).unlink()
    notes = [str(each) for each in verify_study(study).notes]
    words = "is not of its CSV as that is now, and not read; vrcomfort pack renews it"
    assert f"{SESSION}/gaze.parquet: {words}" in notes


def test_a_packed_copy_that_was_changed_is_named_and_one_that_was_removed_is_not(
    run, study: Path
) -> None:
    assert run("pack", study)[0] == 0
    file = study / SESSION / "frames.parquet"
    content = bytearray(file.read_bytes())
    content[len(content) // 3] ^= 1
    file.write_bytes(content)
    (fault,) = told(study)
    assert fault.startswith(f"{SESSION}/frames.parquet: has changed since it was packed")
    file.unlink()
    assert verify_study(study).findings == []
    assert run("pack", study)[0] == 0
    assert verify_study(study).findings == []


def test_what_the_system_does_not_let_us_read_is_a_finding_like_others(study, monkeypatch) -> None:
    table = study / SESSION / "ratings.csv"
    table.unlink()
    table.mkdir()
    place = f"{SESSION}/ratings.csv: cannot be read: Is a directory; ask for access, or restore it"
    assert any(each.startswith(place) for each in told(study))

    def refuse(folder: Path) -> None:
        raise PermissionError(13, "Permission denied", str(folder))

    monkeypatch.setattr(verifying, "verify_session", lambda folder, _: refuse(folder))
    faults = told(study)
    refused = "cannot be read: Permission denied; ask for access, or restore it from a copy"
    assert {f"{SESSION}: {refused}", f"sub-P01/ses-2: {refused}"} <= set(faults)


@pytest.mark.parametrize("text", [None, "", "participant,sequence,status,enrolled_at,note\n"])
def test_a_list_that_lost_its_people_is_told_and_nobody_is_enrolled_again(study, text) -> None:
    file = study / "participants.csv"
    file.unlink()
    if text is not None:
        file.write_text(text)
    assert any(each.startswith("participants.csv: ") for each in told(study))
    with pytest.raises(
        InputError, match="it has no participants, and sub-P01 has a session"
    ) as caught:
        read_participants(study)
    assert caught.value.file == file


@pytest.mark.parametrize(
    ("column", "cell_text", "says"),
    [
        ("participant", "Zoë", "a name is 1 to 64 letters"),
        ("status", "done", "write enrolled, completed, withdrawn or excluded"),
        ("sequence", "a b", "write the sequence that the session's manifest has"),
    ],
)
def test_a_cell_of_the_list_that_cannot_be_says_what_can(study, column, cell_text, says) -> None:
    cell(study / "participants.csv", 2, column, cell_text)
    assert any(f"'{cell_text}' cannot be here; {says}" in each for each in told(study))


def test_an_import_is_checked_for_its_own_files(run, tmp_path: Path) -> None:
    answers = tmp_path / "answers.csv"
    items = [item.name for item in shipped_instruments()["ssq"].items]
    rows = [f"P{p},{c},{'0,3,' * 7}0,3" for p in (1, 2) for c in ("plain", "blur")]
    answers.write_text("\n".join([f"participant,condition,{','.join(items)}", *rows]) + "\n")
    mapping, study = tmp_path / "map.toml", tmp_path / "imported"
    run("import", answers, "--suggest", "--out", mapping)
    code, _, err = run("import", answers, "--mapping", mapping, "--out", study)
    assert code == 0, err
    assert told(study) == []
    assert verify_study(study).counts["rows of questionnaires.csv"] == 64
    edit(study / "questionnaires.csv", 2, lambda line: line.replace("P1", "P9", 1))
    (study / "mapping.toml").write_text("")
    again = "has changed since the import; restore it from a copy, or import again"
    assert told(study) == [
        f"mapping.toml: {again}",
        f"questionnaires.csv: {again}",
        "mapping.toml: is not the mapping that import.json names; restore it, or import again",
        "questionnaires.csv, line 2: participants.csv does not list P9; import again",
    ]


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is not a study folder"):
        verify_study(tmp_path)


def test_the_command_says_what_is_wrong_in_its_exit_code(run, study: Path, tmp_path: Path) -> None:
    code, out, err = run("verify", study)
    assert (code, err) == (0, "")
    assert "nothing is wrong. Counted: 1 participant, 2 sessions" in out
    cell(study / SESSION / "trials.csv", 2, "participant", "P02")
    code, out, _ = run("verify", study)
    assert code == 1
    assert f"wrong: {SESSION}/trials.csv, line 2: participant is P02" in out
    code, out, _ = run("verify", study, "--json")
    said = json.loads(out)
    assert (code, said["whole"], said["faults"][0]["line"]) == (1, False, 2)
    code, _, err = run("verify", tmp_path / "nowhere")
    assert (code, err.count("\n")) == (2, 1)


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("trials.csv", drop_row("trials.csv", 2)),
        ("events.csv", drop_row("events.csv", 20)),
        ("frames.csv", drop_row("frames.csv", 40)),
        ("manifest.json", in_manifest(sequence="ba")),
        ("manifest.json", in_manifest(seed=5)),
        ("manifest.json", remove(f"{SESSION}/manifest.json")),
        ("trials.csv", remove(f"{SESSION}/trials.csv")),
        (
            CHECKSUMS,
            lambda study: edit(study / SESSION / CHECKSUMS, 4, lambda line: "0" + line[1:]),
        ),
        (CHECKSUMS, lambda study: edit(study / SESSION / CHECKSUMS, 3, lambda _: "")),
    ],
)
def test_files_that_are_as_they_were_written_are_not_named(
    study: Path, name: str, changed: Damage
) -> None:
    before = read_checksums(study / SESSION)
    changed(study)
    found = told(study)
    assert found
    assert {each.partition(":")[0].partition(",")[0] for each in found} == {f"{SESSION}/{name}"}
    assert set(before) >= {"trials.csv", "manifest.json"}


def test_a_change_of_the_list_of_participants_by_hand_is_a_note_that_names_columns(
    study: Path,
) -> None:
    file = study / "participants.csv"
    header, *rows = file.read_text().splitlines()
    lines = [f"{header},age", *(f"{row}x,31" for row in rows)]
    file.write_text("".join(f"{line}\n" for line in lines))
    (note,) = map(str, verify_study(study).findings)
    assert note.startswith(
        "participants.csv: was changed by hand, not by vrcomfort: columns note, age;"
    )
    add_note(study, "P01", "late")
    assert verify_study(study).findings == []


def test_a_change_of_the_description_names_its_keys(study: Path) -> None:
    file = study / "dataset_description.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps(content | {"seed": 5, "name": "other"}))
    found = [str(each) for each in verify_study(study).findings]
    assert "keys name, seed" in found[0]
    assert {each.partition(":")[0] for each in found} == {file.name}


def test_a_changed_list_of_participants_is_named_and_not_what_disagrees_with_it(
    study: Path,
) -> None:
    file = study / "participants.csv"
    whole = file.read_text()
    for text in (
        whole.replace("P01", "P07"), whole.splitlines(keepends=True)[0],
        whole.replace(",ab,", ",ba,"), whole.replace("completed", "withdrawn"),
    ):  # fmt: skip
        assert text != whole
        file.write_text(text)
        found = {str(each).partition(":")[0] for each in verify_study(study).findings}
        assert {each.partition(",")[0] for each in found} == {file.name}
    file.write_text(whole)
    shutil.rmtree(study / "sub-P01/ses-2")
    (fault,) = told(study)
    assert fault.startswith("sub-P01: P01 is completed, with 1 of 2 sessions completed")


def test_a_program_that_is_killed_while_it_writes_the_list_leaves_no_finding(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = 0

    def dying(*arguments: Any, **options: Any) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise KeyboardInterrupt
        replace_text(*arguments, **options)

    monkeypatch.setattr(checksums, "replace_text", dying)
    died = []
    for writes in range(4):
        left = writes
        try:
            add_note(study, "P01", f"note {writes}")
        except KeyboardInterrupt:
            died.append(writes)
        assert verify_study(study).findings == []
    assert died == [0, 1, 2]


def test_a_study_of_an_older_version_gets_its_list_with_the_first_change(study: Path) -> None:
    (study / CHECKSUMS).unlink()
    (note,) = map(str, verify_study(study).findings)
    assert note.startswith(f"{CHECKSUMS}: is missing (older versions wrote none)")
    add_note(study, "P01", "late")
    assert set(read_checksums(study)) >= {"participants.csv", "participants.csv: note"}
    assert verify_study(study).findings == []
    (study / CHECKSUMS).write_text("x\n")
    add_note(study, "P01", "later")
    (fault,) = told(study)
    assert fault.startswith(f"{CHECKSUMS}, line 1: this is not a checksum")


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="sha256sum is not here")
def test_lists_of_checksums_are_read_by_sha256sum(study: Path) -> None:
    for folder in (study, study / SESSION):
        words = ["sha256sum", "--check", "--strict", CHECKSUMS]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""


def goes_on(study: Path) -> None:
    """Let the first session be one that is being recorded."""
    in_manifest(status="running", finished_at=None)(study)
    (study / SESSION / CHECKSUMS).unlink()
    file = study / "participants.csv"
    file.write_text(file.read_text().replace("completed", "enrolled"))
    (study / CHECKSUMS).unlink()


def test_rows_that_come_while_a_session_is_looked_at_are_left_out(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes_on(study)
    read = session_of_study._read  # of all rows but those of frames
    frames = (study / SESSION / "frames.csv").read_text().splitlines(keepends=True)
    later = frames[-1].split(",")
    later[0], later[1] = "999.0", str(10**15)

    def and_meanwhile(*arguments: Any) -> Any:
        found = read(*arguments)
        with (study / SESSION / "frames.csv").open("a") as file:
            file.write(",".join(later))
        return found

    monkeypatch.setattr(session_of_study, "_read", and_meanwhile)
    found = verify_study(study)
    assert found.faults == []
    rows = len(frames) - 1
    assert any(f"looked at up to row {rows} of frames.csv" in each.message for each in found.notes)
    assert found.counts["rows of frames.csv"] == 2 * rows


def test_a_moment_is_taken_again_when_the_manifest_changes_in_it(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes_on(study)
    folder = study / SESSION
    read, calls = moments.read_manifest, []

    def and_goes_on(place: Path) -> dict[str, Any]:
        calls.append(place)
        found = read(place)
        if len(calls) == 1:  # the next exposure begins, and its first row comes
            in_manifest(started_at="2026-01-01T00:00:00+00:00")(study)
            with (folder / "events.csv").open("a") as file:
                file.write("1.0,0.0,note,,0\n")
        return found

    monkeypatch.setattr(moments, "read_manifest", and_goes_on)
    manifest, ends = moments.read_moment(folder)
    assert manifest["started_at"].startswith("2026-01-01")
    assert ends is not None
    assert ends["events.csv"] == (folder / "events.csv").stat().st_size
    assert len(calls) == 3


def test_what_is_found_while_a_program_writes_is_looked_at_again(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = study / SESSION / "trials.csv"
    whole = file.read_text()
    file.write_text("")  # another program is just writing it again
    look = verifying.verify_session

    def and_meanwhile(folder: Path, found: Any) -> Any:
        result = look(folder, found)
        file.write_text(whole)
        return result

    monkeypatch.setattr(verifying, "verify_session", and_meanwhile)
    assert told(study) == []


def test_a_study_that_was_just_begun_has_no_fault(study: Path) -> None:
    for each in study.glob("sub-P01/ses-*"):
        shutil.rmtree(each)
    (study / "sub-P01/ses-1").mkdir()
    (study / "participants.csv").unlink()
    (study / "sub-P01/ses-1/events.csv").write_text("")
    found = verify_study(study)
    assert found.faults == []
    words = [each.message for each in found.notes]
    assert any("nobody has been enrolled" in each for each in words)
    assert any("holds no row yet" in each for each in words)


def test_somebody_whose_session_ends_just_now_is_not_yet_completed(study: Path) -> None:
    file = study / "participants.csv"
    file.write_text(file.read_text().replace("completed", "enrolled"))
    (fault,) = told(study)
    assert "all sessions are completed; write completed" in fault
    (study / "sub-P01/lock").write_text('{"pid": 1, "host": "here"}\n')  # a program has it
    assert told(study) == []
