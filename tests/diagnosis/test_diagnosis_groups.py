"""Which effects may stand in another's place: odds below twenty to one, tempered by how much the data scatter."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.judge import groups
from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import AS_PROBABLE, Rival, rivals
from infotraj.diagnosis.judge.verdicts import Judge
from infotraj.diagnosis.select.prior import Scales


def two_alike(scatter):
    """A fit of linear_drag on one axis, and quadratic_drag, whose column is nearly the same. scatter: of its number."""

    def rows(rng, k):
        # Sizes scatter between blocks about a mean that is the same for both cases.
        size = 0.3 + scatter * (1.0 if k % 2 else -1.0)
        x = np.zeros((ROWS, 3))
        x[:, 1] = rng.standard_normal(ROWS)
        x[:, 2] = 0.97 * x[:, 1] + np.sqrt(1.0 - 0.97**2) * rng.standard_normal(ROWS)
        x[:, 0] = size * x[:, 1] + rng.standard_normal(ROWS)
        return x

    return linear_fit(["linear_drag", "quadratic_drag"], rows, ["linear_drag"])


def odds(search, whole):
    """By how many nats the effect is more probable than the other in its place."""
    return whole.solution.score - search.fitted(["quadratic_drag"], whole).solution.score


def test_odds_count_for_less_where_the_data_scatter_more_than_their_noise():
    search, whole = two_alike(scatter=0.4)
    wider = overdispersion(whole)[0]
    assert 1.5 * AS_PROBABLE < odds(search, whole) < 0.8 * AS_PROBABLE * wider
    assert [r.label for r in rivals(search, whole, "linear_drag", 0.0)] == ["quadratic_drag"]


def test_the_same_odds_decide_where_the_data_scatter_as_their_noise_says():
    search, whole = two_alike(scatter=0.0)
    assert overdispersion(whole)[0] < 1.5
    assert odds(search, whole) > 1.5 * AS_PROBABLE
    assert rivals(search, whole, "linear_drag", 0.0) == []


def test_what_another_explains_beside_an_effect_makes_it_no_rival():
    """rotor_drag is outside the set and explains more than linear_drag does, of something else."""

    def rows(rng, _):
        x = np.zeros((ROWS, 3))
        x[:, 1:] = rng.standard_normal((ROWS, 2))
        x[:, 0] = 0.5 * x[:, 1] + 2.0 * x[:, 2] + rng.standard_normal(ROWS)
        return x

    search, whole = linear_fit(["linear_drag", "rotor_drag"], rows, ["linear_drag"])
    assert search.fitted(["rotor_drag"], whole).solution.score > whole.solution.score
    assert rivals(search, whole, "linear_drag", 0.05) == []


def as_group(names, resembles, order=None):
    """A judge, and a group whose first member is true and whose others' columns resemble its own."""

    def rows(rng, _):
        x = np.zeros((ROWS, 1 + len(names)))
        x[:, 1] = rng.standard_normal(ROWS)
        for k, r in enumerate(resembles, 2):
            x[:, k] = r * x[:, 1] + np.sqrt(1.0 - r**2) * rng.standard_normal(ROWS)
        x[:, 0] = x[:, 1] + rng.standard_normal(ROWS)
        return x

    search, whole = linear_fit(names, rows, names[:1])
    search.observation = whole.linear.observation
    fits = [whole, *(search.fitted([n], whole) for n in names[1:])]
    members = [(f.members[0], {}, None if f is whole else Rival(f.labels[0], f)) for f in fits]
    judge = Judge(search, whole, (), tuple(order or sorted(names)), None, {}, 0.05, np.random.default_rng(0))
    return judge, members


def order_of(names, resembles):
    """In which order such a group is named."""
    judge, members = as_group(names, resembles)
    named = [[m[0].candidate.name for m in judge._simplest_first(order)] for order in (members, members[::-1])]
    assert named[0] == named[1]
    return named[0]


@pytest.mark.parametrize(
    ("names", "resembles", "order"),
    [
        # as good: fewer numbers first, then what acts by itself, then the order of the catalogue
        (["linear_drag", "thrust_scale"], [0.999], ["thrust_scale", "linear_drag"]),
        (["wind", "linear_drag"], [0.999], ["linear_drag", "wind"]),
        (["steady_force", "linear_drag"], [0.999], ["linear_drag", "steady_force"]),
        # what leaves more error comes after, however simple it is
        (["linear_drag", "thrust_scale"], [0.7], ["linear_drag", "thrust_scale"]),
        (["wind", "thrust_scale", "linear_drag"], [0.7, 0.999], ["linear_drag", "wind", "thrust_scale"]),
    ],
)
def test_the_simplest_of_those_that_predict_best_stands_for_a_group(names, resembles, order):
    assert order_of(names, resembles) == order


def test_what_a_rival_adds_counts_only_where_it_predicts(monkeypatch):
    """Both columns hold a little of their own: sure in these data, and less than a sixth of the error."""

    def rows(rng, _):
        x = np.zeros((ROWS, 3))
        x[:, 1:] = rng.standard_normal(ROWS)[:, None] + 0.4 * rng.standard_normal((ROWS, 2))
        x[:, 0] = 0.8 * x[:, 1] + 0.84 * x[:, 2] + rng.standard_normal(ROWS)
        return x

    search, whole = linear_fit(["linear_drag", "rotor_drag"], rows, ["linear_drag"])
    both = whole.scorer.scores([(*whole.chosen, 1)])[0]
    assert both - search.fitted(["rotor_drag"], whole).solution.score > 2 * AS_PROBABLE
    assert [r.label for r in rivals(search, whole, "linear_drag", 0.0)] == ["rotor_drag"]
    monkeypatch.setattr("infotraj.diagnosis.judge.groups.TELLS", 0.0)
    assert rivals(search, whole, "linear_drag", 0.0) == []


def test_what_is_taken_off_another_axis_is_not_the_same_error():
    takes = np.array([0.0, 0.1, 0.9])
    assert groups._shared(takes, np.array([2.0, 0.0, 0.0])) == 0.0
    assert groups._shared(takes, np.array([0.0, 0.0, 0.6])) == pytest.approx(0.6)
    assert groups._shared(takes, np.array([0.0, 5.0, 0.9])) == pytest.approx(1.0)
    assert groups._shared(np.array([-0.2, 0.0, 0.4]), np.array([0.0, 0.0, 0.4])) == pytest.approx(1.0)


@pytest.mark.parametrize(("inertia", "together"), [(-0.08, True), (0.0, False)])
def test_thrust_and_mass_are_told_apart_as_exactly_as_the_file_has_inertias(inertia, together):
    """Their ratio is one number. A file of which another kind is off as well has no inertia to hold them against."""
    names = ["thrust_scale", "mass_offset", "inertia_error", "moment_scale"]

    def rows(rng, _):
        lift, roll, yaw = rng.normal(0.0, 3.0, (3, ROWS))
        x = np.zeros((ROWS, 5))
        x[:, 1:] = np.transpose([lift + roll + yaw, -lift, -roll - yaw, yaw])
        x[:, 0] = x[:, 1:] @ [-0.2, 0.0, inertia, 1.5 * inertia] + rng.standard_normal(ROWS)
        x[:, 1:] *= [0.15, 0.05, 0.15, 0.3]  # usual sizes
        return x

    _, whole = linear_fit(names, rows, ["thrust_scale"])

    def fitted(labels, like):
        chosen = tuple(names.index(x) for x in labels)
        return replace(like, chosen=chosen, solution=like.linear.scorer(like.scales).solution(chosen))

    whole = fitted(["thrust_scale"], replace(whole, scales=Scales(1.0)))
    search = SimpleNamespace(fitted=fitted, known=(), barred={}, observation=whole.linear.observation)
    found = [r.label for r in rivals(search, whole, "thrust_scale", 0.05)]
    assert found == (["mass_offset"] if together else [])


@pytest.mark.parametrize(("on_path", "first"), [(True, "steady_force"), (False, "accelerometer_bias")])
def test_a_force_that_the_path_does_not_show_comes_after_the_bias_that_may_be_it(monkeypatch, on_path, first):
    monkeypatch.setattr("infotraj.diagnosis.judge.verdicts.shows_on_path", lambda force, bias: on_path)
    names = ["steady_force", "accelerometer_bias"]
    judge, members = as_group(names, [0.999], order=names)
    assert judge._simplest_first(members)[0][0].candidate.name == first


@pytest.mark.parametrize(
    ("labels", "off"),
    [
        (("com_offset", "thrust_scale"), 5.0),
        (("thrust_scale",), 0.0),
        (("com_offset",), 5.0),
    ],
)
def test_moments_are_as_unsure_as_the_mass_where_a_load_has_moved_its_centre(monkeypatch, labels, off):
    """A tenth less thrust over mass: moments that are right to 10 %, five times what they are beside one that is right
    to 1 %."""
    found = [SimpleNamespace(value=float(np.exp(-0.1)))]
    monkeypatch.setattr(groups, "thrust_over_mass", lambda made, named: found)
    assert groups._as_a_load(SimpleNamespace(labels=labels)) == pytest.approx(off)
