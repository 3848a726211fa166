"""What users do today: each way on regressions with a known answer, and on a flight with a strong effect."""

import json
import shutil

import numpy as np
import pytest
from hidden_flights import OMAV, fly, truth

from infotraj.experiment.hidden.baselines import (
    METHODS,
    Regression,
    lasso,
    methods,
    named_by_each,
    regression,
    sparse,
    stepwise,
)
from infotraj.experiment.hidden.today import name_batch
from infotraj.experiment.hidden.ways import said, score_ways, ways_table


def made(strength, rows=1500, seed=0):
    rng = np.random.default_rng(seed)
    X = rng.standard_normal((rows, 12))
    X[:, 5] += 0.6 * X[:, 2]
    y = X @ np.where(np.isin(np.arange(12), (2, 7)), strength, 0.0) + rng.standard_normal(rows)
    return Regression(y, X, np.repeat(np.arange(3), rows // 3), tuple(f"effect {k}" for k in range(12)))


def present(way):
    if way is sparse:
        pytest.importorskip("pysindy", reason="PySINDy is installed for the benchmark alone")


@pytest.mark.parametrize("way", METHODS.values())
def test_a_way_keeps_the_columns_that_matter(way):
    present(way)
    kept = way(made(0.5))
    assert {2, 7} <= set(kept)
    assert len(kept) <= 4


@pytest.mark.parametrize("way", METHODS.values())
def test_a_way_keeps_next_to_nothing_of_noise(way):
    present(way)
    assert len(way(made(0.0))) <= 1


def test_columns_that_copy_each_other_are_no_failure():
    data = made(0.5)
    twice = Regression(data.y, np.concatenate([data.X, data.X[:, 2:3]], axis=1), data.flight, (*data.names, "copy"))
    assert twice.effects(stepwise(twice)) & {"effect 2", "copy"}
    assert twice.effects(lasso(twice)) & {"effect 2", "copy"}


@pytest.mark.long
def test_every_way_finds_a_strong_effect(tmp_path):
    factor = (1.0,) * 5 + (0.7,) + (1.0,) * 6
    flights = fly(truth(rotors={"thrust_factor": factor}), flights=2, seconds=6.0)
    found = named_by_each(OMAV, flights)
    assert {"stepwise regression, BIC", "LASSO"} <= set(found)
    for named in found.values():
        assert "rotor_effectiveness 5" in named.effects
        assert 0.0 < named.seconds < 60.0
    shown = tmp_path / "flights/run_0"
    shown.mkdir(parents=True)
    shutil.copy("config/vehicles/omav.yaml", shown / "vehicle.yaml")
    for k, flight in enumerate(flights):
        flight.write(shown / f"flight_{k}.parquet")
    name_batch(flights=tmp_path / "flights", named=tmp_path / "named")
    read = json.loads((tmp_path / "named/run_0.json").read_text())
    assert {way: frozenset(named["effects"]) for way, named in read.items()} == {w: n.effects for w, n in found.items()}


def test_a_run_that_was_not_flown_leaves_every_way_without_a_name(tmp_path):
    (tmp_path / "flights/run_0").mkdir(parents=True)
    shutil.copy("config/vehicles/omav.yaml", tmp_path / "flights/run_0/vehicle.yaml")
    name_batch(flights=tmp_path / "flights", named=tmp_path / "named")
    read = json.loads((tmp_path / "named/run_0.json").read_text())
    assert [named["effects"] for named in read.values()] == [[]] * len(methods())


def test_an_effect_brings_the_columns_of_all_its_linearisations():
    data = regression(OMAV, fly(truth(), flights=1, seconds=4.0))
    # a cable is linearised at several lengths, with two columns each
    assert data.names.count("suspended_load") > 2


EFFECTS = [
    {"name": "thrust_scale", "parameters": {"factor": 0.9}},
    {"name": "rotor_effectiveness", "parameters": {"rotor": 3, "factor": 0.8}},
]


STOOD = {"thrust_scale": ["thrust_scale", "coaxial_loss"], "rotor_effectiveness": ["rotor_effectiveness"]}


@pytest.mark.parametrize(
    ("named", "found", "invented"),
    [
        (["rotor_effectiveness 3", "thrust_scale"], 2, []),
        (["rotor_effectiveness 4", "coaxial_loss"], 1, ["rotor_effectiveness 4"]),
        (["coaxial_loss", "thrust_scale"], 1, ["coaxial_loss"]),
        (["mass_offset", "thrust_scale"], 1, ["mass_offset"]),
        ([], 0, []),
    ],
)
def test_one_member_of_a_group_that_stood_counts_and_the_wrong_rotor_does_not(named, found, invented):
    judged = score_ways({"LASSO": {"effects": named, "seconds": 2.0}}, EFFECTS, STOOD)["LASSO"]
    assert (len(judged["found"]), judged["invented"], judged["seconds"]) == (found, invented, 2.0)


def test_both_effects_count_where_one_stands_for_the_other_too():
    effects = [{"name": "battery_sag", "parameters": {}}, {"name": "mass_offset", "parameters": {}}]
    stood = {"battery_sag": ["battery_sag", "mass_offset"]}
    way = {"LASSO": {"effects": ["mass_offset", "battery_sag"], "seconds": 2.0}}
    assert score_ways(way, effects, stood)["LASSO"] == {
        "found": ["battery_sag", "mass_offset"], "invented": [], "seconds": 2.0,
    }  # fmt: skip


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
        {"kind": "single", "case": "omav/single/x", "failed": "could not be flown"},
        run("richer", ["slow servo"], [], [], [], []),
    ]
    (tmp_path / "scores.json").write_text(json.dumps(scores))
    ways = ways_table([tmp_path / "scores.json"])
    assert len(ways) == 2 * 4
    ours, way = (line.split(" | ") for line in said(ways).splitlines()[2:])
    assert [c[:6] for c in ours[1:5]] == ["2 of 2", "2 of 2", "0 of 1", "0 of 1"]
    assert [c[:6] for c in way[1:5]] == ["1 of 2", "0 of 2", "1 of 1", "1 of 1"]
    assert (ours[5], way[5]) == ("0.00", "1.00")
    assert (ours[6], way[6]) == ("8.0 s |", "2.0 s |")
