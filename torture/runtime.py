"""An OpenXR runtime that is killed, or stands still, in every state of a session.

Needs a Monado: `scripts/in_runtime.sh python -m torture --only runtime`.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from torture.case import HANG, OTHER, Outcome, Result, Rig
from torture.rows import PARTICIPANT, TRIALS, session_folder
from torture.session import STUDY, TRACE, Ended, Findings, Victim
from vrcomfort.headset.monado import READY_SOCKET, SERVICE

STATE_S = 120.0
"""A session on a busy machine reaches every state in less."""

END_S, PAUSE_S, TOLD_S = 180.0, 3.0, 12.0
EXIT_RUNTIME_LOST, EXIT_INTERRUPTED, EXIT_BAD_INPUT = 3, 130, 2


class State(NamedTuple):
    """A state of a session, and the exit codes of one whose runtime is killed in it."""

    reached: Callable[[Victim], bool]
    codes: frozenset[int] = frozenset({EXIT_RUNTIME_LOST})


def _listening(victim: Victim) -> bool:
    """Return whether the runtime takes applications."""
    service = _service(victim)
    if service is None:
        return False
    try:
        variables = Path(f"/proc/{service}/environ").read_bytes().split(b"\0")
    except OSError:
        return False  # it has just ended
    folders = [v.partition(b"=")[2] for v in variables if v.startswith(b"XDG_RUNTIME_DIR=")]
    return any((Path(folder.decode()) / READY_SOCKET).exists() for folder in folders)


def _service(victim: Victim) -> int | None:
    """Return the process of the victim's own runtime."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = stat.read_text().rpartition(")")
        except OSError:
            continue  # it has just ended
        if (
            SERVICE.startswith(name.partition("(")[2])
            and int(rest.split()[1]) == victim.process.pid
        ):
            return int(stat.parent.name)
    return None


STATES: Mapping[str, State] = {
    "before the session": State(_listening, frozenset({EXIT_BAD_INPUT, EXIT_RUNTIME_LOST})),
    "before the first question": State(lambda victim: bool(victim.rows())),
    "in a questionnaire": State(lambda victim: len(victim.rows("questionnaires.csv")) > 4),
    "in an exposure": State(lambda victim: len(victim.rows("frames.csv")) > 40),
    "at the end": State(lambda victim: len(victim.rows("trials.csv")) == TRIALS),
}
DEEDS = ("kill", "stop and continue", "stop")


def torture(rig: Rig) -> Result:
    """Do everything to it in every state."""
    pairs = [(state, deed) for deed in DEEDS for state in STATES]
    if rig.short:
        pairs = [("in an exposure", "kill"), ("in a questionnaire", "kill")]
    if shutil.which(SERVICE) is None:
        return Result("runtime", [], f"{SERVICE} is not installed; see scripts/in_runtime.sh")
    folder = rig.place("runtime")

    def case(number: int, seed: int) -> Outcome:
        return _case(folder / str(number), *pairs[number], seed)

    outcomes = list(rig.all("runtime", len(pairs), case, limit_s=rig.count(900, 120)))
    how = (
        f"Monado is killed, stopped for {PAUSE_S:g} s, or stopped for good: {', '.join(STATES)}. "
        "The session ends with one sentence or goes on; one that stands still says so within "
        f"{TOLD_S:g} s and then hears Ctrl-C. Its records are closed and have every row."
    )
    return Result("runtime", outcomes, how, len(pairs))


def _words(folder: Path) -> list[str]:
    answers = folder / "answers.txt"
    answers.write_text("0 1 2 3 " * 100)
    return [
        *("run", str(STUDY), "--participant", PARTICIPANT, "--out", str(folder / "study")),
        *("--headset", "openxr", "--size", "16x16", "--quiet"),
        *("--monado-trace", str(TRACE), "--monado-answers", str(answers)),
    ]


def _case(folder: Path, state: str, deed: str, seed: int) -> Outcome:
    folder.mkdir(parents=True)
    study, found = folder / "study", Findings()
    victim = Victim(_words(folder), folder / "first.txt", slow=False)
    if not victim.wait_for(lambda: STATES[state].reached(victim), STATE_S):
        victim.end(0.0)
        found.fault = HANG if victim.process.returncode == -signal.SIGKILL else OTHER
        found.details.append(f"never reached: {victim.said()[-300:]}")
        return found.outcome(name=f"{deed} {state}", seed=seed, folder=folder)
    ended, codes = _do(victim, deed, STATES[state].codes)
    found.end("the session", ended, codes, noted=deed == "stop")
    found.rows("after its end", victim.must_be_there(None), study)
    _closed(study, found)
    return found.outcome(name=f"{deed} {state}", seed=seed, folder=folder)


def _do(victim: Victim, deed: str, killed: frozenset[int]) -> tuple[Ended, frozenset[int]]:
    """Do something to the runtime; return how the session ended, and which exit codes are right."""
    if deed == "kill":
        _signal(victim, signal.SIGKILL)
        return victim.end(END_S), killed
    before = victim.sentences()
    _signal(victim, signal.SIGSTOP)
    if deed == "stop and continue":
        time.sleep(PAUSE_S)
        _signal(victim, signal.SIGCONT)
        return victim.end(STATE_S), killed | {0}
    told = victim.wait_for(lambda: victim.sentences() > before, TOLD_S)
    victim.send(signal.SIGINT)
    ended = victim.end(END_S)
    if not told:
        ended = ended._replace(code=None, said=f"nothing within {TOLD_S:g} s; {ended.said}")
    return ended, killed | {EXIT_INTERRUPTED}


def _closed(study: Path, found: Findings) -> None:
    """Hold against a session that its manifest says that it is running."""
    manifest = session_folder(study) / "manifest.json"
    if manifest.exists() and json.loads(manifest.read_text())["status"] == "running":
        found.fault = found.fault or OTHER
        found.details.append("the manifest says: running")


def _signal(victim: Victim, number: signal.Signals) -> None:
    service = _service(victim)
    if service is not None:
        os.kill(service, number)
