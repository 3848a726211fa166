"""What changed: flights held against the vehicle's own healthy ones."""

import functools
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner
from exact_simulation import fly

from infotraj.cli import cli
from infotraj.datasets.location import find_dataset, how_to_get
from infotraj.diagnosis.diagnosis import diagnose, learn
from infotraj.diagnosis.gates.level import as_level, unmeasured
from infotraj.diagnosis.gates.premises import examined
from infotraj.diagnosis.gates.saturation import saturated
from infotraj.diagnosis.linear.candidates import places
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.score import diluted
from infotraj.effects import catalogue
from infotraj.effects.channels import is_derived
from infotraj.errors import InfotrajError
from infotraj.experiment.hidden.file_profiles import wrong_file
from infotraj.flight import ATTITUDE, COMMANDED_WRENCH, RATE, Flight
from infotraj.importing import import_log
from infotraj.models import Model, save_model
from infotraj.recording import read_back
from infotraj.vehicle import load_vehicle, parse_vehicle

CONFIG = Path(__file__).parents[2] / "config"
QUADROTOR = CONFIG / "vehicles" / "quadrotor.yaml"
NOISE = {"gyro": 0.01, "accelerometer": 0.1, "position": 0.001, "attitude": 0.002, "velocity": 0.01}
WEAK = {"rotor_effectiveness": {"rotor": 2, "factor": 0.85}}


@functools.cache
def flights(hidden: str, seeds: tuple[int, ...]) -> tuple[Flight, ...]:
    content = yaml.safe_load(QUADROTOR.read_text())
    tables = [fly(content, json.loads(hidden), seconds=8.0, seed=k, noise=NOISE) for k in seeds]
    return tuple(Flight(t, {"source": f"{k}"}) for k, t in zip(seeds, tables, strict=True))


@functools.cache
def wrong() -> Model:
    """The vehicle with a file that is wrong by 10 %."""
    return Model(wrong_file(load_vehicle(QUADROTOR), "10%", np.random.default_rng(4)))


@functools.cache
def answer(hidden: str):
    return diagnose(wrong(), flights(hidden, (10, 11)), reference=flights("{}", (0, 1, 2)))


@pytest.mark.long
def test_a_weaker_rotor_is_told_beside_a_wrong_file():
    found = answer(json.dumps(WEAK))
    assert found.supported == ("rotor_effectiveness",)
    told = found.finding("rotor_effectiveness")
    assert told.parameters["rotor"] == 2
    healthy = found.healthy_numbers(told)["parameters"]["factor"]
    assert told.parameters["factor"] / healthy == pytest.approx(0.85, abs=0.03)
    error = np.array([found.before.rmse[2], found.after.rmse[2]])
    assert error[1] < 0.5 * error[0]


@pytest.mark.long
def test_nothing_is_told_where_nothing_changed():
    found = answer("{}")
    assert found.supported == ()
    assert len(found.healthy.flights) == 3


def test_what_one_flight_differs_by_says_less_of_all():
    rng = np.random.default_rng(0)
    x = rng.standard_normal((400, 4))
    part = x.T @ x
    np.testing.assert_allclose(diluted(part, np.zeros(3)), part)
    scatter = np.array([0.5, 0.0, 0.0])
    # The same flight with the common number and its own, the latter integrated out.
    joint = np.linalg.inv(np.linalg.inv(part[1:, 1:]) + np.diag(scatter**2))
    np.testing.assert_allclose(diluted(part, scatter)[1:, 1:], joint, rtol=1e-9)


def without(flight: Flight, *columns: str) -> Flight:
    return Flight(flight.table.drop(columns=list(columns)), dict(flight.meta))


def test_a_log_without_attitude_is_taken_as_level_and_says_so():
    whole = flights("{}", (0,))[0]
    assert as_level(whole) is whole
    assert unmeasured(whole) == (frozenset(), frozenset())
    gyro = as_level(without(whole, *ATTITUDE))
    assert is_derived(gyro, ATTITUDE)
    assert not is_derived(gyro, RATE)
    assert unmeasured(gyro) == (frozenset({"vx", "vy"}), frozenset({"vz"}))
    still = as_level(without(whole, *ATTITUDE, *RATE))
    assert np.all(still.get(*RATE) == 0.0)
    assert unmeasured(still)[1] == frozenset({"vz", "tx", "ty", "tz"})


def run(*arguments):
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    assert isinstance(result.exception, (type(None), SystemExit, InfotrajError)), result.exception
    return result


@pytest.mark.parametrize("command", ["compare", "locate", "diagnose"])
def test_a_healthy_flight_that_is_a_copy_of_one_in_question_is_rejected_whatever_its_name(command, tmp_path):
    paths = [tmp_path / f"{name}.parquet" for name in ("flown", "copied", "healthy")]
    for path, f in zip(paths, flights("{}", (0, 0, 1)), strict=True):
        f.table.to_parquet(path)
    refused = run(command, QUADROTOR, paths[0], "--reference", paths[1], "--reference", paths[2])
    said = refused.output + str(refused.exception)
    assert f"rejected: {paths[1]}: holds the same numbers as {paths[0]}, which is asked about (own_reference)" in said
    assert "1 of 2 flights rejected" in said
    overruled = run(command, QUADROTOR, paths[0], "--reference", paths[1], "--accept", "copy")
    assert "(own_reference)" in overruled.output + str(overruled.exception)
    assert "changed" not in said


@pytest.mark.long
def test_the_command_takes_several_healthy_flights(tmp_path):
    paths = []
    for k, f in enumerate([*flights("{}", (0, 1, 2)), *flights(json.dumps(WEAK), (10, 11))]):
        paths.append(tmp_path / f"{k}.parquet")
        f.table.to_parquet(paths[-1])
    out = tmp_path / "x.json"
    found = run("diagnose", QUADROTOR, *paths[3:], "--reference", *paths[:3], "--json", out)
    assert found.exit_code == 0, found.output
    assert "Changed: rotor_effectiveness" in found.output
    content = json.loads(out.read_text())
    assert len(content["reference"]["flights"]) == 3
    effect = next(e for e in content["effects"] if e["name"] == "rotor_effectiveness")
    assert effect["reference"]["parameters"]["factor"] == pytest.approx(1.0, abs=0.05)
    for bad in (["--save-model", tmp_path / "m.yaml"], ["--reference", paths[3]]):
        refused = run("diagnose", QUADROTOR, paths[3], "--reference", paths[0], *bad)
        assert refused.exit_code != 0 or refused.exception is not None
        assert not (tmp_path / "m.yaml").exists()


def crazypad_file(name: str) -> Path:
    """The vehicle file of a log: by what was asked of the motors, or by what they were given."""
    kind = "crazypad_requested" if name.startswith("controller_data") else "crazypad"
    return CONFIG / "vehicles" / f"{kind}.yaml"


def crazypad(name: str) -> Flight:
    folder = find_dataset("crazypad")
    if folder is None:
        pytest.skip(how_to_get("crazypad"))
    flight = import_log(folder / name, mapping="crazyflie")
    up = flight.t[flight.get("pz")[:, 0] > 0.3]
    return examined(flight.between(up[0], up[-1]), load_vehicle(crazypad_file(name)))


@pytest.mark.long
def test_a_cut_propeller_is_told_from_the_balance_of_a_real_vehicle():
    """No attitude in these logs, and torques whose fast part does not follow the commands."""
    model = Model(load_vehicle(crazypad_file("controller_data")))
    healthy = [crazypad(f"controller_data/normal_flight/E8_log0{k}") for k in range(5)]
    cut = crazypad("controller_data/cut_propeller_M3_4mm_4mm_39mm/E8_log00")
    found = diagnose(model, [cut], reference=healthy)
    told = found.finding("rotor_effectiveness")
    assert told.verdict in ("Supported", "Not separable")
    assert told.parameters["rotor"] == 2
    at = places(next(c for c in found.search.known if c.label == "rotor_effectiveness 2"), model.vehicle)
    assert 0.7 < told.parameters["factor"] < 0.9  # by what was given, in other flights, 0.79 to 0.82
    assert found.healthy.errors("rotor_effectiveness 2", at)[0] < 0.2
    assert [d.about for d in saturated([cut], model.vehicle)] == ["m3"]
    assert diagnose(model, [healthy[0]], reference=healthy[1:]).supported == ()


@pytest.mark.long
def test_a_cut_of_two_millimetres_is_told_without_gyro_and_pitch():
    """What the healthy flights would rather have of numbers that no flight tells alone is what a flight is held to."""
    model = Model(load_vehicle(crazypad_file("motor_data")))
    reference = learn(model, [crazypad(f"motor_data/normal_flight/E8_log0{k}") for k in range(5)])
    found = diagnose(model, [crazypad("motor_data/cut_propeller_M3_2mm_2mm_43mm/E8_log03")], reference=reference)
    told = found.finding("rotor_effectiveness")
    assert told.verdict in ("Supported", "Not separable")
    assert told.parameters["rotor"] == 2
    assert 0.8 < told.parameters["factor"] < 0.97
    assert diagnose(model, [crazypad("motor_data/tape_on_propeller_M3/E8_log00")], reference=reference).supported == ()


@pytest.mark.long
def test_what_is_asked_begins_at_the_mean_of_the_healthy_flights():
    found = answer(json.dumps(WEAK))
    linear, healthy = found.whole.linear, found.healthy
    owners = [(c.candidate.label, c.place) for c in linear.columns]
    mean = healthy.mean(owners)
    assert np.count_nonzero(mean) > 10
    scorer = linear.scorer(Scales(1.0))
    start = linear.absent.shifted(mean).gram.sum(axis=(0, 1))
    np.testing.assert_allclose(scorer.parts[0][0, 0], start[0, 0], rtol=1e-9)
    np.testing.assert_array_equal(scorer.given, mean)
    alike = [i for i, owner in enumerate(owners) if owner == ("rotor_effectiveness 2", 0)]
    assert np.count_nonzero(mean[alike]) == 1


def test_errors_stand_beside_those_of_healthy_flights(tmp_path):
    paths = []
    for k, f in enumerate([*flights("{}", (0, 1)), *flights(json.dumps(WEAK), (10,))]):
        paths.append(tmp_path / f"{k}.parquet")
        f.table.to_parquet(paths[-1])
    out = tmp_path / "x.json"
    found = run("compare", QUADROTOR, paths[2], "--reference", *paths[:2], "--json", out)
    assert found.exit_code == 0, found.output
    assert "beside 2 healthy flights" in found.output
    content = json.loads(out.read_text())
    healthy = [f["bias"]["fz"] for f in content["reference"]["flights"]]
    assert abs(content["bias"]["fz"]) > 10 * max(map(abs, healthy))


@pytest.mark.long
def test_a_page_is_made_of_logs_that_tell_a_balance_alone(tmp_path):
    """The healthy flights are taken as level there as well: their model has a steady force, which needs an attitude."""
    lost = ["qw", "qx", "qy", "qz", "wx", "wy", "wz", "ax", "ay", "az"]
    paths = []
    for k, f in enumerate([*flights("{}", (0, 1)), *flights(json.dumps(WEAK), (10,))]):
        paths.append(tmp_path / f"{k}.parquet")
        f.table.drop(columns=lost).to_parquet(paths[-1])
    made = run("report", QUADROTOR, paths[2], "--reference", *paths[:2], "-o", tmp_path / "page.html")
    assert made.exit_code == 0, made.output
    assert "no attitude: the vehicle is taken as level" in (tmp_path / "page.html").read_text()


@pytest.mark.long
def test_a_recording_holds_both_models_beside_healthy_flights(tmp_path):
    paths, weaker = [], tmp_path / "weaker.yaml"
    for k, f in enumerate([*flights("{}", (0, 1)), *flights(json.dumps(WEAK), (10, 11))]):
        paths.append(tmp_path / f"{k}.parquet")
        f.table.to_parquet(paths[-1])
    drawn = [tmp_path / f"{k}.rrd" for k in range(2)]
    beside = ("--reference", *paths[:2], "--recording")
    weak = catalogue()["rotor_effectiveness"](**WEAK["rotor_effectiveness"])
    save_model(Model(load_vehicle(QUADROTOR), [weak]), weaker)
    told = run("compare", weaker, *paths[2:], "--against", QUADROTOR, *beside, drawn[0])
    assert told.exit_code == 0, told.output
    told = run("diagnose", QUADROTOR, *paths[2:], *beside, drawn[1])
    assert told.exit_code == 0, told.output
    assert "Changed: rotor_effectiveness" in told.output
    for path, names in zip(
        drawn,
        (("predicted by weaker", "predicted by quadrotor"), ("the new model", "the model of the healthy flights")),
        strict=True,
    ):
        shown = {k: v for k, v in read_back(path).items() if "/fz/" in k}
        lines = [shown[f"wrench/fz/predicted{n}"]["SeriesLines:names"] for n in ("", "_2")]
        assert lines == [[name] for name in names]
        with_change, without = (np.std(shown[f"residual/fz/residual{n}"]["Scalars:scalars"]) for n in ("", "_2"))
        assert with_change < 0.5 * without


def test_places_stand_beside_the_error_of_healthy_flights_there(tmp_path):
    paths = []
    drag = {"linear_drag": {"d": [0.3, 0.3, 0.3]}}
    for k, f in enumerate([*flights("{}", (0, 1)), *flights(json.dumps(drag), (10,))]):
        paths.append(tmp_path / f"{k}.parquet")
        f.table.to_parquet(paths[-1])
    out = tmp_path / "x.json"
    found = run("locate", QUADROTOR, paths[2], "--reference", *paths[:2], "--json", out)
    assert found.exit_code == 0, found.output
    assert "healthy flights: RMS" in found.output
    assert "% of this trend" in found.output
    content = json.loads(out.read_text())
    assert len(content["reference"]["flights"]) == 2
    sideways = next(p for p in content["places"] if p["axis"] == "fx" and "speed" in p["group"])
    assert sideways["reference"]["now_rms"] > 2 * max(sideways["reference"]["rms"])
    assert max(map(abs, sideways["reference"]["share_of_trend"])) < 0.1
    nearly = tmp_path / "nearly.parquet"  # the same flight, a row shorter: no flight is its own reference
    pd.read_parquet(paths[2]).iloc[:-1].to_parquet(nearly)
    same = run("locate", QUADROTOR, paths[2], "--reference", nearly, "--json", out)
    assert same.exit_code == 0, same.output
    again = next(p for p in json.loads(out.read_text())["places"] if p["axis"] == "fx" and "speed" in p["group"])
    assert again["reference"]["share_of_trend"][0] == pytest.approx(1.0, abs=0.1)
    assert again["reference"]["rms"][0] == pytest.approx(again["reference"]["now_rms"], rel=0.01)


def by_wrench(flight: Flight, rotors) -> Flight:
    """The same flight as a log that holds the wrench which the rotors were asked for, and no rotors."""
    thrust = np.stack([r.thrust_coefficient * flight.get(f"cmd_rotor_{k}")[:, 0] ** 2 for k, r in enumerate(rotors)])
    moment = [np.cross(r.position, r.axis) - r.spin * r.moment_constant * np.array(r.axis) for r in rotors]
    wrench = np.hstack([thrust.T @ [r.axis for r in rotors], thrust.T @ moment])
    table = flight.table.drop(columns=[c for c in flight.table if c.startswith("cmd_rotor_")])
    return Flight(table.assign(**dict(zip(COMMANDED_WRENCH, wrench.T, strict=True))), dict(flight.meta))


@pytest.mark.long
def test_what_changed_is_told_of_a_vehicle_that_is_commanded_by_wrench():
    content = yaml.safe_load(QUADROTOR.read_text())
    rotors = load_vehicle(QUADROTOR).rotors
    keys = {k: content[k] for k in ("name", "mass", "inertia", "gravity")}
    # A mass that is wrong by 8 %, an inertia by 15 %, and a lag of the thrust that is about that of the speeds.
    keys |= {"inputs": "wrench", "thrust_axis": [0, 0, 1], "time_constant": 0.03, "mass": 0.92 * keys["mass"]}
    keys["inertia"] = {k: 1.15 * v for k, v in keys["inertia"].items()}
    model = Model(parse_vehicle(keys))
    healthy = [by_wrench(f, rotors) for f in flights("{}", (0, 1, 2))]
    moved = {"com_offset": {"r": [0.006, -0.004, 0.0]}}
    found = diagnose(model, [by_wrench(f, rotors) for f in flights(json.dumps(moved), (10, 11))], reference=healthy)
    names = {f.name for f in found.findings if f.verdict in ("Supported", "Not separable")}
    assert "com_offset" in names
    assert found.supported in (("com_offset",), ("steady_torque",))
    told = found.finding("com_offset")
    change = np.subtract(told.parameters["r"], found.healthy_numbers(told)["parameters"]["r"])
    np.testing.assert_allclose(change[:2], [0.006, -0.004], atol=0.001)
    assert found.finding("rotor_effectiveness").verdict == "Not testable here"
    again = diagnose(model, [by_wrench(f, rotors) for f in flights("{}", (10, 11))], reference=healthy)
    assert again.supported == ()


def crazyswarm2(log: int) -> Flight:
    folder = find_dataset("crazyswarm2")
    if folder is None:
        pytest.skip(how_to_get("crazyswarm2"))
    flight = import_log(folder / f"logs/log{log}", mapping="crazyflie")
    return examined(flight, load_vehicle(CONFIG / "vehicles" / "crazyswarm2.yaml"))


@pytest.mark.long
def test_a_load_is_told_from_real_flights_of_a_vehicle_that_is_commanded_by_wrench():
    model = Model(load_vehicle(CONFIG / "vehicles" / "crazyswarm2.yaml"))
    free = [crazyswarm2(k) for k in (160, 164, 172, 176)]
    found = diagnose(model, [crazyswarm2(202)], reference=free)
    told = found.finding("suspended_load")
    assert told.verdict in ("Supported", "Not separable")
    assert told.parameters["mass"] == pytest.approx(0.005, rel=0.2)
    # The healthy flights have no accelerometer: what only an accelerometer shows is not known to have changed.
    assert found.finding("time_offset").verdict == "Not testable here"
    assert diagnose(model, free[:1], reference=free[1:]).supported == ()
