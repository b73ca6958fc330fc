"""Recorded sessions in the making: frames with cuts, gaps and menus, and what a session is."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pandas as pd

PERIOD_NS = 13_888_889
TRIALS = ("participant", "session", "trial", "condition", "scene", "start_s", "end_s", "status",
          "attempt", "frames", "dropped")  # fmt: skip


def frames(n: int, *, trials: int = 2, seed: int = 1) -> pd.DataFrame:
    """Return `n` frames of a head that moves, with everything that a recording can have."""
    random = np.random.default_rng(seed)
    gaps = random.choice([1, 2, 3], n, p=[0.9, 0.07, 0.03])
    time_ns = np.cumsum(gaps) * PERIOD_NS
    turns = random.normal(size=(n, 4)).cumsum(axis=0) * 0.01 + [0, 0, 0, 3]
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    turns *= random.choice([1, -1], (n, 1))  # q and −q are one orientation
    steps = random.normal(size=(n, 6)).cumsum(axis=0) * 0.003
    focus_m = np.where(random.random(n) < 0.1, np.nan, 1 + random.random(n))
    return pd.DataFrame({
        "session_s": time_ns / 1e9, "xr_time_ns": time_ns, "period_ns": PERIOD_NS,
        "trial": np.arange(n) * (trials + 1) // n,
        "should_render": (random.random(n) > 0.05).astype(int),
        "head_x_m": steps[:, 0], "head_y_m": steps[:, 1], "head_z_m": steps[:, 2],
        "head_qx": turns[:, 0], "head_qy": turns[:, 1], "head_qz": turns[:, 2],
        "head_qw": turns[:, 3],
        "avatar_x_m": steps[:, 3], "avatar_y_m": steps[:, 4], "avatar_z_m": steps[:, 5],
        "head_valid": (random.random(n) > 0.05).astype(int),
        "head_tracked": (random.random(n) > 0.1).astype(int),
        "session_state": random.choice(["focused", "visible"], n, p=[0.9, 0.1]),
        "focus_m": focus_m, "focus_raw_m": 1 + random.random(n),
        "max_blur_px": random.choice([5.6, 11.2], n),
        "dropped": ((gaps > 1) & (random.random(n) < 0.7)).astype(int),
        "missed_refreshes": gaps - 1,
        "discontinuity": random.choice([0, 1, 2], n, p=[0.96, 0.02, 0.02]),
        "rays_used": "111101111",
    })  # fmt: skip


def session(folder: Path, table: pd.DataFrame, *, participant: str = "P01") -> Path:
    """Write frames.csv and trials.csv of one session and return the former."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "frames.csv"
    table.to_csv(file, index=False, lineterminator="\n")
    shown = table[table["trial"] > 0].groupby("trial")
    with (folder / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(TRIALS)
        for trial, rows in shown:
            start, end = rows["session_s"].min(), rows["session_s"].max()
            names = (participant, 1, trial, "ab"[int(trial) % 2], "temple")
            counts = (len(rows), rows["dropped"].sum())
            writer.writerow((*names, start, end, "completed", 1, *counts))
    return file
