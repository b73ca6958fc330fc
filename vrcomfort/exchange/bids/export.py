"""Exports a study, recorded or imported, as a BIDS dataset."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.exchange.bids.dataset import write_dataset
from vrcomfort.exchange.bids.imported import write_import
from vrcomfort.exchange.export_checks import new_folder, require_whole, said_of
from vrcomfort.exchange.imports import Import, is_import
from vrcomfort.records.choice import EVERYTHING, Choice


def export_bids(study: Path, out: Path, choice: Choice = EVERYTHING) -> list[str]:
    """Write a study as a BIDS dataset into a new folder; return a sentence for each omission.

    Raises
    ------
    InputError
        If the study is not whole, or the folder is there already.
    """
    faults = require_whole(study, choice)
    with new_folder(study, out) as draft:
        if is_import(study):
            return write_import(Import(study), draft, said_of(choice, faults))
        return write_dataset(study, draft, choice, faults)
