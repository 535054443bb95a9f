"""Damaged model files: every file of every format, with bytes changed, cut, doubled, and numbers made huge.

`damaged` applies changes, which hypothesis (tests) or a seeded generator (verify) draws; `answer` reads the result and lets
nothing pass but a model or an `InputError`, within a time limit.
"""

import gzip
import io
import resource
import signal
import zipfile
from contextlib import contextmanager, suppress
from pathlib import Path

from readers.conftest import KINDS, Chain

from stickslip.model.readers.read import FORMATS, read_model
from stickslip.study import job
from stickslip.study.templates import write_new
from stickslip.support.checks import InputError

SECONDS = 20
HUGE = (b"999999999999", b"-1", b"0", b"1e308", b"nan", b"99999999", b"", b"1000000", b"*", b"\xff\xff\xff\x7f", b"\x00" * 8)
CHANGES = ("flip", "cut", "drop", "double", "huge", "word")
APART = ("mat", "mat_compressed", "mat4", "mat73", "mapping")
"""Kinds that are read in a process of their own, half a second each."""
DATA = Path(__file__).parents[1] / "data" / "calculix"


class TookTooLongError(BaseException):
    """No exception that a reader could take for a fault of the file."""


def damaged(content, changes):
    """`content` after changes (kind, place in [0, 1), value in [0, 2^32))."""
    for kind, share, value in changes:
        place, length = int(share * len(content)), 1 + value % 16
        match kind:
            case "flip":
                content = content[:place] + bytes([value % 256]) + content[place + 1 :]
            case "cut":
                content = content[:place]
            case "drop":
                content = content[:place] + content[place + length :]
            case "double":
                content = content[:place] + content[place : place + 8 * length] + content[place:]
            case "word":
                content = content[:place] + value.to_bytes(4, "little") + content[place + 4 :]
            case "huge":
                content = _with_number(content, place, HUGE[value % len(HUGE)])
    return content


def _repacked(archive, which, changes):
    """An archive of which one member is damaged, with sound checksums."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(archive)) as old, zipfile.ZipFile(buffer, "w") as new:
        for number, member in enumerate(old.namelist()):
            content = old.read(member)
            new.writestr(member, damaged(content, changes) if number == which // 2 % len(old.namelist()) else content)
    return buffer.getvalue()


def _with_number(content, place, number):
    """The digits from `place` on, replaced: a count of a header or a number of the data."""
    start = next((k for k in range(place, len(content)) if chr(content[k]).isdigit()), len(content))
    end = next((k for k in range(start, len(content)) if not chr(content[k]).isdigit()), len(content))
    return content[:start] + number + content[end:]


def drawn(generator):
    """Some changes of a seeded `random.Random`."""
    return [
        (generator.choice(CHANGES), generator.random(), generator.getrandbits(32))
        for _ in range(generator.choice((1, 1, 1, 2, 5)))
    ]


@contextmanager
def time_limit(seconds=SECONDS):
    """Raise when the block takes longer."""

    def stop(number, frame):
        raise TookTooLongError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


class Victims:
    """For each kind of file: the file to read, and the files beside it that may be damaged, in a folder of its own."""

    def __init__(self, folder):
        self.paths = {kind: self._saved(folder / kind, kind) for kind in KINDS}
        self.paths |= {"calculix": self._calculix(folder / "calculix"), "substructure": folder / "calculix" / "blade_pad_K.mtx"}
        self.paths["mapping"] = self._mapping(folder / "mapping")
        self.sound = {file: file.read_bytes() for path in self.paths.values() for file in path.parent.iterdir()}

    @staticmethod
    def _saved(folder, kind):
        folder.mkdir()
        return Chain().save(folder, kind)

    @staticmethod
    def _calculix(folder):
        folder.mkdir()
        for file in DATA.glob("blade*"):
            target = folder / file.name.removesuffix(".gz")
            target.write_bytes(gzip.decompress(file.read_bytes()) if file.suffix == ".gz" else file.read_bytes())
        return folder / "blade.inp"

    def _mapping(self, folder):
        path = self._saved(folder, "matrix_market")
        lines = ["node,direction,x,y,z,set", *(f"{k},x,{k},0,0,A B" for k in range(1, 7))]
        path.with_name("names.csv").write_text("\n".join(lines))
        return path

    def answer(self, kind, which, changes):
        """Damage one file of a kind, read, restore; whether a model came out. Anything but an `InputError` passes through."""
        path = self.paths[kind]
        files = sorted(file for file in self.sound if file.parent == path.parent)
        victim = path.with_name("names.csv") if kind == "mapping" else files[which % len(files)]
        sound = self.sound[victim]
        victim.write_bytes(_repacked(sound, which, changes) if which % 2 and path.suffix == ".npz" else damaged(sound, changes))
        names = path.with_name("names.csv") if kind == "mapping" else None
        try:
            with time_limit(), suppress(InputError):
                read_model(path, names=names)
                return True
            return False
        finally:
            victim.write_bytes(self.sound[victim])


STUDY = b"""
units = "mm-t-s"
[study]
analysis = "forced_response"
[structure]
model = "chain.npz"
keep = { a = "2", b = 5 }
modes = 2
[[contact]]
law = "macroslip"
between = ["a.x", "ground"]
kt = 0.5
mu = 1.0
normal_load = 1.0
start = { slider_offset = [0.1] }
[[force]]
direction = "b.x"
amplitude = [1.0, 2.0]
[sweep]
frequency = [10.0, 30.0]
harmonics = 5
samples = 256
outputs = ["a.x", { name = "rim", direction = { "a.x" = 1.0, "b.x" = 0.5 } }]
"""


QUICK = ("response_bounds", "response_samples", "damper_cycle", "performance_curve", "damper_design")
"""Kinds of studies whose check builds no mesh."""


def studies(folder):
    """A study of a model, beside chain.npz in `folder`, and the commented ones that are checked quickly, as bytes."""
    for kind in QUICK:
        write_new(kind, folder / f"{kind}.toml", overwrite=True)
    return (STUDY, *((folder / f"{kind}.toml").read_bytes() for kind in QUICK))


def study_answer(study, folder, changes):
    """Read a study after changes, with its files in `folder`; whether it was sound. Only an `InputError` is kept."""
    with time_limit(), suppress(InputError):
        job(damaged(study, changes).decode("utf-8", "replace"), folder, "study")
        return True
    return False


def peak_memory():
    """The largest memory of this process so far, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def reader_of(victims, kind):
    """The name of the format that reads a kind."""
    suffix = victims.paths[kind].suffix
    fitting = [form.name for form in FORMATS if suffix in form.endings]
    if kind == "mat73":
        return "MATLAB 7.3 file"
    return "mapping file" if kind == "mapping" else ("Matrix Market" if kind.startswith("matrix_market") else fitting[0])
