"""Presentation of mistuned disks."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from stickslip.analyses.mistuning.work import blade_margins, quantile_interval, smallest_blade_margin
from stickslip.analyses.stress import has_fatigue
from stickslip.results.schema import in_system, system_of
from stickslip.results.view import energy_text, size_text
from stickslip.show.plots.disk import all_blades, amplification, busiest_damper, worst_blade
from stickslip.show.plots.paper import Figures
from stickslip.show.report.markup import presents
from stickslip.support.checks import Array, counted
from stickslip.support.late import pd, xr


def sentences(dataset: "xr.Dataset") -> list[str]:
    """The highest amplification and its blade, the tuned disk, the distribution."""
    solved = dataset.isel(sample=dataset["worst_blade"].values > 0)
    tuned, place = float(dataset["tuned_peak"]), float(dataset["tuned_peak_frequency"])
    units = dataset["tuned_peak"].attrs["units"]
    edge = _edge(dataset["tuned_frequency"].values, place)
    disk = f"tuned disk of {dataset.attrs['sectors']} blades: {size_text(tuned, units, dataset)} at {place:.5g} Hz{edge}"
    ratio = solved["amplification"].values
    if not np.isfinite(ratio).any():
        return ["no amplification: every sample or the tuned disk failed", disk]
    top = solved.isel(sample=int(ratio.argmax()))
    blade = int(top["worst_blade"])
    place = float(top["blade_peak_frequency"].sel(blade=blade))
    where = f"blade {blade} at {place:.5g} Hz{_edge(top['frequency'].values, place)}"
    damper = int(top["busiest_damper"])
    if bool(top["damper_missing"].all()):
        busiest = "no dampers"
    elif not damper:
        busiest = "all dampers stuck"
    else:
        work = energy_text(float(top["damper_work"].sel(blade=damper)), top)
        busiest = f"where the damper after blade {damper} works most ({work} a period)"
    lines = [f"highest amplification {float(ratio.max()):.4g}: {where}, {busiest}", disk]
    if "stress_von_mises" in dataset:
        lines.append(_stress(solved))
    lines += _fatigue(dataset)
    if ratio.size > 1:
        middle, high = (_with_interval(ratio, share) for share in (0.5, 0.95))
        lines.append(f"{ratio.size} samples: median {middle}, 95 % stay below {high}, mean {ratio.mean():.4g}")
        often, times = Counter(solved["worst_blade"].values.tolist()).most_common(1)[0]
        lines.append(f"most often worst: blade {often}, in {counted(times, 'sample')}")
        often, times = Counter(solved["busiest_damper"].values.tolist()).most_common(1)[0]
        if often:
            lines.append(f"most often busiest: the damper after blade {often}, in {counted(times, 'sample')}")
    return lines


def _with_interval(values: Array, share: float) -> str:
    """A quantile with its 95 % confidence interval: "1.31 (1.28 to 1.4)", or "1.31 (from 1.28)" where samples are too few."""
    low, high = (f"{end:.4g}" if np.isfinite(end) else "" for end in quantile_interval(values, share))
    ends = f"{low} to {high}" if low and high else f"from {low}" if low else f"to {high}" if high else ""
    return f"{np.quantile(values, share):.4g}" + (f" ({ends})" if ends else "")


def _edge(frequencies: Array, place: float) -> str:
    """What to add where the highest value stands at an end of several frequencies: the peak itself may lie beyond."""
    known = frequencies[np.isfinite(frequencies)]
    at_end = np.unique(known).size > 1 and bool(np.isclose(place, [known.min(), known.max()], rtol=1e-12, atol=0.0).any())
    return " (the edge of the band: a peak may lie beyond)" if at_end else ""


def _stress(dataset: "xr.Dataset") -> str:
    """The largest stress of all blades and samples, each blade at its largest amplitude, and that of the tuned disk."""
    stress, (factor, unit) = dataset["stress_von_mises"], in_system("MPa", system_of(dataset))
    sample, blade, place = np.unravel_index(int(np.nanargmax(stress.values)), stress.shape)
    here = f"blade {dataset['blade'].values[blade]}, {dataset['place'].values[place]}"
    largest = stress.values[sample, blade, place], dataset["tuned_stress_von_mises"].max()
    sizes = [factor * 1e-6 * float(size) for size in largest]
    return f"largest von Mises stress {sizes[0]:.4g} {unit}: {here}; of the tuned disk {sizes[1]:.4g} {unit}"


def _fatigue(dataset: "xr.Dataset") -> list[str]:
    """The smallest fatigue margin with its blade and sample, and how margins are spread over the samples."""
    worst = smallest_blade_margin(dataset)
    if worst is None:
        return []
    several = dataset.sizes["sample"] > 1
    sample = f" of sample {worst.sample}" if several else ""
    where = f"blade {worst.blade}{sample}, {worst.place}, at {worst.frequency:.5g} Hz"
    factor, unit = in_system("MPa", system_of(dataset))
    amplitude, mean = (f"{factor * 1e-6 * size:.4g} {unit}" for size in (worst.alternating, worst.mean))
    verdict = "" if worst.size >= 1.0 else "; the material does not withstand it"
    lines = [
        f"smallest fatigue margin {worst.size:.4g} ({dataset.attrs['fatigue_criterion']}): {where}, amplitude {amplitude} at a "
        f"mean of {mean}{verdict}; of the tuned disk {worst.tuned:.4g}"
    ]
    smallest = blade_margins(dataset).min(["blade", "place"]).dropna("sample").values
    if several and np.isfinite(smallest).all():
        low, middle = (_with_interval(smallest, share) for share in (0.05, 0.5))
        lines.append(f"smallest fatigue margins of the samples: median {middle}, 5 % stay below {low}")
    return lines


def failures(dataset: "xr.Dataset") -> list[str]:
    """Samples that failed, grouped by why."""
    reasons: dict[str, list[int]] = {}
    for sample in np.flatnonzero(dataset["worst_blade"].values == 0):
        reasons.setdefault(str(dataset["sample_message"].values[sample]), []).append(int(sample) + 1)
    lines = [f"{counted(len(samples), 'sample')} failed, the first is {samples[0]}: {why}" for why, samples in reasons.items()]
    if not np.isfinite(float(dataset["tuned_peak"])):
        lines.append("The tuned disk failed, so there is no amplification.")
    return lines


def tables(dataset: "xr.Dataset") -> "Mapping[str, pd.DataFrame]":
    """Every sample, and every blade of the worst one."""
    units = dataset["blade_peak"].attrs["units"]
    samples = pd.DataFrame(
        {
            "sample": range(1, dataset.sizes["sample"] + 1),
            "amplification": dataset["amplification"].values,
            "worst blade": _known(dataset["worst_blade"]),
            "busiest damper": _known(dataset["busiest_damper"]),
            f"largest amplitude [{units}]": dataset["blade_peak"].max("blade").values,
            "dampers missing": dataset["damper_missing"].sum("blade").values,
        }
    )
    if "stress_von_mises" in dataset:
        samples["largest stress [Pa]"] = dataset["stress_von_mises"].max(["blade", "place"]).values
    if has_fatigue(dataset):
        samples["smallest margin"] = blade_margins(dataset).min(["blade", "place"]).values
    frames = {"samples": samples}
    if np.isfinite(dataset["amplification"].values).any():
        top = dataset.isel(sample=int(np.nanargmax(dataset["amplification"].values)))
        columns = {"blade": top["blade"], f"largest amplitude [{units}]": top["blade_peak"], "at Hz": top["blade_peak_frequency"]}
        columns["work of the damper after it [J]"] = top["damper_work"]
        if "stress_von_mises" in top:
            columns["largest stress [Pa]"] = top["stress_von_mises"].max("place")
        if has_fatigue(top):
            columns["smallest margin"] = blade_margins(top).min("place")
        columns |= {name.replace("_", " "): top[name] for name in map(str, top) if name.endswith("_deviation")}
        frames["blades of the worst sample"] = pd.DataFrame({name: each.values for name, each in columns.items()})
    return frames


def _known(numbers: "xr.DataArray") -> "pd.Series":
    """Numbers of sectors; nothing in place of 0, where a sample failed or no damper slips."""
    found = pd.Series(numbers.values).astype("Int64")
    return found.where(found > 0)


def figures(dataset: "xr.Dataset") -> Figures:
    """The blades of the worst sample and the dampers; of several samples the distribution and the worst blades."""
    if not np.isfinite(dataset["amplification"].values).any():
        return {}
    several = dataset.sizes["sample"] > 1
    shown: Figures = {"all_blades": all_blades, "busiest_damper": busiest_damper}
    return {**shown, "amplification": amplification, "worst_blade": worst_blade} if several else shown


presents("mistuned_population", "Mistuned disks", sentences, figures, tables, failures=failures)
