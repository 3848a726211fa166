"""Sums of products that a test has made itself, without spectra."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from infotraj.diagnosis.linear.sums import Sums


def given_sums(gram: np.ndarray, slow: np.ndarray, axes: tuple[str, ...]) -> Sums:
    """Sums of products gram (axes, blocks, 1 + p, 1 + p); every block is a flight of one window, and all of it slow.

    slow (axes, blocks): how many coefficients each block has, with a noise of 1.
    """
    flights = np.arange(gram.shape[1])
    made: Any = SimpleNamespace(
        folds=gram.sum(axis=0),
        gram=gram,
        plain=gram,
        believed=gram,
        slow=slow,
        noise=slow.sum(axis=1),
        windows=np.ones(gram.shape[:2]),
    )
    return Sums(made, axes, flights, flights, np.zeros(gram.shape[-1] - 1))
