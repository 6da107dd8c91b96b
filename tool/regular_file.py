"""Opens files that are read: regular files only, as runtime_eval/regular_file does for the tools."""
import errno
import os
import stat

KINDS = [(stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"), (stat.S_ISDIR, "a directory"), (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device")]


def kind_of(mode):
    return next((name for is_kind, name in KINDS if is_kind(mode)), "something else")


def regular(path, flags):
    """An opener for open(): open(path, "rb", opener=regular).

    A pipe would keep its reader waiting, a device may never end. Links are followed.
    raises   OSError with what stands at the path instead, or the system's reason
    """
    try:
        file = os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    except OSError as error:
        # of a socket the system says no more than that it cannot be opened
        if error.errno != errno.ENXIO:
            raise
        raise OSError(error.errno, kind_of(os.stat(path).st_mode), path) from None
    mode = os.fstat(file).st_mode
    if stat.S_ISREG(mode):
        os.set_blocking(file, True)
        return file
    os.close(file)
    raise OSError(errno.EINVAL, kind_of(mode), path)
