"""Files that a user writes in YAML: keys that do not exist are errors, told in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from infotraj.errors import UsageError, problem
from infotraj.vehicle import validation_line


class Strict(BaseModel):
    """A part of such a file."""

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


T = TypeVar("T", bound=Strict)


def content_of(path: str | Path) -> Any:
    """What the file holds. UsageError, one line, where it cannot be read."""
    try:
        return yaml.safe_load(Path(path).read_text())
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UsageError(problem(f"{path}: cannot be read ({error})", "a YAML file", "Check the path.")) from error


def read_yaml(cls: type[T], path: str | Path) -> T:
    """The file's content as `cls`. UsageError, one line, where it cannot be used."""
    try:
        return cls.model_validate(content_of(path))
    except ValidationError as error:
        raise UsageError(f"{path}: {validation_line(error, cls)}") from error
