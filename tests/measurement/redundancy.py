"""Measured tables with one fault each, by the classes of `readers.redundancy`, and what comes of them.

The judge is a sound logger: it writes, in the layout of the file, the test that was read from the faulty one. Where that is the
faulty file again, number by number, nobody could have seen the fault; where it is not, the fault could have been seen. A change
that a note names is said.
"""

import warnings
from collections import Counter

import numpy as np
from measurement import universal_writer
from readers.fuzzing import time_limit
from readers.redundancy import NUMBER, TOKEN, mutant

import stickslip as ss

FREQUENCY = 330.0 + 0.5 * np.arange(40)
FORCE = 2.0
NOTHING = 1e-15
"""Far below the responses, m/N."""


def receptance(frequency):
    """Of a mode at 340 Hz with 0.5 % damping, mm/N."""
    return 1e3 / (4.0 * np.pi**2) / (340.0**2 - frequency**2 + 2j * 0.005 * 340.0 * frequency)


def text(separator=",", decimal=".", units=False, preamble=(), blanks=False):
    """A logger of text: titles with units, or a line of units, above rows of fixed decimals."""

    def write(frequency, amplitude, phase):
        titles = ("Frequency", "Receptance", "Phase") if units else ("Frequency [Hz]", "Receptance [mm/N]", "Phase [deg]")
        lines = [*preamble, separator.join(titles), *([separator.join(("Hz", "mm/N", "deg"))] if units else [])]
        for row in zip(frequency, 1e3 * amplitude, np.degrees(phase), strict=True):
            cells = [f"{row[0]:.2f}", f"{row[1]:.6f}", f"{row[2]:.3f}"]
            lines.append(separator.join(f"{cell:>12}" if blanks else cell for cell in cells).replace(".", decimal))
        return ("\n".join(lines) + "\n").encode()

    return write


def universal(binary=""):
    """A universal file of the complex response, evenly spaced."""

    def write(frequency, amplitude, phase):
        y = amplitude * np.exp(1j * phase)
        even = universal_writer.function(
            frequency, y, ordinate=(universal_writer.DISPLACEMENT, "m"), denominator=(universal_writer.FORCE, "N"), binary=binary
        )
        return bytes(even)

    return write


LAYOUTS = {
    "text, commas": (text(), ".csv"),
    "text, semicolons and decimal commas": (text(";", ",", True), ".csv"),
    "text, tabs and a preamble": (text("\t", preamble=("Logger 3", "Operator\tA. B.", "Points\t40")), ".txt"),
    "text, blanks": (text(" ", units=True, blanks=True), ".txt"),
    "universal file, 58": (universal(), ".unv"),
    "universal file, 58b": (universal("<"), ".unv"),
}


class SoundTable:
    """A sound file of a layout, and what is read from it."""

    def __init__(self, folder, layout):
        folder.mkdir(parents=True, exist_ok=True)
        self.write, ending = LAYOUTS[layout]
        self.path = folder / f"test{ending}"
        H = receptance(FREQUENCY)
        self.path.write_bytes(self.write(FREQUENCY, np.abs(1e-3 * H), np.angle(H)))
        self.test = self._read()
        self.content = self.write(*written_values(self.test))
        self.path.write_bytes(self.content)
        self.test = self._read()

    def _read(self):
        with time_limit(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ss.read_measured_response(self.path, force=FORCE)

    def verdict(self, group, random):
        """refused, same, said, unseen or seen."""
        faulty = mutant(self.content, group, random)
        if faulty == self.content:
            return "same"
        self.path.write_bytes(faulty)
        try:
            test = self._read()
        except ss.InputError:
            return "refused"
        if alike(test, self.test):
            return "same"
        if set(said(test)) - set(said(self.test)):
            return "said"
        return "unseen" if same_content(self.write(*written_values(test)), faulty) else "seen"


def said(test):
    """Notes of a test, and units that are assumed, which every command names."""
    return *test.notes, *(f"{key} assumed" for key, unit in test.units.items() if unit.assumed)


def written_values(test):
    """Frequency, amplitude per force and phase of the response against the force, as a logger has them."""
    return np.asarray(test.frequency), np.asarray(test.amplitude) / FORCE, np.asarray(test.phase)


def alike(one, other):
    pairs = ((one.frequency, other.frequency), (one.amplitude, other.amplitude), (one.phase, other.phase))
    return one.quantity == other.quantity and all(
        (a is None) == (b is None) and (a is None or (np.shape(a) == np.shape(b) and np.allclose(a, b, rtol=1e-9, atol=1e-12)))
        for a, b in pairs
    )


def same_content(one, other):
    """Equal in the tokens of each line, numbers in six digits; of a 58b in the header and in single precision of the values."""
    if b"\0" not in one and b"\0" not in other:
        return tokens(one) == tokens(other)
    start = one.rfind(b"\n", 0, one.find(b"\0")) + 1  # values follow the header
    end = one.rfind(b"    -1")
    if len(one) != len(other) or one[:start] != other[:start] or one[end:] != other[end:] or (end - start) % 4:
        return one == other
    if (end - start) % 8:
        return False
    values = [np.frombuffer(content[start:end], "<c8") for content in (one, other)]
    return bool(np.allclose(*values, rtol=1e-5, atol=NOTHING))


def tokens(content):
    lines = [line.upper() for line in content.splitlines() if line.strip()]
    return [[_value(token) for token in TOKEN.findall(line)] for line in lines]


def _value(token):
    """A number in six digits; one that is nothing beside the others is 0."""
    if not NUMBER.fullmatch(token):
        return token
    value = float(token.replace(b"D", b"E"))
    return 0.0 if abs(value) < NOTHING else float(f"{value:.5e}")


def counts(sound, group, random, number):
    return Counter(sound.verdict(group, random) for _ in range(number))
