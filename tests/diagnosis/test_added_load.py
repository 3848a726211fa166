"""A load by hand: first moments add up."""

from types import SimpleNamespace

import pytest

from infotraj.diagnosis.report.added_load import added_load


def found(
    dm, r, *, verdicts=("Supported", "Supported"), file=1.0, healthy=None, nominal=(0.0, 0.0, 0.0), sure=0.001, still=()
):
    """A diagnosis of a vehicle of 1 kg that has these changes; healthy: the numbers of the healthy flights."""
    mass = SimpleNamespace(
        name="mass_offset", verdict=verdicts[0], parameters={"dm": dm}, standard_errors={"dm": sure},
        group=("mass_offset",) if verdicts[0] == "Supported" else ("thrust_scale", "mass_offset"),
    )  # fmt: skip
    centre = SimpleNamespace(
        name="com_offset", verdict=verdicts[1], parameters={"r": r}, standard_errors={"r": [0.001, 0.001, 0.002]},
        group=("com_offset",) if verdicts[1] == "Supported" else ("rotor_effectiveness", "com_offset"),
    )  # fmt: skip
    vehicle = SimpleNamespace(mass=1.0, center_of_mass=nominal)
    return SimpleNamespace(
        findings=(mass, centre), healthy=healthy, model=SimpleNamespace(vehicle=vehicle),
        whole=SimpleNamespace(
            scales=SimpleNamespace(common=file),
            linear=SimpleNamespace(observation=SimpleNamespace(still=frozenset(still))),
        ),
        healthy_numbers=lambda f: {"parameters": healthy[f.name]} if f.name in (healthy or {}) else None,
    )  # fmt: skip


def test_a_quarter_of_the_mass_is_five_times_as_far_out_as_the_centre_moved():
    load = added_load(found(0.25, [0.02, 0.0, -0.04]))
    assert load.mass == 0.25
    assert load.place == pytest.approx([0.1, 0.0, -0.2])
    # Five times the error of the centre, and the mass's own: (c - r) / dm of it.
    assert load.place_errors == pytest.approx(
        [(0.005**2 + (0.08 * 0.004) ** 2) ** 0.5, 0.005, (1e-4 + 0.00064**2) ** 0.5]
    )
    assert load.sentence() == (
        "mass and centre of mass together: a load of 0.25 +- 0.001 kg at (100, 0, -200) +- (5, 5, 10) mm from the "
        "body's origin"
    )
    assert added_load(found(0.25, [0.02, 0.0, -0.04])).as_dict()["place"] == pytest.approx([0.1, 0.0, -0.2])


def test_what_was_there_before_is_no_part_of_the_load():
    """Of a vehicle whose centre the file, or healthy flights, have beside the origin the change alone is the load's."""
    beside = added_load(found(0.25, [0.0, 0.0, 0.0], nominal=(0.03, 0.0, 0.0)))
    assert beside.place == pytest.approx([0.03, 0.0, 0.0])
    healthy = {"mass_offset": {"dm": 0.6}, "com_offset": {"r": [0.01, 0.0, 0.0]}}
    changed = added_load(found(1.0, [0.03, 0.0, 0.0], healthy=healthy, file=9.0))
    assert changed.mass == pytest.approx(0.4)
    assert changed.place == pytest.approx([(2.0 * 0.03 - 1.6 * 0.01) / 0.4, 0.0, 0.0])


def test_a_part_that_is_gone_was_where_the_centre_moved_away_from():
    gone = added_load(found(-0.2, [-0.025, 0.0, 0.0]))
    assert gone.place == pytest.approx([0.1, 0.0, 0.0])
    assert "a part gone of 0.2 +- 0.001 kg at (100, 0, 0)" in gone.sentence()


def test_what_may_be_thrust_is_a_load_only_if_it_is_mass():
    load = added_load(found(0.25, [0.02, 0.0, 0.0], verdicts=("Not separable", "Supported")))
    assert ", if it is no thrust_scale: a load" in load.sentence()
    assert load.as_dict()["or_else"] == ["thrust_scale"]
    assert load.as_dict()["sentence"] == load.sentence()
    both = added_load(found(0.25, [0.02, 0.0, 0.0], verdicts=("Not separable", "Not separable")))
    assert ", if it is no thrust_scale or rotor_effectiveness: a load" in both.sentence()


@pytest.mark.parametrize(
    "without",
    [
        {"verdicts": ("Plausible", "Supported")},
        {"verdicts": ("Supported", "Not needed")},
        {"file": 3.0},
        {"sure": 0.1},
        {"still": [("com_offset", 2)]},
        {"healthy": {"mass_offset": {"dm": 0.1}}},
    ],
)
def test_there_is_no_load_where_a_change_is_not_named_or_sure_or_not_all_of_it_is_known(without):
    assert added_load(found(0.25, [0.02, 0.0, 0.0], **without)) is None
