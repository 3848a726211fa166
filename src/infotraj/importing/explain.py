"""What was recognised in a log and what is missing, as text for a person."""

from __future__ import annotations

from pathlib import Path

from infotraj.flight import Flight
from infotraj.importing.channels import CHANNELS
from infotraj.importing.leftover import described, grouped, unused, wanting
from infotraj.importing.log import Log
from infotraj.importing.mapping import Mapping
from infotraj.importing.mapping_files import shipped
from infotraj.importing.opening import kind_of, open_log
from infotraj.importing.reading import Streams, table_layout
from infotraj.importing.recognise import fits
from infotraj.importing.streams import plan


def explain(
    flight: Flight, read: Streams | None = None, definitions: tuple[Path, ...] = (), allow_damaged: bool = False
) -> str:
    """An imported flight's origin: mapping, clock, a line a channel, what is derived, what is missing, notes.

    With the streams that it was made of also what the log holds and the table does not use, and why.
    """
    meta = flight.meta
    clock = meta["clock"]
    t = flight.t
    lines = [
        f"{meta['source']}: {meta['kind']}, mapping {meta['mapping']}"
        + (f", with {' '.join(meta['settings'])}" if "settings" in meta else ""),
        f"rows: {len(t)}, {clock['rows']}, t from {t[0]:.3f} to {t[-1]:.3f} s; "
        + (
            f"{clock['gaps']} gaps longer than {clock['gap_longer_than_s']} s, the longest {clock['longest_gap_s']} s"
            if clock["gaps"]
            else "no gaps"
        ),
        "",
    ]
    rows = [("channel", "topic", "fields", "unit", "axes", "Hz", "rule", "rows without")]
    for name, said in meta["channels"].items():
        axes = said.get("expressed_in", said.get("order", ""))
        if "frames" in said:
            axes = f"{axes} ({'/'.join(f if isinstance(f, str) else ' '.join(f) for f in said['frames'])})"
        fields = " ".join(said["fields"])
        rows.append(
            (
                name,
                said["topic"],
                fields if len(fields) <= 44 else fields[:41] + "...",
                said["unit"],
                axes,
                f"{said.get('rate_hz', 0):.1f}",
                said["rule"],
                str(said["rows_without"]),
            )
        )
    width = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines += ["  ".join(cell.ljust(w) for cell, w in zip(row, width, strict=True)).rstrip() for row in rows]
    if meta["derived"]:
        how = sorted(set(meta["derived_how"].values()))
        lines += ["", f"derived: {' '.join(meta['derived'])} ({'; '.join(how)})"]
    missing = missing_channels(flight)
    if missing:
        lines += ["", "missing:"] + [
            f"- {name}: needed for {why}"
            + (f"; {wanting(read, name, definitions, allow_damaged)}" if read is not None else "")
            for name, why in missing.items()
        ]
    left = unused(read, definitions, allow_damaged) if read is not None else {}
    if left:
        lines += ["", "in the log and not used:"] + [f"- {line}" for line in grouped(left)]
    if meta["notes"]:
        lines += ["", "notes:"] + [f"- {note}" for note in meta["notes"]]
    return "\n".join(lines)


def missing_channels(flight: Flight) -> dict[str, str]:
    """Channels that the flight lacks, with what they are needed for; measured rotors only where commands lack too."""
    there = set(flight.meta["channels"])
    columns = set(flight.table.columns)
    has_command = bool(there & {"rotor_command", "commanded_force"})
    optional = {"rotor", "tilt", "tilt_command", "airborne"} | (
        {"rotor_command", "commanded_force", "commanded_torque"} if has_command else set()
    )
    return {
        name: channel.needed_for
        for name, channel in CHANNELS.items()
        if name not in there and name not in optional and not columns & set(channel.columns)
    }


def inventory(path: Path, definitions: tuple[Path, ...] = (), allow_damaged: bool = False) -> str:
    """For a log that no mapping fits: its topics or columns, and the shipped mappings of its kind that do not fit."""
    kind = kind_of(path)
    mappings = [m for m in shipped().values() if kind in m.reads]
    names = frozenset(topic for m in mappings for s in m.streams for topic in (s.topic or ()))
    layout = table_layout(path, mappings) if kind == "table" else None
    mappings = [m for m in mappings if m.table == layout]
    log = open_log(path, kind, names, definitions, allow_damaged, layout)
    try:
        lines = [f"{path}: {kind}"]
        columns = getattr(log, "columns", None)
        if columns is not None:
            lines.append("columns: " + ", ".join(filter(None, columns)))
        else:
            lines += [f"- {t.name}  {t.type}  {'' if t.messages is None else t.messages} messages" for t in log.topics]
            lines += [f"- {t.name}" for t in getattr(log, "others", ())]
        for mapping in mappings:
            if mapping.automatic:
                lines.append(f"mapping {mapping.name} {_verdict(log, mapping)}")
    finally:
        log.close()
    return "\n".join(lines)


def _verdict(log: Log, mapping: Mapping) -> str:
    asked = described(mapping)
    if not fits(log, mapping):
        return f"does not fit; it requires {asked}"
    if not plan(log, mapping).channels:
        return f"has what it requires ({asked}), but finds the columns of no channel"
    return f"fits; it requires {asked}"
