"""Numbers as people read them: digits that mean something, units, prefixes, errors."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

_PREFIXES = (("", 1.0), ("m", 1e3), ("µ", 1e6))


def numbers(row: dict[str, Any], about: dict[str, Any], key: str = "parameters") -> list[str]:
    """The numbers of an effect with errors and units, a line each. Beside healthy ones the errors of a row are those of
    the changes (`changes`)."""
    values = row[key] if key == "parameters" else row[key]["parameters"]
    own = {} if row.get("change") else row["standard_errors"]
    errors = own if key == "parameters" else row[key]["standard_errors"]
    units = about.get("units", {})
    lines = []
    for name, value in values.items():
        if value is None:
            continue
        if name in about.get("index", ()):
            lines.append(f"{name} {value} (counted from 0)")
            continue
        unit = plain_unit(units.get(name, ""))
        lines.append(f"{name} {_with_error(value, errors.get(name))}{' ' + unit if unit and unit != '-' else ''}")
    return lines


def changes(row: dict[str, Any]) -> list[str]:
    """By how much the numbers of an effect, and of its other instances, differ from the healthy ones, with errors and
    units, a line each."""
    own, others = _changes(row.get("change", ())), row.get("other_changes", ())
    if not others:
        return own
    each = [row["parameters"], *(values for values in row["instances"] if values != row["parameters"])]
    places = [", ".join(f"{k} {v}" for k, v in x.items() if k not in row["standard_errors"]) for x in each]
    told = zip(places, (own, *map(_changes, others)), strict=True)
    return [f"{place}: {line}" for place, lines in told for line in lines]


def _changes(change: Sequence[dict[str, Any]]) -> list[str]:
    lines = []
    for c in change:
        if "times_healthy" in c:
            lines.append(f"{c['name']} {_with_error(c['times_healthy'], c['standard_error'])} times the healthy one")
        else:
            number = _with_error(c["difference"], c["standard_error"])
            lines.append(f"{c['name']} by {number} {plain_unit(c['unit'] or '')}".rstrip())
    return lines


def _with_error(value: Any, error: Any) -> str:
    if isinstance(value, list):
        errors = error if isinstance(error, list) else [None] * len(value)
        return "(" + ", ".join(_with_error(v, e) for v, e in zip(value, errors, strict=True)) + ")"
    if isinstance(value, int) or error is None:
        return significant(value, 4)
    if not error > 0:
        return significant(value, 4)
    # As many digits as the error deserves: two of it.
    places = 1 - math.floor(math.log10(error))
    if not -3 < places < 7:
        return f"{value:.4g} ± {error:.2g}"
    return f"{value:.{max(places, 0)}f} ± {error:.{max(places, 0)}f}"


def prefixed(unit: str, largest: float) -> tuple[float, str]:
    """What values up to `largest` are multiplied by to be shown in the unit that is given with it."""
    options = _PREFIXES if unit.startswith("N") else _PREFIXES[:1]
    prefix, factor = next((o for o in options if largest * o[1] >= 1.0), options[-1])
    return factor, prefix + plain_unit(unit)


def measure(value: float | None, unit: str) -> str:
    """A number with its unit, prefixed."""
    if value is None:
        return "–"
    factor, name = prefixed(unit, abs(value))
    return f"{significant(factor * value)}\u00a0{name}"


def significant(value: float | None, digits: int = 3) -> str:
    """A number with so many digits; a dash for none."""
    if value is None:
        return "–"
    text = f"{value:.{digits}g}"
    if "e" not in text:
        return text.replace("-", "−")
    mantissa, _, power = text.partition("e")
    return f"{mantissa} × 10{str(int(power)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}".replace("-", "−")


def signed(value: float | None, digits: int = 3) -> str:
    """The same with its sign."""
    return "–" if value is None else ("+" if value > 0 else "") + significant(value, digits)


def percent(value: float | None) -> str:
    """A share in per cent."""
    return "–" if value is None else f"{100 * value:.0f}\u00a0%".replace("-", "−")


def change(value: float | None) -> str:
    """A relative change in per cent, with the digits that a change to nearly nothing needs."""
    if value is None:
        return "–"
    left = 1.0 + value
    digits = int(abs(value) < 0.1)
    if left < 0.1:
        digits = 4 if left <= 1e-6 else max(0, min(4, -math.floor(math.log10(100 * left))))
    return f"{100 * value:+.{digits}f}\u00a0%".replace("-", "−")


def interval(ends: Sequence[float | None], value: float | None) -> str:
    """The 95 % interval of a relative change; in words where all of it is the value, to the digits shown."""
    low, high = map(change, ends)
    return "the same over the 95 % interval" if low == high == change(value) else f"95 % interval {low} to {high}"


def minus(text: str) -> str:
    """A sentence with the signs of its numbers as signs."""
    return re.sub(r"(?<![\w.)-])-(?=\d)", "−", text)


def plain_unit(unit: str) -> str:
    """A unit as people read it."""
    return unit.replace("^2", "²").replace("^3", "³")
