"""The hidden-effect study: its cases, what the diagnosis gets to see, how answers are scored and counted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from infotraj.comparing.equation_error import equation_error
from infotraj.errors import UsageError
from infotraj.evaluation.proportions import proportion
from infotraj.experiment.common.config import HiddenEffects, read
from infotraj.experiment.hidden import scoring as hidden_scoring
from infotraj.experiment.hidden import tables as hidden_tables
from infotraj.experiment.hidden.cases import Batch, Case, batches, hidden_values
from infotraj.experiment.hidden.config import load_study, read_study
from infotraj.experiment.hidden.diagnosing import diagnose_batch
from infotraj.experiment.hidden.flying import fly_batch
from infotraj.experiment.hidden.logs import logged
from infotraj.experiment.hidden.scoring import score_batch
from infotraj.experiment.hidden.summary import report, summarise
from infotraj.experiment.hidden.ways import ways_table
from infotraj.flight import Flight, read_flight
from infotraj.models import load_model
from infotraj.plots.hidden_effects import figure_curves
from infotraj.vehicle import load_vehicle

STUDY = read_study("config/studies/hidden_effects.yaml")


def test_every_case_of_the_plan_has_its_own_name_and_its_effects_can_be_drawn():
    planned = batches(STUDY)
    assert len({b.key for b in planned}) == len(planned)
    cases = {b.case for b in planned}
    assert len({c.name for c in cases}) == len(cases)
    vehicles = {name: load_vehicle(v.file) for name, v in STUDY.vehicles.items()}
    for case in cases:
        named, other = hidden_values(case, 3, STUDY, vehicles[case.vehicle])
        assert len(named) + len(other) == len(case.effects) + len(case.other)


def test_the_plan_is_as_large_as_was_asked_for():
    count = {}
    for b in batches(STUDY):
        count[b.case.kind, b.case.vehicle] = count.get((b.case.kind, b.case.vehicle), 0) + len(b.seeds)
    assert count["nothing", "omav"] >= 150
    assert count["nothing", "quadrotor"] >= 150
    for vehicle in (v for v in STUDY.vehicles.values() if v.effects):
        assert len(set(vehicle.pairs)) == 17
        assert len(set(vehicle.triples)) == 8
    runs = STUDY.runs
    assert min(runs.single, runs.other_size, runs.several + runs.several_clutter, runs.richer, runs.unlisted) >= 10


def test_what_acts_beside_another_only_is_hidden_beside_it_only():
    from infotraj.effects import effect_class

    found = {c.effects for c in (b.case for b in batches(STUDY)) if c.vehicle == "omav"}
    for name in ("wind", "pressure_centre"):
        with_it = [[n for n, _ in effects] for effects in found if name in dict(effects)]
        assert with_it
        assert all(set(effect_class(name).beside) & set(names) for names in with_it)


def test_sizes_multiply_the_change_and_seeds_vary_it():
    vehicle = load_vehicle("config/vehicles/omav.yaml")

    def drawn(name, multiple, seed):
        case = Case("omav", "single", ((name, multiple),))
        return hidden_values(case, seed, STUDY, vehicle)[0][0][1]

    assert drawn("thrust_scale", 2.0, 0)["factor"] == pytest.approx(0.84, abs=0.025)
    assert drawn("servo_rate_limit", 1.0, 0)["max_rate"] == pytest.approx(3.0, abs=0.76)
    assert drawn("suspended_load", 0.25, 0)["length"] == 0.6
    assert drawn("linear_drag", 1.0, 0) == drawn("linear_drag", 1.0, 0) != drawn("linear_drag", 1.0, 1)
    signs = np.sign([drawn("com_offset", 1.0, k)["r"] for k in range(20)])
    assert (np.abs(signs.sum(axis=0)) < 20).all()
    assert len({drawn("rotor_effectiveness", 1.0, k)["rotor"] for k in range(20)}) > 4


def test_a_study_file_may_extend_another():
    short = read_study("config/studies/hidden_effects_short.yaml")
    assert short.vehicles == STUDY.vehicles
    assert short.curves == STUDY.curves
    assert short.base_seed != STUDY.base_seed
    assert (short.runs.single, short.runs.nothing) == (1, 75)


def test_patterns_and_a_limit_choose_runs():
    few = batches(STUDY, ("omav/single/com_offset-usual", "*/nothing/nothing"), 1)
    assert [b.case.name for b in few] == [
        "omav/nothing/nothing", "omav/single/com_offset-usual", "quadrotor/nothing/nothing",
    ]  # fmt: skip
    assert all(b.seeds == (0,) for b in few)


@pytest.mark.parametrize(
    "only", [("omav/single/com_ofset-usual",), ("*/nothing/nothing", "omav/single/com_ofset-usual")]
)
def test_a_pattern_that_matches_no_case_is_refused_in_one_line(only):
    says = r"no case matches omav/single/com_ofset-usual; expected .*omav/single/com_offset-usual.*Correct `only`"
    with pytest.raises(UsageError, match=says) as caught:
        batches(STUDY, only)
    assert "\n" not in str(caught.value)


def test_the_quick_configuration_names_cases_that_exist():
    quick = read("config/quick.yaml").hidden_effects
    assert len(batches(STUDY, quick.only, quick.seeds)) == len(quick.only) == 5


def test_a_wrong_key_is_refused_in_one_line():
    with pytest.raises(UsageError, match=r"runs\.singel: unknown key") as caught:
        load_study({"vehicles": {}, "runs": {"singel": 3}}, "study")
    assert "\n" not in str(caught.value)


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> Path:
    top = tmp_path_factory.mktemp("flown")
    flights = {
        "train": ("low",), "held_out": ("low",), "seconds": 3.0, "low": 0.15, "tilt": 0,
    }  # fmt: skip
    vehicle = STUDY.vehicles["quadrotor"].model_copy(
        update={"flights": STUDY.vehicles["quadrotor"].flights.model_copy(update=flights)}
    )
    study = STUDY.model_copy(update={"vehicles": {"quadrotor": vehicle}})
    case = Case("quadrotor", "single", (("linear_drag", 1.0),), clutter=True, size="usual")
    fly_batch(study, Batch(case, (0, 1)), flights=top / "flights", truth=top / "truth")
    return top


def test_what_is_given_to_the_diagnosis_tells_nothing(flown):
    shown = sorted(p.relative_to(flown).as_posix() for p in (flown / "flights").rglob("*") if p.is_file())
    assert shown == [f"flights/run_{k}/{f}" for k in (0, 1) for f in ("flight_0.parquet", "vehicle.yaml")]
    assert yaml.safe_load((flown / "flights/run_0/vehicle.yaml").read_text()) == yaml.safe_load(
        Path("config/vehicles/quadrotor.yaml").read_text()
    )
    flight = read_flight(flown / "flights/run_0/flight_0.parquet")
    assert set(flight.meta) == {"vehicle", "imu_rate", "mocap_rate", "source"}
    assert not [c for c in flight.table if c.startswith(("est_", "ref_", "true"))]
    assert (flown / "truth/run_0/truth.yaml").is_file()
    truth = yaml.safe_load((flown / "truth/run_0/run.yaml").read_text())
    assert truth["effects"][0]["name"] == "linear_drag"


def test_the_scorers_floor_flights_hide_nothing_and_its_held_out_ones_do(flown):
    """By the right file: the floor flights are at the sensors' noise, those with the hidden effect are not."""
    model = load_model(flown / "truth/run_0/vehicle.yaml")

    def excess(name):
        error = equation_error(model, read_flight(flown / f"truth/run_0/{name}_0.parquet"))
        return max(
            np.sqrt(np.mean(error.residual[rows, k] ** 2)) / error.floor[k] for k, rows in enumerate(error.scored.T)
        )

    assert excess("floor") < 1.5
    assert excess("held_out") > 3.0


def test_seeds_fly_other_paths_with_other_values(flown):
    first, second = (read_flight(flown / f"flights/run_{k}/flight_0.parquet") for k in (0, 1))
    assert not np.allclose(first.get("cmd_rotor_0"), second.get("cmd_rotor_0"))
    values = [
        yaml.safe_load((flown / f"truth/run_{k}/run.yaml").read_text())["effects"][0]["parameters"] for k in (0, 1)
    ]
    assert values[0] != values[1]


def test_a_voltage_in_the_log_does_not_tell_that_a_battery_is_hidden(tmp_path):
    train = STUDY.vehicles["quadrotor"].flights.model_copy(
        update={"train": ("low",), "held_out": (), "seconds": 3.0, "low": 0.15, "tilt": 0}
    )
    vehicle = STUDY.vehicles["quadrotor"].model_copy(update={"flights": train})
    study = STUDY.model_copy(update={"vehicles": {"quadrotor": vehicle}})
    case = next(b.case for b in batches(STUDY, ("quadrotor/nothing/nothing.voltage",)))
    fly_batch(study, Batch(case, (0,)), flights=tmp_path / "flights", truth=tmp_path / "truth")
    flight = read_flight(tmp_path / "flights/run_0/flight_0.parquet")
    assert np.ptp(flight.get("battery")) > 0.1
    assert yaml.safe_load((tmp_path / "flights/run_0/vehicle.yaml").read_text())["nominal_voltage"] == 14.8
    assert yaml.safe_load((tmp_path / "truth/run_0/run.yaml").read_text())["effects"] == []


def test_a_run_that_could_not_be_flown_does_not_stop_the_batch(tmp_path):
    (tmp_path / "flights/run_0").mkdir(parents=True)
    diagnose_batch(flights=tmp_path / "flights", answers=tmp_path / "answers")
    kept = tmp_path / "truth/run_0"
    kept.mkdir(parents=True)
    about = {
        "case": {"vehicle": "quadrotor", "kind": "single", "size": "usual", "clutter": False, "curve": ""},
        "name": "quadrotor/single/x", "seed": 0, "effects": [], "other": [], "nearest": [], "failed": "left the room",
    }  # fmt: skip
    (kept / "run.yaml").write_text(yaml.safe_dump(about))
    parts = {n: tmp_path / n for n in ("flights", "answers", "named", "truth")}
    score_batch(**parts, scores=tmp_path / "scores.json")
    (only,) = json.loads((tmp_path / "scores.json").read_text())
    assert (only["answered"], only["failed"]) == (False, "left the room")


def test_a_refused_run_counts_as_nothing_found_and_the_ways_are_scored(tmp_path, flown):
    answers, named = tmp_path / "answers", tmp_path / "named"
    named.mkdir()
    for k in (0, 1):
        (answers / f"run_{k}").mkdir(parents=True)
        spent = {"wall": 1.0, "cpu": 1.0, "status": 3, "error": "refused"}
        (answers / f"run_{k}" / "time.json").write_text(json.dumps(spent))
        (named / f"run_{k}.json").write_text(json.dumps({"LASSO": {"effects": ["linear_drag"], "seconds": 2.0}}))
    score_batch(flights=flown / "flights", answers=answers, named=named, truth=flown / "truth", scores=tmp_path / "s")
    ways = ways_table([tmp_path / "s"]).groupby("way")[["hidden", "found"]].sum()
    assert ways.loc["infotraj diagnose"].tolist() == [2, 0]
    assert ways.loc["LASSO"].tolist() == [2, 2]


def test_poorer_logs_hold_less():
    n = 40
    table = pd.DataFrame({c: np.arange(n, dtype=float) for c in ("px", "wx", "ax", "cmd_tilt_0", "est_px")})
    table.insert(0, "t", 0.005 * np.arange(n))
    for axis in ("wy", "wz", "ay", "az"):
        table[axis] = 0.0
    flight = Flight(table, {"vehicle": "v", "robot": "mujoco secret"})
    assert "robot" not in logged(flight, "full").meta
    assert list(logged(flight, "mocap").table) == ["t", "px", "cmd_tilt_0"]
    assert len(logged(flight, "mocap").table) == n // 2
    assert "cmd_tilt_0" not in logged(flight, "no_tilts").table
    assert np.diff(logged(flight, "50hz").t) == pytest.approx(0.02)


EFFECTS = [
    {"name": "mass_offset", "parameters": {"dm": 0.2}},
    {"name": "rotor_effectiveness", "parameters": {"rotor": 3, "factor": 0.8}},
]
ROWS = {
    "mass_offset": {"parameters": {"dm": 0.21}, "group": ["mass_offset", "thrust_scale"]},
    "rotor_effectiveness": {"parameters": {"rotor": 3, "factor": 0.81}, "group": ["rotor_effectiveness"]},
    "thrust_scale": {"parameters": {"factor": 0.95}},
}


@pytest.mark.parametrize(
    ("groups", "reached", "found", "invented", "right"),
    [
        ([["mass_offset"], ["rotor_effectiveness"]], 1.0, 2, 0, True),
        ([["mass_offset"]], 1.0, 1, 0, False),
        ([["mass_offset"], ["rotor_effectiveness"], ["linear_drag"]], 1.0, 2, 1, False),
        ([["thrust_scale"], ["rotor_effectiveness"]], 1.0, 1, 1, False),
        ([["mass_offset", "thrust_scale"], ["rotor_effectiveness"]], 1.04, 2, 0, True),
        ([["mass_offset", "thrust_scale"], ["rotor_effectiveness"]], 1.06, 1, 0, False),
        ([["mass_offset", "a", "b", "c", "thrust_scale"], ["rotor_effectiveness"]], 1.0, 1, 0, False),
        ([], 1.0, 0, 0, False),
    ],
)
def test_right_is_all_named_in_groups_that_do_as_well_and_nothing_else(
    monkeypatch, groups, reached, found, invented, right
):
    class Held:
        def error(self, model):
            return reached

    monkeypatch.setattr(hidden_scoring, "_fitted", lambda base, names, training: names)
    score = hidden_scoring._names(EFFECTS, groups, ROWS, None, [], Held(), 1.0, 0.05)
    assert (len(score["found"]), len(score["invented"]), score["right"]) == (found, invented, right)


def test_a_second_rotor_beside_the_right_one_is_invented():
    weak = {"parameters": {"rotor": 3, "factor": 0.8}, "instances": [{"rotor": 3}, {"rotor": 7}]}
    rows = {**ROWS, "rotor_effectiveness": weak}
    score = hidden_scoring._names(EFFECTS[1:], [["rotor_effectiveness"]], rows, None, [], None, 1.0, 0.05)
    assert score["found"] == ["rotor_effectiveness"]
    assert len(score["invented"]) == 1
    assert not score["right"]


def test_the_wrong_rotor_is_not_right():
    rows = {**ROWS, "rotor_effectiveness": {"parameters": {"rotor": 4, "factor": 0.8}}}
    score = hidden_scoring._names(EFFECTS[1:], [["rotor_effectiveness"]], rows, None, [], None, 1.0, 0.05)
    assert not score["right"]
    assert score["invented"] == ["rotor_effectiveness"]


@pytest.mark.parametrize(
    ("kind", "groups", "unexplained", "right"),
    [
        ("unlisted", [], True, True),
        ("unlisted", [], False, False),
        ("unlisted", [["steady_force"]], True, False),
        ("cannot_show", [], False, True),
        ("cannot_show", [["gyroscopic"]], False, False),
        ("richer", [["servo_lag", "actuation_delay"]], True, True),
        ("richer", [["servo_lag"], ["mass_offset"]], False, False),
        ("richer", [], True, False),
    ],
)
def test_what_has_no_name_of_its_own_is_judged_by_what_is_said_about_it(kind, groups, unexplained, right):
    invented = [g[0] for g in groups]
    said = {"beyond": groups, "invented": invented, "unexplained": unexplained, "nearest": ["servo_lag"]}
    assert hidden_scoring._right_beyond(kind, said) == right


def score(case: str, **more) -> dict:
    vehicle, kind, _ = case.split("/")
    return {
        "case": case, "vehicle": vehicle, "kind": kind, "size": "", "clutter": False, "curve": "", "seed": 0,
        "hidden": [], "nearest": [], "failed": "", "status": 0, "refusal": "", "wall": 1.0, "cpu": 1.0,
        "answered": True, "unexplained": False, "supported": [], "groups": [], "found": [], "invented": [],
        "right": True, "error_nominal": 1.0, "error_oracle": 1.0, "error_answer": 1.0, "parameters": [], **more,
    }  # fmt: skip


def test_the_summary_counts_what_was_and_what_was_not_run(tmp_path):
    drag = {
        "size": "usual", "hidden": ["linear_drag"], "supported": ["linear_drag"], "groups": [["linear_drag"]],
        "found": ["linear_drag"], "error_nominal": 3.0, "error_answer": 1.02,
    }  # fmt: skip
    numbers = [
        {"effect": "linear_drag", "parameter": "d", "place": 0, "true": 1.0, "estimate": e, "standard_error": 0.1}
        for e in (1.05, 1.5)
    ]
    scores = [
        score("omav/nothing/nothing"),
        score("omav/nothing/nothing", supported=["mass_offset"], groups=[["mass_offset"]], invented=["mass_offset"],
              right=False),
        score("omav/single/linear_drag-usual", parameters=numbers, **drag),
        score("omav/unlisted/slosh", hidden=["slosh"], unexplained=True),
        score("omav/single/com_offset-usual", answered=False, status=3, right=False, size="usual",
              hidden=["com_offset"]),
    ]  # fmt: skip
    path = tmp_path / "scores.json"
    path.write_text(json.dumps(scores))
    settings = HiddenEffects(only=("omav/*/nothing", "omav/single/linear_drag-usual", "omav/unlisted/slosh"), seeds=2)
    summarise(settings, [path], tmp_path / "summary.md", tmp_path / "tables", tmp_path / "figures")
    said = (tmp_path / "summary.md").read_text()
    assert "| single effects, usual size: right | at least 98 % | 50.0 % (1.3 to 98.7) | 2 |" in said
    assert "| nothing missing, omav: false alarms | at most 2 % | 50.0 %" in said
    assert "| unlisted: flagged as unexplained, nothing wrongly supported | at least 90 % | 100.0 %" in said
    assert "| 95 % intervals that hold the true number, clean | 90 to 99 % | 50.0 %" in said
    assert "| explainable error gone on held-out flights, median | at least 95 % | 99.0 % | 1 |" in said
    assert "| unlisted | omav | 1 | 2 |" in said
    assert "1 were refused by the diagnosis: omav/single/com_offset-usual" in said
    cells = pd.read_csv(tmp_path / "tables/confusion.csv").set_index(["hidden", "named"])["share"]
    assert cells["linear_drag", "linear_drag"] == 1.0
    assert cells["(nothing)", "mass_offset"] == cells["(nothing)", "(nothing)"] == 0.5
    assert (tmp_path / "figures/confusion.png").stat().st_size > 5000
    assert (tmp_path / "figures/error_fall.png").stat().st_size > 5000
    assert (tmp_path / "figures/numbers.png").stat().st_size > 5000


def test_a_summary_of_nothing_says_that_nothing_was_run():
    runs, parameters = hidden_tables.runs_table([])
    said = report(runs, parameters, batches(STUDY, ("omav/nothing/nothing",), 3))
    assert "0 of 3 planned runs were made; 3 were not." in said


def test_a_curve_has_a_point_of_all_effects_together(tmp_path):
    scores = [
        score(f"omav/curve/{name}@size=0.1", curve="size=0.1", hidden=[name], right=right)
        for name, right in (("linear_drag", True), ("com_offset", True), ("rotor_lag", False))
    ]
    (tmp_path / "scores.json").write_text(json.dumps(scores))
    points = hidden_tables.curves_table(hidden_tables.runs_table([tmp_path / "scores.json"])[0]).set_index("effect")
    assert list(points["runs"]) == [1, 1, 1, 3]
    together = points.loc["all together"]
    assert together["share"] == pytest.approx(2 / 3)
    assert (together["low"], together["high"]) == pytest.approx((proportion(2, 3).low, proportion(2, 3).high))
    figure_curves(points.reset_index(), tmp_path / "curves.pdf", tmp_path / "curves.png")
    assert (tmp_path / "curves.png").stat().st_size > 5000


def test_exact_intervals():
    p = proportion(0, 150)
    assert (p.share, p.low) == (0.0, 0.0)
    assert p.bound == pytest.approx(1 - 0.05 ** (1 / 150))
    assert proportion(10, 10).high == 1.0
    # Clopper and Pearson's interval of 8 in 10, as tabulated
    assert (proportion(8, 10).low, proportion(8, 10).high) == pytest.approx((0.4439, 0.9748), abs=1e-4)
    assert np.isnan(proportion(0, 0).share)
