"""The tutorial, followed to the letter: what it says to type runs, and prints what it says."""

from __future__ import annotations

import csv
import importlib.util
import json
import re
import shlex
import sys

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from tests.support.places import ROOT
from vrcomfort.cli.app import app

PAGE = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def tutorial():
    file = ROOT / "scripts" / "tutorial_pictures.py"
    spec = importlib.util.spec_from_file_location("tutorial_pictures", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules["tutorial_pictures"] = module
    spec.loader.exec_module(module)
    return module


def test_every_block_of_commands_and_every_picture_of_the_page_is_known(tutorial):
    assert len(tutorial.steps()) == PAGE.count("```sh\n")
    assert "".join(step.commands for step in tutorial.steps()).count("vrcomfort ") == 6
    for picture in re.findall(r"\]\((images/[^)]+)\)", PAGE):
        with Image.open(ROOT / "docs" / picture) as image:
            assert min(image.size) > 300
    for page in re.findall(r"\]\((\w+\.md)", PAGE):
        assert (ROOT / "docs" / page).is_file()


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_what_the_page_says_to_type_runs_and_prints_what_it_says(tutorial, tmp_path):
    printed = tutorial.follow(tmp_path)
    for step, text in zip(tutorial.steps(), printed, strict=True):
        said = " ".join(text.split())
        for line in filter(None, step.printed):
            assert " ".join(line.split()) in said, step.commands
    assert (tmp_path / "lens_report" / "index.html").is_file()
    ratings = [row for file in tmp_path.glob("lens_data/*/*/ratings.csv") for row in rows(file)]
    assert 0 < sum(row["missed"] == "1" for row in ratings) < len(ratings) / 5
    assert min(float(row["latency_s"]) for row in ratings if row["latency_s"]) > 0.5
    summary = json.loads((tmp_path / "lens_report" / "results.json").read_text(encoding="utf-8"))
    assert not any("shortened" in notice for notice in summary["notices"])
    with (tmp_path / "lens_report" / "tables" / "rating_curves.csv").open() as file:
        assert {float(row["time_s"]) for row in csv.DictReader(file)} == {60, 120, 180, 240, 300}


def rows(file):
    with file.open(encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


def test_the_picture_of_the_panel_is_of_this_version(tutorial, tmp_path):
    written = shlex.split(tutorial.steps()[0].commands)[2:]
    file = str(tmp_path / written[0])
    assert CliRunner().invoke(app, ["new", file, *written[1:]]).exit_code == 0
    panel = tutorial.picture_of_the_panel(tmp_path)
    with Image.open(ROOT / "docs" / "images" / "tutorial_panel.png") as shipped:
        assert np.array_equal(np.asarray(shipped.convert("RGB")), np.asarray(panel))
