"""Wrong files and rough logs in the hidden-effect study: what is shown, what is kept, how it is counted."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from infotraj.errors import UsageError
from infotraj.experiment.hidden import circumstances as hidden_circumstances
from infotraj.experiment.hidden import scoring as hidden_scoring
from infotraj.experiment.hidden import tables as hidden_tables
from infotraj.experiment.hidden.cases import Batch, Case, batches
from infotraj.experiment.hidden.config import load_study, read_study
from infotraj.experiment.hidden.file_errors import told_in_file
from infotraj.experiment.hidden.flying import fly_batch
from infotraj.experiment.hidden.once import chosen, once
from infotraj.experiment.hidden.summary import report
from infotraj.flight import read_flight
from infotraj.plots.hidden_circumstances import figure_false_alarms
from infotraj.vehicle import load_vehicle

STUDY = read_study("config/studies/hidden_effects.yaml")
SHORT = {"train": ("low",), "held_out": ("low",), "seconds": 3.0, "low": 0.15, "tilt": 0}
DRAG = Case("quadrotor", "single", (("linear_drag", 1.0),), size="usual")


def short_study():
    quad = STUDY.vehicles["quadrotor"]
    quad = quad.model_copy(update={"flights": quad.flights.model_copy(update=SHORT)})
    return STUDY.model_copy(update={"vehicles": {"quadrotor": quad}})


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    top = tmp_path_factory.mktemp("circumstances")
    cases = {
        "plain": DRAG,
        "wrong": replace(DRAG, file="10%"),
        "autopilot": replace(DRAG, log="autopilot"),
        "mocap": replace(DRAG, log="motion_capture", seconds=10.0),
    }
    for name, case in cases.items():
        fly_batch(short_study(), Batch(case, (0,)), flights=top / name / "flights", truth=top / name / "truth")
    return top


@pytest.fixture(scope="module")
def heavy(tmp_path_factory):
    top = tmp_path_factory.mktemp("heavy")
    case = replace(DRAG, effects=(("mass_offset", 1.0),), file="3%")
    fly_batch(short_study(), Batch(case, (0,)), flights=top / "flights", truth=top / "truth")
    return top


def shown(runs, name):
    return read_flight(runs / name / "flights/run_0/flight_0.parquet")


def test_a_wrong_file_goes_to_the_diagnosis_and_the_right_one_to_the_scorer(runs):
    file = load_vehicle(runs / "wrong/flights/run_0/vehicle.yaml")
    true = load_vehicle(runs / "wrong/truth/run_0/vehicle.yaml")
    assert (
        true == load_vehicle("config/vehicles/quadrotor.yaml") == load_vehicle(runs / "plain/truth/run_0/vehicle.yaml")
    )
    assert file.mass != true.mass
    assert file.name == true.name


def test_file_and_log_leave_the_flight_and_what_is_hidden_alone(runs):
    truths = [yaml.safe_load((runs / n / "truth/run_0/run.yaml").read_text())["effects"] for n in ("plain", "wrong")]
    assert truths[0] == truths[1]
    plain = shown(runs, "plain").get("cmd_rotor_0", "wx", "ax")
    np.testing.assert_array_equal(shown(runs, "wrong").get("cmd_rotor_0", "wx", "ax"), plain)
    # filtered and shaken, but the same motion
    assert np.corrcoef(shown(runs, "autopilot").get("wx")[:, 0], plain[:, 1])[0, 1] > 0.5
    kept = [read_flight(runs / n / "truth/run_0/held_out_0.parquet").get("wx", "ax") for n in ("plain", "autopilot")]
    np.testing.assert_array_equal(*kept)


def test_no_commanded_wrench_betrays_the_true_file(runs):
    assert shown(runs, "plain").has("cmd_fz")
    for name in ("wrong", "autopilot", "mocap"):
        assert not shown(runs, name).has("cmd_fz")


def test_rough_logs_hold_what_such_logs_hold(runs):
    autopilot, mocap = shown(runs, "autopilot"), shown(runs, "mocap")
    assert autopilot.has("px", "vx", "wx", "ax", "cmd_rotor_3")
    assert not autopilot.has("rotor_0")
    assert np.isfinite(autopilot.get("px", "qw", "vz")).all()
    assert mocap.has("px", "qw", "rotor_3", "cmd_rotor_3")
    assert not mocap.has("ax")
    steps = mocap.get("rotor_0") / (10 * 2 * np.pi / 60)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_what_a_log_cannot_show_is_not_planned_with_it():
    planned = {b.case for b in batches(STUDY)}
    seen = {(c.log, n.split(".")[0]) for c in planned for n, _ in c.effects}
    assert ("motion_capture", "linear_drag") in seen
    assert ("motion_capture", "rotor_lag") not in seen
    assert ("autopilot", "rotor_lag") in seen
    assert {c.file for c in planned if c.kind == "nothing"} == {"exact", "1%", "3%", "10%"}


def test_unknown_files_and_logs_are_refused():
    with pytest.raises(UsageError, match=r"circumstances\.files\.0"):
        load_study({"vehicles": {}, "circumstances": {"files": ["2%"]}}, "study")
    with pytest.raises(UsageError, match=r"circumstances\.logs\.0"):
        load_study({"vehicles": {}, "circumstances": {"logs": ["papyrus"]}}, "study")


def test_one_run_can_be_flown_from_the_command_line(tmp_path):
    words = ["--vehicle", "quadrotor", "--effects", "linear_drag:2", "--file", "3%", "--log", "vibration"]
    words += ["--seconds", "6", "--seed", "3"]
    said = CliRunner().invoke(once, [str(tmp_path / "shown"), str(tmp_path / "kept"), *words])
    assert said.exit_code == 0, said.output
    assert sorted(p.name for p in (tmp_path / "shown").iterdir()) == [
        *(f"flight_{k}.parquet" for k in range(4)), "vehicle.yaml",
    ]  # fmt: skip
    run = yaml.safe_load((tmp_path / "kept/run.yaml").read_text())
    assert run["name"] == "quadrotor/single/linear_drag~3%~vibration"
    assert 0.2 < run["effects"][0]["parameters"]["d"][0] < 0.3


@pytest.mark.parametrize(
    ("vehicle", "effects", "other", "says"),
    [("zeppelin", "", "", "--vehicle"), ("omav", "phlogiston", "", "--effects"), ("omav", "", "ether", "--other"),
     ("omav", "linear_drag:much", "", "numbers")],
)  # fmt: skip
def test_names_that_the_study_does_not_have_are_refused(vehicle, effects, other, says):
    with pytest.raises(UsageError, match=says):
        chosen(STUDY, vehicle, effects, other)


@pytest.mark.parametrize(
    ("nominal", "oracle", "rough", "allowed"),
    [(3.0, 1.0, False, 0.05), (1.2, 1.0, False, 0.05), (60.0, 50.0, False, 0.5), (51.0, 50.0, False, 0.05),
     (9.0, 1.0, True, 2.0), (9.0, None, True, 0.0), (9.0, np.inf, True, 0.0)],
)  # fmt: skip
def test_how_much_a_group_may_miss_is_measured_by_what_the_truth_takes_away(nominal, oracle, rough, allowed):
    assert hidden_scoring._allowed(nominal, oracle, rough) == pytest.approx(allowed)


def scored(groups, instances, file="wrong", log="clean", stood=(), effects=0, told=()):
    """The score of an answer with these groups about a file of 0.76 kg where 0.8 is true."""
    true = load_vehicle("config/vehicles/quadrotor.yaml")
    rows = {n: {"parameters": v[0], "instances": v if len(v) > 1 else []} for n, v in instances.items()}
    score = {"groups": groups, "log": log, "stood": {n: [n] for n in stood}, "sought": effects, "used": []}
    score["told_in_file"] = list(told)
    score["used"] = [k for k, g in enumerate(groups) if g[0] in stood]
    score["invented"] = [g[0] for k, g in enumerate(groups) if k not in score["used"]]
    score["invented"] += [g[0] + hidden_scoring.AGAIN for g in groups for _ in instances[g[0]][1:]]
    wrong = true.model_copy(update={"mass": 0.76}) if file == "wrong" else true
    hidden_scoring._excuse(score, rows, wrong, true)
    return score


def test_a_file_error_that_is_named_rightly_is_no_false_alarm():
    right = scored([["mass_offset"]], {"mass_offset": [{"dm": 0.04}]})
    assert (right["file_errors"], right["invented"], right["right"]) == (["mass_offset"], [], True)
    wrong = scored([["mass_offset"]], {"mass_offset": [{"dm": 0.2}]})
    assert (wrong["file_errors"], wrong["invented"], wrong["right"]) == ([], ["mass_offset"], False)
    exact = scored([["mass_offset"]], {"mass_offset": [{"dm": 0.04}]}, file="exact")
    assert exact["invented"] == ["mass_offset"]


def test_a_lag_that_the_log_itself_has_is_no_false_alarm():
    late = {"time_offset": [{"dt": 0.008}]}
    assert scored([["time_offset"]], late, file="exact", log="autopilot")["log_errors"] == ["time_offset"]
    assert scored([["time_offset"]], late, file="exact")["invented"] == ["time_offset"]


def test_a_second_rotor_is_invented_unless_the_file_is_wrong_about_it():
    two = {"rotor_effectiveness": [{"rotor": 3, "factor": 0.8}, {"rotor": 1, "factor": 0.9}]}
    found = scored([["rotor_effectiveness"]], two, stood=("rotor_effectiveness",), effects=1)
    assert found["invented"] == ["rotor_effectiveness, another"]
    assert not found["right"]


QUADROTOR = load_vehicle("config/vehicles/quadrotor.yaml")
assert QUADROTOR.mass is not None
HEAVIER = QUADROTOR.model_copy(update={"mass": QUADROTOR.mass - 0.04})  # 0.04 kg are missing in this file
WEAK, LATE = {"rotor": 2, "factor": 0.8}, {"extra_time_constant": 0.03}


def stated(name, declared, by):
    return {"name": name, "declared": declared, "value": declared + by, "standard_error": 0.01, "ordinary": False}


@pytest.mark.parametrize(
    ("name", "hidden", "section", "told"),
    [
        ("mass_offset", {"dm": 0.06}, [stated("mass", 0.8, 0.1)], True),  # the file's 0.04 kg with it
        ("mass_offset", {"dm": 0.06}, [stated("mass", 0.8, 0.068)], True),
        ("mass_offset", {"dm": 0.06}, [stated("mass", 0.8, 0.06)], False),
        ("mass_offset", {"dm": 0.06}, [stated("inertia.xx", 0.01, 0.1)], False),
        ("mass_offset", {"dm": 0.06}, [], False),
        ("mass_offset", {"dm": 0.06}, [stated("thrust of all rotors over mass, factor", 1.0, -0.11)], True),
        ("mass_offset", {"dm": 0.06}, [stated("thrust of the other rotors over mass, factor", 1.0, -0.11)], True),
        ("mass_offset", {"dm": 0.06}, [stated("force over mass, factor", 1.0, -0.02)], False),
        ("com_offset", {"r": [0.01, 0.0, 0.0]}, [stated("center_of_mass.x", 0.0, 0.009)], True),
        ("com_offset", {"r": [0.01, 0.0, 0.0]}, [stated("center_of_mass.y", 0.0, 0.01)], False),
        ("com_offset", {"r": [0.01, 0.01, 0.0]}, [stated("center_of_mass.x", 0.0, 0.01)], False),  # half is missing
        ("inertia_error", {"dxx": 2e-3, "dyy": 0.0, "dzz": 0.0}, [stated("inertia.xx", 0.005, 2.4e-3)], True),
        ("inertia_error", {"dxx": 2e-3, "dyy": 0.0, "dzz": 0.0}, [stated("inertia.zz", 0.005, 2e-3)], False),
        ("rotor_effectiveness", WEAK, [stated("rotor_2.thrust_coefficient", 2e-6, -4e-7)], True),
        ("rotor_effectiveness", WEAK, [stated("rotor_2.thrust, factor", 1.0, -0.2)], True),
        ("rotor_effectiveness", WEAK, [stated("rotor_1.thrust_coefficient", 2e-6, -4e-7)], False),
        ("moment_scale", {"factor": 1.3}, [stated("moment_constant of all rotors, factor", 1.0, 0.25)], True),
        ("moment_scale", {"factor": 1.3}, [stated(f"rotor_{k}.moment_constant", 0.02, 0.005) for k in range(4)], True),
        ("moment_scale", {"factor": 1.3}, [stated("rotor_0.moment_constant", 0.02, 0.006)], False),
        ("rotor_lag", LATE, [stated("time_constant of the rotors, more by", 0.0, 0.028)], True),
        ("rotor_lag", LATE, [stated("time_constant of the tilts, more by", 0.0, 0.03)], False),
        ("linear_drag", {"d": [0.1, 0.1, 0.1]}, [stated("mass", 0.8, 0.1)], False),
    ],
)  # fmt: skip
def test_a_hidden_number_of_a_wrong_file_may_be_told_in_the_section_on_the_file(name, hidden, section, told):
    assert told_in_file(name, hidden, section, HEAVIER, QUADROTOR) is told
    assert not told_in_file(name, hidden, section, QUADROTOR, QUADROTOR)


def test_what_the_section_on_the_file_tells_is_not_lost():
    said = {"linear_drag": [{"d": [0.1, 0.1, 0.1]}]}
    kept = scored([["linear_drag"]], said, stood=("linear_drag",), effects=2, told=("mass_offset",))
    lost = scored([["linear_drag"]], said, stood=("linear_drag",), effects=2)
    assert (kept["right"], lost["right"]) == (True, False)


@pytest.mark.parametrize(("share", "told"), [(1.0, ["mass_offset"]), (0.5, [])])
def test_a_flown_run_with_a_wrong_file_is_scored_by_what_the_section_tells(tmp_path, heavy, share, told):
    file, true = (load_vehicle(heavy / f"{k}/run_0/vehicle.yaml") for k in ("flights", "truth"))
    hidden = yaml.safe_load((heavy / "truth/run_0/run.yaml").read_text())["effects"][0]["parameters"]["dm"]
    section = [stated("mass", file.mass, share * (true.mass + hidden - file.mass))]
    said = {"verdict": {"supported": [], "unexplained": False}, "effects": [], "file": section}
    (tmp_path / "answers/run_0").mkdir(parents=True)
    (tmp_path / "answers/run_0/answer.json").write_text(json.dumps(said))
    (tmp_path / "named").mkdir()
    (tmp_path / "named/run_0.json").write_text("{}")
    places = {"flights": heavy / "flights", "answers": tmp_path / "answers", "named": tmp_path / "named"}
    hidden_scoring.score_batch(**places, truth=heavy / "truth", scores=tmp_path / "scores.json")
    (score,) = json.loads((tmp_path / "scores.json").read_text())
    assert (score["told_in_file"], score["found"], score["right"]) == (told, [], bool(told))


def row(kind, **more):
    named = more.pop("named", {})
    return {
        "case": f"omav/{kind}/x", "vehicle": "omav", "kind": kind, "size": "usual" if kind == "single" else "",
        "clutter": False, "curve": "", "seed": 0, "hidden": list(named), "nearest": [], "failed": "", "status": 0,
        "wall": 1.0, "cpu": 1.0, "answered": True, "unexplained": False, "supported": [],
        "groups": list(named.values()),
        "stood": {n: g for n, g in named.items() if n in g}, "found": list(named), "invented": [], "right": True,
        "error_nominal": 1.0, "error_oracle": 1.0, "error_answer": 1.0, "parameters": [], **more,
    }  # fmt: skip


def numbers(*estimates):
    return [
        {"effect": "linear_drag", "parameter": "d", "place": 0, "true": 1.0, "estimate": e, "standard_error": 0.1}
        for e in estimates
    ]


def counted(tmp_path, *scores):
    (tmp_path / "scores.json").write_text(json.dumps(scores))
    runs, parameters = hidden_tables.runs_table([tmp_path / "scores.json"])
    return hidden_circumstances.circumstances_table(runs, parameters)


def cell(table, circumstance, what, vehicle="all"):
    (found,) = table[
        (table["circumstance"] == circumstance) & (table["what"] == what) & (table["vehicle"] == vehicle)
    ].itertuples()
    return found.count, found.total


def test_each_circumstance_is_counted_apart(tmp_path):
    table = counted(
        tmp_path,
        row("nothing"),
        row("nothing", file="3%", invented=["linear_drag"], right=False),
        row("nothing", file="3%", file_errors=["mass_offset"]),
        row("nothing", file="3%", answered=False),
        row("nothing", log="autopilot", log_errors=["time_offset"]),
        row("single", named={"linear_drag": ["linear_drag"]}, parameters=numbers(1.05, 1.5)),
        row("single", file="3%", hidden=["mass_offset"], told_in_file=["mass_offset"]),
        row("single", clutter=True, named={"linear_drag": ["linear_drag"]}, parameters=numbers(1.1)),
        row("pair", gusts=True, named={"linear_drag": ["linear_drag"], "rotor_lag": ["rotor_lag", "time_offset"]}),
    )
    assert cell(table, "file 3%", "false alarms") == (1, 2)
    assert cell(table, "file 3%", "file errors named as effects") == (1, 2)
    assert cell(table, "file 3%", "told in the section on the file") == (1, 1)
    assert "told in the section on the file" not in set(table[table["circumstance"] == "clean"]["what"])
    assert cell(table, "clean", "false alarms") == (0, 1)
    assert cell(table, "log autopilot", "log errors named as effects") == (1, 1)
    assert cell(table, "clean", "numbers in their 95 % interval") == (1, 2)
    assert cell(table, "clutter", "numbers in their 95 % interval") == (1, 1)
    assert cell(table, "gusts", "named alone") == cell(table, "gusts", "named in a group") == (1, 2)
    assert "linear_drag" not in hidden_circumstances.said(table)
    assert "| file 3% |" in hidden_circumstances.said(table)


def test_false_alarms_are_a_curve_over_how_wrong_the_file_is(tmp_path):
    levels = [("exact", 0), ("1%", 0), ("3%", 1), ("10%", 3)]
    scores = [
        row("nothing", file=level, invented=["steady_force"] if k < wrong else [])
        for level, wrong in levels
        for k in range(4)
    ]
    curve = hidden_circumstances.false_alarm_curve(counted(tmp_path, *scores))
    own = curve[(curve["what"] == "false alarms") & (curve["vehicle"] == "all")]
    assert list(own["off"]) == pytest.approx([0.0, 1.0, 3.0, 10.0])
    assert list(own["share"]) == pytest.approx([0.0, 0.0, 0.25, 0.75])
    figure_false_alarms(curve, tmp_path / "f.pdf", tmp_path / "f.png")
    assert (tmp_path / "f.png").stat().st_size > 5000


def test_the_summary_says_what_wrong_files_and_faster_flights_must_show(tmp_path):
    scores = [
        row("single", named={"linear_drag": ["linear_drag"]}),
        row("single", file="3%", right=False),
        row("nothing", file="10%"),
        row("single", log="filters"),
        row("richer", vehicle="agile_quadrotor", force_nominal=11.0, force_answer=3.0),
    ]
    (tmp_path / "scores.json").write_text(json.dumps(scores))
    said = report(*hidden_tables.runs_table([tmp_path / "scores.json"]), [])
    assert "| single effects, usual size: right | at least 98 % | 100.0 %" in said
    assert "| files wrong by 3%: singles right | at least 95 % | 0.0 %" in said
    assert "| files wrong by 10%: false alarms | at most 5 % | 0.0 %" in said
    assert "| rough logs: singles, pairs and triples right | 95 % of what clean ones give | 100.0 %" in said
    assert "| agile quadrotor: force error gone on faster flights, median | at least 70 % | 80.0 % | 1 |" in said
