"""New plants come from the written distribution, and the committed ones are what it gives."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from infotraj.robots.plant import drawing
from infotraj.robots.plant.truth import Truth, load_truth
from infotraj.vehicle import load_vehicle

OMAV = load_vehicle("config/vehicles/omav.yaml")


@pytest.mark.long
@pytest.mark.parametrize("name", ["omav_d", "omav_e", "omav_f"])
def test_the_committed_plants_are_what_the_seed_gives(name, tmp_path):
    drawing.write(OMAV, name, 18, tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_text() == Path(f"config/plants/{name}.yaml").read_text()
    load_truth(tmp_path / "again.yaml", OMAV)


def test_draws_keep_to_the_ranges_that_are_written():
    rng = np.random.default_rng(0)
    found = [Truth.model_validate(drawing.drawn(OMAV, "x", rng)) for _ in range(300)]
    beside = [np.hypot(*truth.center_of_mass[:2]) for truth in found]
    assert min(beside) >= 0.005 - 1e-5
    assert max(beside) <= 0.008 + 1e-5
    assert {truth.servos.dynamics.kind for truth in found} == {"second_order", "lag"}
    factors = np.array([truth.rotors.thrust_factor for truth in found])
    assert factors.std() == pytest.approx(0.02, rel=0.1)
    assert np.corrcoef(factors[:, :2].T)[0, 1] == pytest.approx(0.0, abs=0.2)
    assert np.degrees(np.std([truth.servos.zero_error for truth in found])) == pytest.approx(1.0, rel=0.1)


def test_the_stream_of_a_plant_is_its_own():
    plain = yaml.safe_load(Path("config/plants/omav_e.yaml").read_text())
    assert drawing.accepted(OMAV, "omav_e", 18)[0] == plain
    assert drawing.accepted(OMAV, "omav_e", 19)[0] != plain
