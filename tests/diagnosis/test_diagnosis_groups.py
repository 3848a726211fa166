"""Which effects may stand in another's place: odds below twenty to one, tempered by how much the data scatter."""

import numpy as np
from linear_fits import ROWS, linear_fit

from infotraj.diagnosis.judge.evidence import overdispersion
from infotraj.diagnosis.judge.groups import AS_PROBABLE, rivals


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
