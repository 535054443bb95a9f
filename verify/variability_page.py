"""The tables of docs/variability_numbers.md, from results/variability.json."""

from __future__ import annotations

from typing import Any

PUBLISHED = {("4.6", 20.0): "536, 549", ("4.6", 80.0): "529"}


def tables(numbers: dict[str, Any]) -> str:
    """All tables as Markdown."""
    parts = ["<!-- Written by `make verify`. Do not edit. -->"]
    parts += [peak_table(mass, found) for mass, found in numbers["peaks"].items()]
    parts += [
        ratio_table(numbers["ratios"]),
        history_table(numbers["history"]),
        proxy_table(numbers),
        variants_table(numbers["variants"]),
        cost(numbers),
    ]
    return "\n\n".join(parts) + "\n"


def peak_table(mass: str, found: dict[str, Any]) -> str:
    effort = f"{found['search']}; {found['cpu_seconds'] / 60:.0f} minutes CPU"
    heads = ("force, N", "virgin", "sampled start states", "lower bound, at Hz, η", "upper bound, at Hz, η", "spread, µm")
    lines = [
        f"**Resonance peak, {mass} kg** (amplitudes in nm per N of force; {effort})",
        "",
        "| " + " | ".join((*heads, "of the virgin", "published Hz")) + " |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for k, force in enumerate(found["force"]):
        nm = 1e9 / force
        (low, high), (f_low, f_high), (e_low, e_high) = (found[key][k] for key in ("amplitude", "resonance", "loss_factor"))
        spread = (high - low) / found["virgin"][k]
        cells = (
            f"{force:g}",
            f"{nm * found['virgin'][k]:.0f}",
            f"{nm * found['cloud'][0][k]:.0f} to {nm * found['cloud'][1][k]:.0f}",
            f"{nm * low:.0f}, {f_low:.1f}, {e_low:.4f}",
            f"{nm * high:.0f}, {f_high:.1f}, {e_high:.4f}",
            f"{1e6 * (high - low):.3f}",
            f"{100 * spread:.0f} %",
            PUBLISHED.get((mass, force), ""),
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def ratio_table(found: dict[str, Any]) -> str:
    """The peak by the published variable, in the plane of the dampers."""
    common = found["common"]
    (low, high), (f_low, f_high), (e_low, e_high) = (found[key] for key in ("amplitude", "resonance", "loss_factor"))
    lines = [
        "**Traction ratios in the plane of the dampers, sliders at 0 along their axes, 4.6 kg, 20 N** (published: 536, 549 Hz)",
        "",
        "| start state | peak, Hz | nm/N | η |",
        "| --- | --- | --- | --- |",
    ]
    for ratio, frequency, amplitude in zip(common["ratio"], common["frequency"], common["amplitude"], strict=True):
        lines.append(f"| ratio {ratio:.1f} at all contacts | {frequency:.1f} | {1e9 * amplitude / 20.0:.0f} | |")
    lines.append(f"| one ratio per contact, searched: lower bound | {f_low:.1f} | {1e9 * low / 20.0:.0f} | {e_low:.4f} |")
    lines.append(f"| one ratio per contact, searched: upper bound | {f_high:.1f} | {1e9 * high / 20.0:.0f} | {e_high:.4f} |")
    unsolved = f"{found['unsolved']} of {found['cloud']} sampled start states have no solution"
    return "\n".join([*lines, "", f"{unsolved}; {found['cpu_seconds'] / 60:.0f} minutes CPU."])


def history_table(found: dict[str, Any]) -> str:
    lines = [
        "**A history: 1 to 100 N and back, 4.6 kg**",
        "",
        "| force, N | before: nm/N, at Hz | after: nm/N, at Hz | largest change of a mean contact force, N |",
        "| --- | --- | --- | --- |",
    ]
    last = len(found["force"]) - 1
    for k, force in enumerate(found["force"][: last // 2]):
        first, second = (f"{1e9 * found['amplitude'][i] / force:.0f}, {found['frequency'][i]:.0f}" for i in (k, last - k))
        lines.append(f"| {force:g} | {first} | {second} | {found['change'][str(force)]['mean_force']:.3f} |")
    return "\n".join(lines)


def variants_table(found: dict[str, Any]) -> str:
    """Other models of the rig: stuck frequency and virgin peaks."""
    levels = found["force"]
    lines = [
        "**Other models of the same rig, 4.6 kg, virgin contacts**: peak in Hz, µm",
        "",
        "| model | stuck, Hz | " + " | ".join(f"{level:g} N" for level in levels) + " |",
        "| --- | --- |" + " --- |" * len(levels),
    ]
    for name, model in found["models"].items():
        pairs = zip(model["frequency"], model["amplitude"], strict=True)
        peaks = (f"{f:.1f}, {1e6 * a:.3f}" if f == f else "none in 490 to 590 Hz" for f, a in pairs)
        lines.append(f"| {name} | {model['stuck']:.1f} | " + " | ".join(peaks) + " |")
    return "\n".join(lines)


def proxy_table(numbers: dict[str, Any]) -> str:
    lines = [
        "**Amplitude bounds and loss-factor bounds, 4.6 kg, 500 to 575 Hz, against 40 sampled start states at each frequency**",
        "",
        "| force | objective | samples below the lower bound | above the upper bound | worst below | worst above | CPU, s |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for level in ("20", "80"):
        record = numbers[f"proxy_{level}N"]
        for objective in ("amplitude", "loss_factor"):
            r = record[objective]
            below, above = min(r["worst"][0], 0.0), max(r["worst"][1], 0.0)
            shares = f"{100 * r['below']:.0f} % | {100 * r['above']:.0f} % | {100 * below:.1f} % | {100 * above:.1f} %"
            lines.append(f"| {level} N | {objective.replace('_', ' ')} | {shares} | {record['cpu_seconds'][objective]:.0f} |")
    drawn = (f"{numbers[f'fresh_{level}N']['solved']:.0f} at {level} N" for level in ("20", "80"))
    outside = sum(numbers[f"fresh_{level}N"]["outside"] for level in ("20", "80"))
    lines += [
        "",
        f"Of other start states, which no search has seen ({', '.join(drawn)}), {outside:.0f} lie outside the amplitude bounds.",
    ]
    return "\n".join(lines)


def cost(numbers: dict[str, Any]) -> str:
    c, six = numbers["cost"], numbers["six_sliders"]
    solves = numbers["proxy_20N"]["solves"]
    return (
        f"**Cost.** The same search with {c['variables']} variables takes {c['exact']} residual evaluations with exact gradients "
        f"and {c['forward_differences']} with forward differences: {c['forward_differences'] / c['exact']:.0f} times as many. "
        f"One frequency of the rig at 20 N takes {min(solves):.0f} to {max(solves):.0f} solutions for both bounds.\n\n"
        "**Six free sliders, 20 N, 540 Hz**: 20 000 draws reach "
        f"{1e6 * six['lower_drawn']:.4f} to {1e6 * six['upper_drawn']:.4f} µm, the best 50 polished "
        f"{1e6 * six['lower_polished']:.4f} to {1e6 * six['upper_polished']:.4f} µm (with {six['lower_local_optima']} and "
        f"{six['upper_local_optima']} different local optima), the search {1e6 * six['lower_bound']:.4f} to "
        f"{1e6 * six['upper_bound']:.4f} µm."
    )
