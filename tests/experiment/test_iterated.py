"""The study of the iterated loop: its plan, its usual flights, when a loop ends, how answers are scored, its page."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml

from infotraj.design.paths import Room
from infotraj.effects import effect_class
from infotraj.errors import UsageError
from infotraj.experiment.common.scores import read_scores
from infotraj.experiment.hidden.plants import file_of
from infotraj.experiment.iterated.cases import drawn, of, read_iterated, runs
from infotraj.experiment.iterated.doublets import axes_of, doublets
from infotraj.experiment.iterated.loop import ARMS, settled
from infotraj.experiment.iterated.scoring import judged, score_runs, scored
from infotraj.experiment.iterated.table import loops, ratio, summarise_iterated
from infotraj.vehicle import load_vehicle

STUDIES = Path(__file__).parents[2] / "config" / "studies"
STUDY, HIDDEN = read_iterated(STUDIES / "iterated.yaml")
VEHICLE = load_vehicle(STUDIES.parents[1] / HIDDEN.vehicles["quadrotor"].file)
ROOM = Room(np.array([2.0, 2.0, 1.0]), np.array([0.0, 0.0, 1.5]), 12.0, 2.5, 0.44, free=False)


@pytest.fixture(autouse=True)
def _at_the_root(monkeypatch):
    monkeypatch.chdir(STUDIES.parents[1])


def test_kinds_come_in_turn_and_no_effect_comes_twice_before_all_have_come():
    planned = runs(STUDY)
    assert [r.kind for r in planned[: len(STUDY.kinds)]] == list(STUDY.kinds)
    hidden = {r.name: drawn(STUDY, HIDDEN, r, VEHICLE) for r in planned}
    assert all(len(hidden[r.name]) == {"nothing": 0, "single": 1, "pair": 2}[r.kind] for r in planned)
    singles = [hidden[r.name][0][0] for r in planned if r.kind == "single"]
    there = {n for n, e in HIDDEN.vehicles["quadrotor"].effects.items() if e.alone and e.voltage is None}
    there -= set(STUDY.left_out)
    assert sorted(singles[: len(there)]) == sorted(there)
    assert drawn(STUDY, HIDDEN, planned[0], VEHICLE) == hidden[planned[0].name]


def test_what_is_hidden_lies_within_the_sizes_of_the_study():
    low, high = STUDY.sizes
    vary = HIDDEN.vary
    for run in runs(STUDY):
        for name, values in drawn(STUDY, HIDDEN, run, VEHICLE) if run.kind == "single" else ():
            usual, cls = HIDDEN.vehicles["quadrotor"].effects[name].parameters, effect_class(name)
            for p in cls.parameters:
                if p.name not in usual or p.index or p.name in ("delay", "dt"):
                    continue
                absent = cls.absent(VEHICLE, p)
                times = np.abs(values[p.name] - absent) / np.abs(np.asarray(usual[p.name], dtype=float) - absent)
                assert np.all((times > low * (1 - vary) - 1e-9) & (times < high * (1 + vary) + 1e-9)), name


@pytest.mark.parametrize(
    ("key", "value"), [("runs", {"blimp": 3}), ("flights", 1), ("kinds", ["triple"]), ("sizes", [2, 1])]
)
def test_a_study_that_cannot_be_used_is_refused_in_one_line(tmp_path, key, value):
    content = yaml.safe_load((STUDIES / "iterated.yaml").read_text())
    bad = tmp_path / "bad.yaml"
    bad.write_text(yaml.safe_dump({**content, "hidden": str(STUDIES / "hidden_effects.yaml"), key: value}))
    with pytest.raises(UsageError, match=r"bad\.yaml") as said:
        read_iterated(bad)
    assert "\n" not in str(said.value)


def test_doublets_move_one_axis_after_the_other_from_rest_to_rest():
    made = doublets(ROOM, np.random.default_rng(3))
    moving = np.abs(np.column_stack([made.velocity, made.rate[:, 2]])) > 1e-6
    moving[:, 3] &= ~moving[:, :2].any(axis=1)  # a vehicle that leans turns about its own z, too
    count = axes_of(ROOM)
    length = len(made.t) / count
    turns = [int(np.median(np.flatnonzero(moving[:, k])) // length) for k in range(count)]
    assert sorted(turns) == list(range(count))
    for k in range(3):
        assert np.all(np.flatnonzero(moving[:, k]) // length == turns[k])
        there = made.position[:, k] - ROOM.center[k]
        assert there.max() > 0.0 > there.min()
    assert not moving[[0, -1], :3].any()
    assert np.linalg.norm(made.velocity, axis=1).max() <= ROOM.speed + 1e-9


def test_the_order_and_the_sides_of_doublets_are_drawn_and_shares_scale_their_axis():
    a, b = (doublets(ROOM, np.random.default_rng(k)).position for k in (1, 2))
    assert np.abs(a - b).max() > 0.05
    less = doublets(ROOM, np.random.default_rng(1), np.array([1.0, 1.0, 0.0, 1.0])).position
    assert np.ptp(less[:, 2]) < 1e-9
    assert np.abs(less - a)[:, :2].max() < 1e-12


def said(*supported, open_=(), groups=None, numbers=None):
    """An answer with these names; groups, numbers: by name."""
    rows = [
        {
            "name": n,
            "verdict": "Supported",
            "group": (groups or {}).get(n, [n]),
            "parameters": (numbers or {}).get(n, {}),
        }
        for n in supported
    ]
    rows += [{"name": n, "verdict": "Plausible", "group": [n], "parameters": {}} for n in open_]
    return {"supported": sorted(supported), "open": sorted(open_), "effects": rows, "file": []}


DRAG = ("linear_drag", {"d": [0.2, 0.2, 0.1]})
ROTOR = ("rotor_effectiveness", {"rotor": 2, "factor": 0.85})


@pytest.mark.parametrize(
    ("answer", "hidden", "what"),
    [
        (said("linear_drag"), [DRAG], "right"),
        (said("linear_drag", open_=["wind"]), [DRAG], "right"),
        (said(open_=["linear_drag"]), [DRAG], "open"),
        (said("linear_drag", groups={"linear_drag": ["linear_drag", "rotor_drag"]}), [DRAG], "open"),
        (said("rotor_drag"), [DRAG], "wrong"),
        (said("linear_drag", "wind"), [DRAG], "wrong"),
        (said("linear_drag"), [DRAG, ROTOR], "open"),
        (said("rotor_effectiveness", numbers={"rotor_effectiveness": {"rotor": 2.0}}), [ROTOR], "right"),
        (said("rotor_effectiveness", numbers={"rotor_effectiveness": {"rotor": 1.0}}), [ROTOR], "wrong"),
        (said(), [], "right"),
        (said("wind"), [], "wrong"),
    ],
)
def test_an_answer_is_right_where_all_is_named_alone_and_nothing_else_is(answer, hidden, what):
    assert judged(answer, hidden, VEHICLE, VEHICLE) == what


def test_a_name_for_what_the_file_has_wrong_is_not_wrong():
    file = VEHICLE.model_copy(update={"mass": VEHICLE.mass - 0.05})
    told = said("linear_drag", "mass_offset", numbers={"mass_offset": {"dm": 0.05}})
    assert judged(told, [DRAG], file, VEHICLE) == "right"
    assert (
        judged(said("linear_drag", "mass_offset", numbers={"mass_offset": {"dm": 0.2}}), [DRAG], file, VEHICLE)
        == "wrong"
    )


def test_a_loop_ends_where_nothing_is_open_and_the_names_stay():
    assert settled(said("wind"), said("wind"))
    assert not settled(said(), said("wind"))
    assert not settled(said("wind"), said("wind", open_=["linear_drag"]))


def run_of(number, hidden, first, **steps):
    answers = {"failed": "", "first": first, **{arm: steps.get(arm, [first]) for arm in ARMS}}
    about = {"run": f"quadrotor {number}", "kind": "single", "hidden": [n for n, _ in hidden]}
    return about | scored(answers, hidden, VEHICLE, VEHICLE)


RIGHT, WRONG, NONE = said("linear_drag"), said("rotor_drag"), said()


def test_needed_flights_count_from_when_the_answer_stays_right():
    one = run_of(
        0, [DRAG], NONE, designed=[RIGHT, RIGHT], random=[RIGHT, WRONG, RIGHT], doublets=[NONE] * 4, task=[WRONG]
    )
    two = run_of(1, [], NONE)
    made = loops([one, two], 4).set_index(["run", "arm"])
    assert [made.loc[("quadrotor 0", arm), "needed"] for arm in ARMS] == [1, 3, 5, 5]
    assert [made.loc[("quadrotor 0", arm), "ends"] for arm in ARMS] == [True, False, True, False]
    assert [made.loc[("quadrotor 0", arm), "wrong_on_the_way"] for arm in ARMS] == [False, True, False, True]
    assert [made.loc[("quadrotor 1", arm), "needed"] for arm in ARMS] == [0] * 4
    assert ratio(made.reset_index(), "random")[0] == pytest.approx(1 / 3)


def test_the_page_says_how_every_run_ended_and_which_failed(tmp_path):
    one = run_of(0, [DRAG], NONE, designed=[RIGHT, RIGHT], random=[WRONG])
    failed = {"run": "quadrotor 1", "kind": "nothing", "hidden": [], "failed": "no motion"}
    scores = tmp_path / "scores.jsonl"
    scores.write_text("".join(json.dumps(s) + "\n" for s in (one, failed)))
    summarise_iterated(scores, STUDY, tmp_path / "table.csv", tmp_path / "page.md")
    page = (tmp_path / "page.md").read_text()
    assert f"2 of {sum(STUDY.runs.values())} planned runs were made" in page
    assert "- quadrotor 1 (nothing): no motion" in page
    assert "| right: linear_drag, 2 | **rotor_drag**, 1 |" in page
    assert len((tmp_path / "table.csv").read_text().splitlines()) == 1 + len(ARMS)


@pytest.mark.long
def test_a_run_is_flown_answered_and_not_made_twice(tmp_path):
    short = STUDY.model_copy(update={"candidates": 3, "flights": 2, "base_seed": 80})
    hidden = HIDDEN.model_copy(update={"base_seed": 80})
    run = next(r for r in runs(short) if [n for n, _ in drawn(short, hidden, r, VEHICLE)] == ["mass_offset"])
    scores = tmp_path / "scores.jsonl"
    for _ in range(2):
        score_runs(short, hidden, [run], scores)
    (score,) = read_scores(scores)
    assert score["failed"] == ""
    assert score["hidden"] == ["mass_offset"]
    assert all(1 <= len(score[arm]) <= 2 for arm in ARMS)
    assert file_of(VEHICLE, short.files, partial(of, short, run)).mass != VEHICLE.mass
    # A motion that speeds up and slows down tells a mass from a thrust; the hover of the task does not.
    assert score["first"]["supported"] == []
    assert score["designed"][-1]["what"] == "right"
    assert score["designed"][-1]["supported"] == ["mass_offset"]
