"""What a finding says to set, as the mapping takes it that the log was read with."""

from __future__ import annotations

from dataclasses import replace

from infotraj.checking.finding import Finding
from infotraj.checking.settings import command
from infotraj.errors import UsageError
from infotraj.importing import Mapping, Plan, parse_settings
from infotraj.importing.again import FLIGHT_TABLE
from infotraj.importing.on_top import on_top
from infotraj.importing.settings import same_reading, with_settings


def standing(findings: list[Finding], plan: Plan | None) -> list[Finding]:
    """The findings with settings, and the command in the remedy, on top of what the plan's mapping says already.

    A finding that no setting of this mapping mends has none, and its remedy says where to look: a flight table of
    quaternions cannot be told that the log held degrees.
    """
    if plan is None:
        return findings
    return [_standing(finding, plan) if finding.settings else finding for finding in findings]


def _standing(finding: Finding, plan: Plan) -> Finding:
    settings = on_top(plan, finding.settings)
    said = command(finding.settings)
    if _changes(plan.mapping, settings):
        return replace(finding, settings=settings, remedy=finding.remedy.replace(said, command(settings)))
    elsewhere = (
        f"with the log that this table was made of, not the table: {said}"
        if plan.mapping.name == FLIGHT_TABLE
        else f"map the channel anew: infotraj import LOG --explain --save-mapping {plan.mapping.name}_of_mine.yaml"
    )
    return replace(finding, settings=(), remedy=finding.remedy.replace(said, elsewhere))


def _changes(mapping: Mapping, settings: tuple[str, ...]) -> bool:
    try:
        return not same_reading(with_settings(mapping, parse_settings(settings)), mapping)
    except UsageError:
        return False
