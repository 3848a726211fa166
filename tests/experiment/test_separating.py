"""The study of separating flights: its plan, the plant and the shown file, how answers are scored, and its page."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from infotraj.diagnosis.diagnosis import diagnose
from infotraj.errors import UsageError
from infotraj.experiment.common.scores import read_scores
from infotraj.experiment.separating.cases import Run, drawn, read_separating, runs
from infotraj.experiment.separating.flying import plant, shown_file, task
from infotraj.experiment.separating.loop import AGAIN, ARMS, told
from infotraj.experiment.separating.scoring import judged, score_runs, scored
from infotraj.experiment.separating.table import OPEN, calibration, flights, needed, summarise_separating
from infotraj.flight import Flight
from infotraj.models import Model
from infotraj.vehicle import load_vehicle

STUDIES = Path(__file__).parents[2] / "config" / "studies"
STUDY, HIDDEN = read_separating(STUDIES / "separating_wide.yaml")
PAIR = ("linear_drag", "rotor_drag")


@pytest.fixture(autouse=True)
def _at_the_root(monkeypatch):
    monkeypatch.chdir(STUDIES.parents[1])


def test_every_pair_hides_both_of_its_effects_in_turn_within_the_sizes_of_the_study():
    planned = runs(STUDY)
    assert len(planned) == STUDY.runs * len(STUDY.pairs)
    for pair in range(len(STUDY.pairs)):
        own = [r for r in planned if r.pair == pair]
        assert [r.hides for r in own[:4]] == [0, 1, 0, 1]
        vehicle = load_vehicle(HIDDEN.vehicles[STUDY.pairs[pair].vehicle].file)
        sizes = [drawn(STUDY, HIDDEN, r, vehicle)[2] for r in own]
        assert STUDY.sizes[0] <= min(sizes) < max(sizes) <= STUDY.sizes[1]
        assert {drawn(STUDY, HIDDEN, r, vehicle)[0] for r in own} == set(STUDY.pairs[pair].effects)


def test_the_narrow_room_differs_from_the_wide_one_in_its_room_and_seeds_alone():
    narrow, _ = read_separating(STUDIES / "separating_narrow.yaml")
    assert narrow.model_copy(update={"room": STUDY.room, "base_seed": STUDY.base_seed}) == STUDY
    assert max(narrow.room.box) < min(STUDY.room.box)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("pairs", [{"vehicle": "blimp", "effects": PAIR}]),
        ("pairs", [{"vehicle": "quadrotor", "effects": ("linear_drag", "linear_drag")}]),
        ("files", ["7%"]),
        ("sizes", [2, 1]),
    ],
)
def test_a_study_that_cannot_be_used_is_refused_in_one_line(tmp_path, key, value):
    content = yaml.safe_load((STUDIES / "separating_wide.yaml").read_text())
    bad = tmp_path / "bad.yaml"
    value = json.loads(json.dumps(value))
    bad.write_text(yaml.safe_dump({**content, "hidden": str(STUDIES / "hidden_effects.yaml"), key: value}))
    with pytest.raises(UsageError, match=r"bad\.yaml") as said:
        read_separating(bad)
    assert "\n" not in str(said.value)


def test_the_plant_hides_what_was_drawn_and_the_file_is_wrong():
    """A weak rotor has to turn faster, in its own run and not in another one's."""
    pair = next(k for k, p in enumerate(STUDY.pairs) if p.effects[0] == "rotor_effectiveness")
    weak = Run(pair, 0)
    vehicle = load_vehicle(HIDDEN.vehicles["quadrotor"].file)
    name, values, _ = drawn(STUDY, HIDDEN, weak, vehicle)
    assert name == "rotor_effectiveness"
    flight = plant(STUDY, HIDDEN, weak)(task(STUDY, weak)[0], "task 0")
    assert not flight.has("cmd_wrench_fz")
    speeds = flight.numbered("cmd_rotor_").mean(axis=0)
    assert int(np.argmax(speeds)) == values["rotor"]
    shown = shown_file(STUDY, HIDDEN, weak)
    assert shown.mass != vehicle.mass
    assert shown == shown_file(STUDY, HIDDEN, weak)
    assert Model(shown).vehicle == shown


def effects(**verdicts):
    return {n: {"verdict": v, "group": g or [n], "parameters": {}} for n, (v, g) in verdicts.items()}


def step(odds=0.0, predicted=0.5, **verdicts):
    return {"effects": effects(**verdicts), "odds": odds, "predicted": predicted, "again": 0.1, "warning": ""}


GROUP = ("Not separable", list(PAIR))


@pytest.mark.parametrize(
    ("verdicts", "what"),
    [
        ({"linear_drag": ("Supported", None)}, "right"),
        ({"rotor_drag": ("Supported", None)}, "wrong"),
        ({"linear_drag": ("Supported", None), "rotor_drag": ("Supported", None)}, "undecided"),
        ({"linear_drag": GROUP, "rotor_drag": GROUP}, "group"),
        ({"linear_drag": ("Plausible", None), "wind": ("Supported", None)}, "undecided"),
        ({}, "undecided"),
    ],
)
def test_one_of_the_two_is_told_where_it_alone_is_supported(verdicts, what):
    said = step(**verdicts)
    assert judged(said, PAIR, 0) == what
    turned = {"right": "wrong", "wrong": "right"}.get(what, what)
    assert judged(said, PAIR, 1) == turned
    assert (told(said, PAIR) is None) == (what in ("undecided", "group"))


def answered(designed, random, again):
    said = {"pair": list(PAIR), "failed": "", "task": step(), "designed": designed, "random": random, AGAIN: again}
    return {"number": 0, "pair": "quadrotor: a or b", "hidden": "rotor_drag", "size": 1.0, **scored(said, 1)}


RIGHT, WRONG = {"rotor_drag": ("Supported", None)}, {"linear_drag": ("Supported", None)}


def test_flights_needed_and_calibration_are_counted_from_the_scores():
    a = answered([step(-9.0, 0.97, **RIGHT)], [step(1.0, 0.1), step(-5.0, 0.6, **RIGHT)], [step(0.0, 0.3)])
    b = answered([step(4.0, 0.99, **WRONG)], [step(0.0, 0.1), step(0.0, 0.0), step(0.0, 0.3)], [step(-3.5, 0.3)])
    made = flights([a, {**b, "number": 1}])
    counted = needed(made, 3)
    assert counted["designed"].tolist() == [1, 4]
    assert counted["random"].tolist() == [2, 4]
    own = calibration(made, "designed")
    assert own["flights"].tolist() == [0, 0, 0, 0, 2]
    assert (own["passed"].iloc[-1], own["right"].iloc[-1]) == (1, 1)
    assert own["predicted"].iloc[-1] == pytest.approx(0.98)
    assert calibration(made, AGAIN)["passed"].tolist() == [0, 1, 0, 0, 0]
    assert sum(calibration(made, arm)["flights"].sum() for arm in (*ARMS, AGAIN)) == len(made) == 9


def test_the_page_counts_failed_runs_and_what_was_told(tmp_path):
    one = answered([step(-9.0, 0.97, **RIGHT)], [step(0.0, 0.1)] * 3, [step(0.0, 0.3)])
    failed = {"pair": "quadrotor: a or b", "number": 1, "failed": "no motion"}
    scores = tmp_path / "scores.jsonl"
    scores.write_text("".join(json.dumps(s) + "\n" for s in (one, failed)))
    summarise_separating(scores, STUDY, tmp_path / "table.csv", tmp_path / "page.md")
    said = (tmp_path / "page.md").read_text()
    assert "2 of 140 planned runs" in said
    assert "1 could not be flown" in said
    assert "1 of 1: 100 % (2 to 100)" in said
    assert "| 1.00 | 4.00 | 0.25" in said
    assert len((tmp_path / "table.csv").read_text().splitlines()) == 1 + 1 + 3 + 1


@pytest.mark.long
def test_a_run_is_flown_answered_and_not_made_twice(tmp_path):
    short = STUDY.model_copy(update={"candidates": 3, "designed": 1, "random": 1, "base_seed": 69})
    scores = tmp_path / "scores.jsonl"
    for _ in range(2):
        score_runs(short, HIDDEN.model_copy(update={"base_seed": 69}), [Run(0, 0)], scores)
    (score,) = read_scores(scores)
    assert score["failed"] == ""
    assert score["hidden"] == STUDY.pairs[0].effects[0]
    assert all(0.0 <= s["predicted"] <= 1.0 for arm in (*ARMS, AGAIN) for s in score[arm])
    # A heavier vehicle and less thrust are alike in hover. Which further flight tells is the study's result, no test's.
    assert score["task"]["what"] in OPEN
    assert [len(score[arm]) for arm in (*ARMS, AGAIN)] == [1, 1, 1]
    assert {s["what"] for arm in (*ARMS, AGAIN) for s in score[arm]} <= {"right", "wrong", *OPEN}


@pytest.mark.long
def test_the_answer_on_a_flight_near_hover_does_not_hang_on_the_last_digit():
    """Exact sensors beside a wrong file: a search whose steps need not pay makes 1e-12 as large as an effect."""
    study, hidden = (x.model_copy(update={"base_seed": 69}) for x in (STUDY, HIDDEN))
    run = Run(2, 0)
    fly = plant(study, hidden, run)
    model = Model(shown_file(study, hidden, run))
    flown = [fly(reference, f"task {k}") for k, reference in enumerate(task(study, run))]
    rng = np.random.default_rng(1)
    found = []
    for share in (0.0, 1e-12):
        tables = [f.table.copy() for f in flown]
        for table in tables:
            numbers = [c for c in table.columns if c != "t" and table[c].dtype == float]
            table[numbers] *= 1.0 + share * rng.standard_normal((len(table), len(numbers)))
        found.append(diagnose(model, [Flight(t, f.meta) for t, f in zip(tables, flown, strict=True)]))
    one, two = found
    assert [(f.name, f.verdict, f.group) for f in one.findings] == [(f.name, f.verdict, f.group) for f in two.findings]
    assert one.whole.labels == two.whole.labels
    assert one.whole.solution.score == pytest.approx(two.whole.solution.score, abs=0.1)
