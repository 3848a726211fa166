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


def unread(path: object, error: Exception, expected: str) -> str:
    """One line on a file that was to be YAML and could not be read as it: `expected` it was to be."""
    if isinstance(error, FileNotFoundError):
        return problem(f"{path}: there is no such file", expected, "Check the path.")
    if isinstance(error, UnicodeDecodeError):
        return swapped(path, expected)
    if isinstance(error, IsADirectoryError):
        return problem(f"{path} is a folder", expected, "Name a file in it.")
    what = getattr(error, "strerror", None) or error
    return problem(f"{path}: cannot be read as YAML ({what})", expected, "Check the path.")


def swapped(path: object, expected: str) -> str:
    """One line on a file that looks like a flight or a log where a model or vehicle file was expected."""
    return problem(f"{path} is no YAML file", expected, "Is it a flight or a log? MODEL comes before FLIGHT.")


def problem(found: str, expected: str, remedy: str) -> str:
    """One line: what was found, what was expected, what to do."""
    return " ".join(f"{found}; expected {expected}. {remedy}".split())
