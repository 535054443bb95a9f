"""Contact law in a study: the table [contact_law], from measured loops of one contact to kt, mu and law."""

from functools import partial
from typing import Annotated, Literal

from pydantic import Field

from stickslip.laboratory.identification.contact_law.fit import LoopErrors
from stickslip.laboratory.identification.contact_law.work import contact_law_work
from stickslip.study.analysis import Asked, Kind, Works, content_of
from stickslip.study.fields import FORCE, STIFFNESS, Column, Number, Positive, Table, errors_of, in_si
from stickslip.support.checks import counted

LawName = Literal["jenkins", "iwan", "dahl", "array", "valanis"]
DEFAULT: list[LawName] = ["jenkins", "iwan", "dahl", "array"]
ColumnName = Literal["displacement", "force", "normal", "time"]


class ContactLawTable(Table):
    """Measured loops of one contact, and what is known of them."""

    files: Annotated[list[str], Field(min_length=1)]
    """records (text or .mat), of many cycles or one each, in the order of the last numbers of names"""
    normal_load: Annotated[Positive | None, FORCE, Field(description="in place of a column of it in the files")] = None
    laws: Annotated[list[LawName], Field(min_length=1)] = Field(default_factory=lambda: list(DEFAULT))
    """laws to fit; of several, the simplest that predicts loops not used in the fit is chosen"""
    rig_stiffness: Annotated[Positive | None, STIFFNESS] = None
    """of what yields between displacement sensor and contact, in series with it"""
    harmonics: Annotated[int | None, Field(ge=5, le=2000)] = None
    """harmonics to which every cycle is smoothed; default: as many as the displacement needs"""
    lag: Annotated[Number, Field(ge=-0.05, le=0.05)] = 0.0
    """share of a period by which the force is recorded later than the displacement"""
    friction_over: Annotated[Annotated[list[Positive], Field(min_length=2)] | None, FORCE] = None
    """normal loads at which the friction coefficient is identified, ascending; default: one coefficient"""
    columns: dict[ColumnName, Column] = Field(default_factory=dict)
    """titles or numbers (from 1) of columns that are not understood"""
    column_units: dict[ColumnName, str] = Field(default_factory=dict)
    """units of columns, such as um or kN, where the files state none"""
    errors: dict[str, Number] = Field(default_factory=dict)
    """of sensors and rig, by the names of LoopErrors"""


def plan(asked: Asked) -> Works:
    """Files and what to fit to them; they are read when the work begins."""
    table = ContactLawTable.model_validate(asked.tables["contact_law"])
    given = in_si(table, asked.units) | {"errors": errors_of(LoopErrors, table.errors, "contact_law")}
    files, given["units"] = [asked.folder / name for name in given.pop("files")], given.pop("column_units")
    summary = f"{counted(len(files), 'file')}, {' or '.join(table.laws)}"
    work = partial(contact_law_work, files, **given)
    return Works(work, summary, lambda work, arrays: work.contact_law(arrays[0]).dataset, content_of(files))


KIND = Kind(plan, {"contact_law": ContactLawTable}, on_problem=False)
