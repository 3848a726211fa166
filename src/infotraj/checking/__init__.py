"""Does this log mean what it says? Detectors, one family a file, and the report they end in."""

from infotraj.checking.finding import Finding, outcome, usable_spans
from infotraj.checking.load import Loaded, load
from infotraj.checking.logs import check_logs
from infotraj.checking.whole import Check, check, examine

__all__ = ["Check", "Finding", "Loaded", "check", "check_logs", "examine", "load", "outcome", "usable_spans"]
