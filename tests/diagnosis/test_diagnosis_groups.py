"""Which effects may stand in another's place: odds below twenty to one, tempered by how much the data scatter."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import AS_PROBABLE, rivals
from infotraj.diagnosis.linear.candidates import Candidate, places
from infotraj.diagnosis.linear.observation import Member
from infotraj.diagnosis.linear.sums import Sums
from infotraj.diagnosis.select.around import Column, Linear
from infotraj.diagnosis.select.prior import Scales
from infotraj.diagnosis.select.score import Choice
from infotraj.diagnosis.select.search import Fit
from infotraj.effects import catalogue
from infotraj.vehicle import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[2] / "config/vehicles/quadrotor.yaml")
BLOCKS, ROWS = 40, 50


def two_alike(scatter):
    """A fit of linear_drag on one axis, and quadratic_drag, whose column is nearly the same. scatter: of its number."""
    rng = np.random.default_rng(1)
    names = ("linear_drag", "quadratic_drag")
    candidates = [Candidate(catalogue()[n], tuple(p for p in catalogue()[n].parameters if not p.index)) for n in names]
    gram = np.zeros((1, BLOCKS, 3, 3))
    for k in range(BLOCKS):
        # Sizes scatter between blocks about a mean that is the same for both cases.
        size = 0.3 + scatter * (1.0 if k % 2 else -1.0)
        x = np.zeros((ROWS, 3))
        x[:, 1] = rng.standard_normal(ROWS)
        x[:, 2] = 0.97 * x[:, 1] + np.sqrt(1.0 - 0.97**2) * rng.standard_normal(ROWS)
        x[:, 0] = size * x[:, 1] + rng.standard_normal(ROWS)
        gram[0, k] = x.T @ x
    number = np.arange(BLOCKS)
    many = np.full((1, BLOCKS), float(ROWS))
    sums = Sums(gram, gram, gram, many, np.ones((1, BLOCKS)), ("fx",), number, number)
    columns = tuple(Column(c, 0, places(c, VEHICLE)[0].scale, 0.0, -np.inf, np.inf) for c in candidates)
    observation = SimpleNamespace(
        vehicle=VEHICLE, command_step=0.005, healthy=None, scatter={}, base=lambda c: c.absent(VEHICLE)
    )
    point = tuple(Member(c, c.absent(VEHICLE)) for c in candidates)
    choices = tuple(Choice(n, (k,), 3.0) for k, n in enumerate(names))
    linear = Linear(observation, point, columns, choices, (None,), (), None, sums)
    scales = Scales(0.0)
    scorer = linear.scorer(scales)

    def fitted(labels, like):
        chosen = tuple(names.index(x) for x in labels)
        return Fit(linear, chosen, scales, scorer.solution(chosen))

    return SimpleNamespace(fitted=fitted), fitted(["linear_drag"], None)


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
