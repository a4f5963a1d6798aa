"""The one exception that bad input raises."""


class DatasetError(ValueError):
    """A file, or the numbers in it, cannot be used; the message says where and what was expected."""

    def __init__(self, message, path=None, line=None):
        where = "" if path is None else f"{path}:{line}: " if line is not None else f"{path}: "
        super().__init__(where + message)
        self.path = path
        self.line = line
