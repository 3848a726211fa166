"""The text that heads each log in a blackbox file: `H name:value` lines, and from them how its frames are coded."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

MAGIC = b"H Product:Blackbox"
# Motor protocols from here on are digital and log 48..2047 (Betaflight's `fast_pwm_protocol`).
_FIRST_DIGITAL = 5
_MOST_FIELDS = 512


@dataclass(frozen=True)
class Header:
    """One log's header: its lines, and the coding (3, n) of predictor, encoding and sign of each kind of frame."""

    values: dict[str, str]
    names: dict[str, tuple[str, ...]]
    coding: dict[str, Any]

    def number(self, name: str, default: float = 0.0, part: int = 0) -> float:
        """A number, or one of several with commas; `default` where the header has none."""
        parts = self.values.get(name, "").split(",")
        try:
            found = int(parts[part], 0) if part < len(parts) else default
        except ValueError:
            return default
        return float(found) if abs(found) < 2**32 else default

    @property
    def firmware(self) -> tuple[str, tuple[int, ...]]:
        """('Betaflight', (4, 2, 11)), from the revision that the firmware names."""
        words = self.values.get("Firmware revision", "").split()
        version = words[1].split("-")[0].split(".") if len(words) > 1 else []
        return (words[0] if words else ""), tuple(int(v) for v in version if v.isascii() and v.isdigit())

    @property
    def gyro_unit(self) -> float | None:
        """deg/s that one count of gyroADC stands for; None where the header does not say."""
        text = self.values.get("gyro_scale", self.values.get("gyro.scale", ""))
        try:
            scale = struct.unpack("<f", struct.pack("<I", int(text, 16)))[0]
        except (ValueError, struct.error):
            return None
        if not np.isfinite(scale) or scale <= 0:
            return None
        # Baseflight wrote rad/us, all later firmware deg/s.
        factor = np.degrees(1e6) if self.values.get("Firmware type", "") in ("", "Baseflight") else 1.0
        return float(scale * factor / (10.0 if self.number("blackbox_high_resolution") else 1.0))

    @property
    def digital_motors(self) -> bool:
        """True where motor[] counts 48..2047 (DShot, ProShot), not pulses of 1000..2000 us."""
        top = self.number("motorOutput", part=1)
        if top:
            return top > 2000.0 or self.number("motorOutput") < 500.0
        name = "fast_pwm_protocol" if "fast_pwm_protocol" in self.values else "motor_pwm_protocol"
        return self.firmware[0] == "Betaflight" and self.number(name) >= _FIRST_DIGITAL

    @property
    def battery_unit(self) -> float | None:
        """V that one count of vbatLatest stands for; None for firmware whose unit is not known."""
        name, version = self.firmware
        if name == "Betaflight" and version >= (4,):
            return 0.01
        if (name == "Betaflight" and version >= (3, 1)) or (name == "Cleanflight" and version >= (2,)):
            return 0.1
        scale = self.number("vbat_scale", self.number("vbatscale"))
        return 3.3 * scale / 4095.0 if name in ("Betaflight", "Cleanflight") and scale else None


def parse_header(data: bytes) -> tuple[Header, int]:
    """The header at the start of `data`, and where its frames begin. ValueError where no frame can be decoded by it."""
    place, values, lists = 0, {}, {}
    while data[place : place + 2] == b"H ":
        end = data.find(b"\n", place, place + 4096)
        if end < 0:
            raise ValueError("a header line has no end")
        name, _, value = data[place + 2 : end].decode("utf-8", "replace").strip("\r").partition(":")
        if name.startswith("Field "):
            lists[name] = tuple(value.split(","))
        else:
            values[name] = value
        place = end + 1
    names = {kind: lists.get(f"Field {kind} name", ()) for kind in "ISGH"}
    names["P"] = names["I"]
    coding = {kind: _coding(lists, kind, len(names[kind])) for kind in "IPSGH"}
    if names["I"][:2] != ("loopIteration", "time"):
        raise ValueError("its header names no loopIteration and time")
    return Header(values, names, coding), place


def _coding(lists: dict[str, tuple[str, ...]], kind: str, count: int) -> Any:
    rows = []
    for what in ("predictor", "encoding", "signed"):
        # difference frames (P) hold the same fields as complete ones and do not repeat their signs
        given = lists.get(f"Field {kind} {what}", lists.get("Field I signed", ()) if what == "signed" else ())
        if len(given) < count and not (what == "signed" and not given):
            raise ValueError(f"its header lists {len(given)} of {count} {what}s of {kind} frames")
        if any(not (g.strip().isascii() and g.strip().isdigit() and int(g) < 256) for g in given[:count]):
            raise ValueError(f"its header has a {what} of {kind} frames that is no number")
        rows.append([int(g) for g in given[:count]] or [0] * count)
    if count > _MOST_FIELDS:
        raise ValueError(f"its header names {count} fields")
    return np.array(rows, dtype=np.int64).reshape(3, count)
