"""One trial: a command under limits, and what is wrong with how it ended."""
import math
import os
import re
import resource
import select
import signal
import subprocess
import time
from dataclasses import dataclass, field

# The table's columns, all of which must stand at zero.
TORN, LEFT, HANG, SILENT, TRACEBACK, MEMORY, ENDING = COLUMNS = ("torn", "left behind", "hang", "silently accepted", "traceback or abort", "memory", "wrong ending")

# tool/error.h
SUCCESS, INTERNAL_ERROR, USAGE_ERROR, INPUT_ERROR, NUMERICAL_ERROR, OUTPUT_ERROR, CHECK_FAILED, DAMAGED_FILE = range(8)
DOCUMENTED = (USAGE_ERROR, INPUT_ERROR, NUMERICAL_ERROR, OUTPUT_ERROR, CHECK_FAILED, DAMAGED_FILE)

WAIT = 4
GONE_SECONDS = 120  # what a killed process may take to be gone on a busy machine
STDERR_BYTES = 1 << 20
ADDRESS_SPACE_BYTES = 12 << 30  # the machine's own limit, so that a trial cannot take the machine
# what an abort of ours, of the libraries and of the sanitizers says
ABORTS = re.compile(r"Traceback \(most recent|terminate called|check failed:|Assertion .* failed|core dumped|Fatal Python error")
SANITIZERS = re.compile(r"(Address|UndefinedBehavior|Leak|Thread)Sanitizer|runtime error:")
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")


@dataclass
class Limits:
    seconds: float = 60.0  # of a processor, and WAIT times as many by the clock: other work on the machine is no hang
    peak_mb: float = 2000.0
    address_space: bool = True  # sanitizers map terabytes


@dataclass
class Ending:
    code: int  # negative: a signal
    stderr: str
    seconds: float
    peak_mb: float
    hung: bool

    def words(self):
        return f"code {self.code}, {self.seconds:.1f} s, {self.peak_mb:.0f} MB: {self.stderr.strip()[-300:]}"


@dataclass
class Faults:
    """What is wrong with a case: (column, words)."""
    found: list = field(default_factory=list)

    def add(self, column, words):
        self.found.append([column, words])


def limit_child(limits):
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    seconds = math.ceil(limits.seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    if limits.address_space:
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE_BYTES, ADDRESS_SPACE_BYTES))


def start(command, folder, environment, limits, stderr_path):
    with open(os.path.join(folder, "stdout"), "wb") as stdout, open(stderr_path, "wb") as stderr:
        return subprocess.Popen(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, start_new_session=True,
                                preexec_fn=lambda: limit_child(limits))


def session_of(leader):
    """(process, name) of what lives in a session that we started."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as file:
                words, _, rest = file.read().rpartition(")")
        except OSError:
            continue
        state, _, _, session = rest.split()[:4]
        if int(session) == leader and state != "Z":
            found.append((int(name), words.split("(", 1)[1]))
    return found


def wait_for(goes_on):
    deadline = time.monotonic() + GONE_SECONDS
    while goes_on() and time.monotonic() < deadline:
        time.sleep(0.02)


def end_group(process):
    """Nothing of a trial outlives it: the session is its own. Locks are free once all of it is gone."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    wait_for(lambda: session_of(process.pid))


def run(command, folder, environment, limits, kill_after=None):
    """Runs a command in a folder, its standard output into the file `stdout` there; kill_after: seconds until all of it is killed."""
    stderr_path = f"{folder}.stderr"
    began = time.monotonic()
    process = start(command, folder, environment, limits, stderr_path)
    handle = os.pidfd_open(process.pid)
    poll = select.poll()
    poll.register(handle, select.POLLIN)
    is_over = bool(poll.poll(1000 * (WAIT * limits.seconds if kill_after is None else kill_after)))
    end_group(process)
    _, status, usage = os.wait4(process.pid, 0)
    os.close(handle)
    process.returncode = os.waitstatus_to_exitcode(status)
    with open(stderr_path, "rb") as file:
        text = file.read(STDERR_BYTES).decode(errors="replace")
    os.remove(stderr_path)
    is_hung = process.returncode == -signal.SIGXCPU or (not is_over and kill_after is None)
    return Ending(process.returncode, text, time.monotonic() - began, usage.ru_maxrss / 1024, is_hung)


# of a configuration, before the run
NOTES = re.compile(r"pipeline\.sh: .*(the report's verdict is of|the verdict will be) ")


def error_lines(text):
    """Ours, and those of pipeline.sh and what it calls."""
    return [line for line in text.splitlines() if re.match(r"[\w.\- ]+: error: |pipeline\.sh: ", line) and not NOTES.match(line)]


def judge(ending, limits, faults, codes=DOCUMENTED, is_quiet=True):
    """Whether an ending is one that is documented: success, or one of the codes with one line that says why.

    is_quiet   nothing else may stand on stderr; tools that report there say more
    """
    if ending.hung:
        faults.add(HANG, ending.words())
        return
    if SANITIZERS.search(ending.stderr):
        faults.add(MEMORY, ending.words())
    elif ending.code < 0 or ABORTS.search(ending.stderr):
        faults.add(TRACEBACK, ending.words())
    if ending.peak_mb > limits.peak_mb:
        faults.add(MEMORY, ending.words())
    if CONTROL.search(ending.stderr):
        faults.add(ENDING, f"control characters on stderr: {ending.stderr[:200]!r}")
    if faults.found or ending.code == SUCCESS:
        return
    lines = error_lines(ending.stderr)
    if ending.code not in codes:
        faults.add(ENDING, f"expected one of {', '.join(map(str, codes))}: {ending.words()}")
    elif len(lines) != 1 or (is_quiet and len([line for line in ending.stderr.splitlines() if line]) != 1):
        faults.add(ENDING, f"expected one line: {ending.words()}")
