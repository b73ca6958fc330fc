"""A clock that was set back is flagged."""

from __future__ import annotations

import json
import time

from tests.support.resume import folder, go, manifest
from tests.support.study import AheadHeadset


def test_a_clock_that_stands_before_what_is_recorded_is_flagged(tmp_path):
    go(tmp_path, interrupt=(2, 30))
    file = folder(tmp_path) / "manifest.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps({**content, "finished_at": "2999-01-01T00:00:00+00:00"}))
    outcome = go(tmp_path, resume=True)
    (flag,) = manifest(tmp_path)["clock_set_back"]
    assert "folder has records of 2999-01-01T00:00:00+00:00" in flag
    assert outcome.warnings == (flag,)


def test_an_enrolment_in_the_future_is_flagged_and_one_that_a_spreadsheet_wrote_is_not(tmp_path):
    go(tmp_path, sessions=[1])
    assert manifest(tmp_path)["clock_set_back"] == []
    file = tmp_path / "S" / "participants.csv"
    text = file.read_text()
    enrolled_at = text.splitlines()[1].split(",")[3]
    for written, flagged in (("2999-01-01T00:00:00+00:00", True), ("01.02.2999 10:00", False)):
        file.write_text(text.replace(enrolled_at, written))
        session = 2 if flagged else 1
        study = tmp_path / f"copy{session}"
        study.mkdir()
        (study / "dataset_description.json").write_text(
            (tmp_path / "S" / "dataset_description.json").read_text()
        )
        (study / "participants.csv").write_text(file.read_text())
        go(tmp_path, study=study.name, sessions=[1])
        said = json.loads((study / "sub-P01" / "ses-1" / "manifest.json").read_text())
        assert bool(said["clock_set_back"]) is flagged


def test_a_clock_that_is_set_back_in_a_session_is_flagged_once(tmp_path, monkeypatch):
    real = time.time

    class Meanwhile(AheadHeadset):
        def frames(self):
            monkeypatch.setattr("time.time", lambda: real() - 3600)
            yield from super().frames()

    go(tmp_path, headset_for=lambda *_: Meanwhile())
    (flag,) = manifest(tmp_path)["clock_set_back"]
    assert "was set back by 3600 s" in flag


def test_a_clock_that_goes_as_it_should_is_not_flagged(tmp_path):
    assert go(tmp_path).warnings == ()
    assert manifest(tmp_path)["clock_set_back"] == []
