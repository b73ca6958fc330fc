"""Which key gives which answer, in the terminal and on a panel: numbers, and these."""

from __future__ import annotations

BACK = "b"
DECLINE = "-"
STOP = "q"
YES = "y"
NO = "n"

HELP = f"{DECLINE} = rather not say, {BACK} = back, {STOP} = withdraw"
SURE = f"Stop the study for this participant? {YES} = yes, {NO} = go on"
