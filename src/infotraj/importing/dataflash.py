"""ArduPilot DataFlash logs: topics are messages, with what the parameters say about motors.

Decoded here, column by column, because pymavlink's reader carries the GPL in its head and takes a Python object a
message. Body axes are forward, right, down; the world is north, east, down.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from infotraj.importing.log import Request, Samples, Topic, reading
from infotraj.rotations import Array

_EXPECTED = "an ArduPilot DataFlash log (.BIN, or .log as text)"
_REMEDY = "Download it again from the vehicle."
# SERVOn_FUNCTION: motors 1 to 8, and 9 to 12.
_MOTORS = {**{33 + k: k for k in range(8)}, **{82 + k: 8 + k for k in range(4)}}
_TRICOPTER = (0, 1, 3)  # ArduPilot's tricopters have motors 1, 2 and 4, and the tail's servo as motor 7
_TRI_CLASS, _TRI_TAIL = 7, 39
_TILTS = (41, 45, 46, 47, 75, 76)  # outputs that tilt rotors: all of them, those at the back, one on either side
_INSTANCE = ("I", "C", "Instance", "Inst")
_CHANNELS = 32


class DataFlashLog:
    """One log.

    A message that comes several times over (two IMUs, two estimators) is a topic a number, by the column that the log
    (FMTU) or ArduPilot's habit names. Two topics are made up: `motors` is RCOU with `throttle[k]`, the outputs that the
    parameters give to motor k (SERVOn_FUNCTION 33 to 40), scaled from MOT_PWM_MIN to MOT_PWM_MAX; `rotors` is ESC
    telemetry with `rpm[k]` of motor k.
    """

    kind = "dataflash"

    def __init__(self, path: Path, allow_damaged: bool = False) -> None:
        self.path, self.notes = path, []
        with reading(path, _EXPECTED, _REMEDY):
            from infotraj.importing.dataflash_messages import HEAD, read_binary, read_text

            data = path.read_bytes()
            is_binary = data.startswith(HEAD)
            log = read_binary(data) if is_binary else read_text(data.decode("utf-8", "replace"))
            self._tables: dict[tuple[str, int], dict[str, Any]] = {}
            for name, columns in log.columns.items():
                if "TimeUS" not in columns and "TimeMS" in columns:
                    columns["TimeUS"] = (np.nan_to_num(columns["TimeMS"]) * 1000.0).astype(np.int64)
                if len(columns.get("TimeUS", ())):
                    self._split(name, columns, _instance_column(log, name, columns))
            self.parameters = dict(
                zip(log.text("PARM", "Name"), log.columns.get("PARM", {}).get("Value", ()), strict=False)
            )
            self._add_motors()
            self._add_rotors()
        if log.skipped:
            self.notes.append(
                f"{log.skipped} {'bytes' if is_binary else 'lines'} belong to no message and are left out"
            )
        self.topics = [
            Topic(name, name, instance, len(columns["TimeUS"]))
            for (name, instance), columns in sorted(self._tables.items())
        ]

    def close(self) -> None:
        """Nothing is held open."""

    def has(self, topic: Topic, name: str) -> bool:
        """True where the message has the column, and it holds numbers."""
        column = self._tables[topic.name, topic.instance].get(name.replace("*", "0"))
        return column is not None and column.dtype.kind != "S"

    def first(self, topic: Topic, name: str) -> Any:
        """The column in the first message."""
        column = self._tables[topic.name, topic.instance].get(name)
        if column is None or not len(column):
            return None
        value = column[0].item()
        return value.decode("utf-8", "replace") if isinstance(value, bytes) else value

    @np.errstate(invalid="ignore")  # damaged bytes may spell a signalling NaN
    def read(self, requests: list[Request]) -> list[Samples]:
        """The asked columns as doubles."""
        found = []
        for request in requests:
            table = self._tables[request.topic.name, request.topic.instance]
            numbers: dict[str, Array] = {}
            for name in request.numbers:
                if "*" not in name:
                    numbers[name] = table[name].astype(float)
                    continue
                group: list[Array] = []
                while name.replace("*", str(len(group))) in table:
                    group.append(table[name.replace("*", str(len(group)))].astype(float))
                numbers[name] = np.stack(group, axis=-1)
            found.append(Samples(None, {t: _whole(table[t]) for t in request.times}, numbers))
        return found

    def _split(self, name: str, columns: dict[str, Any], by: str | None) -> None:
        if by is None or columns[by].dtype.kind not in "iuf":
            self._tables[name, 0] = columns
            return
        for value in np.unique(columns[by]):
            if np.isfinite(value):
                rows = columns[by] == value
                self._tables[name, int(value)] = {c: v[rows] for c, v in columns.items()}

    def _functions(self) -> dict[int, int]:
        """Output channel, from 0: what the parameters say that it drives."""
        said = {k: self.parameters.get(f"SERVO{k + 1}_FUNCTION") for k in range(_CHANNELS)}
        return {k: int(function) for k, function in said.items() if function is not None and np.isfinite(function)}

    def _motors(self) -> dict[int, int]:
        """Number of the motor, as ArduPilot counts, from 0: output channel."""
        found: dict[int, int] = {}
        for channel, function in self._functions().items():
            if function in _MOTORS and not (self._tricopter and function == _TRI_TAIL):
                found.setdefault(_MOTORS[function], channel)
        return found

    @property
    def _tricopter(self) -> bool:
        """Whether the log's parameters say so: of a plane's lifting rotors, else of the frame."""
        frame = self.parameters.get("Q_FRAME_CLASS", self.parameters.get("FRAME_CLASS"))
        return frame is not None and int(frame) == _TRI_CLASS

    def _note_tricopter_and_tilts(self) -> None:
        if self._tricopter:
            self.notes.append("motors 1, 2 and 4 of a tricopter are read as rotors 0, 1 and 2")
        turned = (*_TILTS, _TRI_TAIL) if self._tricopter else _TILTS
        tilts = [str(k + 1) for k, function in self._functions().items() if function in turned]
        if tilts:
            self.notes.append(
                f"outputs {', '.join(tilts)} tilt rotors (SERVOn_FUNCTION): no angle of theirs is in the log; forces "
                "along the body, and the torque about z, are predicted wrong where rotors are tilted"
            )

    def _outputs(self) -> tuple[dict[int, int], str]:
        """Motor number: output channel, both from 0; or none, and why the motors' numbers are not known."""
        found = self._motors()
        if not found:
            return {}, "no parameters SERVOn_FUNCTION in the log that say which outputs are motors"
        if self._tricopter and tuple(sorted(found)) == _TRICOPTER:
            return {k: found[motor] for k, motor in enumerate(_TRICOPTER)}, ""
        missing = [str(k + 1) for k in range(max(found)) if k not in found]
        if missing:
            has = ", ".join(str(k + 1) for k in sorted(found))
            return {}, f"SERVOn_FUNCTION gives outputs to motors {has}, but none to motor {', '.join(missing)}"
        return {k: found[k] for k in sorted(found)}, ""

    def _add_motors(self) -> None:
        first = self._tables.get(("RCOU", 0))
        if first is None:
            return
        outputs, why_not = self._outputs()
        if why_not:
            self.notes.append(f"RCOU not used: {why_not}")
            return
        self._note_tricopter_and_tilts()
        low, high = self._pulses()
        pulses = {int(c[1:]) - 1: v for c, v in first.items() if c[:1] == "C" and c[1:].isdigit()}
        if all(channel in pulses for channel in outputs.values()):
            table = {"TimeUS": first["TimeUS"]}
            for motor, channel in outputs.items():
                # 0 is no pulse: the output is off
                pulse = pulses[channel].astype(float)
                table[f"throttle[{motor}]"] = np.where(pulse > 0, (pulse - low) / (high - low), 0.0)
            self._tables["motors", 0] = table

    def _pulses(self) -> tuple[float, float]:
        """us at no and at full throttle; where they are 0, older firmware takes those of the pilot's throttle."""
        for least, most in (("Q_M_PWM_MIN", "Q_M_PWM_MAX"), ("MOT_PWM_MIN", "MOT_PWM_MAX"), ("RC3_MIN", "RC3_MAX")):
            low, high = (float(self.parameters.get(name, 0.0)) for name in (least, most))
            if 500.0 <= low < high <= 2500.0:
                return low, high
        return 1000.0, 2000.0

    def _add_rotors(self) -> None:
        speeds = {k: t for (name, k), t in self._tables.items() if name == "ESC" and "RPM" in t}
        if not speeds:  # before ArduPilot 4.1: a message an ESC
            speeds = {
                int(name[3:]) - 1: t
                for (name, _), t in self._tables.items()
                if name[:3] == "ESC" and name[3:].isdigit() and "RPM" in t
            }
        speeds = {k: t for k, t in speeds.items() if len(t["TimeUS"])}
        if not speeds:
            return
        outputs, why_not = self._outputs()
        if why_not:  # an ESC is numbered by its output
            self.notes.append(f"ESC not used: {why_not}")
            return
        if not all(channel in speeds for channel in outputs.values()):
            self.notes.append("ESC not used: its numbers are not those of the motors' outputs")
            return
        clock = speeds[outputs[0]]["TimeUS"]
        table: dict[str, Any] = {"TimeUS": clock}
        for motor, channel in outputs.items():
            table[f"rpm[{motor}]"] = _nearest(clock, speeds[channel]["TimeUS"], speeds[channel]["RPM"].astype(float))
        self._tables["rotors", 0] = table


def _instance_column(log: Any, name: str, columns: dict[str, Any]) -> str | None:
    units = dict(zip(log.columns.get("FMTU", {}).get("FmtType", ()), log.text("FMTU", "UnitIds"), strict=False))
    for kind, ids in units.items():
        if log.kinds.get(int(kind)) == name and "#" in ids and ids.index("#") < len(columns):
            return list(columns)[ids.index("#")]
    return next((c for c in _INSTANCE if c in columns and name not in ("PARM", "EV", "MODE")), None)


def _nearest(clock: Any, t: Any, values: Array) -> Array:
    """The sample nearest in time, where it is no further away than half the clock's period; else NaN."""
    right = np.clip(np.searchsorted(t, clock), 1, max(len(t) - 1, 1))
    nearest = np.where(clock - t[right - 1] <= t[np.minimum(right, len(t) - 1)] - clock, right - 1, right)
    nearest = np.minimum(nearest, len(t) - 1)
    period = float(np.median(np.diff(clock))) if len(clock) > 1 else 0.0
    return np.where(np.abs(t[nearest] - clock) <= 0.5 * period, values[nearest], np.nan)


def _whole(times: Any) -> Any:
    return times if times.dtype == np.int64 else np.nan_to_num(times).astype(np.int64)
