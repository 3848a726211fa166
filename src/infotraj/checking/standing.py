"""What a finding says to set, as the mapping takes it that the log was read with."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from infotraj.checking.finding import Finding
from infotraj.checking.settings import command
from infotraj.errors import UsageError
from infotraj.importing import Mapping, Plan, parse_settings, shipped
from infotraj.importing.again import FLIGHT_TABLE
from infotraj.importing.on_top import on_top
from infotraj.importing.settings import same_reading, with_settings
from infotraj.suggested import quoted


def standing(findings: list[Finding], plan: Plan | None, meta: dict[str, Any] | None = None) -> list[Finding]:
    """The findings with settings, and the command in the remedy, on top of what the plan's mapping says already.

    A finding that no setting of this mapping mends has none, and its remedy says where to look: a flight table of
    quaternions cannot be told that the log held degrees. `meta`: what the table says of the log that it was made of.
    """
    if plan is None:
        return findings
    return [_standing(finding, plan, meta or {}) if finding.settings else finding for finding in findings]


def _standing(finding: Finding, plan: Plan, meta: dict[str, Any]) -> Finding:
    settings = on_top(plan, finding.settings)
    said = command(finding.settings)
    if _changes(plan.mapping, settings):
        return replace(finding, settings=settings, remedy=finding.remedy.replace(said, command(settings)))
    elsewhere = (
        _of_origin(finding.settings, meta)
        if plan.mapping.name == FLIGHT_TABLE
        else f"map the channel anew: infotraj import LOG --explain --save-mapping {plan.mapping.name}_of_mine.yaml"
    )
    return replace(finding, settings=(), remedy=finding.remedy.replace(said, elsewhere))


def _of_origin(settings: tuple[str, ...], meta: dict[str, Any]) -> str:
    """What to do with the log that a table was made of, as a command where the table says which one that is."""
    while meta.get("mapping") == FLIGHT_TABLE and isinstance(meta.get("origin"), dict):
        meta = meta["origin"]
    log, mapping, before = meta.get("source_file"), meta.get("mapping"), meta.get("settings")
    if not isinstance(log, str) or not isinstance(mapping, str) or mapping == FLIGHT_TABLE:
        options = " ".join(f"--set {quoted(s)}" for s in settings)
        return f"import the log that this table was made of anew, with {options}"
    together = (*before, *settings) if isinstance(before, list) else settings
    named = mapping if mapping in shipped() else f"{mapping}.yaml"
    again = command(together).replace("import LOG", f"import {quoted(log)} --mapping {quoted(named)}")
    file = "" if mapping in shipped() else f" ({named}: your file of the mapping {mapping})"
    return f"with the log that this table was made of: {again}{file}"


def _changes(mapping: Mapping, settings: tuple[str, ...]) -> bool:
    try:
        return not same_reading(with_settings(mapping, parse_settings(settings)), mapping)
    except UsageError:
        return False
