"""The plants that hide effects move as the catalogue says with the same parameters: units, frames and signs."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_plants import BESIDE, EFFECTS, VEHICLES, flights, floor, left
from mass_properties import mass_properties

from infotraj.errors import InputError
from infotraj.robots.plant.hiding import CATALOGUE, clutter, hide
from infotraj.robots.plant.plant import Plant

CASES = [(vehicle, effect, values) for vehicle, listed in EFFECTS.items() for effect, values in listed]
# Logged voltage carries noise of its own, and what swings on a cable grows with every rounding.
LOOSE = {"battery_sag exponent": 0.15, "suspended_load": 0.6}
# In IMU errors the residual of the nominal model is small against sensor noise, though large against the floor.
SMALL = ("gyro_bias",)


@pytest.mark.long
@pytest.mark.parametrize(("vehicle", "effect", "values"), CASES, ids=lambda v: v if isinstance(v, str) else "")
def test_the_true_parameters_explain_the_plant(vehicle, effect, values):
    found = flights(vehicle, effect, values)
    nominal, true = left(vehicle, found, None, values), left(vehicle, found, effect, values)
    assert nominal > (0.05 if effect in SMALL else 0.25)
    key = "battery_sag exponent" if "exponent" in values else effect
    assert true < floor(vehicle) + LOOSE.get(key, 0.02)


TOGETHER = [(v, *case) for v, cases in BESIDE.items() for case in cases]


@pytest.mark.parametrize(
    ("vehicle", "effect", "values", "beside"),
    [*TOGETHER[:2], *(pytest.param(*case, marks=pytest.mark.long) for case in TOGETHER[2:])],
    ids=lambda v: v if isinstance(v, str) else v[0] if isinstance(v, tuple) else "",
)  # fmt: skip
def test_what_acts_beside_another_explains_the_plant_beside_it(vehicle, effect, values, beside):
    found = flights(vehicle, effect, values, beside=[beside])
    assert left(vehicle, found, None, values, [beside]) > 0.25
    assert left(vehicle, found, effect, values, [beside]) < floor(vehicle) + 0.02


def test_every_effect_of_the_catalogue_can_be_hidden():
    from infotraj.effects import catalogue

    # A plant's flights hold commands, and nothing that was measured of its rotors.
    assert set(CATALOGUE) == set(catalogue(())) - {"telemetry_offset"}


@pytest.mark.parametrize("effect", ["moment_scale", "gyroscopic"])
def test_equal_coaxial_pairs_hide_it_completely(effect):
    values = {"factor": 0.7} if effect == "moment_scale" else {"rotor_inertia": 3e-5}
    found = flights("omav", effect, values, seconds=4.0)
    assert left("omav", found, None, values) < floor("omav") + 0.02


def test_a_name_that_no_plant_carries_is_refused():
    with pytest.raises(InputError, match="phlogiston"):
        hide(VEHICLES["omav"], [("phlogiston", {})])


@pytest.mark.parametrize(
    ("vehicle", "what", "values"),
    [
        ("omav", "slosh", {"mass": 0.4, "place": [0.0, 0.0, -0.05], "frequency": 1.2}),
        ("quadrotor", "slosh", {"mass": 0.08, "place": [0.0, 0.0, -0.03], "frequency": 1.5}),
        ("omav", "flexible_arm", {"rotor": 2, "tip_mass": 0.25, "frequency": 7.0}),
        ("quadrotor", "flexible_arm", {"rotor": 2, "tip_mass": 0.08, "frequency": 9.0}),
    ],
)
def test_bodies_inside_leave_the_totals_as_they_are(vehicle, what, values):
    plant = Plant(VEHICLES[vehicle], hide(VEHICLES[vehicle], [(what, values)]))
    mass, center, inertia = mass_properties(plant.bodies)
    assert mass == pytest.approx(VEHICLES[vehicle].mass)
    np.testing.assert_allclose(center, 0.0, atol=1e-5)
    np.testing.assert_allclose(inertia, VEHICLES[vehicle].inertia_matrix(), atol=2e-6)


def test_clutter_is_as_large_as_it_says():
    vehicle = VEHICLES["omav"]
    sizes = {
        "rotors": 0.01, "inertia": 0.02, "center_of_mass": 4e-4, "force": 0.003, "torque": 0.001,
        "correlation_time": 0.5,
    }  # fmt: skip
    made = [clutter(hide(vehicle, []), vehicle, sizes, np.random.default_rng(k)) for k in range(50)]
    spread = np.std([t.rotors.thrust_factor for t in made])
    assert spread == pytest.approx(0.01, rel=0.15)
    assert [np.linalg.norm(t.center_of_mass) for t in made] == pytest.approx([4e-4] * 50)
    for t in made:
        np.testing.assert_allclose(np.abs(t.inertia.xx / vehicle.inertia.xx - 1), 0.02)
