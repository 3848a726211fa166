"""Errors that a user can act on: one line that says what was found, what was expected and what to do."""

from __future__ import annotations


class InfotrajError(Exception):
    """A failure that ends a command. `exit_status` is what the process returns (files-and-commands)."""

    exit_status = 1


class UsageError(InfotrajError):
    """The call itself is wrong: a bad option, an unknown name, a configuration key that does not exist."""

    exit_status = 2


class InputError(InfotrajError):
    """A file that was handed in cannot be used: a log, a vehicle, a reference, a model."""

    exit_status = 3


def problem(found: str, expected: str, remedy: str) -> str:
    """One line: what was found, what was expected, what to do."""
    return " ".join(f"{found}; expected {expected}. {remedy}".split())
