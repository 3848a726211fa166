"""NanoBench and ARPL through import, check, compare and locate; skipped where the data sets are not here."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from infotraj.comparing import compare, parse_horizons
from infotraj.comparing.files import write_json
from infotraj.comparing.summary import as_dict as compared_as_dict
from infotraj.datasets.location import find_dataset
from infotraj.errors import UsageError
from infotraj.experiment import real_flights, thrust_map
from infotraj.flight import read_flight
from infotraj.importing import import_log
from infotraj.locating.locating import locate
from infotraj.locating.quantities import cannot_name
from infotraj.locating.summary import as_dict as located_as_dict
from infotraj.models import load_model
from infotraj.vehicle import load_vehicle

ROOT = Path(__file__).parents[1]
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
