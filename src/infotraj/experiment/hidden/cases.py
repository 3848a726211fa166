"""The cases of the hidden-effect study: what is hidden in which run, and in which order the runs are made."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from infotraj.effects import effect_class
from infotraj.experiment.common.patterns import matching
from infotraj.experiment.common.randomness import generator
from infotraj.experiment.hidden.config import HiddenStudy, VehicleStudy
from infotraj.experiment.hidden.logs import UNSEEN_IN_LOGS
from infotraj.vehicle import Vehicle

SIZES = ("small", "usual", "large")
# Parameters that may as well be negative, number by number.
SIGNED = ("dm", "r", "f", "t", "b", "rotvec", "bias", "v", "n")
# Parameters that a plant takes in whole time steps of 1 ms.
IN_STEPS = ("delay", "dt")


@dataclass(frozen=True)
class Case:
    """One combination of hidden physics and circumstances on one vehicle.

    kind: nothing, single, pair, triple, cannot_show, richer, unlisted or curve. effects: (name, size) of the catalogue;
    other: names beyond it. wave: runs of lower waves are made first. file: how wrong the vehicle file is
    (`file_profiles`); log: the profile by which the flights are logged (`hidden_logs`); gusts: whether they
    fly in gusts.
    """

    vehicle: str
    kind: str
    effects: tuple[tuple[str, float], ...] = ()
    other: tuple[str, ...] = ()
    clutter: bool = False
    size: str = ""
    wave: int = 1
    seconds: float | None = None
    noise: float = 1.0
    logging: str = "full"
    curve: str = ""
    voltage: float | None = None
    file: str = "exact"
    log: str = "clean"
    gusts: bool = False

    @property
    def name(self) -> str:
        """Readable and unique: omav/single/linear_drag-usual, omav/pair/a+b~clutter, omav/nothing/nothing~3%."""
        return (
            self.flown
            + (f"~{self.file}" if self.file != "exact" else "")
            + (f"~{self.log}" if self.log != "clean" else "")
        )

    @property
    def flown(self) -> str:
        """The name without what is done after flying: cases that share it fly the same paths with the same values."""
        nothing = "nothing" if self.voltage is None else "nothing.voltage"
        what = "+".join([*(n for n, _ in self.effects), *self.other]) or nothing
        size = f"-{self.size}" if self.size else ""
        curve = f"@{self.curve}" if self.curve else ""
        return (
            f"{self.vehicle}/{self.kind}/{what}{size}{curve}"
            + ("~clutter" if self.clutter else "")
            + ("~gusts" if self.gusts else "")
        )


@dataclass(frozen=True)
class Batch:
    """Some seeds of one case: what one job of each kind works on. `key` tells nothing about the case."""

    case: Case
    seeds: tuple[int, ...]
    key: str = field(default="")

    def __post_init__(self) -> None:
        text = json.dumps([asdict(self.case), self.seeds], sort_keys=True)
        object.__setattr__(self, "key", hashlib.sha256(text.encode()).hexdigest()[:12])


def batches(study: HiddenStudy, only: Sequence[str] = (), seeds: int | None = None) -> list[Batch]:
    """All batches in the order of their waves. only: patterns of case names; seeds: at most so many a case.

    UsageError where a pattern matches no case.
    """
    found = []
    planned = list(_planned(study))
    planned += [more for case, _, _ in planned for more in _circumstances(study, case)]
    wanted = matching((case.name for case, _, _ in planned), only)
    for case, count, first in planned:
        if case.name not in wanted:
            continue
        count = count if seeds is None else min(count, seeds)
        whole = range(first, first + count)
        found += [Batch(case, tuple(whole[k : k + study.batch])) for k in range(0, count, study.batch)]
    return sorted(found, key=lambda b: b.case.wave)


def _planned(study: HiddenStudy) -> Iterator[tuple[Case, int, int]]:
    """Each case with its number of seeds and the first of them."""
    runs = study.runs
    for name, vehicle in study.vehicles.items():
        both = (("", runs.nothing, 0), ("c", runs.nothing_clutter, 1000))
        # a vehicle without effects of its own is there for its richer physics
        for flag, count, first in both if vehicle.effects else ():
            yield Case(name, "nothing", clutter=bool(flag)), count, first
        if vehicle.voltage is not None:
            yield Case(name, "nothing", voltage=vehicle.voltage), runs.nothing_voltage, 0
        for effect, settings in vehicle.effects.items():
            one = Case(name, "single", voltage=settings.voltage)
            for size, multiple in zip(SIZES, settings.sizes, strict=True) if settings.alone else ():
                case = replace(one, effects=((effect, multiple),), size=size)
                if size == "usual":
                    yield case, runs.single, 0
                    yield replace(case, clutter=True), runs.single_clutter, 1000
                else:
                    yield replace(case, wave=3), runs.other_size, 0
        for kind, lists in (("pair", vehicle.pairs), ("triple", vehicle.triples)):
            for members in lists:
                volts = next((v for m in members if (v := vehicle.effects[m].voltage)), None)
                case = Case(name, kind, tuple((m, 1.0) for m in members), voltage=volts)
                yield case, runs.several, 0
                yield replace(case, clutter=True), runs.several_clutter, 1000
        for effect in vehicle.cannot_show:
            yield Case(name, "cannot_show", ((effect, 1.0),), wave=3), runs.cannot_show, 0
        for other, near in vehicle.richer.items():
            yield Case(name, "richer", other=(other,), voltage=near.voltage, wave=2), runs.richer, 0
        for other in vehicle.unlisted:
            yield Case(name, "unlisted", other=(other,), wave=2), runs.unlisted, 0
        yield from _curves(study, name)


def _circumstances(study: HiddenStudy, case: Case) -> Iterator[tuple[Case, int, int]]:
    """A clean case (nothing, a single at usual size, a pair, a triple) with wrong files and rough logs, the first two
    also in gusts."""
    kind = {"pair": "several", "triple": "several"}.get(case.kind, case.kind)
    if case.clutter or kind not in ("nothing", "single", "several") or case.size not in ("", "usual"):
        return
    if kind == "nothing" and case.voltage is not None:
        return
    c, runs = study.circumstances, study.runs
    if kind != "several":
        yield replace(case, gusts=True, wave=2), getattr(runs, f"{kind}_gusts"), 0
    for level in c.files:
        yield replace(case, file=level, wave=2), getattr(runs, f"{kind}_file"), 0
    for log in c.logs:
        if not {plain(n) for n, _ in case.effects} & UNSEEN_IN_LOGS.get(log, frozenset()):
            yield replace(case, log=log, wave=2), getattr(runs, f"{kind}_log"), 0


def _curves(study: HiddenStudy, vehicle: str) -> Iterator[tuple[Case, int, int]]:
    c = study.curves
    for effect in c.effects.get(vehicle, ()):
        one = Case(vehicle, "curve", ((effect, 1.0),), wave=4, voltage=study.vehicles[vehicle].effects[effect].voltage)
        cases = [replace(one, effects=((effect, m),), curve=f"size={m:g}") for m in c.sizes]
        cases += [replace(one, seconds=s, curve=f"seconds={s:g}") for s in c.seconds]
        cases += [replace(one, noise=n, curve=f"noise={n:g}") for n in c.noise]
        cases += [replace(one, logging=k, curve=f"logging={k}") for k in c.logging]
        yield from ((case, study.runs.curve, 0) for case in cases)


def hidden_values(
    case: Case, seed: int, study: HiddenStudy, vehicle: Vehicle
) -> tuple[list[tuple[str, dict[str, Any]]], list[tuple[str, dict[str, Any]]]]:
    """What is hidden in one run: catalogue effects and other physics, each a list of names and parameters."""
    settings = study.vehicles[case.vehicle]
    rng = generator(study.base_seed, "hidden values", case.vehicle, *[n for n, _ in case.effects], seed)
    named = [(n, _drawn(n, m, settings, vehicle, study.vary, rng)) for n, m in case.effects]
    other = [(n, dict(_other(settings, n))) for n in case.other]
    return [(plain(n), values) for n, values in named], other


def plain(name: str) -> str:
    """The public name of a study's effect: `battery_sag.voltage` is battery_sag in another form."""
    return name.split(".")[0]


def _other(settings: VehicleStudy, name: str) -> dict[str, Any]:
    return settings.richer[name].parameters if name in settings.richer else settings.unlisted[name]


def _drawn(
    name: str, multiple: float, settings: VehicleStudy, vehicle: Vehicle, vary: float, rng: np.random.Generator
) -> dict[str, Any]:
    """Parameters: absent + multiple x (usual - absent), each number a little different from seed to seed."""
    usual = settings.effects[name].parameters if name in settings.effects else settings.cannot_show[name]
    cls = effect_class(plain(name))
    out: dict[str, Any] = {}
    for p in cls.parameters:
        if p.name not in usual:
            continue
        if p.index:
            out[p.name] = int(rng.integers(len(vehicle.rotors)))
            continue
        absent = cls.absent(vehicle, p)
        change = np.asarray(usual[p.name], dtype=float) - absent
        value = absent + multiple * change * rng.uniform(1 - vary, 1 + vary, change.shape)
        if p.name in SIGNED:
            value = value * rng.choice([-1.0, 1.0], change.shape)
        if p.name in IN_STEPS:
            value = np.maximum(np.round(value, 3), 1e-3)
        out[p.name] = float(value[0]) if p.size == 1 else [float(v) for v in value]
    return out
