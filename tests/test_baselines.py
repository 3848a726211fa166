"""What users do today: each way on regressions with a known answer, and on a flight with a strong effect."""

import json
import shutil

import numpy as np
import pytest
from hidden_flights import OMAV, fly, truth

from infotraj.experiment import hidden_scoring, hidden_ways
from infotraj.experiment.baselines import Regression, lasso, methods, named_by_each, stepwise
from infotraj.experiment.hidden_diagnosing import name_batch


def made(strength, rows=1500, seed=0):
    rng = np.random.default_rng(seed)
    X = rng.standard_normal((rows, 12))
    X[:, 5] += 0.6 * X[:, 2]
    y = X @ np.where(np.isin(np.arange(12), (2, 7)), strength, 0.0) + rng.standard_normal(rows)
    return Regression(y, X, np.repeat(np.arange(3), rows // 3), tuple(f"effect {k}" for k in range(12)))


@pytest.mark.parametrize("way", [stepwise, lasso])
def test_a_way_keeps_the_columns_that_matter(way):
    kept = way(made(0.5))
    assert {2, 7} <= set(kept)
    assert len(kept) <= 4


@pytest.mark.parametrize("way", [stepwise, lasso])
def test_a_way_keeps_next_to_nothing_of_noise(way):
    assert len(way(made(0.0))) <= 1


def test_columns_that_copy_each_other_are_no_failure():
    data = made(0.5)
    twice = Regression(data.y, np.concatenate([data.X, data.X[:, 2:3]], axis=1), data.flight, (*data.names, "copy"))
    assert twice.effects(stepwise(twice)) & {"effect 2", "copy"}
    assert twice.effects(lasso(twice)) & {"effect 2", "copy"}


def test_every_way_finds_a_strong_effect(tmp_path):
    factor = (1.0,) * 5 + (0.7,) + (1.0,) * 6
    flights = fly(truth(rotors={"thrust_factor": factor}), flights=2, seconds=6.0)
    found = named_by_each(OMAV, flights)
    assert set(found) == set(methods())
    for named in found.values():
        assert "rotor_effectiveness 5" in named.effects
        assert 0.0 < named.seconds < 60.0
    shown = tmp_path / "flights/run_0"
    shown.mkdir(parents=True)
    shutil.copy("config/vehicles/omav.yaml", shown / "vehicle.yaml")
    for k, flight in enumerate(flights):
        flight.write(shown / f"flight_{k}.parquet")
    name_batch(flights=tmp_path / "flights", answers=tmp_path / "answers")
    read = json.loads((tmp_path / "answers/run_0/today.json").read_text())
    assert {way: frozenset(said["effects"]) for way, said in read.items()} == {w: n.effects for w, n in found.items()}


def test_flights_that_cannot_be_used_leave_the_ways_without_an_answer(tmp_path):
    (tmp_path / "flights/run_0").mkdir(parents=True)
    shutil.copy("config/vehicles/omav.yaml", tmp_path / "flights/run_0/vehicle.yaml")
    name_batch(flights=tmp_path / "flights", answers=tmp_path / "answers")
    assert json.loads((tmp_path / "answers/run_0/today.json").read_text()) == {}


EFFECTS = [
    {"name": "thrust_scale", "parameters": {"factor": 0.9}},
    {"name": "rotor_effectiveness", "parameters": {"rotor": 3, "factor": 0.8}},
]


@pytest.mark.parametrize(
    ("named", "found", "invented"),
    [
        (["rotor_effectiveness 3", "thrust_scale"], 2, []),
        (["rotor_effectiveness 4", "coaxial_loss"], 1, ["rotor_effectiveness 4"]),
        (["mass_offset", "thrust_scale"], 1, ["mass_offset"]),
        ([], 0, []),
    ],
)
def test_a_member_of_a_group_that_stands_counts_and_the_wrong_rotor_does_not(named, found, invented):
    members = {"thrust_scale as coaxial_loss": 1.01, "thrust_scale as mass_offset": 1.2}
    score = hidden_scoring._today(named, EFFECTS, members)
    assert (len(score["found"]), score["invented"]) == (found, invented)


def test_the_table_counts_found_and_invented_of_every_way(tmp_path):
    def run(kind, hidden, found, invented, way_found, way_invented):
        way = {"found": way_found, "invented": way_invented, "seconds": 2.0}
        return {
            "case": f"omav/{kind}/x", "kind": kind, "clutter": False, "hidden": hidden, "found": found,
            "invented": invented, "cpu": 8.0, "today": {"LASSO": way},
        }  # fmt: skip

    scores = [
        run("pair", ["drag", "mass"], ["drag", "mass"], [], ["drag", "mass"], ["load"]),
        run("single", ["drag"], ["drag"], [], [], []),
        run("nothing", [], [], [], [], ["drag", "mass"]),
        run("unlisted", ["slosh"], [], [], [], ["mass"]),
        {"kind": "single", "case": "omav/single/refused"},
        run("richer", ["slow servo"], [], [], [], []),
    ]
    (tmp_path / "scores.json").write_text(json.dumps(scores))
    ways = hidden_ways.ways_table([tmp_path / "scores.json"])
    assert len(ways) == 2 * 4
    ours, way = (line.split(" | ") for line in hidden_ways.said(ways).splitlines()[2:])
    assert [c[:6] for c in ours[1:5]] == ["2 of 2", "2 of 2", "0 of 1", "0 of 1"]
    assert [c[:6] for c in way[1:5]] == ["1 of 2", "0 of 2", "1 of 1", "1 of 1"]
    assert (ours[5], way[5]) == ("0.00", "1.00")
    assert (ours[6], way[6]) == ("8.0 s |", "2.0 s |")
