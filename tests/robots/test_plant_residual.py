"""The committed plants have a residual of the real vehicle's size, and the page says what the code computes."""

from pathlib import Path

import numpy as np
import pytest

from infotraj.errors import InfotrajError, InputError
from infotraj.robots.plant import residual_table
from infotraj.robots.plant.static import StaticPlant
from infotraj.robots.plant.truth import Interference, Truth, load_truth
from infotraj.vehicle import load_vehicle

OMAV_FILE = Path("config/vehicles/omav.yaml")
FILES = [Path(f"config/plants/omav_{letter}.yaml") for letter in "abcdef"]
OMAV = load_vehicle(OMAV_FILE)


@pytest.fixture(scope="module", params=FILES, ids=lambda f: f.stem)
def residual(request):
    return residual_table.held_hovers(StaticPlant(OMAV, load_truth(request.param, OMAV)))


def test_every_plant_lies_in_the_range_seen_on_the_real_vehicle(residual):
    found = residual_table.summary(residual)
    for key, (low, high) in residual_table.SPEC.items():
        assert low <= getattr(found, key) <= high, key


def test_the_residual_has_a_part_about_z_and_grows_with_tilt(residual):
    z = np.sqrt(np.mean(residual.torque[..., 2] ** 2, axis=1))
    assert z[-1] > 0.1
    assert z[-1] > 1.5 * z[0]


def test_a_plant_without_hidden_effects_has_no_residual():
    ideal = residual_table.held_hovers(StaticPlant(OMAV, Truth.ideal(OMAV)))
    assert np.abs(ideal.torque).max() < 1e-8
    assert np.abs(ideal.deficit).max() < 1e-9


def test_without_interference_the_residual_is_nearly_affine_in_the_force():
    truth = load_truth(FILES[0], OMAV)
    air = truth.air.model_copy(update={"interference": Interference()})
    calm = residual_table.held_hovers(StaticPlant(OMAV, truth.model_copy(update={"air": air})))
    assert np.abs(residual_table.after_affine_fit(calm)).max() < 2e-3
    assert residual_table.summary(calm).growth > 0.1


def test_an_attitude_that_cannot_be_held_is_one_line():
    quadrotor = load_vehicle("config/vehicles/quadrotor.yaml")
    with pytest.raises(InfotrajError, match="no command holds it") as failure:
        StaticPlant(quadrotor, Truth.ideal(quadrotor)).hold(np.array([0.6, 0.0, 0.8]))
    assert "\n" not in str(failure.value)


def test_the_committed_page_holds_this_table():
    page = Path("docs/plants.md").read_text()
    inside = page.split(residual_table.BEGIN)[1].split(residual_table.END)[0].strip()
    assert inside == residual_table.table(OMAV_FILE, FILES)


def test_a_page_without_markers_is_left_alone(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("nothing here\n")
    with pytest.raises(InputError, match="no place for the table"):
        residual_table.write_table(page, "x")
    assert page.read_text() == "nothing here\n"
