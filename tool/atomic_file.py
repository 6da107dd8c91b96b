"""Files that are either whole or not there: the Python side of tool/atomic_file.h, with the same names of temporary files."""
import errno
import itertools
import os
import socket
import stat

from tool.errors import OutputError

REASONS = {errno.ENOSPC: " (the disk is full: free some space or write elsewhere)", errno.EDQUOT: " (the user's share of the disk is full)"}
counter = itertools.count()


def prefix_for(path):
    """What the temporary files of this machine's processes begin with: a process id means something on its own machine only."""
    return f"{os.path.basename(path)}.tmp.{(socket.gethostname() or 'host').replace('/', '_')}."


def is_gone(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        pass
    return False


def remove_stale_temporaries(path):
    """Removes what processes of this machine that are gone left behind for path. Whatever cannot be removed stays: it harms nobody."""
    folder, prefix = os.path.dirname(os.path.abspath(path)), prefix_for(path)
    for name in os.listdir(folder):
        process, dot, _ = name[len(prefix):].partition(".")
        if name.startswith(prefix) and dot and process.isdecimal() and int(process) > 0 and is_gone(int(process)):
            try:
                os.remove(os.path.join(folder, name))
            except OSError:
                pass


def flush_folder(folder):
    """Without this the rename itself may be lost in a power cut."""
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return  # a folder that may be written but not read: the rename stands all the same
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(descriptor)


def write_atomically(path, data):
    """Writes bytes to a temporary file beside path, flushes it to the disk and renames it; makes the folder if it is missing.

    Killed at any moment, it leaves path as it was before; the temporary file then goes when the same machine next writes to path.
    throws   OutputError, which names path
    """
    path = os.fspath(path)
    folder = os.path.dirname(os.path.abspath(path))
    try:
        os.makedirs(folder, exist_ok=True)
        # renaming over a device, a link or a folder would replace it
        if os.path.lexists(path) and not stat.S_ISREG(os.lstat(path).st_mode):
            raise OutputError(path, "it is a directory" if os.path.isdir(path) and not os.path.islink(path) else "it exists and is not a regular file")
        remove_stale_temporaries(path)
        temporary_path = os.path.join(folder, f"{prefix_for(path)}{os.getpid()}.{next(counter)}")
        try:
            with open(temporary_path, "xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.rename(temporary_path, path)
        except BaseException:
            if os.path.lexists(temporary_path):
                os.remove(temporary_path)
            raise
        flush_folder(folder)
    except OSError as error:
        raise OutputError(path, f"{error.strerror or error}{REASONS.get(error.errno, '')}") from None


def write_files(files):
    """path → bytes, written in this order."""
    for path, data in files.items():
        write_atomically(path, data)
