"""Questions need a wording before a person is asked them."""

from __future__ import annotations

from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import find_instrument

IPQ = PROTOCOL.replace('timepoint = "recovery"', 'timepoint = "recovery"\ninstrument = "ipq"')
IPQ_ITEMS = [item.name for item in find_instrument("ipq").asked]
WORDED = 'languages = ["en"]\n' + IPQ
WORDED += "\n[text.en]\nsource = 'A lab (2026)'\n[text.en.instruments.ipq.items]\n"
WORDED += "".join(f'{name} = "Question {name[-3:]}?"\n' for name in IPQ_ITEMS)


def test_items_without_wording_are_a_fault_of_check_and_no_person_is_asked_them(run, tmp_path):
    file = tiny_protocol(tmp_path, IPQ).file
    code, out, err = run("check", file, "--no-draw")
    assert code == 2
    assert "nothing is wrong" not in out
    assert "the IPQ has no wording in `en` for ipq_g1, ipq_sp1, " in err
    assert (
        'write the questions into [text.en.instruments.ipq.items], with `languages = ["en"]`' in err
    )
    study = tmp_path / "people"
    told = ["run", file, "--participant", "P01", "--out", study, "--exposure-s", "0.1"]
    code, _, err = run(*told, "--respondent", "terminal")
    assert code == 2
    assert "the IPQ has no wording in `en`" in err
    assert not study.exists()
    assert run("simulate", file, "-n", "1", "--no-draw", "--out", tmp_path / "simulated")[0] == 0


def test_a_protocol_can_give_an_instrument_the_wording_of_its_own_language(run, tmp_path):
    file = tiny_protocol(tmp_path, WORDED).file
    code, _, err = run("check", file, "--no-draw")
    assert code == 0, err
    protocol = load_protocol(file).spoken("en")
    (ask,) = (each for each in protocol.questionnaires if each.instrument == "ipq")
    assert [item.text for item in protocol.form(ask).items][:2] == [
        "Question _g1?",
        "Question sp1?",
    ]
    assert {"instrument": "ipq", "language": "en", "source": "A lab (2026)"} in protocol.wordings
