"""Errors that a user sees: what is wrong, where, the value, and the remedy."""

import errno
import functools
import re
import sys

INTERRUPTED = 130  # exit code of a command that Ctrl-C ended, as a shell gives it
# What a disk or a folder can refuse, whatever the program does. Other errors of the system are defects of the program.
STORAGE_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EACCES, errno.EPERM, errno.EROFS)
CHECK_STORAGE = "check the folder, its rights and the free space"
LAST_LINES = 6  # number of last lines of a log, taken as the message if the log has no error message of this project


class UserError(Exception):
    """Base of the errors that end a command with one clear message."""

    exit_code = 1

    def __init__(self, what, where, value, remedy):
        self.what, self.where, self.value, self.remedy = what, str(where), value, remedy
        super().__init__(f"error: {what}\n  where:  {where}\n  value:  {value}\n  remedy: {remedy}")


class InputError(UserError):
    """Bad input: exit code 2, raised before any long work."""

    exit_code = 2


class ComputationError(UserError):
    """A computation did not converge, or its result cannot be trusted: exit code 3, and no output is written."""

    exit_code = 3


class WriteError(UserError):
    """A file cannot be written, for example on a full disk: exit code 1."""

    def __init__(self, path, reason):
        super().__init__("the file cannot be written", path, reason, CHECK_STORAGE)


def guarded(main):
    """Decorator for a command's main(): a UserError ends it with its message and exit code, without a traceback.

    The same holds for a full disk or a forbidden folder (STORAGE_ERRORS, exit code 1) and for Ctrl-C (exit code 130).
    """

    @functools.wraps(main)
    def run(*args, **kwargs):
        try:
            return main(*args, **kwargs)
        except UserError as error:
            print(error, file=sys.stderr)
            sys.exit(error.exit_code)
        except KeyboardInterrupt:
            print("ended by Ctrl-C", file=sys.stderr)
            sys.exit(INTERRUPTED)
        except OSError as error:
            if error.errno not in STORAGE_ERRORS:
                raise
            where = error.filename or "a file of this command"
            refused = UserError("a file cannot be read or written", where, error.strerror, CHECK_STORAGE)
            print(refused, file=sys.stderr)
            sys.exit(refused.exit_code)

    return run


def error_message(text, last_lines=LAST_LINES):
    """The error in a log: the last error message of this project if there is one, else so many of the last lines."""
    begins = [one.start() for one in re.finditer(r"^error: ", text, re.M)]
    return text[begins[-1] :].strip() if begins else "\n".join(text.strip().splitlines()[-last_lines:])


def error_sentence(text):
    """What the last error message of this project in a log says is wrong; "" if the log has no such message."""
    first = error_message(text).partition("\n")[0]
    return first.removeprefix("error: ").strip() if first.startswith("error: ") else ""


def error_summary(text):
    """The error in a log on one line, without its remedy. If it is no message of this project: the log's last line."""
    lines = [line.strip() for line in error_message(text, last_lines=1).splitlines()]
    return "; ".join(line for line in lines[:3] if not line.startswith("remedy"))  # what, where, value
