"""The configuration: its files are those of its model, and a key that does not exist is refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest
import yaml

from infotraj.errors import UsageError
from infotraj.experiment.common.config import ExperimentConfig, load, read
from infotraj.experiment.common.config_files import DEFAULTS, SCHEMA, default_yaml, schema

TOP = Path(__file__).parents[2]


def test_the_committed_files_are_those_of_the_model():
    remedy = "run `python -m infotraj.experiment.common.config_files`"
    assert (TOP / DEFAULTS).read_text() == default_yaml(), remedy
    assert (TOP / SCHEMA).read_text() == schema(), remedy


def test_the_default_file_holds_the_defaults():
    assert read(TOP / DEFAULTS) == ExperimentConfig()


def test_the_schema_accepts_the_defaults_and_no_other_key():
    validator = jsonschema.Draft202012Validator(json.loads(schema()))
    defaults = yaml.safe_load(default_yaml())
    validator.validate(defaults)
    assert not validator.is_valid({**defaults, "seds": 3})
    assert not validator.is_valid({**defaults, "selection": {**defaults["selection"], "drws": 3}})
    assert not validator.is_valid({**defaults, "gains": {**defaults["gains"], "position": 3.0}})


@pytest.mark.parametrize("path", sorted((TOP / "config").glob("*.yaml")), ids=lambda path: path.name)
def test_every_configuration_of_the_project_is_valid(path):
    read(path)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"seds": 3}, "seds: unknown key"),
        ({"selection": {"drws": 3}}, r"selection\.drws: unknown key"),
        ({"gains": {"position": 3.0}}, r"gains\.position: unknown key"),
        ({"base_sed": 3}, "base_sed: unknown key; did you mean base_seed?"),
        ({"gains": {"positon_p": 3.0}}, r"gains\.positon_p: unknown key; did you mean position_p?"),
        ({"gains": {"position_p": -1.0}}, r"gains\.position_p: .* 0 \(found '-1\.0'\)"),
        ({"gains": {"max_correction": 0}}, r"gains\.max_correction: .*greater than 0"),
        ({"seeds": 0}, "seeds: "),
        ({"seeds": True}, "seeds: a number is expected, not true or false"),
        ({"sample_time": True}, "sample_time: a number is expected, not true or false"),
        ({"plants": "omav_a"}, r"plants: a list is expected; write \['omav_a'\]"),
        ({"plants": ["../omav_a"]}, r"plants\.0: a name of letters, digits, _ and - is expected"),
        ({"plants": ["omav_a", "omav_b", "omav_a"]}, "plants: omav_a is named twice; name it once"),
        ({"added_points": [20, 20]}, "added_points: 20 is named twice; name it once"),
        ({"selection": {"estimate_noise": [1, 2, 3, 4, 5]}}, "estimate_noise: a list of at most 4 is expected"),
        ({"task": 3}, "task: keys with values are expected"),
        ({"hindsight": {"costs": ["kernal"]}}, r"costs\.0: [^;]*found 'kernal'\)$"),
        ({"deviations": {"min_frequency": 3}}, "min_frequency 3 Hz is above max_frequency 2 Hz; lower the one"),
        ({"closed_loop": {"cases": ["com_offset"]}}, "shown is .*, which is none of cases; show one of com_offset"),
        ({"check_corpus": {"spoiled": 19}}, "spoiled 19 of only 18 flights"),
        ({"seeds": "many"}, "seeds: .*found 'many'"),
        ({"execution": "balloon"}, "execution: .*found 'balloon'"),
        ({"plants": []}, "plants: a list of at least 1 is expected"),
        (None, "no mapping"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(content, says):
    with pytest.raises(UsageError, match=says) as caught:
        load(content, "my.yaml")
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("my.yaml: ")


def test_deviations_without_a_limit_of_jerk_can_be_asked_for():
    """As the description of the key says; .nan stays refused."""
    config = load(yaml.safe_load("deviations: {max_jerk: .inf}"))
    assert config.model_dump(mode="json")["deviations"]["max_jerk"] == float("inf")
    with pytest.raises(UsageError, match="max_jerk"):
        load(yaml.safe_load("deviations: {max_jerk: .nan}"))


@pytest.mark.parametrize("content", [b"a: [", b"\x80"])
def test_a_file_that_is_not_yaml_is_one_line(tmp_path, content):
    (tmp_path / "c.yaml").write_bytes(content)
    with pytest.raises(UsageError) as caught:
        read(tmp_path / "c.yaml")
    assert "\n" not in str(caught.value)
