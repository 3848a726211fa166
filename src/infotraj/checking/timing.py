"""The time column: order, duplicates, gaps, jitter, and the unit it is in."""

from __future__ import annotations

import numpy as np
import pandas as pd

from infotraj.checking.finding import Finding, Span, spans_text
from infotraj.checking.settings import command
from infotraj.flight import RATE, VELOCITY, Flight
from infotraj.importing import row_rate
from infotraj.rotations import Array, Mask
from infotraj.terminal import counted

TIME_UNITS = {1e-3: ("milliseconds", "ms"), 1e-6: ("microseconds", "us"), 1e-9: ("nanoseconds", "ns")}
# No multirotor is logged slower than 2 Hz or faster than 20 kHz: outside, the unit is not seconds.
SLOWEST_STEP = 0.5
FASTEST_STEP = 5e-5


def order(table: pd.DataFrame) -> tuple[pd.DataFrame, list[Finding]]:
    """The rows with a finite and strictly increasing time, and findings about those that are left out."""
    t = table["t"].to_numpy(dtype=float)
    findings = []
    finite = np.isfinite(t)
    if not finite.all():
        findings.append(_left_out("time_not_finite", int((~finite).sum()), len(t), "time is not a number", ()))
        table, t = table[finite], t[finite]
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        rows = int((t < np.maximum.accumulate(t)).sum())
        share = rows / len(t)
        spans = tuple((float(t[k + 1]), float(t[k])) for k in back)
        findings.append(
            Finding(
                "time_backwards",
                "reject" if share > 0.01 else "warning",
                f"time runs backwards {len(back)} times, {rows} rows lie before an earlier row "
                f"(first at {t[back[0]]:.4f} s, "
                f"by {t[back[0]] - t[back[0] + 1]:.4f} s)",
                "derivatives, delays and the order of cause and effect are wrong",
                "cut the log where the clock was set, or use the sender's time stamps",
                spans=spans,
                channels=("t",),
                values={"jumps": len(back), "rows": rows},
            )
        )
        keep = t >= np.maximum.accumulate(t)
        table, t = table[keep], t[keep]
    same = np.concatenate([[False], np.diff(t) == 0])
    if same.any():
        findings.append(_left_out("duplicate_times", int(same.sum()), len(t), "time stamps repeat", _at(t[same])))
        table = table[~same]
    return table.reset_index(drop=True), findings


def gaps(flight: Flight, airborne: Mask) -> list[Finding]:
    """Steps longer than five median steps (and 50 ms), counted in flight."""
    t = flight.t
    step = np.diff(t)
    usual = float(np.median(step))
    long = np.flatnonzero((step > max(5 * usual, 0.05)) & airborne[:-1] & airborne[1:])
    if not len(long):
        return []
    spans = tuple((float(t[k]), float(t[k + 1])) for k in long)
    lost = float(step[long].sum())
    share = lost / float(t[-1] - t[0])
    return [
        Finding(
            "gaps",
            "warning" if share > 0.05 else "note",
            f"{counted(len(long), 'gap')} in flight, {lost:.2f} s in all, "
            f"the longest {step[long].max():.2f} s ({spans_text(spans)})",
            "nothing is known there; filters and rollouts must start again after each gap",
            "nothing, gaps are kept as gaps" if share <= 0.05 else "find out what the logger lost",
            spans=spans,
            channels=("t",),
            values={"count": len(long), "seconds": lost, "share": share},
        )
    ]


def jitter(flight: Flight) -> list[Finding]:
    """Steps that vary by more than a quarter of the usual one (central 90 %): stamps of arrival, not of sampling."""
    step = np.diff(flight.t)
    usual = float(np.median(step))
    low, high = np.percentile(step, [5, 95])
    if high - low <= 0.5 * usual:
        return []
    return [
        Finding(
            "jitter",
            "note",
            f"time steps vary between {1000 * low:.2f} and {1000 * high:.2f} ms (5 to 95 %) "
            f"around {1000 * usual:.2f} ms",
            "time stamps look like those of arrival: derivatives are noisy, delays uncertain by as much",
            "use the sender's time stamps where the log has them",
            channels=("t",),
            values={"p05": float(low), "p50": usual, "p95": float(high)},
        )
    ]


def slow_rows(flight: Flight) -> list[Finding]:
    """Rows further apart than motion allows, made from a log that has more of it."""
    lost = row_rate.denser(flight.meta, flight.t)
    if not lost:
        return []
    return [
        Finding(
            "slow_rows",
            "warning",
            row_rate.in_words(lost, flight.t),
            "what moved and what was commanded between the rows is missing",
            f"import the log with {row_rate.rows_option(lost)}",
            channels=("t",),
            values=dict(lost),
        )
    ]


def time_unit(flight: Flight) -> tuple[Flight, list[Finding]]:
    """The flight with its time in seconds, and a finding where the declared time cannot be in seconds."""
    step = float(np.median(np.diff(flight.t)))
    if FASTEST_STEP <= step <= SLOWEST_STEP:
        return flight, []
    fitting = [u for u in TIME_UNITS if 1e-4 <= step * u <= 0.2]
    settings: tuple[str, ...] = ()
    if step > SLOWEST_STEP and fitting:
        factor = fitting[0]
        name, unit = TIME_UNITS[factor]
        settings = (f"time.unit={unit}",)
    elif step < FASTEST_STEP and any(1e-4 <= step / u <= 0.2 for u in TIME_UNITS):
        factor = 1 / next(u for u in TIME_UNITS if 1e-4 <= step / u <= 0.2)
        name = f"units of {factor:g} s"
    else:
        name, factor = "an unknown unit", 1.0
    finding = Finding(
        "time_unit",
        "reject",
        f"rows are {step:.4g} apart: t is in {name}, not in seconds",
        "every derivative and every delay would be wrong",
        command(settings)
        if settings
        else "declare the unit of the time column" + (f" (factor {factor:g})" if factor != 1.0 else ""),
        sure=0.999,
        channels=("t",),
        values={"median_step": step, "factor": factor},
        settings=settings,
    )
    if factor == 1.0:
        return flight, [finding]
    # What was derived by this time is too slow or too fast by the same factor.
    rates = [c for c in (*VELOCITY, *RATE) if c in (flight.meta.get("derived") or ()) and c in flight.table]
    again = flight.table[rates] / factor
    return Flight(flight.table.assign(t=flight.t * factor, **again), dict(flight.meta)), [finding]


def _left_out(code: str, count: int, total: int, what: str, spans: tuple[Span, ...]) -> Finding:
    share = count / total
    return Finding(
        code,
        "warning" if share > 0.01 else "note",
        f"{what} in {count} of {total} rows",
        "these rows are left out",
        "find out why the logger wrote them" if share > 0.01 else "nothing",
        spans=spans,
        channels=("t",),
        values={"count": count, "share": share},
    )


def _at(t: Array) -> tuple[Span, ...]:
    return tuple((float(a), float(a)) for a in t[:100])
