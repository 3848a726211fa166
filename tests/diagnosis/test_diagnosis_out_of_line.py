"""What is too far off for any file, and takes half of an error, is named; what does the same stands with it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis import diagnosis
from infotraj.diagnosis.diagnosis import share_taken
from infotraj.diagnosis.judge import out_of_line as module
from infotraj.diagnosis.judge import verdicts
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.select.prior import Scales
from infotraj.errors import InputError

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


class Asked:
    """A centre of mass that is too far off for any file, judged with given falls of errors and given models."""

    def __init__(self, monkeypatch, takes, other):
        self.search, self.told = told([2.5, 0.0, 0.0, 0.0, 0.0])
        falls = {"com_offset": {"tx": takes, "fz": 0.1}, "linear_drag": {"tx": other}}
        self.lost = {}
        monkeypatch.setattr(
            module, "evidence", lambda fit, label, rng: SimpleNamespace(falls=falls.get(label, {"tx": 0.0}))
        )
        monkeypatch.setattr(
            module,
            "given",
            lambda search, fit, labels: SimpleNamespace(labels=labels, lost=self.lost, at_bound={}, gain=len(fit)),
        )
        member = {x: SimpleNamespace(candidate=SimpleNamespace(name=x)) for x in NAMES}
        monkeypatch.setattr(module, "in_fit", lambda fit, label, told: (member[label], {}))
        monkeypatch.setattr(verdicts, "values_of", lambda member: {})
        self.search.fitted, self.search.held = lambda labels, *_, **__: tuple(labels), ()
        self.absent = tuple(Finding(n, "Not needed", (n,), None, {}, {}) for n in NAMES)
        self.given = SimpleNamespace(fit=SimpleNamespace(labels=("mass_offset",)), beside=(), of_ratio={}, at_bound={})

    def __call__(self, findings=None, **asked):
        rng = np.random.default_rng(0)
        found = self.absent if findings is None else findings
        return module.with_out_of_line(self.search, found, self.told, self.given, rng, **asked)

    @property
    def unchanged(self):
        return self.absent, self.told, self.given


@pytest.mark.parametrize(
    ("takes", "other", "group"),
    [
        (0.6, 0.1, None),
        (1.5, 0.1, ["com_offset"]),
        (1.5, 1.0, ["com_offset", "linear_drag"]),
        (1.5, 2.0, ["com_offset", "linear_drag"]),
        (1.5, 2.5, ["linear_drag"]),
    ],
)
def test_it_is_named_where_it_halves_an_error_with_what_leaves_less_than_twice_as_much(
    monkeypatch, takes, other, group
):
    found, around, after = Asked(monkeypatch, takes, other)()
    verdict = "Supported" if group and len(group) == 1 else "Not separable"
    assert [(f.name, f.verdict) for f in found if f.verdict != "Not needed"] == [(n, verdict) for n in group or []]
    assert {f.group for f in found if f.verdict != "Not needed"} == ({tuple(group)} if group else set())
    # Around what is named where the model that is given predicts better so.
    if group:
        assert after.labels == list(around) == ["mass_offset", group[0]]


def test_it_is_no_finding_where_a_name_is_lost_for_it_or_it_was_judged_already(monkeypatch):
    asked = Asked(monkeypatch, 1.5, 0.1)
    for lost in ("com_offset", "mass_offset"):
        asked.lost = {lost: "tz is predicted worse with it"}
        assert asked() == asked.unchanged
    asked.lost = {}
    assert asked(never={"com_offset"}) == asked.unchanged
    named = tuple(replace(f, verdict="Supported") if f.name == "com_offset" else f for f in asked.absent)
    assert asked(named)[0] == named
    # A centre of mass does not make torques smaller as a whole.
    assert asked(faint=lambda told: {"tx": 0.1}) != asked.unchanged
    monkeypatch.setattr(module, "_class", lambda told, label: SimpleNamespace(like_commands=True))
    assert asked(faint=lambda told: {"ty": 0.1}) != asked.unchanged
    assert asked(faint=lambda told: {"tx": 0.1}) == asked.unchanged


def test_a_name_that_is_told_already_is_in_no_second_group(monkeypatch):
    asked = Asked(monkeypatch, 1.5, 1.4)
    named = tuple(replace(f, verdict="Supported") if f.name == "linear_drag" else f for f in asked.absent)
    found, *_ = asked(named)
    assert [f.name for f in found if f.verdict == "Supported"] == ["com_offset", "linear_drag"]


def test_nothing_is_out_of_line_beside_healthy_flights():
    search, made = told([2.5, 0.0, 0.0, 0.0, 0.0])
    made.linear.observation.healthy = "flights"
    assert module.with_out_of_line(search, (), made, None, np.random.default_rng(0)) == ((), made, None)


def test_what_another_part_takes_off_is_none_of_a_share():
    """Names leave 0.1 of an error, the numbers of the file all of it, both 0.1; then both leave 0.3, alone or together;
    then names take nothing; then the numbers take half alone, and nine tenths beside the names."""
    alone, names, both = np.array([[1.0, 0.3, 0.1, 0.5], [0.1, 0.3, 1.0, 0.2], [0.1, 0.3, 0.1, 0.02]])
    np.testing.assert_allclose(share_taken(np.ones(4), alone, names, both), [0.0, 0.0, 0.9, 0.5])


def test_the_share_of_the_file_is_of_models_with_its_corrections_and_with_the_names_alone(monkeypatch):
    """An effect that the model had before is in all of them."""
    left = {frozenset("h"): 1.0, frozenset("hf"): 0.5, frozenset("hn"): 0.4, frozenset("hfn"): 0.1}
    statistics = {k: SimpleNamespace(rmse=np.full(6, v)) for k, v in left.items()}
    members = {x: SimpleNamespace(candidate=SimpleNamespace(label=x), held=x == "h") for x in "hfn"}
    model = SimpleNamespace(flights=(), model=lambda own: frozenset(m.candidate.label for m in own))
    monkeypatch.setattr(diagnosis.refusal, "errors", lambda made, *_: statistics[made])

    def share(labels):
        before, after = statistics[frozenset("h")], statistics[frozenset(labels)]
        added, search = [members[x] for x in labels], SimpleNamespace(observation=model)
        return diagnosis._by_file(search, ("f",), added, before, after, None, None)[0]

    assert share("hfn") == pytest.approx(1.0 - max(0.5, 0.1 / 0.4))
    assert (share("hf"), share("hn"), share("h")) == (0.5, 0.0, 0.0)

    def no_body(*_):
        raise InputError("no body")

    monkeypatch.setattr(diagnosis.refusal, "errors", no_body)
    assert np.isnan(share("hfn"))
