"""What is too far off for any file, and takes half of an error, is named; what does the same stands with it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.diagnosis import share_taken
from infotraj.diagnosis.judge import out_of_line as module
from infotraj.diagnosis.judge import verdicts
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.select.prior import Scales

NAMES = ["com_offset", "steady_force", "mass_offset", "linear_drag", "pressure_centre"]


def told(steps, common=1.0):
    """The fit of nothing beside a file that is off by `common` times 1 %, of columns that are off by so many sizes."""

    def rows(rng, _):
        x = rng.standard_normal((ROWS, 1 + len(NAMES)))
        x[:, 0] += 3.0 * x[:, 1:] @ np.array(steps)
        x[:, 1:] *= 3.0
        return x

    search, made = linear_fit(NAMES, rows, [])
    scales = Scales(common)
    return search, replace(made, scales=scales, solution=made.linear.scorer(scales).solution(()))


def test_what_is_further_off_than_in_the_worst_of_files_is_told_by_its_label():
    """Such a file has 0.77 usual sizes of a centre of mass, and 0.5 of a force: 2.5 and 1.7 are more than three times
    as far off."""
    assert module.beyond_any_file(told([2.5, 0.0, 0.0, 0.0, 0.0])[1]) == ["com_offset"]
    assert module.beyond_any_file(told([1.2, 1.7, 0.0, 0.0, 0.0])[1]) == ["steady_force"]
    # Thrust over mass is of several numbers; a drag, and where it acts, are in no file.
    assert module.beyond_any_file(told([0.0, 0.0, 9.0, 3.0, 9.0])[1]) == []


@pytest.mark.parametrize(
    ("takes", "other", "group"),
    [(0.6, 0.1, None), (1.5, 0.1, ["com_offset"]), (1.5, 1.0, ["com_offset", "linear_drag"])],
)
def test_it_is_named_where_it_halves_an_error_with_what_leaves_less_than_twice_as_much(
    monkeypatch, takes, other, group
):
    search, made = told([2.5, 0.0, 0.0, 0.0, 0.0])
    falls = {"com_offset": {"tx": takes, "fz": 0.1}, "linear_drag": {"tx": other}}
    monkeypatch.setattr(
        module, "evidence", lambda fit, label, rng: SimpleNamespace(falls=falls.get(label, {"tx": 0.0}))
    )
    lost = {}
    monkeypatch.setattr(
        module,
        "given",
        lambda search, fit, labels: SimpleNamespace(labels=labels, lost=lost, at_bound={}, gain=len(fit)),
    )
    member = {x: SimpleNamespace(candidate=SimpleNamespace(name=x)) for x in NAMES}
    monkeypatch.setattr(module, "in_fit", lambda fit, label, told: (member[label], {}))
    monkeypatch.setattr(verdicts, "values_of", lambda member: {})
    search.fitted, search.held = lambda labels, *_, **__: tuple(labels), ()
    absent = tuple(Finding(n, "Not needed", (n,), None, {}, {}) for n in NAMES)
    given = SimpleNamespace(fit=SimpleNamespace(labels=("mass_offset",)), beside=(), of_ratio={})
    found, around, after = module.with_out_of_line(search, absent, made, given, np.random.default_rng(0))
    verdict = "Supported" if group and len(group) == 1 else "Not separable"
    assert [(f.name, f.verdict) for f in found if f.verdict != "Not needed"] == [(n, verdict) for n in group or []]
    assert getattr(after, "labels", None) == (["mass_offset", "com_offset"] if group else None)
    # Around what is named where the model that is given predicts better so.
    assert around == (("mass_offset", "com_offset") if group else made)
    lost["com_offset"] = "tz is predicted worse with it"
    same = module.with_out_of_line(search, absent, made, given, np.random.default_rng(0))
    assert same == (absent, made, given)
    lost.clear()
    confident = tuple(replace(f, verdict="Supported") if f.name == "com_offset" else f for f in absent)
    assert module.with_out_of_line(search, confident, made, given, np.random.default_rng(0))[0] == confident


def test_nothing_is_out_of_line_beside_healthy_flights():
    search, made = told([2.5, 0.0, 0.0, 0.0, 0.0])
    made.linear.observation.healthy = "flights"
    assert module.with_out_of_line(search, (), made, None, np.random.default_rng(0)) == ((), made, None)


def test_what_another_part_takes_off_is_none_of_a_share():
    """Names leave 0.1 of an error, the numbers of the file all of it, both 0.1; then both leave 0.3, alone or together;
    then names take nothing; then the numbers take half alone, and nine tenths beside the names."""
    alone, names, both = np.array([[1.0, 0.3, 0.1, 0.5], [0.1, 0.3, 1.0, 0.2], [0.1, 0.3, 0.1, 0.02]])
    np.testing.assert_allclose(share_taken(np.ones(4), alone, names, both), [0.0, 0.0, 0.9, 0.5])
