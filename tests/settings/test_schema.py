"""JSON Schemas of the settings files, the reference page, and all faults of a file at once."""

from __future__ import annotations

import copy
import json
import tomllib

import jsonschema
import pytest
from pydantic import BaseModel

from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.reference import protocol_reference
from vrcomfort.resources import data_folder
from vrcomfort.scene.side_car import SideCar
from vrcomfort.settings.schema import json_schema, key_texts, models_in

FILES = {
    "protocol": sorted(data_folder("protocols").glob("*.toml")),
    "plan": sorted(data_folder("analysis").glob("*.toml")),
    "side-car": sorted(data_folder("scenes").glob("*.toml")),
}


VALIDATORS: dict[str, jsonschema.Draft202012Validator] = {}


@pytest.fixture
def schema_of(run):
    """Return what gives the schema that the command prints, made once of each kind."""

    def call(kind: str) -> jsonschema.Draft202012Validator:
        if kind not in VALIDATORS:
            code, out, _ = run("schema", kind)
            assert code == 0
            schema = json.loads(out)
            jsonschema.Draft202012Validator.check_schema(schema)
            VALIDATORS[kind] = jsonschema.Draft202012Validator(schema)
        return VALIDATORS[kind]

    return call


@pytest.mark.parametrize("kind", FILES)
def test_every_shipped_file_is_valid_by_its_schema(schema_of, kind):
    validator = schema_of(kind)
    assert FILES[kind]
    for file in FILES[kind]:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
        assert [error.message for error in validator.iter_errors(data)] == [], file


@pytest.mark.parametrize(
    "change",
    [
        lambda data: data.pop("title"),
        lambda data: data.update(exposre_s=1.0),
        lambda data: data.update(exposure_s=-1.0),
        lambda data: data.update(exposure_s="900"),
        lambda data: data.update(scenes=[]),
        lambda data: data["order"].update(rule="explict"),
        lambda data: data["conditions"][0].update(name="a b"),
        lambda data: data["conditions"][1]["depth_of_field"].update(pupil_mm=300),
        lambda data: data["conditions"][1]["depth_of_field"].update(slices_m=[]),
        lambda data: data.update(headset={"image_size_px": [1832]}),
    ],
)
def test_the_schema_finds_what_reading_finds(schema_of, change):
    data = tomllib.loads(PROTOCOL)
    validator = schema_of("protocol")
    assert list(validator.iter_errors(data)) == []
    changed = copy.deepcopy(data)
    change(changed)
    assert list(validator.iter_errors(changed))


def test_a_schema_has_no_null_which_toml_has_not(schema_of):
    for kind in FILES:
        schema = json.dumps(schema_of(kind).schema)
        assert '"null"' not in schema
        assert '"default": null' not in schema


def test_optional_tables_keep_their_shape():
    properties = json_schema(Protocol)["properties"]
    assert properties["allocation"]["$ref"] == "#/$defs/Allocation"
    one_or_more = properties["ratings"]["anyOf"]
    assert [each.get("$ref") for each in one_or_more] == [None, "#/$defs/Ratings"]
    assert properties["participants"]["type"] == "integer"
    assert properties["participants"]["description"] == "Planned number of participants."


class Choice(BaseModel):
    """A table."""

    value: int | str | None = None
    """A value."""


def test_a_choice_loses_null_and_keeps_the_others():
    value = json_schema(Choice)["properties"]["value"]
    assert value == {"anyOf": [{"type": "integer"}, {"type": "string"}], "description": "A value."}


@pytest.mark.parametrize("model", [Protocol, SideCar])
def test_every_key_is_described(model):
    for table in models_in(model):
        assert table.__doc__, table
        undescribed = table.model_fields.keys() - key_texts(table).keys()
        assert not undescribed, f"{table.__name__}: {undescribed}"


def test_descriptions_are_in_the_schema_also_of_what_is_inherited():
    tables = json_schema(Protocol)["$defs"]
    for model in models_in(Protocol)[1:]:
        for entry in tables[model.__name__]["properties"].values():
            assert entry["description"]
    assert (
        "`head`: of the tracked head" in tables["Vignette"]["properties"]["speed_of"]["description"]
    )


@pytest.mark.smoke
def test_the_reference_page_is_that_of_these_models():
    page = data_folder("protocols").parent / "docs" / "protocol_reference.md"
    assert page.read_text(encoding="utf-8") == protocol_reference(), (
        "run python scripts/protocol_reference.py"
    )


def test_the_reference_page_names_every_key_once_with_its_default():
    page = protocol_reference()
    for model in models_in(Protocol)[1:]:
        section = page.split(f'<a id="{model.__name__.lower()}"></a>')[1].split("<a id=")[0]
        for key in model.model_fields:
            assert section.count(f"\n| `{key}` |") == 1, (model, key)
    assert "| `exposure_s` | number from 0.001 to 14400 | **needed** |" in page
    assert "`[[conditions]]`" in page
    assert "`[conditions.focus]`, `[factors.levels.focus]`" in page


def test_all_faults_of_a_file_are_told_with_their_places(tmp_path, run):
    text = PROTOCOL.replace("training_s", "traning_s").replace('"explicit"', '"explict"')
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text.replace("every_s = 3.0", 'every_s = "3"'))
    told = [caught.value.alone, *caught.value.others]
    assert [(each.line, each.column) for each in told] == [(5, 1), (15, 1), (38, 1)]
    assert "did you mean `training_s`?" in told[0].message
    assert "did you mean `explicit`?" in told[1].message
    assert "2 more problems in this file" in str(caught.value)
    code, _, err = run("design", tmp_path / "tiny.toml")
    assert code == 2
    lines = err.strip().splitlines()
    assert [line.startswith("error: ") for line in lines] == [True] * 3
    assert "more problem" not in err
    for line, each in zip(lines, told, strict=True):
        assert f"tiny.toml, line {each.line}, column {each.column}: " in line


def test_faults_that_types_do_not_see_are_all_told(tmp_path):
    text = PROTOCOL.replace('condition = "plain"', 'condition = "plane"')
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text.replace('["room.glb"]', '["room.glb", "hall.glb"]'))
    told = [caught.value.alone, *caught.value.others]
    assert [each.line for each in told] == [4, 19, 20]
    assert "no scene file" in told[0].message
    assert all("did you mean `plain`?" in each.message for each in told[1:])


def test_a_misspelt_key_is_not_told_as_missing_as_well(tmp_path):
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, PROTOCOL.replace("exposure_s =", "exposre_s ="))
    assert "did you mean `exposure_s`?" in caught.value.message
    assert caught.value.others == ()
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, PROTOCOL.replace("exposure_s =", "nothing_like_it ="))
    assert [each.message for each in caught.value.others] == ["`exposure_s` is missing; add it"]
