"""What every file of a run was made of, and whether that is still what the configuration asks and what lies on the disk.

Beside the results, in FOLDER/.origins, each file that a rule finished has a record: its SHA-256, and its origin, which is what the rule's tool
was asked for, the digests of its inputs, the digest of every other file that the tool read or looked for (NLG_INPUTS, tool/command/tool_main.h),
and the tools' revision. No time and no place is in it: a copy of a run's folder says the same. The one list of what a stage depends on are its
`input` and its `asked` in the Snakefile; Snakemake's own records and its look at times have no say.
"""
import functools
import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_atomically
from tool.errors import USAGE_ERROR, InputError, OutputError, say
from tool.input_file import as_documented, read_bytes
from tool.regular_file import regular

FOLDER = ".origins"
CHECKOUT = ("workflow", "validate", "tool", "weights")  # folders of it that stages read
NONE, CHANGED = "none", "changed while it was read"


hashed = {}  # path → (what the system says of it, SHA-256): archives of levels are read by many jobs


def sha256_of(path):
    with open(path, "rb", opener=regular) as file:
        status = os.fstat(file.fileno())
        state = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
        if hashed.get(path, (None,))[0] != state:
            hashed[path] = (state, hashlib.file_digest(file, "sha256").hexdigest())
        return hashed[path][1]


def sha256_of_text(text):
    return hashlib.sha256(text.encode()).hexdigest()


def digest_of(path):
    """Of a file's bytes, or of all that is in a folder; NONE where there is nothing."""
    if os.path.isdir(path):
        files = (os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names if not name.startswith(".snakemake"))
        return sha256_of_text(json.dumps(sorted((os.path.relpath(file, path), sha256_of(file)) for file in files)))
    return sha256_of(path) if os.path.lexists(path) else NONE


def record_path(folder, path):
    return os.path.join(folder, FOLDER, os.path.relpath(path, folder) + ".json")


def read_record(folder, path):
    """Empty where there is none that is whole: then the file's origin is not known."""
    place = record_path(folder, path)
    try:
        with as_documented(place):
            record = json.loads(read_bytes(place))
            return {key: record[key] for key in ("sha256", "asked", "inputs", "files", "tools")}
    except InputError:
        return {}


def names_in(path):
    """What inputsText of tool/input_file.h wrote."""
    with open(path, encoding="utf-8") as file:
        return [name[1:].encode("latin-1") if name.startswith("\1") else name.encode() for name in json.load(file)]


def revision_of(tools):
    return subprocess.run([os.path.join(tools, "nlg-datagen"), "--version"], capture_output=True, text=True, check=True).stdout.strip()


def is_inside(path, folder):
    return path == folder or path.startswith(folder.rstrip(os.sep) + os.sep)


class Origins:
    """Of the jobs of one run.

    folders    the run's and its data's; no_inputs: files that say nothing of a result: the configuration
    root       of the checkout, whose scripts may lie anywhere
    tools      their folder
    """

    def __init__(self, folders, root, no_inputs, tools):
        self.folders, self.root, self.no_inputs, self.tools = [os.path.abspath(folder) for folder in folders], root, [*no_inputs, tools], tools
        self.began = {}  # first output → (when in ns, origin): of the jobs at work
        self.why = {}    # rule → reason → how many jobs are done again for it
        self.known = {}  # file → its record: a shard's is asked for by many stages

    @functools.cached_property
    def revision(self):
        return revision_of(self.tools)

    def folder_of(self, path):
        return next((folder for folder in self.folders if is_inside(path, folder)), None)

    def _record(self, path):
        if path not in self.known:
            self.known[path] = read_record(self.folder_of(path), path)
        return self.known[path]

    def _digest(self, path):
        """Of a file of the run by its record, with which check_artefacts.py has compared it."""
        known = self.folder_of(path) and os.path.lexists(path) and self._record(path).get("sha256")
        return known or digest_of(path)

    def _home(self, path):
        """The folder that a file's name is told from, because it may lie anywhere: of the run, or the checkout's; None: neither."""
        in_checkout = any(is_inside(path, os.path.join(self.root, name)) for name in CHECKOUT)
        return self.folder_of(path) or (self.root if in_checkout else None)

    def _base(self, job):
        """The folder of the level, or of the weights, that a job is about: names of other files are told from there."""
        return next((os.path.dirname(path) for path in map(os.path.abspath, job.input) if not self._home(path)), self.root)

    def _name(self, path, job):
        return os.path.relpath(path, self._home(path) or self._base(job))

    def _origin(self, job):
        # what is only there for a while stands for inputs that the job has as well
        inputs = [path for path in map(os.path.abspath, job.input) if not path.endswith(".cache")]
        return {"asked": sha256_of_text(f"{job.rule.name}: {getattr(job.params, 'asked', '')}"),
                "inputs": sha256_of_text(json.dumps(sorted((self._name(path, job), self._digest(path)) for path in inputs)))}

    def difference(self, job):
        """Why a job's outputs are not what it would make now; empty where they are."""
        outputs = [os.path.abspath(path) for path in job.output]
        if all(path in job.temp_output for path in job.output) and not any(map(os.path.lexists, outputs)):
            return ""  # made when it is asked for
        origin = self._origin(job)
        for path in (path for path, output in zip(outputs, job.output) if output not in job.temp_output or len(outputs) == 1):
            record = self._record(path)
            if not os.path.lexists(path):
                return "missing"
            if not record:
                return "nothing says what it was made of"
            if record["asked"] != origin["asked"]:
                return "other settings"
            if record["inputs"] != origin["inputs"]:
                return "other inputs"
            for name, digest in record["files"].items():
                if digest != digest_of(os.path.join(self._base(job), name)):
                    return f"another {os.path.basename(name)}"
        return ""

    def note(self, job):
        """difference(), counted for lines(). What is of another run is never replaced."""
        reason = self.difference(job)
        if reason and any(map(os.path.lexists, job.output)):
            of_rule = self.why.setdefault(job.rule.name, {})
            of_rule[reason] = of_rule.get(reason, 0) + 1
            others = [path for path in map(os.path.abspath, job.output) if not is_inside(path, self.folders[0])]
            if others:
                say("pipeline.sh", f"data: {others[0]}: {reason} than this run asks for or finds; run {os.path.basename(self.folders[1])} again, or leave `data` out")
                sys.stderr.flush()
                os._exit(USAGE_ERROR)
        return reason

    def lines(self):
        return [f"{rule}: {count} made again: {reason}" for rule, reasons in self.why.items() for reason, count in reasons.items()]

    def started(self, job):
        # a batch system's job is told of twice: when it is sent, and when it has its number there
        if job.output[0] not in self.began:
            self.began[job.output[0]] = (time.time_ns(), self._origin(job))

    def _files(self, job, since_ns):
        """Digests of what a tool has read beside the inputs, by name. One that was changed meanwhile is like no other."""
        told = os.path.abspath(job.output[0]) + ".reads"
        if not os.path.exists(told):
            return {}
        paths = {os.fsdecode(os.path.abspath(name)) for name in names_in(told)}
        os.remove(told)
        found = {}
        for path in paths:
            if self.folder_of(path) or os.path.isdir(path) or any(is_inside(path, place) for place in self.no_inputs):
                continue
            is_old = not os.path.lexists(path) or os.stat(path).st_ctime_ns < since_ns
            found[os.path.relpath(path, self._base(job))] = digest_of(path) if is_old else CHANGED
        return found

    def finished(self, job):
        since_ns, origin = self.began.pop(job.output[0], (time.time_ns(), None))
        try:
            record = {**(origin or self._origin(job)), "files": self._files(job, since_ns), "tools": self.revision}
            for path in map(os.path.abspath, job.output):
                self.known[path] = {"sha256": digest_of(path), **record}
                write_atomically(record_path(self.folder_of(path), path), json.dumps(self.known[path], sort_keys=True).encode())
        except (OSError, OutputError) as error:
            # the files themselves are there; they are made again
            print(f"{', '.join(job.output)}: what it was made of is not recorded: {error}", file=sys.stderr)


def install(workflow, persistence, io, jobs, folder, origins):
    """Makes Snakemake go by origins, and keep what it writes for itself in the run's folder.

    workflow, persistence, io, jobs   its modules of these names; origins: None in the processes of single jobs, which judge nothing
    """
    class RunPersistence(persistence.Persistence):
        def __init__(self, *arguments, **options):
            here = os.getcwd()
            os.makedirs(folder, exist_ok=True)
            os.chdir(folder)
            try:
                super().__init__(*arguments, **options)
            finally:
                os.chdir(here)

        def started(self, job, external_jobid=None):
            super().started(job, external_jobid)
            # of a group its jobs are told one by one
            if origins and not job.is_group() and job.output:
                origins.started(job)

        def finished(self, job, keep_metadata=True):
            super().finished(job, keep_metadata=False)
            if origins and job.output:
                origins.finished(job)

        def input_changed(self, job, file=None):
            return [True] if origins and job.output and origins.note(job) else []

        def _nothing(self, job, file=None):
            return []

        params_changed = code_changed = conda_env_changed = container_changed = version_changed = _nothing

    wait_for_files = jobs.wait_for_files

    def wait(files, *arguments, **options):
        try:
            wait_for_files(files, *arguments, **options)
        except OSError:
            gone = [path for path in files if not os.path.exists(path)]
            raise workflow.WorkflowError(f"{', '.join(gone)}: is gone since the run began; the same command goes on with what is there") from None

    jobs.wait_for_files = wait
    workflow.Persistence = RunPersistence
    io._IOFile.is_newer = lambda self, time: False
