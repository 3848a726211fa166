"""The list of deliberate errors fits the code as it is, and what runs them sees an error and tells it from none."""

import ast
import importlib.util
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
_spec = importlib.util.spec_from_file_location("deliberate_errors", TOP / ".ci" / "deliberate_errors.py")
made = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(made)
ERRORS = made.read()


def test_there_are_forty_and_no_two_alike():
    assert len({(e["path"], e["before"], e["after"]) for e in ERRORS}) == len(ERRORS) >= 40


@pytest.mark.parametrize("error", ERRORS, ids=lambda e: e["path"])
def test_each_applies_once_and_is_python_still(error):
    path, text = made.changed(error, TOP / "src" / "infotraj")
    assert text != path.read_text()
    ast.parse(text)
    assert all((TOP / "tests" / name).is_file() for name in error["tests"])


def test_an_error_that_does_not_apply_is_said(tmp_path):
    (tmp_path / "a.py").write_text("x = 1\nx = 1\n")
    with pytest.raises(ValueError, match="stands there 2 times"):
        made.changed({"path": "a.py", "before": "x = 1", "after": "x = 2"}, tmp_path)
