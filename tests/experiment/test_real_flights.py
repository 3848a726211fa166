"""NanoBench and ARPL through import, check, compare, locate, diagnose and add; skipped where the data are not here."""

import re
import shutil
from pathlib import Path

import fast_flyer
import numpy as np
import pandas as pd
import pytest
import yaml
from pydantic import ValidationError

from infotraj import rotations
from infotraj.comparing import compare, parse_horizons
from infotraj.comparing.files import write_json
from infotraj.comparing.summary import as_dict as compared_as_dict
from infotraj.datasets.location import find_dataset
from infotraj.effects import effect_class
from infotraj.errors import InputError, UsageError
from infotraj.evaluation.lateral_error import lateral_error
from infotraj.experiment.common.config import ExperimentConfig, RealDiagnosis, RealFlights
from infotraj.experiment.real import diagnosis as real_diagnosis
from infotraj.experiment.real import flights as real_flights
from infotraj.experiment.real import thrust_map
from infotraj.experiment.real import verdicts as real_verdicts
from infotraj.experiment.real import windows as real_windows
from infotraj.flight import ATTITUDE, VELOCITY, Flight, read_flight
from infotraj.importing import import_log
from infotraj.locating.locating import locate
from infotraj.locating.quantities import cannot_name
from infotraj.locating.summary import as_dict as located_as_dict
from infotraj.models import Model, load_model, save_model
from infotraj.vehicle import load_vehicle

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "config"
NANOBENCH, ARPL = find_dataset("nanobench"), find_dataset("arpl_crazyflie")
needs_nanobench = pytest.mark.skipif(NANOBENCH is None, reason="NanoBench is not here: infotraj data get nanobench")


def test_every_model_of_a_data_set_is_a_valid_file():
    for name, chosen in real_flights.DATA_SETS.items():
        for path in chosen.models:
            model = load_model(CONFIG / path)
            assert model.vehicle.mass == 0.027, name
    calibrated, plain = load_model(CONFIG / "models/nanobench.yaml"), load_vehicle(CONFIG / "vehicles/nanobench.yaml")
    assert calibrated.vehicle == plain
    assert [e.name for e in calibrated.effects] == ["battery_sag"]


def test_an_unknown_data_set_is_refused():
    with pytest.raises(UsageError, match="nanobench or arpl_crazyflie"):
        real_flights.data_set("euroc")


@needs_nanobench
def test_the_numbers_of_the_vehicle_files_are_those_of_the_fit():
    flights = thrust_map.named_flights()
    model = load_model(CONFIG / "models/nanobench.yaml")
    rotor, exponent = model.vehicle.rotors[0], model.effects[0].exponent
    best = thrust_map.fit_thrust_map(flights, exponents=exponent + np.array([-0.1, 0.0, 0.1]), time_constants=[0.025])
    assert best.exponent == pytest.approx(exponent)
    assert rotor.thrust_polynomial == pytest.approx((0.0, best.c1, best.c2), abs=1e-5)
    alone = thrust_map.fit_thrust_map(flights, exponents=[0.0], time_constants=[0.025], linear_only=True)
    uncalibrated = load_vehicle(CONFIG / "vehicles/nanobench_uncalibrated.yaml").rotors[0]
    assert uncalibrated.thrust_polynomial == pytest.approx((0.0, alone.c1, 0.0), abs=1e-5)
    assert alone.rmse > 2 * best.rmse


@pytest.mark.long
@needs_nanobench
def test_nanobench_fails_with_speed_sideways_and_with_voltage_upward_where_it_is_left_out(tmp_path, monkeypatch):
    names = ["B3_figure8_fast_rep1", "B5_helix_medium_rep1", "B10_lissajous_fast_rep1", "B7_oval_slow_rep1"]
    (tmp_path / "nanobench").mkdir()
    for name in names:
        shutil.copy(NANOBENCH / f"{name}.parquet", tmp_path / "nanobench")
    monkeypatch.delenv("INFOTRAJ_DATA", raising=False)
    out = tmp_path / "out" / "nanobench"
    real_flights.receive_logs(name="nanobench", data_dir=tmp_path, flights=out / "flights", table=out / "checks.csv")
    assert {p.stem for p in (out / "flights").iterdir()} == set(names[:3])
    assert "no_flight" in (out / "checks.csv").read_text()

    flights = [read_flight(p) for p in sorted((out / "flights").iterdir())]
    chosen = real_flights.data_set("nanobench")
    models = {path: load_model(CONFIG / path) for path in chosen.models}
    found = locate(models[chosen.models[1]], flights, force_from=chosen.force_from)
    first = {axis: next(p.group for p in found.places if p.axis == axis) for axis in ("fx", "fy", "fz")}
    assert first == {"fx": "speed", "fy": "speed", "fz": "battery"}

    compared = compare(models, flights, force_from=chosen.force_from)
    calibrated, uncalibrated = (m.overall for m in compared.models)
    assert calibrated.rmse[2] < 0.7 * uncalibrated.rmse[2]
    write_json(compared_as_dict(compared), out / "comparison.json")
    where = out / "nanobench_uncalibrated" / "places.json"
    write_json(located_as_dict(found), where)
    real_flights.summarise(
        comparisons=[out / "comparison.json"], places=[where], table=out / "summary.csv", markdown=out / "summary.md"
    )
    assert "battery voltage" in (out / "summary.md").read_text()


@pytest.mark.skipif(ARPL is None, reason="the ARPL logs are not here: infotraj data get arpl_crazyflie")
def test_arpl_logs_are_compared_without_pose():
    flight = import_log(ARPL / "log10", "crazyflie")
    model = load_model(CONFIG / "vehicles/crazyflie_arpl.yaml")
    found = compare(model, [flight], horizons=parse_horizons("10"), start=35.0, stop=65.0)
    assert found.models[0].overall.explained[2] > 0.85
    assert found.models[0].rollouts[0].reason == "the flight has no position"
    assert set(cannot_name(flight, model.vehicle)) == {"speed", "height", "tilt", "battery"}


@needs_nanobench
def test_the_example_of_the_docs_runs(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    example = re.search(r"```python\n(.*?)```", (ROOT / "docs/compare.md").read_text(), re.S).group(1)
    exec(compile(example, "docs/compare.md", "exec"), {})
    assert "forward speed" in capsys.readouterr().out


def straight_flight(push: float, slow: float, mean: float = 0.0, seconds: float = 12.0) -> Flight:
    """A level 0.8 kg quadrotor at hover thrust, pushed sideways: by x `push` cos(slow t), by y `mean`, m/s^2."""
    t = np.arange(0.0, seconds, 0.01)
    columns: dict[str, object] = {**dict.fromkeys(("pz", "qw"), 1.0)}
    columns |= dict.fromkeys(("px", "py", "qx", "qy", "qz", "vz"), 0.0)
    columns |= dict.fromkeys(("wx", "wy", "wz"), 0.0) | {"t": t, "az": 9.81, "ay": mean, "vy": mean * t}
    columns |= {"ax": push * np.cos(slow * t), "vx": push / slow * np.sin(slow * t)}
    hover = np.sqrt(0.8 * 9.81 / 4 / 1.5e-6)
    return Flight(pd.DataFrame(columns | {f"cmd_rotor_{k}": hover for k in range(4)}))


@pytest.mark.parametrize("source", ["accelerometer", "velocity"])
def test_the_lateral_error_is_what_pushes_the_vehicle_sideways(source):
    vehicle = load_vehicle(CONFIG / "vehicles/quadrotor.yaml")
    long, short = straight_flight(0.4, 1.3, 0.2, 60.0), straight_flight(1.0, 1.7, -0.5, 20.0)
    for flight in (long, short):  # what is not asked for is wrong
        flight.table[{"accelerometer": "vx", "velocity": "ax"}[source]] *= 3.0
    found = lateral_error(Model(vehicle), [long, short], source)
    # The steady push is each flight's mean. The filter of 0.15 s takes 1 % of the slow push at most.
    assert found.rms[:, 1] == pytest.approx(0.0, abs=1e-6)
    assert found.rms[:, 0] == pytest.approx([0.4 / np.sqrt(2), 1.0 / np.sqrt(2)], rel=0.02)
    assert found.rmse == pytest.approx(np.sqrt((0.08 + 0.5) / 4), rel=0.02)  # both flights count the same


@pytest.mark.parametrize("source", ["accelerometer", "velocity"])
def test_the_lateral_error_vanishes_with_the_drag_that_was_there(source):
    vehicle = load_vehicle(CONFIG / "vehicles/quadrotor.yaml")
    flights = [Flight(fast_flyer.fly(CONFIG / "vehicles/quadrotor.yaml", 8.0, 2, {"linear_drag": 0.1}, noise=0.0))]
    without = lateral_error(Model(vehicle), flights, source)
    speed = rotations.to_body(flights[0].get(*ATTITUDE), flights[0].get(*VELOCITY))[50:, :2]
    assert without.rms[0] == pytest.approx(0.1 / 0.8 * speed.std(axis=0), rel=0.05)
    right = lateral_error(Model(vehicle, [effect_class("linear_drag")(d=[0.1, 0.1, 0.1])]), flights, source)
    assert (right.rms < 0.05 * without.rms).all()


def test_a_flight_without_lateral_force_is_refused():
    flight = straight_flight(1.0, 1.0)
    blind = Flight(flight.table.drop(columns=["ax", "ay", "az"]), {"source": "blind"})
    with pytest.raises(InputError, match="blind: no lateral force by accelerometer"):
        lateral_error(load_model(CONFIG / "vehicles/quadrotor.yaml"), [blind])


def test_what_is_diagnosed_is_consistent():
    assert set(RealFlights.model_fields) == set(real_flights.DATA_SETS)
    for name in real_flights.DATA_SETS:
        assert load_model(CONFIG / real_windows.chosen(ExperimentConfig(), name).model).vehicle.mass == 0.027
    for wrong, why in (
        ({"held_out": ("a",)}, "fitted and held out"),
        ({"windows": {"a": (2.0, 2.0)}}, "ends before it starts"),
    ):
        with pytest.raises(ValidationError, match=why):
            RealDiagnosis(model="vehicles/quadrotor.yaml", fit=("a",), **wrong)


def test_the_nominal_crazyflie_is_the_published_one_but_for_lag_and_inertia():
    nominal, published = (load_vehicle(CONFIG / f"vehicles/crazyflie_arpl{n}.yaml") for n in ("_nominal", ""))
    assert {r.time_constant for r in nominal.rotors} == {0.0}
    assert np.diag(nominal.inertia_matrix()) == pytest.approx([1.6e-5, 1.6e-5, 2.9e-5])
    same = [r.model_copy(update={"time_constant": 0.0}) for r in published.rotors]
    assert same == list(nominal.rotors)
    assert (nominal.mass, nominal.gravity) == (published.mass, published.gravity)


@pytest.mark.long
def test_a_named_lag_and_inertia_come_back_and_beside_the_lag_alone_the_file_is_corrected(tmp_path):
    hidden = {"rotor_lag": 0.05, "inertia": 1.3}
    content = yaml.safe_load((CONFIG / "vehicles/quadrotor.yaml").read_text())
    for rotor in content["rotors"]:
        rotor["time_constant"] = 0.03 + hidden["rotor_lag"]
    for axis in content["inertia"]:
        content["inertia"][axis] *= hidden["inertia"]
    (tmp_path / "true.yaml").write_text(yaml.safe_dump(content))
    for k in range(2):
        Flight(fast_flyer.fly(tmp_path / "true.yaml", 6.0, k)).write(tmp_path / f"log{k}.parquet")
    wanted = RealDiagnosis(
        model="vehicles/quadrotor.yaml", fit=("log0", "log1"), add=("rotor_lag", "rotor_lag+inertia_error")
    )
    settings = ExperimentConfig(real_flights=RealFlights(arpl_crazyflie=wanted))
    table = tmp_path / "added.csv"
    real_diagnosis.add_named(settings, name="arpl_crazyflie", config=CONFIG, flights=tmp_path, table=table)
    rows = pd.read_csv(table).set_index("effects")
    given, alone, both = (rows.loc[n] for n in ("nothing", "rotor_lag", "rotor_lag+inertia_error"))
    assert (given["time_constant"], given["J_xx"], given["J_yy"]) == (0.03, 0.0055, 0.0055)
    # Where the lag alone is asked for, the inertia is an error of the file, which is corrected beside it.
    assert alone["J_xx"] == pytest.approx(1.3 * 0.0055, rel=0.05)
    assert both["time_constant"] == pytest.approx(0.08, rel=0.05)
    assert [both["J_xx"], both["J_yy"]] == pytest.approx([1.3 * 0.0055] * 2, rel=0.05)
    assert 0 < both["J_xx_error"] < 0.2 * 0.0055
    assert both["rmse_tx"] < 1.02 * alone["rmse_tx"] < 0.5 * given["rmse_tx"]


def test_the_summary_says_which_flights_got_better_and_what_ended_at_a_bound(tmp_path):
    verdict = {
        "data_set": "nanobench",
        "effect": "linear_drag", "verdict": "Supported", "group": "", "rise": 3.0, "axis": "fx",
        "heldout_change": -0.2, "low": -0.3, "high": -0.1, "better": "4/5", "selected": 1.0,
        "parameters": '{"d": [0.01, 0.02, 0.0]}', "standard_errors": '{"d": [0.001, 0.002, 0.003]}',
        "further_instances": '[{"d": [0.03, 0.0, 0.0]}]', "reason": "",
    }  # fmt: skip
    absent = dict.fromkeys(verdict) | {"data_set": "nanobench", "effect": "gyro_bias", "verdict": "Not needed"}
    pd.DataFrame([absent, verdict]).to_csv(tmp_path / "v.csv", index=False)
    (tmp_path / "n.json").write_text('{"verdict": {"summary": "Missing: linear_drag."}}')
    tested = [["nanobench", "velocity", *row] for row in (["a", 0.3, 0.1], ["b", 0.1, 0.2], ["all", 0.22, 0.16])]
    columns = ["data_set", "force_from", "flight", "before", "after"]
    pd.DataFrame(tested, columns=columns).to_csv(tmp_path / "h.csv", index=False)
    out = {k: tmp_path / f"{k}.csv" for k in ("table", "held_out_table", "added_table")}
    real_verdicts.summarise_diagnoses(
        verdicts=[tmp_path / "v.csv"], numbers=[tmp_path / "n.json"], held_out=[tmp_path / "h.csv"], added=[],
        markdown=tmp_path / "d.md", **out,
    )  # fmt: skip
    text = (tmp_path / "d.md").read_text()
    assert "| linear_drag | Supported |  | 3 (fx) | -0.200 [-0.300, -0.100] | 1.00 | d 0.01 +- 0.001, " in text
    assert "0.02 +- 0.002, 0 +- 0.003 and d 0.03, 0, 0 |" in text
    assert "Not needed: gyro_bias." in text
    assert "Missing: linear_drag." in text
    assert "| 0.220 | 0.160 | 1/2 | a 0.300 to 0.100; b 0.100 to 0.200 |" in text
    assert pd.read_csv(out["table"])["effect"].tolist() == ["gyro_bias", "linear_drag"]
    assert pd.read_csv(out["added_table"]).empty


@needs_nanobench
def test_drag_is_what_nanobench_lacks_sideways_on_flights_that_were_not_fitted(tmp_path, monkeypatch):
    monkeypatch.setenv("INFOTRAJ_DATA", str(NANOBENCH.parent))
    few = RealDiagnosis(
        model="vehicles/nanobench_uncalibrated.yaml", fit=("B3_figure8_fast_rep1",), held_out=("B2_circle_fast_rep1",),
        windows={"B3_figure8_fast_rep1": (5.0, 20.0)},
    )  # fmt: skip
    settings = ExperimentConfig(real_flights=RealFlights(nanobench=few))
    real_windows.cut_flights(settings, name="nanobench", data_dir=None, flights=tmp_path)
    cut = read_flight(tmp_path / "B3_figure8_fast_rep1.parquet").t
    assert cut[0] >= 5.0
    assert cut[-1] < 20.0
    vehicle = load_vehicle(CONFIG / few.model)
    save_model(Model(vehicle, [effect_class("linear_drag")(d=[0.0085, 0.0091, 0.0])]), tmp_path / "drag.yaml")
    real_diagnosis.score_held_out(
        settings, name="nanobench", config=CONFIG, flights=tmp_path, model=tmp_path / "drag.yaml",
        table=tmp_path / "held_out.csv",
    )  # fmt: skip
    rows = pd.read_csv(tmp_path / "held_out.csv").set_index(["force_from", "flight"])
    felt, seen = rows.loc[("accelerometer", "all")], rows.loc[("velocity", "all")]
    assert felt["before"] == pytest.approx(0.288, abs=0.01)
    assert felt["after"] < 0.3 * felt["before"]
    assert seen["before"] == pytest.approx(0.33, abs=0.01)
    assert seen["after"] < 0.6 * seen["before"]
    for wrong in ({"fit": ("B99",)}, {"fit": few.fit, "windows": {"B99": (1.0, 2.0)}}):
        other = ExperimentConfig(real_flights=RealFlights(nanobench=RealDiagnosis(model=few.model, **wrong)))
        with pytest.raises(UsageError, match="nanobench has no log B99"):
            real_windows.logs(other, "nanobench", NANOBENCH)
