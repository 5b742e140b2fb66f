"""The errors that friction-audit raises on purpose; anything else is a bug.

A message says: where, what was found, what was expected, what to do.
"""

from traceback import format_exception


class FrictionAuditError(Exception):
    """Base of every deliberate error; ``exit_code`` is what the command line exits with."""

    exit_code = 1


class UsageError(FrictionAuditError):
    """The request contradicts itself or the log; another option is needed."""

    exit_code = 2


class InputError(FrictionAuditError):
    """The input cannot be read as a joint log."""

    exit_code = 3


class AnalysisError(FrictionAuditError):
    """The log is readable, but the question has no answer: no cycle, no excitation."""

    exit_code = 4


def bug_sentence(what: str, error: Exception) -> str:
    """Say that a part of the work ended in an error that was not foreseen."""
    return f"{what} failed with {type(error).__name__}: {error}; this is a bug, please report it"


def traced(error: Exception) -> str:
    """Return the traceback of an error as Python prints it."""
    return "".join(format_exception(error))
