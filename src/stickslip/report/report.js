"use strict";
// Draws the charts of the report from the JSON in #data. Text from the data reaches the page as textContent, or through plain().
const data = JSON.parse(document.getElementById("data").textContent);
const byId = id => document.getElementById(id);
const chosen = name => document.querySelector(`input[name="${name}"]:checked`).value;
const index = id => byId(id) ? Number(byId(id).value || 0) : 0;
const result = () => data.results[index("result")];
const dark = matchMedia("(prefers-color-scheme: dark)");
let printing = false;

// plotly.js has a button that uploads the chart to a server: neither the button nor the address may be there.
const CONFIG = { responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "", typesetMath: false,
  modeBarButtonsToRemove: ["sendChartToCloud", "lasso2d", "select2d", "autoScale2d"] };

// plotly.js reads a little HTML in its texts: names are shown as they are.
const plain = text => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const scheme = () => data.colours[dark.matches && !printing ? "dark" : "light"];
const levelColours = shown => shown.cases.map(c => scheme().levels[c.levels][c.colour]);
const representatives = shown => shown.representatives.map(i => ({ c: shown.cases[i], i }));
const inLegend = c => ({ name: plain(c.label), legendgroup: c.label, showlegend: c.entry, opacity: c.thin ? 0.5 : 1 });
const perForce = (shown, unit = data.length) => `${unit}${shown.newtons ? "/N" : " per unit level"}`;

// Time derivatives of the displacement: order, unit and factor from the page's unit of length.
const micro = data.length === "µm";
const QUANTITIES = { displacement: { order: 0, unit: data.length, factor: 1, symbol: "X₁" },
  velocity: { order: 1, unit: micro ? "mm/s" : "m/s", factor: micro ? 1e-3 : 1, symbol: "ωX₁" },
  acceleration: { order: 2, unit: "m/s²", factor: micro ? 1e-6 : 1, symbol: "ω²X₁" } };
const derived = (y, f, quantity) => y === null || f === null ? null : y * quantity.factor * (2 * Math.PI * f) ** quantity.order;

function joules(energy) {
  if (energy === null) return "–";
  const [size, unit] = [[1, "J"], [1e-3, "mJ"], [1e-6, "µJ"]].find(([size]) => Math.abs(energy) >= size) || [1e-9, "nJ"];
  return energy === 0 ? "0 J" : `${Number((energy / size).toPrecision(3))} ${unit}`;
}

function fill(select, names) {
  const kept = Number(select.value || 0);
  select.replaceChildren(...names.map((name, i) => new Option(name, i)));
  select.value = kept < names.length ? kept : 0;
  select.parentElement.hidden = names.length < 2;
}

function axis(title, more = {}) {
  return { title: { text: title, standoff: 8 }, gridcolor: css("--line"), zerolinecolor: css("--line"), linecolor: css("--soft"),
    showline: true, ticks: "outside", tickcolor: css("--soft"), automargin: true, ...more };
}

function draw(id, traces, layout) {
  const place = byId(id);
  if (!place) return;
  const narrow = place.clientWidth < 640;
  const base = { font: { color: printing ? "#000000" : css("--ink"), family: "system-ui, sans-serif", size: 13 }, paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)", margin: { l: 60, r: 16, t: 34, b: 48 }, hoverlabel: { namelength: 40 },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: css("--soft"), activecolor: css("--accent") },
    legend: narrow ? { orientation: "h", y: -0.25 } : { x: 1.02, y: 1 } };
  Plotly.react(place, traces, { ...base, ...layout }, CONFIG);
}

function linearCurves(shown, output, factors, normalised, quantity) {
  const words = { free: "no contacts", stuck: "contacts stuck" }, dashes = { free: "dot", stuck: "dash" };
  return Object.keys(words).flatMap(which => shown.cases.map((c, i) => ({ c, i })).filter(({ c, i }) => normalised ? i === 0 : c.first).map(({ c, i }) => ({
    x: shown.linearFrequency, y: c[which][output].map((y, k) => y === null ? null : derived(y, shown.linearFrequency[k], quantity) * factors[i]), mode: "lines", opacity: 0.6,
    line: { width: 1, dash: dashes[which], color: normalised ? css("--soft") : levelColours(shown)[i] }, name: words[which],
    legendgroup: which, showlegend: i === 0, hovertemplate: `%{x:.2f} Hz, %{y:.4g}<extra>${words[which]}, ${plain(c.level)}</extra>` })));
}

function drawCurves() {
  const shown = result(), output = index("output"), normalised = chosen("normal") === "perForce", quantity = QUANTITIES[chosen("quantity")], log = chosen("scale") === "log";
  const factors = shown.cases.map(c => normalised ? (c.force ? 1 / Math.abs(c.force) : NaN) : 1);
  const curves = shown.cases.map((c, i) => ({
    x: c.frequency, y: c.amplitude[output].map((y, k) => y === null ? null : derived(y, c.frequency[k], quantity) * factors[i]), ...inLegend(c), meta: i,
    mode: c.frequency.length < 12 ? "lines+markers" : "lines", line: { width: c.thin ? 0.8 : 2.2, color: levelColours(shown)[i] },
    hovertemplate: `%{x:.3f} Hz, %{y:.5g}<extra>${plain(c.level)}</extra>` }));
  const peaks = shown.cases.map((c, i) => ({ c, i, peak: c.dots[output][quantity.order] })).filter(p => p.peak);
  const dots = { x: peaks.map(p => p.peak.frequency), y: peaks.map(p => derived(p.peak.amplitude, p.peak.frequency, quantity) * factors[p.i]), mode: "markers", name: "peak",
    marker: { size: peaks.map(p => p.c.thin ? 4 : 8), color: peaks.map(p => levelColours(shown)[p.i]), line: { width: 1.5, color: css("--paper") } }, showlegend: false,
    text: peaks.map(p => plain(p.c.level)), hovertemplate: "%{x:.3f} Hz, %{y:.5g}<extra>peak, %{text}</extra>" };
  const failed = shown.cases.flatMap(c => c.failed.map((f, k) => ({ f, level: `${c.causes[k]}, ${plain(c.level)}` })));
  const crosses = { x: failed.map(p => p.f), y: failed.map(() => 0.012), yaxis: "y2", mode: "markers", name: "not converged",
    marker: { symbol: "x", size: 8, color: css("--bad") }, text: failed.map(p => p.level), showlegend: failed.length > 0,
    hovertemplate: "%{x:.3f} Hz<extra>%{text}</extra>" };
  const heights = curves.flatMap(c => c.y).filter(y => y > 0);
  const low = heights.reduce((a, b) => Math.min(a, b), Infinity), high = heights.reduce((a, b) => Math.max(a, b), 0);
  const range = log ? [Math.log10(0.7 * low), Math.log10(1.7 * high)] : [0, 1.06 * high];
  const title = normalised ? `|${quantity.symbol}| / F in ${perForce(shown, quantity.unit)}` : `amplitude |${quantity.symbol}| in ${quantity.unit}`;
  draw("chart-curves", [...linearCurves(shown, output, factors, normalised, quantity), ...curves, dots, crosses], {
    xaxis: axis("frequency in Hz"), hovermode: "closest",
    yaxis: axis(title, { type: log ? "log" : "linear", exponentformat: "power", ...(log && high > 30 * low ? { dtick: 1 } : {}), ...(heights.length ? { range } : {}) }),
    yaxis2: { overlaying: "y", range: [0, 1], visible: false, fixedrange: true } });
}

function tellPoint(event) {
  const clicked = event.points[0], shown = result(), c = shown.cases[clicked.data.meta];
  if (!c) return;
  const at = clicked.pointIndex, number = (x, digits = 4) => x === null ? "–" : String(Number(x.toPrecision(digits)));
  const known = c.states.map((row, i) => ({ name: shown.contacts[i], state: row[at] })).filter(row => row.state !== null);
  const stuck = known.filter(row => data.mixtures[row.state].shares[0] === 100), moving = known.filter(row => !stuck.includes(row));
  const states = moving.map(row => `${row.name} ${stateWords(row.state)}`);
  if (stuck.length) states.push(moving.length ? `the other ${stuck.length} contact directions 100 % stick` : "all contacts 100 % stick");
  byId("point").textContent = `${c.level}, point ${c.point[at]}: ${number(c.frequency[at], 7)} Hz, ` +
    `${shown.outputs[index("output")]} ${number(c.amplitude[index("output")][at])} ${data.length}, loss factor ${number(c.lossFactor[at])}, ` +
    `dissipated ${joules(c.dissipated[at])} per cycle. ${states.join("; ")}${states.length ? "." : ""}`;
  drawCycle(shown, c, at);
}

// x(t) = a0 + Σ a_h cos hωt + b_h sin hωt over one period.
function series(storage, samples) {
  return Array.from({ length: samples + 1 }, (_, n) => {
    const angle = 2 * Math.PI * n / samples;
    let x = storage[0];
    for (let h = 1; 2 * h < storage.length; h++) x += storage[2 * h - 1] * Math.cos(h * angle) + storage[2 * h] * Math.sin(h * angle);
    return x;
  });
}

function drawCycle(shown, c, at) {
  const distance = c.cycleAt.map(k => Math.abs(k - at)), nearest = distance.indexOf(Math.min(...distance));
  const loops = nearest < 0 ? [] : c.cycles[nearest].map((loop, i) => ({ loop, row: shown.cycleRows[i], colour: data.colours.contacts[i % data.colours.contacts.length] }))
    .filter(({ loop }) => loop[0].every(x => x !== null) && loop[1].every(x => x !== null));
  byId("cycle").hidden = !loops.length;
  if (!loops.length) return;
  const point = c.cycleAt[nearest], samples = 32 * Math.max(shown.harmonics, 4);
  const traces = loops.map(({ loop, row, colour }) => ({ x: series(loop[0], samples), y: series(loop[1], samples), mode: "lines", line: { color: colour, width: 2 },
    name: `${plain(shown.contacts[row])}: ${c.states[row][point] === null ? "–" : stateWords(c.states[row][point])}`,
    hovertemplate: `%{x:.4g} ${data.length}, %{y:.4g} N<extra>${plain(shown.contacts[row])}</extra>` }));
  draw("chart-cycle", traces, { xaxis: axis(`relative displacement in ${data.length}`), yaxis: axis("contact force in N"), hovermode: "closest", showlegend: true,
    title: { text: `${plain(c.level)}, point ${c.point[point]}, ${Number(c.frequency[point].toPrecision(7))} Hz (truncated to ${shown.harmonics} harmonics)`, font: { size: 14 }, x: 0.01 },
    margin: { l: 60, r: 16, t: 40, b: 48 } });
}

function stateWords(mixture) {
  const [stick, slip, open] = data.mixtures[mixture].shares;
  return [[stick, "stick"], [slip, "slip"], [open, "open"]].filter(([share]) => share > 0).map(([share, word]) => `${share} % ${word}`).join(", ");
}

function drawTrend() {
  const name = result().outputs[index("output")];
  const alike = data.results.filter(r => r.peakSymbol === data.results[0].peakSymbol);
  const traces = alike.flatMap(r => {
    const i = data.results.indexOf(r), output = r.outputs.indexOf(name), found = r.cases.filter(c => c.peak[output] && c.force), peaks = found.map(c => c.peak[output]);
    const look = { x: found.map(c => c.force), mode: r.cases.some(c => c.thin) ? "markers" : "lines+markers", name: plain(r.label), legendgroup: String(i),
      line: { color: data.results.length > 1 ? scheme().results[i] : css("--accent"), width: 2 } };
    return [{ ...look, y: peaks.map((p, k) => p.amplitude / Math.abs(found[k].force)), showlegend: data.results.length > 1 },
      { ...look, y: peaks.map(p => p.frequency), xaxis: "x2", yaxis: "y2", showlegend: false }];
  });
  const forces = traces.flatMap(t => t.x), wide = Math.min(...forces) > 0 && Math.max(...forces) > 8 * Math.min(...forces);
  const force = () => axis(data.results[0].newtons ? "force level in N" : "force level", { type: wide ? "log" : "linear", dtick: wide ? "D2" : undefined });
  const narrow = byId("chart-trend") && byId("chart-trend").clientWidth < 640;
  draw("chart-trend", traces, { grid: { rows: narrow ? 2 : 1, columns: narrow ? 1 : 2, pattern: "independent", xgap: 0.16, ygap: 0.3 }, xaxis: force(), xaxis2: force(),
    yaxis: axis(`peak ${data.results[0].peakSymbol}/F in ${perForce(data.results[0], data.results[0].peakUnit)}`, { rangemode: "tozero" }), yaxis2: axis("its frequency in Hz"),
    title: { text: `Highest peak of ${plain(name)}`, font: { size: 14 }, x: 0.01 }, margin: { l: 60, r: 16, t: 40, b: 48 } });
}

function drawLoops() {
  const shown = result(), row = index("contact"), own = chosen("size") === "own";
  const middle = values => values.length ? (Math.max(...values) + Math.min(...values)) / 2 : 0;
  const half = values => values.length ? (Math.max(...values) - Math.min(...values)) / 2 || 1 : 1;
  const closed = values => values.length ? [...values, values[0]] : values;
  const traces = representatives(shown).map(({ c, i }) => ({ c, i, loop: c.loops[row] })).filter(t => t.loop && t.loop[0].every(u => u !== null)).map(({ c, i, loop }) => {
    const [u, force] = loop.map(closed), [u0, f0, su, sf] = own ? [middle(u), middle(force), half(u), half(force)] : [0, 0, 1, 1];
    return { x: u.map(v => (v - u0) / su), y: force.map(v => (v - f0) / sf), customdata: u.map((v, k) => [v, force[k]]), mode: "lines", name: plain(c.level),
      line: { color: levelColours(shown)[i], width: 2 }, hovertemplate: `%{customdata[0]:.4g} ${data.length}, %{customdata[1]:.4g} N` };
  });
  const words = own ? ["relative displacement, centred, in half ranges", "contact force, centred, in half ranges"] : [`relative displacement in ${data.length}`, "contact force in N"];
  draw("chart-loops", traces, { xaxis: axis(words[0]), yaxis: axis(words[1]), hovermode: "closest", showlegend: true });
}

function drawStates() {
  const shown = result(), drawn = representatives(shown), count = drawn.length, rows = Math.max(shown.contacts.length, 1), last = data.mixtures.length - 1;
  const scale = data.mixtures.map((m, i) => [i / last, m.colour]), panel = 46 + (rows > 12 ? 10 : 16) * rows, height = count * panel + 70;
  const layout = { showlegend: false, height, margin: { l: 60, r: 16, t: 34, b: 44 }, annotations: [] };
  const traces = drawn.map(({ c }, i) => {
    const key = i ? i + 1 : "", top = 1 - i * panel / (count * panel), ascending = c.frequency.length < 2 || c.frequency[0] <= c.frequency.at(-1);
    const order = c.frequency.map((_, k) => k);
    if (!ascending && !c.folded) order.reverse();
    const ticks = [...new Set(Array.from({ length: 7 }, (_, k) => Math.round(k * (order.length - 1) / 6)))];
    layout[`xaxis${key}`] = axis(i === count - 1 ? "frequency in Hz" : "", { anchor: `y${key}`, showgrid: false,
      ...(c.folded ? { tickvals: ticks, ticktext: ticks.map(k => String(Number(c.frequency[k].toPrecision(4)))) } : {}) });
    layout[`yaxis${key}`] = axis("", { domain: [top - (panel - 40) / (count * panel), top], anchor: `x${key}`, autorange: "reversed", showgrid: false,
      zeroline: false, tickvals: shown.contacts.map((_, k) => k), ticktext: shown.contacts.map(plain), tickfont: { size: rows > 12 ? 8 : 12 } });
    layout.annotations.push({ text: `<b>${plain(c.level)}</b>${c.folded ? ", along the folded curve" : ""}`, x: 0, xref: "paper", xanchor: "left", y: top,
      yref: "paper", yanchor: "bottom", showarrow: false, font: { size: 12 } });
    return { type: "heatmap", x: c.folded ? order : order.map(k => c.frequency[k]), y: shown.contacts.map((_, k) => k), xaxis: `x${key}`, yaxis: `y${key}`,
      z: c.states.map(row => order.map(k => row[k])), zmin: 0, zmax: last, colorscale: scale, showscale: false, hoverongaps: false,
      text: c.states.map((row, r) => order.map(k => row[k] === null ? "" : `${plain(shown.contacts[r])}, ${c.frequency[k].toFixed(2)} Hz: ${stateWords(row[k])}`)),
      hovertemplate: "%{text}<extra></extra>" };
  });
  byId("chart-states").style.height = `${height}px`;
  draw("chart-states", traces, layout);
}

function drawEnergy() {
  const shown = result(), colours = data.colours.contacts, drawn = representatives(shown).map(({ c }) => c), levels = drawn.map((c, i) => i);
  const shares = shown.energyNames.map((name, k) => ({ type: "bar", orientation: "h", name: plain(name), y: levels,
    x: drawn.map(c => c.total > 0 ? 100 * c.shares[k] / c.total : null), customdata: drawn.map(c => c.shares[k]),
    marker: { color: colours[k % colours.length] }, hovertemplate: "%{x:.1f} %, %{customdata:.4g} J per cycle" }));
  draw("chart-shares", shares, { barmode: "stack", title: { text: "Dissipated at the highest peak", font: { size: 14 }, x: 0.01 }, showlegend: true,
    margin: { l: 60, r: 16, t: 40, b: 48 }, xaxis: axis("share in %", { range: [0, 100] }), yaxis: axis("", { autorange: "reversed", tickvals: levels,
      ticktext: drawn.map(c => `${plain(c.level)}: ${joules(c.total)}`) }) });
  const lines = name => shown.cases.map((c, i) => ({ x: c.frequency, y: name === "lossFactor" ? c[name] : c[name].map(v => v > 0 ? v : null),
    mode: c.frequency.length < 12 ? "lines+markers" : "lines", ...inLegend(c), line: { color: levelColours(shown)[i], width: c.thin ? 0.8 : 2 },
    hovertemplate: `%{x:.2f} Hz, %{y:.4g}<extra>${plain(c.level)}</extra>` }));
  const below = { orientation: "h", y: -0.25 };
  draw("chart-loss", lines("lossFactor"), { xaxis: axis("frequency in Hz"), yaxis: axis("loss factor", { rangemode: "tozero" }), legend: below });
  draw("chart-energy", lines("dissipated"), { xaxis: axis("frequency in Hz"), legend: below,
    yaxis: axis("energy per cycle in J", { type: "log", exponentformat: "power" }) });
}

function drawAll() {
  drawTrend(); drawCurves(); drawLoops(); drawStates(); drawEnergy();
}

function showResult() {
  fill(byId("output"), result().outputs);
  fill(byId("contact"), result().contacts);
  byId("contact").value = result().largestLoop;
  byId("point").textContent = "";
  byId("cycle").hidden = true;
  drawAll();
}

if (byId("result")) {
  fill(byId("result"), data.results.map(r => r.label));
  byId("result").addEventListener("change", showResult);
}
showResult();
byId("output").addEventListener("change", () => { drawTrend(); drawCurves(); });
byId("contact").addEventListener("change", drawLoops);
for (const [name, redraw] of [["scale", drawCurves], ["quantity", drawCurves], ["normal", drawCurves], ["size", drawLoops]])
  document.querySelectorAll(`input[name="${name}"]`).forEach(input => input.addEventListener("change", redraw));
byId("chart-curves").on("plotly_click", tellPoint);
dark.addEventListener("change", drawAll);
addEventListener("beforeprint", () => { printing = true; drawAll(); });
addEventListener("afterprint", () => { printing = false; drawAll(); });
