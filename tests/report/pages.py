"""A page as a browser would read it: elements, table cells, and the charts with their numbers written out."""

import base64
import gzip
import itertools
import json
from html.parser import HTMLParser
from math import isfinite

import numpy as np

from stickslip.show.report import write


class Page(HTMLParser):
    """Elements, table cells and scripts of a page, as a browser would split them."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.rows, self.scripts, self.words = [], [], [], []
        self._table = self._cell = self._script = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.elements.append((tag, attrs))
        if tag == "table":
            self._table = attrs.get("id")
        if tag == "tr":
            self.rows.append((self._table, attrs, []))
        if tag in ("td", "th"):
            self.rows[-1][2].append(attrs)
        if tag == "script":
            self.scripts.append((attrs, ""))
            self._script = True

    def handle_endtag(self, tag):
        self._script = None if tag == "script" else self._script

    def handle_data(self, data):
        if self._script:
            self.scripts[-1] = (self.scripts[-1][0], self.scripts[-1][1] + data)
        else:
            self.words.append(data)

    def numbers(self, table):
        """data-value of the cells of each row."""
        found = [
            [float(cell["data-value"]) for cell in cells if "data-value" in cell] for name, _, cells in self.rows if name == table
        ]
        return [row for row in found if row]

    def data(self):
        return json.loads(self.unpacked("data"))

    def unpacked(self, identifier):
        """The text of an element that holds it gzipped."""
        packed = next(text for attrs, text in self.scripts if attrs.get("id") == identifier)
        return gzip.decompress(base64.b64decode(packed)).decode()

    def charts(self, place, result=0):
        """Charts of a place with their numbers written out, by the choices that show them."""
        data = self.data()
        entry = data["places"][place][result]
        keys = itertools.product(*(choice["options"] for choice in entry["choices"]))
        return dict(zip(keys, decoded(entry["charts"], data["parts"]), strict=True))

    def text(self):
        return " ".join(" ".join(self.words).split())


def decoded(part, parts):
    """What report.js makes of the data of a chart, but for its colours."""
    if isinstance(part, list):
        return [decoded(value, parts) for value in part]
    if isinstance(part, dict) and "factor" in part:
        values = decoded(parts[part["part"]], parts)
        return [None if value is None or not isfinite(value) else value * part["factor"] for value in values]
    if isinstance(part, dict) and part.get("kind") == "Float32Array":
        return np.frombuffer(base64.b64decode(part["bytes"]), "<f4").astype(float).tolist()
    if isinstance(part, dict) and "part" in part:
        found = decoded(parts[part["part"]], parts)
        return found | {key: value for key, value in part.items() if key != "part"} if isinstance(found, dict) else found
    return {key: decoded(value, parts) for key, value in part.items()} if isinstance(part, dict) else part


def page_of(datasets, tmp_path):
    return Page(write(datasets, tmp_path / "report.html").read_text(encoding="utf-8"))
