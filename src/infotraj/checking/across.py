"""What several logs say together: a lag that differs from flight to flight, the widest coverage."""

from __future__ import annotations

import numpy as np
from scipy import special

from infotraj.checking.finding import Finding
from infotraj.checking.whole import Check

# The smallest actuation delay that the catalogue of effects calls usual: lags that differ by less hide none.
LEAST_RANGE = 0.005


def lags_across(checks: list[Check]) -> list[Finding]:
    """Lags that are not the same in all logs: Cochran's Q with p < 1e-4 and a spread (10 to 90 %) above LEAST_RANGE.

    One log alone may not know its lag well enough; together they show that no single shift serves all of them. Lags of
    streams beside the table (`stream.channel`) make a note, those of the table's own a warning.
    """
    found = []
    for name in sorted({n for c in checks for n in c.lags}):
        known = np.array([c.lags[name] for c in checks if name in c.lags])
        if len(known) < 3:
            continue
        # an error below half a millisecond is not believed: time stamps are not that good
        lag, error = known[:, 0], np.maximum(known[:, 1], 5e-4)
        q = float((((lag - np.average(lag, weights=error**-2)) / error) ** 2).sum())
        p = float(special.chdtrc(len(lag) - 1, q))  # that chi-square is larger
        low, high = np.percentile(lag, [10, 90])
        if p > 1e-4 or high - low < LEAST_RANGE:
            continue
        beside = "." in name
        what = f"stream {name} (not in the table)" if beside else f"the {name}"
        found.append(
            Finding(
                "clock_varies_between_logs",
                "note" if beside or name == "force" else "warning",
                f"the lag of {what} differs between logs: {1000 * lag.min():.0f} to {1000 * lag.max():.0f} ms "
                f"over {len(lag)} logs",
                "no single shift puts the streams of all logs on one clock",
                "take the quantity from another stream, or find each log's own lag",
                sure=1 - p,
                values={"lags": lag.tolist(), "standard_errors": error.tolist()},
            )
        )
    return found
