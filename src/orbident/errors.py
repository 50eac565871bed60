"""The one exception that means: the input is wrong, and here is what to do."""


class InputError(ValueError):
    """What a user gave cannot be used.

    The message is one line: the place, what was found, and what to do. The
    command prints it on standard error and exits with status 2.
    """
