"""`schema`: what the project's TOML files may say, for editors that complete and check them."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from vrcomfort.cli.terminal import answer

if TYPE_CHECKING:
    from pydantic import BaseModel


class FileKind(StrEnum):
    """Which file."""

    PROTOCOL = "protocol"
    PLAN = "plan"
    SIDE_CAR = "side-car"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(schema)


def schema(
    kind: Annotated[FileKind, typer.Argument(help="Which of the project's TOML files.")],
) -> None:
    """Print the JSON Schema of protocols, analysis plans, or scenes' side-cars.

    - `vrcomfort schema protocol > protocol.schema.json`
    - `vrcomfort schema plan > plan.schema.json`
    """
    from vrcomfort.settings.schema import json_schema

    answer(json_schema(_model(kind)))


def _model(kind: FileKind) -> type[BaseModel]:
    from vrcomfort.protocol import Protocol
    from vrcomfort.report.plan_files import AnalysisPlan
    from vrcomfort.scene.side_car import SideCar

    models: dict[FileKind, type[BaseModel]] = {
        FileKind.PROTOCOL: Protocol,
        FileKind.PLAN: AnalysisPlan,
        FileKind.SIDE_CAR: SideCar,
    }
    return models[kind]
