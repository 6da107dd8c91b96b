"""What inject.c is told: which call of which class fails, and how."""
import errno
import os

# class → faults that a system may really have there
ERRNOS = {
    "open": (errno.EMFILE, errno.EIO, errno.EACCES, errno.ENOSPC), "read": (errno.EIO, errno.EINTR), "write": (errno.ENOSPC, errno.EIO, errno.EINTR),
    "sync": (errno.EIO, errno.ENOSPC), "rename": (errno.EIO, errno.ENOSPC), "truncate": (errno.ENOSPC, errno.EIO), "map": (errno.ENOMEM,),
    "close": (errno.EIO,), "folder": (errno.ENOSPC, errno.EACCES), "thread": (errno.EAGAIN,), "memory": (errno.ENOMEM,),
}
SHORT = ("read", "write")
STAYING = (errno.ENOSPC, errno.EMFILE, errno.ENOMEM, errno.EAGAIN)  # what does not pass by itself
ABOVE_BYTES = 1 << 16


def clean(environment):
    return {key: value for key, value in environment.items() if not key.startswith("INJECT_") and key != "LD_PRELOAD"}


def injecting(injection, folder, program, **settings):
    """The environment of a process that the injector sits in; settings: call, at, fault, stay, counts."""
    words = {f"INJECT_{key.upper()}": str(value) for key, value in settings.items() if value}
    return {**injection.environment, "LD_PRELOAD": injection.injector, "INJECT_UNDER": os.path.realpath(folder), "INJECT_ABOVE": str(ABOVE_BYTES), "INJECT_PROGRAM": program, **words}


def read_counts(path):
    """class → calls of one run."""
    counts = {}
    if os.path.exists(path):
        with open(path) as file:
            for line in file:
                name, count = line.split()
                counts[name] = counts.get(name, 0) + int(count)
    return counts


def draw_error(random, counts):
    """A class that the run has calls of, one of them, and a fault: the settings of `injecting`, and their words."""
    call = random.choice(sorted(name for name, count in counts.items() if count and name in ERRNOS))
    at = random.randint(1, counts[call])
    fault = random.choice([*ERRNOS[call], *(("short",) if call in SHORT else ())])
    stay = fault in STAYING and random.random() < 0.5
    word = fault if fault == "short" else errno.errorcode[fault]
    return {"call": call, "at": at, "fault": fault, "stay": stay}, f"{call} {at}: {word}{' from then on' if stay else ''}"


def draw_kill(random, counts):
    call = random.choice(sorted(name for name, count in counts.items() if count and name not in ("thread", "memory")))
    at = random.randint(1, counts[call])
    fault = random.choice(("kill", "tear")) if call == "write" else "kill"
    return {"call": call, "at": at, "fault": fault}, f"{fault} at {call} {at}"
