"""The files that are written from the configuration's model: its default YAML and its JSON schema.

`python -m infotraj.experiment.common.config_files` writes both; a test fails where they differ from the model.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_type_hints

import yaml
from pydantic import BaseModel, ConfigDict, create_model

from infotraj.experiment.common.config import ExperimentConfig
from infotraj.writing import write_text

DEFAULTS = Path("config/config.yaml")
SCHEMA = Path("workflow/schemas/config.schema.json")
_HEAD = """\
# Written by `python -m infotraj.experiment.common.config_files`.
# A file given with --configfile overrides single keys.
"""


def default_yaml() -> str:
    """The default configuration as YAML, each key with its description as a comment."""
    return _HEAD + "\n".join(_lines(ExperimentConfig(), indent="")) + "\n"


def schema() -> str:
    """The JSON schema (draft 2020-12) of a configuration: a description and a default a key, closed to others."""
    content = {"$schema": "https://json-schema.org/draft/2020-12/schema", **ExperimentConfig.model_json_schema()}
    for name, field in ExperimentConfig.model_fields.items():
        if _is_record(field.default):
            record = type(field.default)
            content["$defs"][record.__name__] = _record_by_name(field.default)
            content["properties"][name]["default"] = field.default._asdict()
    return json.dumps(content, indent=2) + "\n"


def _record_by_name(record: Any) -> dict[str, Any]:
    """A record (named tuple) is written as a mapping, which the model reads as well as a list."""
    types = get_type_hints(type(record), include_extras=True)
    fields: dict[str, Any] = {key: (types[key], value) for key, value in record._asdict().items()}
    return create_model(type(record).__name__, __config__=ConfigDict(extra="forbid"), **fields).model_json_schema()


def write(folder: str | Path = ".") -> None:
    """Writes both files below `folder`, the top of the project."""
    for name, text in ((DEFAULTS, default_yaml()), (SCHEMA, schema())):
        write_text(text, Path(folder) / name)


def _is_record(value: object) -> bool:
    return isinstance(value, tuple) and hasattr(value, "_asdict")


def _lines(model: BaseModel, indent: str) -> list[str]:
    lines = []
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        about = field.description or (type(value).__doc__ or "").strip().splitlines()[0]
        if isinstance(value, BaseModel):
            lines += [f"{indent}{name}:  # {about}", *_lines(value, indent + "  ")]
        elif _is_record(value):
            lines.append(f"{indent}{name}:  # {about}")
            lines += [f"{indent}  {key}: {number}" for key, number in value._asdict().items()]
        else:
            plain = model.model_dump(mode="json")[name]
            text = yaml.safe_dump(plain, default_flow_style=True, width=1000).removesuffix("...\n").strip()
            lines.append(f"{indent}{name}: {text}" + (f"  # {field.description}" if field.description else ""))
    return lines


if __name__ == "__main__":
    write()
