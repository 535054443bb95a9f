"""Files that contradict themselves: sound files with one fault each, by classes of what a file says twice, and what comes of it.

A fault of the class `count` changes a small whole number, or leaves a line or a block out or repeats it; `length` inserts or
deletes letters or bytes; `type` changes words, letters and the writing of numbers; `order` exchanges lines or blocks; `end` cuts
the file, repeats its tail or appends to it; `bits` turns one bit over.

What a reader makes of it is one of four: it refuses the file, reads the same model, or another one, and then either the file is
what a sound writer would have written for that other model (one digit of a number: nobody could have seen it), or it is not, and
the fault could have been seen. So the writers of the tests are the judges, and the number of the last kind ought to be 0.
"""

import faulthandler
import os
import re
import struct
import warnings
import zipfile
from collections import Counter
from io import BytesIO
from itertools import chain
from types import SimpleNamespace

import numpy as np
from readers.conftest import Chain
from readers.fuzzing import time_limit
from scipy import sparse

from stickslip.model.readers import process
from stickslip.model.readers.read import read_model
from stickslip.support.checks import InputError

CLASSES = ("count", "length", "type", "order", "end", "bits")
BINARY = (b"\x00", b"\x1f")
NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EDed][-+]?\d+)?")
TOKEN = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EDed][-+]?\d+)?|[A-Za-z]+|[^\sA-Za-z0-9,]")
UNORDERED = ("matrix_market", "abaqus", "abaqus_coordinate")
"""Kinds whose lines may stand in any order."""
COMMENTS = (b"%", b"$", b"**")
WORDS = (
    *b"real integer complex pattern general symmetric skew-symmetric hermitian coordinate array".split(),
    *b"RSA RUA CSA ISA RSE RZA E D I F MASS STIFFNESS DAMPING KAA MAA BAA".split(),
    b"",
)
WRITINGS = (
    lambda n: n.replace(b"E", b"D").replace(b"e", b"D"),
    lambda n: n.replace(b".", b","),
    lambda n: re.sub(rb"[EeDd](?=[+-])", b"", n),
    lambda n: n.replace(b"0", b"O", 1),
    lambda n: n[:2] + b"_" + n[2:],
    lambda n: n[:2] + b" " + n[2:],
    lambda n: n[:2] + b"'" + n[2:],
    lambda n: b"0x" + n,
    lambda n: n[:2] + b"." + n[2:],
    lambda n: n + n[-4:],
    lambda n: n + b"*",
    lambda n: n[:3],
    lambda n: b"-" + n.lstrip(b"+-"),
    lambda n: b"",
)
SAME = 1e-8
"""Of the largest entry: so far a matrix may be from symmetric, too."""
NOTHING = 1e-9
"""Of the chain's masses, the smallest matrix."""
STRAY = (b"0", b"1 1 1.0\n", b"garbage\n", b"\x1a", b"1.0\n", b"\x1a\n", b"     1.000000000E+00\n", bytes(8))


def mutant(content, kind, random):
    """`content` with one fault of a class, drawn by a seeded `random.Random`."""
    if kind == "bits":
        place = random.randrange(len(content))
        return content[:place] + bytes([content[place] ^ 1 << random.randrange(8)]) + content[place + 1 :]
    if kind == "end":
        return random.choice((_cut, _cut_at_a_line, _repeated_tail, _stray))(content, random)
    binary = any(mark in content for mark in BINARY)
    return globals()[f"_{kind}_{'binary' if binary else 'text'}"](content, random)


def _cut(content, random):
    return content[: random.randrange(len(content))]


def _cut_at_a_line(content, random):
    ends = [match.end() for match in re.finditer(rb"\n", content)][:-1] or [len(content) // 8 * 4]
    return content[: random.choice(ends)]


def _repeated_tail(content, random):
    return content + content[random.randrange(len(content)) :]


def _stray(content, random):
    return content + random.choice(STRAY)


def _replaced(content, match, new):
    return content[: match.start()] + new + content[match.end() :]


def _count_text(content, random):
    """A whole number on a line without a decimal point, as headers are, or on any line; or a line left out or repeated."""
    lines = content.splitlines(keepends=True)
    if random.random() < 0.4:
        place = random.randrange(len(lines))
        return b"".join(lines[:place] + lines[place : place + 1] * random.choice((0, 2)) + lines[place + 1 :])
    headers = [place for place, line in enumerate(lines) if not re.search(rb"\d\.\d", line) and re.search(rb"\d", line)]
    place = random.choice(headers) if headers and random.random() < 0.7 else random.randrange(len(lines))
    numbers = list(re.finditer(rb"(?<![\d.+-])\d+(?![\d.])", lines[place]))
    if not numbers:
        return content
    match = random.choice(numbers)
    lines[place] = _fitted(lines[place], match, random.choice(_others(int(match[0]))))
    return b"".join(lines)


def _fitted(line, match, number):
    """A number in place of another, which keeps its last column."""
    new = b"%d" % number
    blanks = len(new) - len(match[0])
    before = line[: match.start()]
    return (
        (before[:-blanks] if blanks > 0 and before.endswith(b" " * blanks) else before + b" " * -blanks)
        + new
        + line[match.end() :]
    )


def _others(number):
    return (number + 1, number - 1, 0, 2 * number, 10 * number + 1, number + 65536)


def _length_text(content, random):
    """A letter more or less, a field less or twice."""
    place = random.randrange(len(content))
    fields = list(re.finditer(rb"[^\s,]+,?", content))
    match = random.choice(fields)
    return random.choice(
        (
            content[:place] + content[place + 1 :],
            content[:place] + random.choice((b" ", b"0", b"\t", b",", b"\n", b".")) + content[place:],
            _replaced(content, match, b""),
            _replaced(content, match, match[0] + b" " + match[0]),
            _replaced(content, match, b" " * len(match[0])),
        )
    )


def _type_text(content, random):
    kind = random.choice(("word", "number", "number", "digit"))
    pattern = {
        "word": rb"(?<![0-9.])[A-Za-z-]{2,}|(?<=[(\d,])[A-Z](?=\d)",
        "number": NUMBER.pattern,
        "digit": rb"(?<=\s)\d(?=\s)",
    }[kind]
    matches = list(re.finditer(pattern, content))
    if not matches:
        return content
    match = random.choice(matches)
    new = {
        "word": random.choice(WORDS),
        "number": random.choice(WRITINGS)(match[0]),
        "digit": b"%d" % random.randrange(10),
    }[kind]
    return _replaced(content, match, new)


def _order_text(content, random):
    lines = content.splitlines(keepends=True)
    first = random.randrange(len(lines) - 1)
    second = min(len(lines) - 1, first + random.choice((1, 1, 2, 3, 6)))
    lines[first], lines[second] = lines[second], lines[first]
    return b"".join(lines)


def _small_words(content):
    """Places of words of four bytes that hold a small whole number, in either order of bytes: counts, lengths, types."""
    return [
        (place, order)
        for place in range(0, len(content) - 3, 4)
        for order in "<>"
        if 0 < struct.unpack_from(f"{order}i", content, place)[0] < 4096
    ]


def _with_word(content, random, numbers):
    """One of these words changed, or a number in letters, as the header of a NumPy array has them."""
    words, letters = _small_words(content), list(re.finditer(rb"(?<=[(, <f])\d{1,3}(?=[,) '])", content))
    if letters and (not words or random.random() < 0.5):
        match = random.choice(letters)
        return _replaced(content, match, b"%d" % random.choice(numbers(int(match[0]))))
    if not words:
        return content
    place, order = random.choice(words)
    (before,) = struct.unpack_from(f"{order}i", content, place)
    return content[:place] + struct.pack(f"{order}i", random.choice(numbers(before))) + content[place + 4 :]


def _count_binary(content, random):
    return _with_word(content, random, _others)


def _type_binary(content, random):
    return _with_word(content, random, lambda _: tuple(range(18)))


def _length_binary(content, random):
    place, size = random.randrange(len(content)) // 4 * 4, random.choice((1, 2, 4, 8, 16))
    return (
        content[:place]
        + random.choice((b"", bytes(size) + content[place : place + size], 2 * content[place : place + size]))
        + content[place + size :]
    )


def _order_binary(content, random):
    size = random.choice((4, 8, 16))
    place = random.randrange((len(content) - 2 * size) // 4) * 4
    return (
        content[:place] + content[place + size : place + 2 * size] + content[place : place + size] + content[place + 2 * size :]
    )


class Calculix(Chain):
    """The chain as CalculiX stores matrices: one triangle by columns, the same places in both files."""

    def _calculix(self, folder):
        stored = [(i, j) for j in range(len(self.K)) for i in range(j, len(self.K)) if self.K[i, j] or self.M[i, j]]
        for matrix, ending in ((self.K, ".sti"), (self.M, ".mas")):
            (folder / f"chain{ending}").write_text("".join(f"{i + 1} {j + 1} {matrix[i, j]:.17e}\n" for i, j in stored))
        (folder / "chain.dof").write_text("".join(f"{node}.{direction}\n" for node, direction in self.places))
        return folder / "chain.sti"


def chain_of(model):
    """What a model is written from."""
    written = Calculix()
    written.M, written.K, written.C = (
        None if matrix is None else matrix.toarray(order="C") for matrix in (model.M, model.K, model.C)
    )
    written.dofs = tuple(f"{node}.x" for node in range(1, model.size + 1)) if model.dofs[0].endswith(".q") else model.dofs
    return written


def normal(path, kind):
    """What counts of a file: the tokens of each line of text, numbers by their value; members of an archive; or all bytes."""
    content = path.read_bytes()
    if kind == "scipy":  # within a row the entries may stand in any order
        matrix = sparse.load_npz(path)
        matrix.sort_indices()
        return [part.tolist() for part in (matrix.data, matrix.indices, matrix.indptr)], matrix.shape
    if path.suffix == ".npz":
        with zipfile.ZipFile(path) as archive:
            return {name: archive.read(name) for name in archive.namelist()}
    if path.suffix == ".mat":
        return content[128:]
    if any(mark in content for mark in BINARY):
        return content
    lines = [line for line in content.splitlines() if line.strip() and not line.startswith(COMMENTS)]
    tokens = [[_token(token) for token in TOKEN.findall(line.upper())] for line in lines]
    if path.suffix == ".op4":  # the number in the last record of a matrix says nothing
        return [line for before, line in zip([[], *tokens], tokens, strict=False) if before[1:] != [1.0, 1.0]]
    if kind.startswith("dmig"):
        return _dmig_terms(tokens)
    if kind == "abaqus":  # node and direction of row and of column, of which either may come first
        tokens = [[*sorted((line[:2], line[2:4])), *line[4:]] for line in tokens]
    return sorted(tokens, key=str) if kind in UNORDERED else tokens


def alike(one, other):
    """Equal, or bytes that differ in numbers so small that they are none."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(alike(one[name], other[name]) for name in one)
    if one == other or not isinstance(one, bytes) or len(one) != len(other):
        return one == other
    for order in "<>":
        for start in (0, 4):
            words = [np.frombuffer(part, f"{order}i8", (len(part) - start) // 8, start) for part in (one, other)]
            differing = words[0] != words[1]
            numbers = np.stack([part[differing] for part in words]).view(f"{order}f8")
            if np.all(np.abs(numbers) < NOTHING) and one[-8:] == other[-8:] and one[:start] == other[:start]:
                return True
    return False


def _dmig_terms(tokens):
    """Headers, and terms with row and column, of which a symmetric matrix may have either first; all in any order."""
    begun = [place for place, line in enumerate(tokens) if line[0] == b"DMIG"]
    entries = [list(chain.from_iterable(tokens[first:last])) for first, last in zip(begun, [*begun[1:], None], strict=True)]
    entries = [[token for token in entry if token not in (b"*", b"+")] for entry in entries]
    symmetric = {entry[1] for entry in entries if entry[2:4] == [0.0, 6.0]}
    found = []
    for entry in entries:
        if entry[2] == 0.0:
            found.append(entry)
            continue
        for k in range(4, len(entry), 3):
            pair = entry[2:4], entry[k : k + 2]
            found.append([entry[1], *(sorted(pair) if entry[1] in symmetric else pair), entry[k + 2 : k + 3]])
    return sorted(found, key=str)


def _token(token):
    return round_to_digits(float(token.replace(b"D", b"E"))) if NUMBER.fullmatch(token) else token


def round_to_digits(value):
    return float(f"{value:.9e}")


class Sound:
    """A kind of file, sound: its files, and the model in them."""

    def __init__(self, folder, kind):
        folder.mkdir()
        self.kind = kind
        self.path = Calculix().save(folder, kind)
        self.files = sorted(folder.iterdir())
        self.content = {file: file.read_bytes() for file in self.files}
        self.model = read_model(self.path)
        self.again = folder.with_name(f"{folder.name}_again")
        self.again.mkdir()

    def verdict(self, group, random):
        """The answer to one fault: refused, same, unseen or seen (another model, and the fault could have been seen)."""
        file = random.choice(self.files)
        faulty = self._faulty(file, group, random)
        if faulty == self.content[file]:
            return "same"
        file.write_bytes(faulty)
        try:
            with time_limit(), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                model = read_model(self.path)
            if _equal(model, self.model):
                return "same"
            if set(model.notes) - set(self.model.notes):
                return "said"
            return "unseen" if self._is_sound(model) else "seen"
        except InputError:
            return "refused"
        finally:
            for name, content in self.content.items():
                name.write_bytes(content)

    def _faulty(self, file, group, random):
        """Of an archive one member, with a sound checksum, unless a bit is turned over or its end is at fault."""
        content = self.content[file]
        if file.suffix != ".npz" or group in ("bits", "end"):
            return mutant(content, group, random)
        buffer = BytesIO()
        with zipfile.ZipFile(file) as old, zipfile.ZipFile(buffer, "w") as new:
            which = random.choice(old.namelist())
            for name in old.namelist():
                new.writestr(name, mutant(old.read(name), group, random) if name == which else old.read(name))
        return buffer.getvalue()

    def _is_sound(self, model):
        """Whether the files at hand are those that a sound writer writes of the model that was read from them."""
        for file in self.again.iterdir():
            file.unlink()
        try:
            chain_of(model).save(self.again, self.kind)
        except (ValueError, IndexError, KeyError, TypeError):
            return False
        written = {file.name: file for file in self.again.iterdir()}
        present = {file.name: file for file in self.files if file.stat().st_size}
        return written.keys() == present.keys() and all(
            alike(normal(written[name], self.kind), normal(present[name], self.kind)) for name in written
        )


def _equal(one, other):
    matrices = ((one.M, other.M), (one.K, other.K), (one.C, other.C))
    return one.dofs == other.dofs and all(
        (a is None) == (b is None) and (a is None or (a.shape == b.shape and abs(a - b).max() <= SAME * abs(b).max()))
        for a, b in matrices
    )


def forked(command, **_):
    """In place of a process that starts anew, one that is split off: a hundred times as fast."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        faulthandler.disable()
        os.dup2(writing, 2)
        try:
            code = process.main(*command[-3:])
        except BaseException:
            code = 1
        os._exit(code)
    os.close(writing)
    with os.fdopen(reading, errors="replace") as stream:
        said = stream.read()
    return SimpleNamespace(returncode=os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), stderr=said)


def counts(sound, group, random, number):
    """How often each answer came."""
    return Counter(sound.verdict(group, random) for _ in range(number))
