"""Short names for the tests of `check`: flights with known conventions, and the corpus's errors put into them."""

import numpy as np

from infotraj.experiment.corpus import injected_errors
from infotraj.experiment.corpus.injected_errors import INJECTED, late
from infotraj.experiment.corpus.kinematic_flights import simulated
from infotraj.experiment.rough.columns import replaced
from infotraj.flight import ATTITUDE, POSITION, RATE, SPECIFIC_FORCE, VELOCITY

P, Q, V, W, A = (list(names) for names in (POSITION, ATTITUDE, VELOCITY, RATE, SPECIFIC_FORCE))
_with, _shift = replaced, late


def named(check):
    """The codes that a check reports as warnings or worse, and, as "or CODE", what it says fits as well."""
    return injected_errors.named(check.findings)


def _spoiler(error):
    return lambda flight: error.spoil(flight, None, np.random.default_rng(0))


# name: (how a flight is spoiled, the codes any of which names the error rightly), for units, frames and clocks
SPOILED = {
    name: (_spoiler(error), (*error.codes, *(f"or {code}" for code in error.codes)))
    for name, error in INJECTED.items()
    if "cmd_rotor_0" not in error.needs and not error.note
}

__all__ = ["SPOILED", "A", "P", "Q", "V", "W", "_shift", "_with", "named", "simulated"]
