"""A study with gaze and head motion, for the report and its documentation: no real people.

``python -m tests.support.gazed FOLDER`` writes it: 8 people, two conditions in two scenes, 30 s
each at 72 Hz. Heads sway (a spectrum that falls with the square of the frequency), eyes fixate
points around the middle of the head's view, closer to it while a shot is fired.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from tests.support.report import Study
from vrcomfort.rotations import rotate
from vrcomfort.stats.gaze_and_head import unit_vectors

RATE_HZ = 72
PERIOD_NS = round(1e9 / RATE_HZ)
EXPOSURE_S = 30.0
HALF_RAD = 0.8
SPREAD_DEG = {"still": 10.0, "blur": 8.0}
"""Standard deviation of fixations around the head's axis, by condition; a third while shooting."""
CONDITIONS, SCENES = ("still", "blur"), ("hall", "garden")


def write(folder: Path, people: int = 8, seconds: float = EXPOSURE_S) -> Path:
    """Write the study and return its folder."""
    study = Study(folder)
    study.describe("looked", still="No blur", blur="Blur")
    for person in range(people):
        name = f"P{person + 1:02d}"
        order = CONDITIONS if person % 2 == 0 else CONDITIONS[::-1]
        totals = {"still": 6 + person % 4, "blur": 3 + person % 3}
        met = [(condition, scene, totals[condition] + (scene == "garden"))
               for condition in order for scene in SCENES]  # fmt: skip
        session = study.session(name, 1, 1, met)
        study.person(name, order[0])
        _record(session, [condition for condition, _, _ in met], seconds, person)
    people_file = folder / "participants.csv"
    errors = np.random.default_rng(1).gamma(6.0, 0.12, people).round(2)
    pd.read_csv(people_file).assign(gaze_validation_error_deg=errors).to_csv(
        people_file, index=False
    )
    return folder


def _record(session: Path, conditions: list[str], seconds: float, seed: int) -> None:
    frames, gaze, events = [], [], []
    for trial, condition in enumerate(conditions, start=1):
        random = np.random.default_rng([seed, trial])
        head, eyes, shots = _exposure(seconds, SPREAD_DEG[condition], random)
        at_s = 100.0 * trial + np.arange(len(head)) / RATE_HZ
        time_ns = (at_s * 1e9).astype(np.int64)
        when = {"session_s": at_s, "xr_time_ns": time_ns}
        begins = (np.arange(len(head)) == 0).astype(int)
        fixed = {"period_ns": PERIOD_NS, "trial": trial, "dropped": 0, "discontinuity": begins}
        frames.append(head.assign(**when, **fixed))
        gaze.append(eyes.assign(**when))
        events += [
            {"onset_s": 100.0 * trial + at, "duration_s": "", "name": "shot"} for at in shots
        ]
    pd.concat(frames).to_csv(session / "frames.csv", index=False)
    pd.concat(gaze).to_csv(session / "gaze.csv", index=False)
    pd.DataFrame(events).to_csv(session / "events.csv", index=False)


def _exposure(
    seconds: float, spread_deg: float, random: np.random.Generator
) -> tuple[pd.DataFrame, pd.DataFrame, list[float]]:
    """Return the head's poses, the gaze in the stage, and when shots were fired."""
    n = round(seconds * RATE_HZ)
    yaw, pitch = np.radians(_sway(n, 12.0, random)), np.radians(_sway(n, 3.0, random))
    turns = np.column_stack([
        np.cos(yaw / 2) * np.sin(pitch / 2), np.sin(yaw / 2) * np.cos(pitch / 2),
        -np.sin(yaw / 2) * np.sin(pitch / 2), np.cos(yaw / 2) * np.cos(pitch / 2),
    ])  # fmt: skip
    head = pd.DataFrame(turns, columns=[f"head_q{axis}" for axis in "xyzw"])
    for axis, middle, metres in (("x", 0.0, 0.02), ("y", 1.6, 0.005), ("z", 0.0, 0.02)):
        head[f"head_{axis}_m"] = middle + _sway(n, metres, random)
    for eye in ("left", "right"):
        for side, sign in (("left", -1), ("right", 1), ("up", 1), ("down", -1)):
            head[f"{eye}_fov_{side}_rad"] = sign * HALF_RAD
    shots = np.sort(random.uniform(0, seconds - 1, round(seconds / 4))).tolist()
    ways, valid = _fixations(turns, spread_deg, shots, random)
    eyes = pd.DataFrame(ways, columns=[f"direction_{axis}" for axis in "xyz"])
    for axis in "xyz":
        eyes[f"origin_{axis}_m"] = head[f"head_{axis}_m"]
    eyes[~valid] = np.nan
    eyes["hit_node"] = np.where(valid, _nodes(ways), "")
    eyes.insert(0, "valid", valid.astype(int))
    return head, eyes, shots


def _nodes(ways: np.ndarray) -> np.ndarray:
    """Return what stands where: a floor, above it a door between two walls, and the sky."""
    right, up = np.degrees(np.arctan2(ways[:, 0], -ways[:, 2])), np.degrees(np.arcsin(ways[:, 1]))
    walls = np.select([right < -8, right < 8], ["left wall", "door"], "right wall")
    return np.select([up < -8, up < 8], ["floor", walls], "")


def _sway(n: int, sd: float, random: np.random.Generator) -> np.ndarray:
    """Return a signal of this standard deviation whose power falls with the frequency squared."""
    f = np.fft.rfftfreq(n, 1 / RATE_HZ)
    phases = np.exp(2j * np.pi * random.random(len(f)))
    signal = np.fft.irfft(phases / np.maximum(f, 0.1), n)
    signal -= signal.mean()
    return signal * (sd / signal.std())


def _fixations(
    turns: np.ndarray, spread_deg: float, shots: list[float], random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return directions that stand still in the stage from saccade to saccade, and blinks."""
    n = len(turns)
    ways, valid, at = np.empty((n, 3)), np.ones(n, dtype=bool), 0
    while at < n:
        length = max(10, round(random.gamma(4.0, 0.08) * RATE_HZ))
        shooting = any(0 <= at / RATE_HZ - shot < 0.5 for shot in shots)
        sd = spread_deg / 3 if shooting else spread_deg
        azimuth, elevation = random.normal(0, sd, 1), random.normal(-3, 0.7 * sd, 1)
        ways[at : at + length] = rotate(turns[at], unit_vectors(azimuth, elevation)[0])
        if random.random() < 0.04:
            valid[at : at + 8] = False
        at += length
    jitter = random.normal(0, 0.0005, ways.shape)
    ways += jitter
    return ways / np.linalg.norm(ways, axis=1, keepdims=True), valid


if __name__ == "__main__":
    print(write(Path(sys.argv[1])))
