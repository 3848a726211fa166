"""One generator a purpose, all derived from the configuration's one seed."""

from __future__ import annotations

from zlib import crc32

import numpy as np


def generator(base_seed: int, *purpose: str | int) -> np.random.Generator:
    """An independent generator for e.g. (base, "omav_a", 3, "prior flight"): the same purpose, the same numbers."""
    words = [p if isinstance(p, int) else crc32(p.encode()) for p in purpose]
    return np.random.default_rng(np.random.SeedSequence([base_seed, *words]))
