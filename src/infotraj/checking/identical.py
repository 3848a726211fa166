"""Copies among the given logs: the same bytes, or the same numbers in another format."""

from __future__ import annotations

import hashlib

import numpy as np

from infotraj.checking.finding import Finding
from infotraj.flight import Flight


def content_hash(flight: Flight) -> str:
    """sha256 of the table's numbers, columns in order of their names, in single precision (formats round)."""
    digest = hashlib.sha256()
    for column in sorted(flight.table.columns):
        digest.update(column.encode())
        x = flight.get(column)[:, 0]
        digest.update(
            np.where(np.isfinite(x), x - (x[0] if column == "t" else 0.0), -1e30).astype(np.float32).tobytes()
        )
    return digest.hexdigest()


def own_reference(original: str) -> Finding:
    """The finding for a healthy flight that is, under another name, one of those in question."""
    return Finding(
        "own_reference",
        "reject",
        f"holds the same numbers as {original}, which is asked about",
        "nothing changes between a flight and itself",
        "leave one of them out",
        values={"original": original},
    )


def copy_finding(original: str, same_bytes: bool) -> Finding:
    """The finding for the later of two equal logs."""
    how = "byte-identical to" if same_bytes else "holds the same numbers as"
    return Finding(
        "copy",
        "reject",
        f"{how} {original}",
        "the same flight would count twice, and would stand on both sides of a split into training and test",
        "keep one of them",
        values={"original": original},
    )
