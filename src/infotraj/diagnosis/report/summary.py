"""A diagnosis as JSON, as a table for people, and in one sentence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from infotraj.checking.acceptance import accepted_in, accepted_lines
from infotraj.comparing.equation_error import AXES
from infotraj.comparing.summary import errors_by_axis, number
from infotraj.diagnosis.diagnosis import Diagnosis
from infotraj.diagnosis.gates.refusal import axis_group
from infotraj.diagnosis.judge.numbers import OF_THRUST_OVER_MASS, FileNumber, number_in_words
from infotraj.diagnosis.judge.unexplained import Structure
from infotraj.diagnosis.judge.verdicts import Finding
from infotraj.diagnosis.judge.worse import worse_lines
from infotraj.diagnosis.linear.change import Change
from infotraj.diagnosis.report.added_load import added_load
from infotraj.diagnosis.report.reasons import about_takes, axis_in_words, why
from infotraj.diagnosis.report.vehicle_file import ONE_FINDING, by_ratio
from infotraj.diagnosis.select.reading import sparse
from infotraj.effects import Effect, labels_in_words
from infotraj.importing import row_rate

_RARE = 0.01  # s between commands: with more, a delay of half of it cannot be told
_FAR = 3.0  # times the floor: an error that large, on an axis that is judged, is spoken of
_DAYS = "what the healthy flights leave open, or differs from one day to the next"
_MOST = 0.5  # of an axis' error: where numbers of the file take as much, the answer says so first
_FIRST = 3  # numbers of the file, axes or plausible changes that the sentence tells, those that take or leave most
_ORDER = ("Supported", "Not separable", "Plausible", "Not needed", "Not testable here")


def as_dict(found: Diagnosis) -> dict[str, Any]:
    """The JSON of `diagnose` (docs/diagnosis.md); numbers that there are none of are null."""
    return {
        "verdict": {
            "supported": list(found.supported),
            "unexplained": found.unexplained.found,
            **({"unnamed_change": unnamed_change(found)} if found.healthy is not None else {}),
            "summary": sentence(found),
        },
        "effects": [_effect(f, found.healthy_numbers(f), [found.changes(x) for x in f.each]) for f in found.findings],
        "corrected": [{"name": e.name, "parameters": v, "standard_errors": s} for e, v, s in _corrected(found)],
        "reference": _reference(found),
        "load": None if (load := added_load(found)) is None else load.as_dict(),
        "error": errors_by_axis(found.before, found.after),
        "unexplained": [
            {
                "axis": s.axis,
                "rise": number(s.rise),
                "heldout_share": number(s.share),
                "goes_with": [{"quantity": q, "correlation": number(c)} for q, c in s.goes_with],
                "hint": s.hint,
                "hint_heldout_share": number(s.hint_share) if s.hint else None,
            }
            for s in found.unexplained.axes
        ],
        "file": [
            {
                "name": n.name,
                "declared": number(n.declared),
                "value": number(n.value),
                "standard_error": number(n.standard_error),
                "ordinary": n.ordinary,
                "unit": n.unit,
                "of_ratio": part,
                "doubt": n.doubt or None,
            }
            for n, part in by_ratio(found.file)
        ],
        "stays": stays(found),
        "faint": found.faint,
        "refused": {d.about: d.reason for d in found.doubts if d.counts},
        "axes": {
            axis: {
                "judged": axis not in found.refused,
                "reason": found.refused.get(axis),
                "coherence": number(found.coherence[i]),
            }
            for i, axis in enumerate(AXES)
        },
        "warnings": [d.reason for d in found.doubts if not d.refuses and not d.accepted],
        "accepted": found.accepted,
        "at_bound": found.at_bound,
        "commands": {"every": number(_between_commands(found)), "steps": found.command_steps},
        "flights": [
            {
                "path": str(s.flight.meta.get("source", "flight")),
                "rows": len(s.logged.t),
                "left_out": s.left_out,
                "missing": s.reasons,
            }
            for s in found.samples
        ],
    }


def _corrected(found: Diagnosis) -> list[tuple[Effect, dict[str, Any], dict[str, Any]]]:
    """Effects of the model that correct the file beside the named ones: each with its numbers, of which rotor they are
    too, and standard errors."""
    made = zip(found.model.effects, found.errors_of, strict=False)
    places = {p.name for e in found.model.effects for p in e.parameters if p.index}
    return [
        (e, {k: v for k, v in e.values.items() if k in errors or k in places}, errors)
        for e, errors in made
        if e.label in found.beside
    ]


def _together(corrected: Sequence[tuple[Effect, dict[str, Any], dict[str, Any]]]) -> list[str]:
    """A line for each name that corrects the file: its numbers, those of all rotors or arms in their order."""
    by_name: dict[str, list[tuple[Effect, dict[str, Any], dict[str, Any]]]] = {}
    for effect, has, errors in corrected:
        by_name.setdefault(effect.name, []).append((effect, has, errors))
    lines = []
    for unsorted in by_name.values():
        own = sorted(unsorted, key=lambda x: [x[1][k] for k in x[1] if k not in x[2]])
        every = dict.fromkeys(k for _, has, errors in own for k in has if k in errors)
        fitted = {k: " ".join(_short(has.get(k), 3) for _, has, _ in own) for k in every}
        numbers = " ".join(f"{k}={v}" for k, v in fitted.items())
        lines.append(f"{labels_in_words([e.label for e, _, _ in own])} {numbers}")
    return lines


def _reference(found: Diagnosis) -> dict[str, Any] | None:
    """What the flights were held against, and the axes of which the balance over seconds alone was."""
    if found.healthy is None:
        return None
    paths = [str(f.meta.get("source", "flight")) for f in found.healthy.flights]
    return {"flights": paths, "balance_only": sorted(found.search.observation.balance)}


def stays(found: Diagnosis) -> dict[str, float]:
    """Axes that are judged and whose error stays far above the floor, with that error, by axis."""
    after, floor = found.after.rmse, found.after.floor
    far = {a: float(after[i]) for i, a in enumerate(AXES) if np.isfinite(after[i]) and after[i] > _FAR * floor[i]}
    return {a: x for a, x in far.items() if a not in found.refused}


def unnamed_change(found: Diagnosis) -> dict[str, float]:
    """Axes that are judged whose error says that something changed which has no name, with how many times what any
    healthy flight leaves it is, the largest first: it is far above that, and far above the floor or structured.

    What the healthy numbers explain as one day may have them is no such error: of few healthy flights one trim is
    soon three times that of any other."""
    far = {a: x for a, x in _above_healthy(found).items() if not _of_a_day(found, a)}
    return {a: far[a] for a in sorted(far, key=lambda a: -far[a])}


def _above_healthy(found: Diagnosis) -> dict[str, float]:
    """Axes that are judged whose error is far above what any healthy flight leaves, and far above the floor or
    structured, with how many times what a healthy flight leaves it is."""
    if found.healthy is None:
        return {}
    structured = {axis_group(s.axis) for s in found.unexplained.axes} - {None, *found.refused}
    with np.errstate(invalid="ignore", divide="ignore"):
        times = dict(zip(AXES, (found.after.rmse / found.usual).tolist(), strict=True))
    return {a: times[a] for a in AXES if times[a] > _FAR and (a in structured or a in stays(found))}


def _of_a_day(found: Diagnosis, axis: str) -> bool:
    """Whether the healthy numbers explain the error of an axis as the day of these flights may have them."""
    i = AXES.index(axis)
    return bool(found.of_day[i] <= _FAR * found.usual[i])


def _over_floor(found: Diagnosis) -> dict[str, float]:
    """How many times its floor the error of each axis is; 0 where it cannot be said."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return dict(zip(AXES, np.nan_to_num(found.after.rmse / found.after.floor).tolist(), strict=True))


def _mended_by_file(found: Diagnosis) -> dict[str, float]:
    """Axes of whose error numbers of the file take most, with the share that goes.

    A torque of which little goes with the prediction is none: a smaller prediction makes a smaller error.
    """
    if not found.beside or found.healthy is not None:
        return {}
    judged = [
        (a, float(x)) for a, x in zip(AXES, found.by_file, strict=True) if a not in (*found.refused, *found.faint)
    ]
    return {a: share for a, share in judged if share > _MOST}


def sentence(found: Diagnosis) -> str:
    """What was found, in one sentence."""
    parts = [_named(found, found.finding(name)) for name in found.supported]
    unnamed = unnamed_change(found)
    first = _missing(found, parts) if found.healthy is None else _changed_or_not(found, parts, unnamed)
    if not found.judged:
        first = f"These data cannot say which effect is missing: {next(iter(found.refused.values()))}"
    elif found.refused:
        first += "; nothing can be said about " + "; ".join(f"{', '.join(a)}: {r}" for r, a in why(found.refused))
    large = sorted((n for n, part in by_ratio(found.file) if n.large and not part), key=lambda n: -n.takes)
    out_of_line = [_number_of_file(n) for n in large if not n.ordinary]
    if out_of_line and found.judged:
        first += f"; your vehicle file is out of line: {' and '.join(out_of_line)}"
    mended = _mended_by_file(found)
    if mended:
        shares = [round(100.0 * x) for x in mended.values()]
        of = f"{min(shares)} to {max(shares)} %" if min(shares) < max(shares) else f"{shares[0]} %"
        first += "; the numbers of your vehicle file make most of the error: corrected, "
        first += f"{of} of it is gone on {', '.join(mended)}"
        ratio = any(x.split()[0] in (*OF_THRUST_OVER_MASS, "rotor_effectiveness") for x in found.beside)
        corrects = [n for n in large if n.label in found.beside or (n.ratio and ratio)]
        most = [_number_of_file(n) for n in corrects if n.ordinary and mended.keys() & set(n.on)][:_FIRST]
        # What is out of line has been told, and comes first.
        first += f", first of all {' and '.join(most)}" if most and not out_of_line else ""
    left = [s for s in found.unexplained.axes if axis_group(s.axis) not in unnamed]
    as_ever = [s for s in left if s.axis in found.as_ever]
    left = [s for s in left if s not in as_ever]
    structured, unpredicted = [s for s in left if s.predicted], [s for s in left if not s.predicted]
    if structured:
        first += f"; structured error is left on {_largest(found, structured)} that no effect of the catalogue explains"
    if unpredicted:
        first += f"; a large error is left on {_largest(found, unpredicted)} that neither an effect of the catalogue "
        first += "nor the motion explains"
    if as_ever:
        first += f"; error without a name is left on {_largest(found, as_ever)}, no more than on the healthy flights"
    return first + "."


def _named(found: Diagnosis, f: Finding) -> str:
    """A name with what else it may be, and where healthy flights stand beside it by how much its numbers changed."""
    others = [_other(found, n) for n in f.group if n != f.name]
    apart = [f"{'; '.join(f'or {n}' for n in others)}: not separable on these flights"] if others else []
    said = [*([_changed(found, x) for x in f.each] if found.healthy is not None else []), *apart]
    places = sorted(" ".join(str(v[k]) for k in v if k not in f.standard_errors) for v in f.instances)
    every = f" ({' '.join(places)})" if len(places) > 1 and not any(said) else ""
    return f.name + every + (f" ({'; '.join(x for x in said if x)})" if any(said) else "")


def _other(found: Diagnosis, name: str) -> str:
    """What a name may be instead, with its change."""
    change = _changed(found, found.finding(name)) if found.healthy is not None else ""
    return name + (f", {change}" if change else "")


def _missing(found: Diagnosis, parts: Sequence[str]) -> str:
    """What the model lacks of the vehicle, and apart from it what is of the log: its clocks, its sensors' constants."""
    sensors = {c.name for c in found.search.known if c.cls.place == "measurement"} if parts else set()
    of_log = {name for name in found.supported if sensors.issuperset({name, *found.finding(name).group})}
    vehicle = [p for name, p in zip(found.supported, parts, strict=True) if name not in of_log]
    log = [p for name, p in zip(found.supported, parts, strict=True) if name in of_log]
    none = f"No missing effect{' of the vehicle' if log else ''} is supported"
    return (f"Missing: {', '.join(vehicle)}" if vehicle else none) + (f"; in its log: {', '.join(log)}" if log else "")


def _changed_or_not(found: Diagnosis, parts: Sequence[str], unnamed: Mapping[str, float]) -> str:
    """What changed since the healthy flights, with or without a name."""
    plausible = [f for f in found.findings if f.verdict == "Plausible"]
    plausible.sort(key=lambda f: -(f.evidence.rise if f.evidence else 0.0))
    perhaps = [_named(found, f) for f in plausible[:_FIRST]]
    perhaps += [f"{len(plausible) - _FIRST} more"] if len(plausible) > _FIRST else []
    if unnamed:
        (axis, most), *others = unnamed.items()
        times = f"{most:.3g} times what the healthy flights leave on {axis}"
        times += "".join(f", {x:.3g} times on {a}" for a, x in others)
        said = f"changed that has no name here: the error is {times}"
        first = f"Changed: {', '.join(parts)}; something else {said}" if parts else f"Something {said}"
    elif parts:
        first = f"Changed: {', '.join(parts)}"
    elif perhaps:
        first = "No change is sure"
    elif found.unexplained.found and not all(s.axis in found.as_ever for s in found.unexplained.axes):
        first = "No change has a name here"
    else:
        first = "Nothing changed that these flights can tell"
    return first + (f"; plausible: {', '.join(perhaps)}" if perhaps else "")


def _largest(found: Diagnosis, left: Sequence[Structure]) -> str:
    """The axes of what is left whose error is the largest beside its floor, largest first."""
    times = _over_floor(found)
    far = sorted(left, key=lambda s: -times.get(axis_group(s.axis) or "", 0.0))
    return ", ".join(list(dict.fromkeys(axis_in_words(s.axis) for s in far))[:_FIRST])


def _beside_healthy(found: Diagnosis, f: Finding) -> list[str]:
    """What the numbers of an effect are now and on healthy flights, and by how much they changed, a line each."""
    usual = found.healthy_numbers(f)
    if usual is None:
        return []
    said = [f"{k}={_plus_minus(v, usual['standard_errors'][k])}" for k, v in usual["parameters"].items()]
    now = [f"{k}={_short(v)}" for k, v in f.parameters.items() if k in usual["parameters"]]
    differ = [f"{k}={_short(v, 2)}" for k, v in usual["from_flight_to_flight"].items() if v is not None]
    count = len(found.healthy.flights) if found.healthy is not None else 0
    days = f"; {count} healthy flights differ by {' '.join(differ)}" if count > 1 and differ else ""
    changed = [f"changed: {_change(c)}" for c in found.changes(f)]
    return [f"now {' '.join(now)}; healthy {' '.join(said)}", *(f"{c}{days}" for c in changed[:1]), *changed[1:]]


def _changed(found: Diagnosis, f: Finding) -> str:
    """By how much the numbers of an effect changed, and of which rotor; empty where healthy flights do not say."""
    told = found.changes(f)
    of = [f"{k} {v}" for k, v in f.parameters.items() if k not in f.standard_errors]
    return f"{' '.join(of)}{': ' if of else ''}{', '.join(map(_change, told))}" if told else ""


def _change(c: Change) -> str:
    """One change with its standard error, as a factor of the healthy number or a difference from it."""
    if c.times:
        return f"{number_in_words(c.name, c.value, c.standard_error)} times the healthy one"
    return f"{number_in_words(c.name, c.value, c.standard_error, ' by ')} {c.unit}".rstrip()


def _number_of_file(n: FileNumber) -> str:
    return f"{n.name} {_short(n.value)} {n.unit}".strip()


def as_text(found: Diagnosis, *, verbose: bool = False) -> str:
    """The table for people: effects by verdict, then the error by axis, then what is left."""
    rows = sorted(found.findings, key=lambda f: (_ORDER.index(f.verdict), -(f.evidence.rise if f.evidence else 0.0)))
    lines = [f"{'effect':<20}{'verdict':<14}{'rise':>9}{'change':>8}{'95 %':>15}{'better':>7}{'kept':>5}  values"]
    for f in rows:
        quiet = f.verdict in ("Not needed", "Not testable here")
        if quiet and not verbose:
            continue
        # Beside healthy flights an error is that of the change, which stands below.
        lines.append(_row(f, f.standard_errors if found.healthy_numbers(f) is None else {}))
        for k, x in enumerate(f.each if not quiet else ()):
            if k > 0:
                lines.append(f"{'':<20}and {' '.join(f'{key}={_short(v)}' for key, v in x.parameters.items())}")
            lines += [f"{'':<20}{line}" for line in _beside_healthy(found, x)]
        if f.reason:
            lines.append(f"{'':<20}{f.reason}")
    if not verbose:
        of_file = {n.label.split()[0] for n in found.file if n.label and not n.doubt}
        below = [f.name for f in rows if f.verdict == "Not needed" and f.name in of_file]
        if below:
            lines.append(f"Numbers of your vehicle file, below: {', '.join(below)}")
        for verdict in ("Not needed", "Not testable here"):
            names = [f.name for f in rows if f.verdict == verdict and f.name not in below]
            if names:
                lines.append(f"{verdict}: {', '.join(names)}")
    shown = [f for f in rows if verbose or f.verdict not in ("Not needed", "Not testable here")]
    lines += about_takes([f.reason for f in shown])
    lines.append("")
    unit = {"f": "N" if found.model.vehicle.mass else "m/s^2", "t": "N m" if found.model.vehicle.inertia else "rad/s^2"}
    if np.isfinite(found.before.rmse).any():
        lines.append(f"{'error':<10}{'before':>11}{'after':>11}{'floor':>11}")
    else:
        lines.append("error before and after: cannot be said; an accelerometer, a velocity or rates tell it")
    for i, axis in enumerate(AXES):
        if np.isfinite(found.before.rmse[i]):
            values = "".join(f"{v:>11.4g}" for v in (found.before.rmse[i], found.after.rmse[i], found.after.floor[i]))
            lines.append(f"{axis:<10}{values} {unit[axis[0]]}")
    if found.after is not found.before and np.isfinite(found.after.rmse).any():
        lines.append("after: the new model, fitted to all of these flights; floor: that of the new model")
        lines += [x for axis, x in worse_lines(found.before, found.after).items() if axis not in found.refused]
    lines += [
        f"{axis}: only {100 * share:.0f} % of the measured torque, noise left aside, goes with what the model predicts"
        for axis, share in found.faint.items()
        if axis not in found.refused
    ]
    if found.file:
        lines.append("your vehicle file, as these flights have it:")
        for n, part in by_ratio([n for n in found.file if verbose or not n.doubt]):
            number = f"{_short(n.value)} +- {_short(n.standard_error)}{f' {n.unit}' if n.unit else ''}"
            number += f", not {_short(n.declared)}" + ("" if n.ordinary else "; out of line with the rest of the file")
            lines.append(f"    {n.name}: {number} ({ONE_FINDING})" if part else f"  {n.name}: {number}")
        for doubt in dict.fromkeys(n.doubt for n in found.file if n.doubt):
            lines.append(f"  in doubt: {', '.join(n.name for n in found.file if n.doubt == doubt)} ({doubt})")
    load = added_load(found)
    if load is not None:
        lines.append(load.sentence())
    corrects = "the new model corrects the file"
    corrects = f"{corrects}, beside what is named" if found.supported else f"no effect is named; {corrects}"
    corrected = _corrected(found)
    if len(corrected) == 1:
        effect, has, deviations = corrected[0]
        numbers = " ".join(f"{k}={_plus_minus(v, deviations.get(k))}" for k, v in has.items())
        lines.append(f"{corrects}: {effect.name} {numbers}")
    elif corrected:
        lines += [f"{corrects}:", *(f"  {x}" for x in _together(corrected))]
        told = any(verbose or not n.doubt for n in found.file)
        sure = "what your file should say is above" if told else "which of them your file has wrong is not told"
        lines.append(f"corrections predict together; one may stand for another: {sure}")
    explained = {s.axis for s in found.unexplained.axes}
    # Healthy flights have the file's own errors, too.
    cause = "what has no name" if found.healthy is not None else "the file's own errors, or what has no name"
    left, above = stays(found), _above_healthy(found)
    if left and not all(s.prepared.recorded.rotor_commanded for s in found.samples):
        cause = f"noise of the measured rotors, {'or ' if found.healthy is not None else ''}{cause}"
    for axis, error in left.items():
        of_day = axis in above and _of_a_day(found, axis)
        if of_day or (axis not in explained and "v" + axis[1] not in explained):
            unit_of = unit[axis[0]]
            before = float(found.usual[AXES.index(axis)])
            leave = f"; the healthy flights leave at most {before:.3g}" if np.isfinite(before) else ""
            lines.append(f"{error:.3g} {unit_of} of error stay on {axis}: {_DAYS if of_day else cause}{leave}")
    for s in found.unexplained.axes:
        goes = ", ".join(f"{q} ({c:+.2f})" for q, c in s.goes_with)
        goes = f"; it goes with {goes}" if goes else ""
        of = axis_in_words(s.axis)
        share = f"{100 * s.share:.0f} % of the slow error can be predicted{goes}"
        times = float(np.sqrt(max(s.rise, 0.0)))
        far = f"a large, slow error, {times:.3g} times its fast noise, that the motion does not predict"
        lines.append(f"left on {of}: {share if s.predicted else far}")
        if s.hint:
            lines.append(f"  hint, not a result: {s.hint.replace(s.axis, of, 1)} ({100 * s.hint_share:.0f} % held out)")
    every = _between_commands(found)
    if every > found.search.observation.command_step:
        lines.append(f"commands: every {1000 * every:.3g} ms, held over the rows between")
    if found.command_steps > 1:
        lines.append(f"commands: every {1000 * every:.3g} ms, read as {found.command_steps} steps from row to row")
    balance = sorted(found.search.observation.balance) if found.healthy is not None else []
    if balance:
        lines.append(f"{', '.join(balance)}: held against the healthy flights by the balance over seconds alone")
    if found.command_steps > 1 or every > _RARE or any(sparse(s.flight, found.model.vehicle) for s in found.samples):
        lines.append(
            f"a delay or lag below {500 * every:.3g} ms cannot be told from how commands ran between their rows"
        )
    lines += [f"not judged: {axis} ({reason})" for axis, reason in found.refused.items()] if found.judged else []
    lines += [f"warning: {d.reason}" for d in found.doubts if not d.refuses and not d.accepted]
    lines += [f"at a bound: {label}: {how}" for label, how in found.at_bound.items()]
    lines += accepted_lines(accepted_in([s.flight for s in found.samples]))
    lines += [f"accepted {d.code} ({', '.join(d.axes) or d.about}): {d.reason}" for d in found.doubts if d.accepted]
    lines.append(sentence(found))
    return "\n".join(lines) + "\n"


def _between_commands(found: Diagnosis) -> float:
    """s between commands, the longest: between rows that hold them, or between those that an import held over rows."""
    filled = (step for s in found.samples for step in row_rate.held(s.flight.meta, s.flight.t).values())
    return max(found.search.observation.command_step, *filled, 0.0)


def _row(f: Finding, errors: Mapping[str, Any]) -> str:
    if f.evidence is None:
        return f"{f.name:<20}{f.verdict}"
    e = f.evidence
    interval = f"{e.ci95[0]:+.3f} {e.ci95[1]:+.3f}"
    better = f"{e.flights_better[0]}/{e.flights_better[1]}"
    told = {k: v for k, v in f.parameters.items() if v is not None}
    values = " ".join(number_in_words(k, v, errors.get(k), "=") for k, v in told.items())
    if values and e.form_error >= 0.1 and f.verdict not in ("Not needed", "Not testable here"):
        values += f", from place to place by {100 * e.form_error:.0f} %"
    return (
        f"{f.name:<20}{f.verdict:<14}{e.rise:>9.3g}{e.heldout_change:>+8.3f}{interval:>15}{better:>7}"
        f"{e.selected:>5.2f}  {values}"
    )


def _plus_minus(value: Any, error: Any) -> str:
    return _short(value) if error is None else f"{_short(value)} +- {_short(error)}"


def _short(value: Any, digits: int = 4) -> str:
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_short(v, digits) for v in value) + "]"
    return "?" if value is None else f"{value:.{digits}g}"


def _effect(f: Finding, usual: dict[str, Any] | None, changes: Sequence[Sequence[Change]] = ((),)) -> dict[str, Any]:
    """changes: of the finding, and of its other instances."""
    e = f.evidence
    own, *others = [[c.as_dict() for c in some] for some in changes]
    return {
        "name": f.name,
        "verdict": f.verdict,
        "group": list(f.group),
        "heldout_change": number(e.heldout_change) if e else None,
        "ci95": [number(v) for v in e.ci95] if e else None,
        "flights_better": list(e.flights_better) if e else None,
        "selected": number(e.selected) if e else None,
        "rise": number(e.rise) if e else None,
        "probability": number(e.probability) if e else None,
        "form_error": number(e.form_error) if e else None,
        "gain": number(e.gain) if e else None,
        "parameters": f.parameters,
        "standard_errors": f.standard_errors,
        "reason": f.reason or None,
        "of_file": f.of_file,
        **({"reference": usual, "change": own} if usual is not None else {}),
        **({"instances": list(f.instances)} if f.instances else {}),
        **({"other_changes": others} if usual is not None and others else {}),
    }
