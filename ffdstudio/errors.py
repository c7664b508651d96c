"""The one exception that means "your input is wrong, and here is why"."""


class InputError(ValueError):
    """Bad input: a broken file, a wrong degree, an impossible request.

    The message is one sentence for the user. It names the file or value at fault and
    the cause; the command line prints it after ``ffdstudio: error:`` and the window
    shows it in a dialog.

    Examples
    --------
    >>> raise InputError("degree 5 needs at least 6 control points, got 4")
    Traceback (most recent call last):
        ...
    ffdstudio.errors.InputError: degree 5 needs at least 6 control points, got 4
    """
