"""What a finding says to set, as the mapping takes it that the log was read with."""

from __future__ import annotations

from dataclasses import replace

from infotraj.checking.finding import Finding
from infotraj.checking.settings import command
from infotraj.importing import Plan
from infotraj.importing.on_top import on_top


def standing(findings: list[Finding], plan: Plan | None) -> list[Finding]:
    """The findings with settings, and the command in the remedy, on top of what the plan's mapping says already."""
    if plan is None:
        return findings
    out = []
    for finding in findings:
        settings = on_top(plan, finding.settings) if finding.settings else ()
        remedy = finding.remedy.replace(command(finding.settings), command(settings)) if settings else finding.remedy
        out.append(replace(finding, settings=settings, remedy=remedy))
    return out
