"""Consent: nobody begins without it, a new version is asked again, and it is kept."""

from __future__ import annotations

import re
from datetime import UTC, datetime

import pytest
from typer.testing import CliRunner

from tests.support.protocols import ASKED_AFTER_EACH, LATIN_SQUARE, protocol_text
from tests.support.study import Scripted
from tests.support.tasks import doing_protocol, in_the_room
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records.consents import Given, read_consents
from vrcomfort.records.session_rows import ConsentRow
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.session import SessionSettings, open_enrolment, run

PROTOCOL = protocol_text(
    ASKED_AFTER_EACH,
    '[consent]\nversion = "v1"\nfile = "consent.md"\n',
    name="consenting",
    order=f"{LATIN_SQUARE}sessions = 2\n",
)
NEWER = PROTOCOL.replace('"v1"', '"v2"')


def agree(folder, given=None, text=PROTOCOL, *, who="P01", words="You may stop.", person=None):
    folder.mkdir(exist_ok=True)
    (folder / "consent.md").write_text(words, encoding="utf-8")
    protocol = doing_protocol(folder, text)
    person = person or Scripted()
    done = len(list((folder / "S" / f"sub-{who}").glob("ses-*")))
    with open_enrolment(
        protocol, who, study=folder / "S", respondent=person.name, consent=given,
        sessions=[done + 1],
    ) as enrolment:  # fmt: skip
        return run(enrolment, SessionSettings(respondent=person, **in_the_room()))


def known(folder):
    return [(row.participant, row.version, row.given_on) for row in read_consents(folder / "S")]


@pytest.fixture
def today():
    """Return what tells whether a day is that of the test, which may pass midnight."""
    began = datetime.now(UTC).date().isoformat()
    return lambda day: began <= day <= datetime.now(UTC).date().isoformat()


def test_no_session_begins_without_it(tmp_path):
    with pytest.raises(InputError, match=r"P01 has not consented; .* `v1`; .* --consent v1"):
        agree(tmp_path)
    assert not (tmp_path / "S/participants.csv").exists()
    agree(tmp_path, Given("v1", "2026-03-01"))
    assert known(tmp_path) == [("P01", "v1", "2026-03-01")]
    agree(tmp_path)  # the second session: it is given
    assert known(tmp_path) == [("P01", "v1", "2026-03-01")]
    with pytest.raises(InputError, match="P02 has not consented"):
        agree(tmp_path, who="P02")
    assert not verify_study(tmp_path / "S").faults


def test_another_version_is_asked_again(tmp_path, today):
    agree(tmp_path, Given("v1", "2026-03-01"))
    says = "P01 consented in version `v1` on 2026-03-01, and the protocol asks for `v2` now"
    with pytest.raises(InputError, match=says):
        agree(tmp_path, text=NEWER)
    with pytest.raises(InputError, match="in version `v2`, not `v1`"):
        agree(tmp_path, Given("v1"), NEWER)
    agree(tmp_path, Given("v2"), NEWER)
    first, (who, version, day) = known(tmp_path)
    assert first == ("P01", "v1", "2026-03-01")
    assert (who, version) == ("P01", "v2")
    assert today(day)
    assert not verify_study(tmp_path / "S").faults


def test_no_text_changes_under_one_version(tmp_path):
    agree(tmp_path, Given("v1"))
    with pytest.raises(InputError, match="has changed since P01 gave it; give the new text"):
        agree(tmp_path, words="You may not stop.")
    (row,) = read_consents(tmp_path / "S")
    assert re.fullmatch("[0-9a-f]{64}", row.text_sha256)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (Given("v1", "yesterday"), "is not a date; write it as 2026-03-01"),
        (Given("v1", "2999-01-01"), "is in the future"),
        (Given("v0"), "in version `v1`, not `v0`"),
    ],
)
def test_what_cannot_have_been_given_is_refused(tmp_path, given, says):
    with pytest.raises(InputError, match=says):
        agree(tmp_path, given)


def test_a_protocol_that_asks_for_none_takes_none(tmp_path):
    text = PROTOCOL.replace('[consent]\nversion = "v1"\nfile = "consent.md"\n', "")
    with pytest.raises(InputError, match="asks for no consent; leave --consent out"):
        agree(tmp_path, Given("v1"), text)
    agree(tmp_path, text=text)
    assert not (tmp_path / "S" / ConsentRow.FILE).exists()


def test_a_text_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"there is no file .*other.md; write the text there"):
        agree(tmp_path, text=PROTOCOL.replace("consent.md", "other.md"))


def test_simulated_participants_consent_to_anything(tmp_path, today):
    (tmp_path / "consent.md").write_text("You may stop.", encoding="utf-8")
    protocol = doing_protocol(tmp_path, PROTOCOL)
    person = SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    agree(tmp_path, person=person)
    ((who, version, day),) = known(tmp_path)
    assert (who, version) == ("P01", "v1")
    assert today(day)


def test_verify_misses_what_is_not_there_and_copies_leave_it_out(tmp_path):
    agree(tmp_path, Given("v1"))
    anonymise(tmp_path / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    assert not (tmp_path / "shared" / ConsentRow.FILE).exists()
    assert not verify_study(tmp_path / "shared").faults
    (tmp_path / "S" / ConsentRow.FILE).unlink()
    (told,) = (str(each) for each in verify_study(tmp_path / "S").faults)
    assert "session 1 of P01 asked for consent `v1`, which is not here" in told


def test_run_takes_it_from_the_command_line(tmp_path):
    (tmp_path / "consent.md").write_text("You may stop.", encoding="utf-8")
    file = doing_protocol(tmp_path, PROTOCOL).file
    words = ["run", str(file), "--participant", "P01", "--out", str(tmp_path / "S")]
    refused = CliRunner().invoke(app, words)
    assert "--consent v1" in str(refused.exception or refused.output)
    refused = CliRunner().invoke(app, [*words, "--consented-on", "2026-03-01"])
    assert "--consented-on needs --consent VERSION" in str(refused.exception or refused.output)
