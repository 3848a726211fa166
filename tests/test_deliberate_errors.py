"""The list of deliberate errors fits the code as it is, and what runs them sees an error and tells it from none."""

import ast
from itertools import chain
from pathlib import Path

import deliberate_errors as made
import drawn_errors
import pytest

TOP = Path(__file__).parents[1]
PACKAGE = TOP / "src" / "infotraj"
ERRORS = made.read()


def test_there_are_forty_and_no_two_alike():
    assert len({(e["path"], e["before"], e["after"]) for e in ERRORS}) == len(ERRORS) >= 40


@pytest.mark.parametrize("error", ERRORS, ids=lambda e: e["path"])
def test_each_applies_once_and_is_python_still(error):
    path, text = made.changed(error, PACKAGE)
    assert text != path.read_text()
    ast.parse(text)
    assert all((TOP / "tests" / name).is_file() for name in error["tests"])


def test_an_error_that_does_not_apply_is_said(tmp_path):
    (tmp_path / "a.py").write_text("x = 1\nx = 1\n")
    with pytest.raises(ValueError, match="stands there 2 times"):
        made.changed({"path": "a.py", "before": "x = 1", "after": "x = 2"}, tmp_path)


@pytest.mark.long
def test_a_seed_draws_the_same_errors_on_different_lines_and_each_is_python_still():
    drawn = drawn_errors.draw(PACKAGE, 60, seed=5)
    assert drawn == drawn_errors.draw(PACKAGE, 60, seed=5) != drawn_errors.draw(PACKAGE, 60, seed=6)
    assert len({(e["path"], e["line"]) for e in drawn}) == 60
    for error in drawn:
        assert ast.dump(ast.parse(error["text"])) != ast.dump(ast.parse((PACKAGE / error["path"]).read_text()))


@pytest.mark.parametrize(
    ("line", "instead"),
    [
        ("a < b", {"((a) >= (b))"}),
        ("(a + b) * c", {"((a + b) / (c))", "(((a) - (b))) * c"}),
        ("2.5 * a", {"((2.5) / (a))", "5.0 * a", "0.0 * a"}),
        ("a and not b", {"((a) or (not b))", "a and (b)"}),
        ("np.sqrt(a)", {"(a)"}),
        ("sorted(a)", {"sorted(a)[::-1]"}),
        ("np.argmin(a)", {"np.argmax(a)"}),
        ("a if b else c", {"((c) if (b) else (a))"}),
        ("a[1:, -1]", {"a[1:, (1)]"}),
        ("max(a, 1e-12)", {"min(a, 1e-12)"}),
    ],
)
def test_what_a_line_can_become(tmp_path, line, instead):
    (tmp_path / "a.py").write_text(line)
    assert {line[:b] + new + line[e:] for _, b, e, new in drawn_errors.errors(tmp_path / "a.py")} == instead


@pytest.mark.parametrize(
    "line",
    [
        '"""text 1 < 2"""',
        'raise ValueError(f"{1 + 2}")',
        "x: Literal[2]",
        "f(tol=2.0, axis=1)",
        'x = "a" + b',
        "x = a[1]",
    ],
)
def test_lines_on_which_nothing_depends_are_left_out(tmp_path, line):
    (tmp_path / "a.py").write_text(f"{line}\n")
    assert drawn_errors.errors(tmp_path / "a.py") == []


def test_the_nearest_tests_are_asked_first():
    near = list(made.near("residual/gaussian_process.py").values())
    assert "tests/residual/test_gaussian_process.py" in near[0]
    assert "tests/residual/test_subset.py" in near[0] + near[1]
    asked = [*chain(*near)]
    assert len(set(asked)) == len(asked)
