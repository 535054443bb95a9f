"""Bulk data of Nastran as entries of fields: small fields of 8, large ones of 16 (NAME*), free format with commas.

Included files are read in place, replicated entries (=) written out, and nothing is read after ENDDATA.
(MSC Nastran Quick Reference Guide, Format of bulk data entries; Replication; INCLUDE; ENDDATA.)

Bulk data entries of Nastran by what the reader of grid points does with them.

What defines properties, loads, constraints, springs and beams, aerodynamics or an optimisation says nothing about where grid
points lie; matrices come from their own file. (MSC Nastran and Simcenter Nastran Quick Reference Guides, Bulk data entries.)
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from stickslip.model.readers.deck import CardList
from stickslip.model.readers.included_files import Line, Lines
from stickslip.model.readers.limits import refuse_utf_16, within_memory
from stickslip.model.readers.numbers import number_of
from stickslip.support.checks import fault


def _names(text: str) -> frozenset[str]:
    return frozenset(text.split())


BULK_CARDS = CardList(
    obeyed=_names(
        """
        BEGIN CHEXA CORD1C CORD1R CORD1S CORD2C CORD2R CORD2S CPENTA CPYRA CPYRAM CQUAD4 CQUAD8 CQUADR CTETRA CTRIA3 CTRIA6 CTRIAR
        ENDDATA EXTRN GRDSET GRID INCLUDE
        """
    ),
    harmless=_names(
        """
        ACADAPT ACCEL ACCEL1 ACMODL ACORDER ACPLNW ACSRCE ADAPT AECOMP AECOMPL AEDW AEFACT AEFORCE AEGRID AELINK AELIST
        AELISTC AEPARM AEPRESS AEQUAD4 AERO AEROS AESTAT AESURF AESURFS AETRIA3 AMLREG ASET ASET1 AXSLOT BAROR BCBDPRP
        BCBODY BCBODY1 BCONECT BCONP BCONPRG BCONPRP BCPARA BCPROP BCRPARA BCSURF BCTABL1 BCTABLE BCTADD BCTPARA BCTPARM
        BCTRIM BCTSET BDYLIST BDYOR BEADVAR BEAMOR BFRIC BGADD BGPARM BGSET BLSEG BMFACE BNDFIX BNDFIX1 BNDFREE BNDFREE1
        BNDGRID BOLT BOLTFOR BOLTFRC BOLTLD BOLTSEQ BOUTPUT BSET BSET1 BSQUEAL BSURF BSURFS BWIDTH CAABSF CACINF3 CACINF4
        CAERO1 CAERO2 CAERO3 CAERO4 CAERO5 CAMPBLL CBAR CBARAO CBEAM CBEAM3 CBELT CBEND CBUSH CBUSH1D CBUSH2D CBUTT
        CCONEAX CCRSFIL CDAMP1 CDAMP1D CDAMP2 CDAMP2D CDAMP3 CDAMP4 CDAMP5 CDUM1 CDUM2 CDUM3 CDUM4 CDUM5 CDUM6 CDUM7 CDUM8
        CDUM9 CELAS1 CELAS1D CELAS2 CELAS2D CELAS3 CELAS4 CFAST CFILLET CFLUID2 CFLUID3 CFLUID4 CGAP CHACAB CHACBR CHBDYE
        CHBDYG CHBDYP CHEXCZ CIFHEX CIFPENT CIFQDX CIFQUAD CINTC CLOAD CMASS1 CMASS2 CMASS3 CMASS4 CMFREE CMREBAI CMREBAR
        CONM1 CONM2 CONROD CONTRLT CONV CONVM CPENTCZ CPLSTN3 CPLSTN4 CPLSTN6 CPLSTN8 CPLSTS3 CPLSTS4 CPLSTS6 CPLSTS8
        CQUAD CQUADX CQUADX4 CQUADX8 CRAC2D CRAC3D CREEP CROD CSEAM CSET CSET1 CSHEAR CSLOT3 CSLOT4 CSPR CSSCHD CTQUAD
        CTRAX3 CTRAX6 CTRIAX CTRIAX6 CTTRIA CTUBE CVISC CWELD CWSEAM CYAX CYJOIN CYSUP CYSYM DAMPING DAMPMT DAREA DCONADD
        DCONSTR DDVAL DEFORM DEFUSET DELAY DEQATN DESVAR DIVERG DLINK DLOAD DMI DMIAX DMIG DMIGOUT DMIGROT DMIJ DMIJI DMIK
        DMNCON DOPTPRM DPHASE DRESP1 DRESP2 DRESP3 DSCREEN DSPARM DTABLE DTABLE2 DTEMP DTEMPEX DTI DVBSHAP DVCREL1 DVCREL2
        DVGEOM DVGRID DVMREL1 DVMREL2 DVPREL1 DVPREL2 DVPSURF DVSET DVSHAP DVTREL1 DYNRED EBDADD EBDSET ECHOOFF ECHOON
        EIGB EIGC EIGP EIGR EIGRL ELAR ELAR2 ELARADD ELEMUDS ELIST ENTUDS EPOINT ERPPNL EXCLUDE FATIGUE FBADLAY FBALOAD
        FBAPHAS FBODYLD FBODYSB FLFACT FLSYM FLUTTER FORCDST FORCE FORCE1 FORCE2 FORCEAX FREEPT FREQ FREQ1 FREQ2 FREQ3
        FREQ4 FREQ5 FRFCOMP FRFCONN FRFFLEX FRFRELS FRFSPC1 FRFXIT FRFXIT1 FSLIST FTGDEF FTGEVNT FTGLOAD FTGPARM FTGSEQ
        GENEL GMBC GMCURV GMINTS GMLOAD GMSPC GMSURF GRAV GROUP GUST HADACRI HADAMPT HADAMSL HYBDAMP INITADD INITIAL INITS
        INITSO IPSTRAIN ISTRESS ISTRN ISTRNTS ITER JCONADD JCONSET LOAD LOADCLID LOADCNAM LOADCSUB LOADCYH LOADCYN LOADCYT
        LOADOF LOADT LSEQ MARCIN MARCOUT MASSSET MAT1 MAT10 MAT10C MAT11 MAT2 MAT3 MAT4 MAT5 MAT8 MAT9 MATCID MATCRP MATCZ
        MATDIGI MATDMG MATEP MATF MATF1 MATFTG MATG MATHE MATHED MATHP MATM MATNLE MATNLE1 MATNLE2 MATNLE3 MATNLE4 MATNLE5
        MATORT MATOVR MATPE1 MATPE2 MATPLCY MATPOR MATS1 MATS3 MATS8 MATSMA MATSORT MATSR MATT1 MATT10 MATT11 MATT2 MATT3
        MATT4 MATT5 MATT8 MATT9 MATTC MATTEP MATTF MATTG MATTHE MATTM MATTORT MATTUSR MATTVE MATUSR MATVE MATVP MBOLT
        MBOLTUS MCOHE MDLPRM MFLUID MICPNT MKAERO1 MKAERO2 MLAYERS MODTRAK MOMAX MOMENT MOMENT1 MOMENT2 MONCARL MONDSP1
        MONGRP MONPNT1 MONPNT2 MONPNT3 MONSUM MONSUM1 MONSUMT MPC MPCADD MPCAX MPCD MPCY MPHEAT MPROCS MTCREEP MTHERM
        NLADAPT NLAUTO NLCNTL NLCNTL2 NLCNTLG NLFREQ NLFREQ1 NLHARM NLHEATC NLMOPTS NLOUT NLPARM NLPCI NLRGAP NLRSFD
        NLSTEP NLSTRAT NOLIN1 NOLIN2 NOLIN3 NOLIN4 NSM NSM1 NSMADD NSML NSML1 NTHICK OMIT OMIT1 OUTPUT OUTRCV PAABSF
        PACABS PACBAR PACINF PAERO1 PAERO2 PAERO3 PAERO4 PAERO5 PANEL PARAM PBAR PBARL PBARN1 PBCOMP PBDISCR PBEAM PBEAM3
        PBEAML PBEAMT PBELTD PBEMN1 PBEND PBMARB6 PBMNUM6 PBMSECT PBRSECT PBSPOT PBUSH PBUSH1D PBUSH2D PBUSHT PCOHE PCOMP
        PCOMPF PCOMPG PCOMPLS PCOMPS PCONEAX PCONV PCONV1 PCONVM PDAMP PDAMP5 PDAMPT PDISTB PDISTBM PDUM1 PDUM2 PDUM3
        PDUM4 PDUM5 PDUM6 PDUM7 PDUM8 PDUM9 PELAS PELAST PERMEAB PFAST PFASTT PGAP PGPLSN PHBDY PIHEX PINTC PINTS PLBLMX
        PLCOMP PLOAD PLOAD1 PLOAD2 PLOAD4 PLOADB3 PLOADE1 PLOADFP PLOADX PLOADX1 PLOTEL PLOTEL3 PLOTEL4 PLOTEL6 PLOTEL8
        PLOTHEX PLOTPEN PLOTPYR PLOTTET PLPLANE PLSOLID PLTSURF PMARKER PMASS PMIC PMINC PMREBAI PMREBAR PORUDS PPLANE
        PRAC2D PRAC3D PRESAX PRESPT PRIM1 PRIM2 PRIM3 PRIM4 PRIM5 PRIM6 PRIM7 PRIM8 PRJCON PROD PSEAM PSET PSHEAR PSHEARN
        PSHELL PSHLN1 PSHLN2 PSLDN1 PSOLCZ PSOLID PSPH PSPRMAT PSURFI PTSHELL PTUBE PVAL PVISC PWELD PWSEAM QBDY1 QBDY2
        QBDY3 QHBDY QSET QSET1 QVECT QVOL RADBC RADBND RADCAV RADCOL RADCT RADLST RADM RADMT RADMTX RADSET RANDPS RANDT1
        RANDVAR RBAR RBAR1 RBAX3D RBE1 RBE2 RBE2A RBE2F RBE2GS RBE3 RCPARM RCROSS REGION RELEASE RESTART RFORCE RFORCE1
        RFORCE2 RGYRO RJOINT RLOAD1 RLOAD2 ROTBENT ROTHYBD ROTOR ROTORAX ROTORB ROTORD ROTORG ROTORSE ROTPARM ROUGH RROD
        RSPINR RSPINT RSPLINE RSSCON RTRPLT RTRPLT1 RVDOF RVDOF1 SEBNDRY SEBSET SEBSET1 SEBULK SECONCT SECSET SECSET1
        SEDLINK SEDRSP2 SEDRSP3 SEELT SEEXCLD SELABEL SELOAD SENQSET SEQGP SEQSEP SEQSET SEQSET1 SESET SESUP SETREE
        SEUPDATE SEUSET SEUSET1 SHREL SHRPOL SICDATA SLBDY SLOAD SNORM SPBLND1 SPBLND2 SPC SPC1 SPCADD SPCAX SPCD SPCG
        SPCOFF SPCOFF1 SPCR SPLINE1 SPLINE2 SPLINE3 SPLINE4 SPLINE5 SPLINE6 SPLINE7 SPLINEX SPLINRB SPOINT SPRELAX STOCHAS
        SUPAX SUPORT SUPORT1 SUPORT6 SURFINI SWLDPRM TABD TABDMP1 TABISTR TABLE3D TABLED1 TABLED2 TABLED3 TABLED4 TABLED5
        TABLEF TABLEF1 TABLEH TABLEH1 TABLEHT TABLEM1 TABLEM2 TABLEM3 TABLEM4 TABLEM5 TABLES1 TABLES2 TABLEST TABLFTG
        TABRND1 TABRNDG TABSCTL TEMP TEMPAX TEMPB3 TEMPBC TEMPD TEMPEX TEMPF TEMPN1 TEMPP1 TEMPP2 TEMPP3 TEMPRB TF THPAD
        TIC TIC3 TICD TIRE TLOAD1 TLOAD2 TMCPARA TMPSET TOPVAR TRIM TRIM2 TRMCPL TSTEP TSTEP1 TSTEPNL TTEMP UDNAME
        UNBALNC USET USET1 UXVEC VARIAN VATVFS VCCT VIEW VIEW3D VIEWEX WEIGHT WETELME WETELMG WETLOAD WETSURF YLDRPL
        """
    ),
    refused={
        "CORD3G": "Give the axes with CORD2R.",
        "CORD3R": "Give the axes with CORD2R.",
        "CORD3RX": "Give the axes with CORD2R.",
        "GMCORD": "Give the axes with CORD2R.",
        "CGEN": "Write the generated grid points out.",
        "EGRID": "Write the generated grid points out.",
        "GRIDG": "Write the generated grid points out.",
        "MDMOVE": "Write the grid points out where the modules are moved to.",
        "/": "Write the deck without entries that delete others.",
    },
    noted={
        "CSUPER": "the grid points inside a superelement are missing",
        "CSUPEXT": "the grid points inside a superelement are missing",
        "SELOC": "superelements are not read",
        "SEMPLN": "superelements are not read",
        "GRIDB": "its grid points get no coordinates",
        "GRIDF": "its grid points get no coordinates",
        "GRIDS": "its grid points get no coordinates",
        "GRIDA": "its grid points get no coordinates",
        "FEEDGE": "grid points on its edge keep the coordinates of their GRID entries",
        "FEFACE": "grid points on its face keep the coordinates of their GRID entries",
        "RINGAX": "rings are not read as grid points",
        "RINGFL": "rings are not read as grid points",
        "SECTAX": "sectors are not read as grid points",
        "POINTAX": "points on rings are not read as grid points",
        "AXIC": "rings are not read as grid points",
        "AXIF": "rings are not read as grid points",
        "POINT": "points of edges are not read as grid points",
        "SET1": "give sets in a table, node,x,y,z,set",
        "SET2": "give sets in a table, node,x,y,z,set",
        "SET3": "give sets in a table, node,x,y,z,set",
    },
)


EXPONENT = re.compile(r"([0-9.])([+-]\d+)$")
REPEAT = re.compile(r"=\(?(\d{1,9})\)?")
SECTION = re.compile(r"\s*BEGIN\s+(BULK\b.*|SUPER\b.*|MODULE\b.*|AUXMODEL\b.*|$)", re.IGNORECASE)
BEGIN = "BEGIN"
"""The name of the entry that stands for BEGIN BULK, BEGIN SUPER=7: its second field is what follows the word."""
MOST_REPLICATED = 100_000
"""Entries that = makes in a deck: more is a slip."""
SMALL, LARGE = 8, 4
"""Fields of a line beside its first and the mark of its continuation."""


class Entry(NamedTuple):
    """The fields of an entry with its continuations, the name without its star first; and where it begins."""

    fields: list[str]
    line: Line


WITH_TEXT = {"DEQATN", "DRESP3", "GROUP", "MONCARL", "MONDSP1", "MONGRP", "MONSUM", "MONSUM1", "MONSUMT", "UDNAME"}
WITH_TEXT |= {"MONPNT1", "MONPNT2", "MONPNT3"}
"""Entries with an equation, a label or a name of a file, in which commas part no fields."""
FREE_FORMAT = re.compile(
    r"\s*(BEGIN|CHEXA|CORD[12][CRS]|CPENTA|CPYRAM?|CQUAD[48R]|CTETRA|CTRIA[36R]|DMIG|EXTRN|GRDSET|GRID)\s*,", re.IGNORECASE
)
"""A line of such an entry that counts, behind blanks."""


def included(text: str, more: Iterator[str]) -> str | None:
    """The file of INCLUDE 'FILE', whose name in quotation marks may go on over several lines."""
    match = re.match(r"\s*INCLUDE\b\s*=?\s*(.*)", text, re.IGNORECASE)
    if not match:
        return None
    name = match[1].strip()
    mark = name[:1]
    if mark not in ("'", '"'):
        return name.split("$")[0].strip()
    while name.count(mark) < 2 and (line := next(more, None)) is not None:
        name += line.strip()
    return name.split(mark)[1]


def bulk_lines(path: Path, memory: int) -> Iterator[Line]:
    """The lines of the bulk data of a deck, after Executive and Case Control where it has them; memory: as `Lines` has it."""
    within_memory(path.name, memory * path.stat().st_size)
    refuse_utf_16(path)
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        started = not any(SECTION.match(text) for text in file)

    def named(text: str, more: Iterator[str]) -> str | None:
        nonlocal started
        started = started or SECTION.match(text) is not None
        return included(text, more) if started else None

    yield from (line for line in Lines(path, named, memory).read() if started)


def entries(lines: Iterable[Line]) -> Iterator[Entry]:
    """Each bulk data entry with its continuations, replicated ones written out; up to ENDDATA."""
    entry: Entry | None = None  # the last one, until a line shows that no continuation of it follows
    mark = ""
    pattern: list[str] = []
    made = 0
    for line in lines:
        text = line.text.split("$")[0].expandtabs()
        if not text.strip():
            continue
        if re.match(r"\s*ENDDATA\b", text, re.IGNORECASE):
            break
        section = SECTION.match(text)
        name = re.match(r"\s*([A-Z][A-Z0-9]*)", text, re.IGNORECASE)
        if not section and name and name[1].upper() in WITH_TEXT:
            if entry is not None:
                yield entry
            entry, mark = Entry([name[1].upper()], line), ""
            continue
        if entry is not None and entry.fields[0] in WITH_TEXT and re.match(r" {8}|[+*]", text) and not FREE_FORMAT.match(text):
            continue
        first, *rest = [BEGIN, section[1].upper()] if section else _fields(text, line)
        if first.startswith("=") and entry is not None:
            yield entry
            count = REPEAT.fullmatch(first)
            pattern = pattern if count else rest  # =(3) repeats the pattern of the line before, = has one of its own
            times = int(count[1]) if count else 1
            made += times
            if made > MOST_REPLICATED or not pattern or len(entry.fields) > SMALL + 1:
                raise fault(f"{line.place}, replication", "must repeat entries of one line", first, "Write the entries out.")
            for number in range(times):
                entry = Entry(_replicated(entry.fields, pattern, line), line)
                if number < times - 1:
                    yield entry
        elif first in ("", "*") or first[0] in "+*":
            _refuse_out_of_order(entry, mark, first, line)
            if entry is not None:
                entry.fields.extend(rest)
            mark = _mark(text)
        else:
            mark = _mark(text)
            if entry is not None:
                yield entry
            entry = Entry([first.partition(" ")[0].rstrip("*").upper(), *rest], line)
    if entry is not None:
        yield entry


def _refuse_out_of_order(entry: Entry | None, mark: str, first: str, line: Line) -> None:
    """Refuse a continuation that does not stand behind the line it continues, whose last field has the same mark."""
    own = first.lstrip("+*").strip().upper()
    alone = entry is None or entry.fields[0] == BEGIN
    if alone or (own and mark and own != mark):
        remedy = "Sort the file, so that each entry is whole."
        behind = "behind no entry" if alone else f"behind a line that ends in {mark!r}"
        raise fault(f"{line.place}, the continuation {first!r}", "must follow the line it continues", behind, remedy)


def _mark(text: str) -> str:
    """The mark of the continuation, the last field of a line."""
    words = text.split(",")
    count = LARGE if "*" in words[0][:8] else SMALL
    last = words[count + 1] if len(words) > count + 1 else "" if len(words) > 1 else text[72:80]
    return last.strip().lstrip("+*").strip().upper()


def _fields(text: str, line: Line) -> list[str]:
    """The first field, and eight small or four large ones; blanks where the line ends early."""
    count = LARGE if "*" in text.split(",")[0][:8] and not text.startswith("=") else SMALL
    if "," in text:
        words = [word.strip() for word in text.split(",")]
        if any(words[count + 2 :]):
            raise fault(
                line.place, f"must hold at most {count} fields after its name", words[:20], "Continue it on another line."
            )
        return (words + [""] * count)[: count + 1]
    width = 64 // count
    return [text[:8].strip(), *(text[start : start + width].strip() for start in range(8, 72, width))]


def _replicated(previous: list[str], pattern: list[str], line: Line) -> list[str]:
    """The entry after `previous`: = is the same field, *x one greater by x, == all fields that are left, others themselves."""
    made = [previous[0]]
    for old, word in zip(previous[1:], pattern, strict=False):
        if word == "==":
            return [*made, *previous[len(made) :]]
        if word.startswith("*"):
            step = word.strip("*()")
            plain = re.fullmatch(r"[+-]?\d*", old) and re.fullmatch(r"[+-]?\d+", step)
            made.append(str(int(old or 0) + int(step)) if plain else repr(number(old) + number(step)))
        elif word.startswith("=") and word != "=":
            raise fault(f"{line.place}, replication", "must hold =, ==, *increment or a value", word, "Write the entries out.")
        else:
            made.append(old if word == "=" else word)
    return made


def integer(word: str) -> int:
    """A whole number; large fields hold up to 16 digits."""
    if not re.fullmatch(r"[+-]?\d{1,16}", word):
        raise fault("A field of an entry", "must be a whole number", word[:20])
    return int(word)


def positive_integer(word: str) -> int:
    """The number of a grid point."""
    value = integer(word)
    if value < 1:
        raise fault("The number of a grid point", "must be positive", value)
    return value


def number(word: str) -> float:
    """A number as Nastran writes it: 1.0+5 and 1.0D+5 are 1e5, a blank is 0."""
    text = EXPONENT.sub(r"\1E\2", word)
    value = number_of(text) if text else 0.0
    if value is None:
        raise fault("A field of an entry", "must be a number", word[:20])
    return value
