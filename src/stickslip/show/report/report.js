"use strict";
// Draws the charts of the page from the JSON in #data: each place shows the chart that the choices of the reader select.
// Nothing here knows what a chart is about. Text from the data reaches the page as textContent, or escaped for plotly.js.
let data;
const dark = matchMedia("(prefers-color-scheme: dark)");
const chosen = {};
let printing = false;

// plotly.js has a button that uploads the chart to a server: neither the button nor the address may be there.
const CONFIG = { responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "", typesetMath: false,
  modeBarButtonsToRemove: ["sendChartToCloud", "lasso2d", "select2d", "autoScale2d"] };
const NARROW = 640;

// Colours stand by name ("@level 0/4"); what several charts share stands once, numbers up to a factor.
function decoded(part) {
  const colours = data.colours[dark.matches && !printing ? "dark" : "light"];
  if (typeof part === "string") return part.startsWith("@") ? colours[part.slice(1)] : part;
  if (Array.isArray(part)) return part.map(decoded);
  if (part === null || typeof part !== "object") return part;
  if ("bytes" in part) return typed(part);
  if ("sum" in part) {
    const arrays = part.sum.map(decoded);
    return arrays[0].map((_, k) => part.weights.reduce((total, weight, i) => total + weight * arrays[i][k], 0));
  }
  if ("factor" in part) return Array.from(decoded(data.parts[part.part]), x => Number.isFinite(x) ? x * part.factor : null);
  if ("part" in part) return decoded(data.parts[part.part]);
  return Object.fromEntries(Object.entries(part).map(([key, value]) => [key, decoded(value)]));
}

const bytesOf = base64 => Uint8Array.from(atob(base64), letter => letter.charCodeAt(0));

// Numbers that stand as bytes, unpacked once.
const unpacked = new Map();
function typed(part) {
  if (!unpacked.has(part)) unpacked.set(part, new { Float32Array, Int32Array }[part.kind](bytesOf(part.bytes).buffer));
  return unpacked.get(part);
}

// Columns of what hovering shows become rows, one for each point.
function trace(part) {
  const found = decoded(part), columns = found.customdata;
  if (columns) found.customdata = columns[0].map((_, k) => columns.map(column => column[k]));
  return found;
}

function draw(div, shared) {
  const chart = { ...data.parts[shared.part], ...shared };
  const narrow = !printing && div.parentElement.clientWidth < NARROW, layout = decoded(narrow ? chart.narrow : chart.wide);
  const caption = div.closest("figure").querySelector("figcaption");
  caption.replaceChildren(...[chart.title, chart.note].filter(words => words).map(words => Object.assign(document.createElement("span"), { textContent: words })));
  div.style.height = `${layout.height}px`;
  div.classList.toggle("scrolled", "width" in layout);
  Plotly.react(div, { data: chart.data.map(trace), layout, config: CONFIG, frames: decoded(chart.frames || []) });
  const steps = div.parentElement.querySelector(".steps");
  if (steps && !steps.children.length) steps.replaceWith(stepper(div));
}

// Of a place for several results that of the chosen one; a result may have none, such as loops without contacts.
const entryOf = place => data.places[place].find(entry => entry.result === "" || entry.result === chosen.result);

function chartOf(entry) {
  const at = entry.choices.reduce((k, { name, options }) => k * options.length + Math.max(options.indexOf(chosen[name]), 0), 0);
  return entry.charts[at];
}

function control({ name, options }, place) {
  const choose = option => { chosen[name] = option; show(); };
  const current = options.includes(chosen[name]) ? chosen[name] : options[0];
  if (options.length > 3) {
    const label = Object.assign(document.createElement("label"), { className: "select", textContent: `${name} ` });
    const select = document.createElement("select");
    select.append(...options.map(option => new Option(option, option, false, option === current)));
    select.addEventListener("change", () => choose(select.value));
    label.append(select);
    return label;
  }
  const group = document.createElement("fieldset");
  group.append(Object.assign(document.createElement("legend"), { textContent: name }));
  group.append(...options.map(option => {
    const label = document.createElement("label");
    const radio = Object.assign(document.createElement("input"), { type: "radio", name: `${name}, ${place}`, value: option, checked: option === current });
    radio.addEventListener("change", () => choose(option));
    label.append(radio, ` ${option}`);
    return label;
  }));
  return group;
}

function show() {
  const focused = document.activeElement && document.activeElement.name;
  for (const figure of document.querySelectorAll(".place")) {
    const place = figure.dataset.place, entry = entryOf(place), div = document.getElementById(place);
    figure.hidden = !entry;
    if (!entry) continue;
    const shown = chartOf(entry);
    const state = JSON.stringify([entry.result, entry.charts.indexOf(shown), dark.matches, printing, figure.clientWidth < NARROW]);
    if (figure.dataset.state === state) continue;
    figure.dataset.state = state;
    figure.querySelector(".controls").replaceChildren(...entry.choices.map(choice => control(choice, place)));
    draw(div, shown);
    if (!entry.opening) continue;
    close(place);
    div.removeAllListeners("plotly_click");
    div.on("plotly_click", event => open(place, entry, event.points[0]));
  }
  const again = focused && [...document.getElementsByName(focused)].find(input => input.checked);
  if (again) again.focus();
}

function close(place) {
  document.querySelector(`[data-opened="${place}"]`).hidden = true;
}

// A click on a point opens the chart of the nearest point of that curve which has one.
function open(place, entry, point) {
  const at = entry.opening.points[point.data.legendgroup];
  if (!at || !point.data.mode.includes("lines")) return;
  const known = at.map((chart, k) => ({ chart, far: Math.abs(k - point.pointIndex) })).filter(({ chart }) => chart !== null);
  if (!known.length) return;
  const nearest = known.reduce((a, b) => b.far < a.far ? b : a), opened = document.querySelector(`[data-opened="${place}"]`);
  opened.hidden = false;
  draw(document.getElementById(`${place}-opened`), entry.opening.charts[nearest.chart]);
}

// The text of an element that stands there gzipped.
function unzipped(id) {
  const bytes = new Blob([bytesOf(document.getElementById(id).textContent)]);
  return new Response(bytes.stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

async function begin() {
  const [library, json] = await Promise.all(["library", "data"].map(unzipped));
  document.head.append(Object.assign(document.createElement("script"), { textContent: library }));
  data = JSON.parse(json);
  chosen.result = data.results[0];
  const results = document.getElementById("result");
  if (results) {
    results.replaceChildren(...data.results.map(name => new Option(name, name)));
    results.addEventListener("change", () => { chosen.result = results.value; show(); });
  }
  show();
  dark.addEventListener("change", show);
  addEventListener("resize", show);
  addEventListener("beforeprint", () => { printing = true; show(); });
  addEventListener("afterprint", () => { printing = false; show(); });
}

if ("DecompressionStream" in window) begin();
else document.querySelector("main").prepend("This browser is too old to show the charts: take one of 2023 or later. The tables below are complete.");
