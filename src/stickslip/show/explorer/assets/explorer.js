// Pairs sliders with their numbers, asks for answers and keeps the state in the address. Requests are numbered: the server drops
// those that a newer one has overtaken, and an answer that is older than what is shown is not shown.
(() => {
  const tab = crypto.randomUUID(), dark = matchMedia("(prefers-color-scheme: dark)");
  const FINE_AFTER = 250, LOST_AFTER = 20000, NARROW = 1000, LOOK_EVERY = 500;
  const BELOW = { legend: { orientation: "h", y: -0.22 } };
  // The renderer of Dash adds these after this script has run.
  const dash = window.dash_clientside = window.dash_clientside || {};
  const set_props = (id, props) => dash.set_props(id, props);
  let version = 0, shown = { version: 0, fine: false }, fine, pinned, started = false, last = {}, sent = -Infinity, moved = 0;
  let stopped = 0, awaited = null; // the version of the last stop, and the request that is under way

  const valueAt = (share, { low, high, log }) => {
    const value = log ? low * (high / low) ** share : low + share * (high - low);
    return Number(value.toPrecision(4));
  };
  const shareOf = (value, { low, high, log }) => {
    const share = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.min(Math.max(share || 0, 0), 1); // NaN, of negative numbers on a logarithmic scale, is its lower end
  };
  const stateOf = (values, sliders, mark) => sliders.flatMap((s, k) => values[k] === s.value ? [] : [[mark + s.name, values[k]]]);

  function read(sliders) {
    const given = new URLSearchParams(location.search), numbers = {};
    for (const slider of sliders)
      for (const mark of ["", "pinned."])
        if (given.has(mark + slider.name) && Number.isFinite(Number(given.get(mark + slider.name))))
          numbers[mark + slider.name] = Number(given.get(mark + slider.name));
    return { numbers, output: given.get("output"), linear: given.has("linear") };
  }

  function keep(values, sliders, output, log) {
    const state = new URLSearchParams(stateOf(values, sliders, ""));
    for (const [name, value] of stateOf(sliders.map(s => pinned[s.name]), sliders, "pinned.")) state.set(name, value);
    if (output) state.set("output", output);
    if (!log) state.set("linear", "");
    history.replaceState(null, "", state.size ? `?${state}` : location.pathname);
  }

  // The point that is shown below belongs to the curve that was seen when it was asked for.
  function date() {
    const details = document.getElementById("details"), known = details.querySelector("[data-version]");
    details.classList.toggle("old", Boolean(known) && Number(known.dataset.version) < shown.version);
  }

  // One coarse request is under way at a time, so that curves follow a slider that does not rest; the fine one follows when it has
  // rested, and a newer coarse one overtakes it.
  function send() {
    if (performance.now() - sent < LOST_AFTER) return;
    sent = performance.now();
    ask({ ...last, fine: false });
  }

  function ask(request) {
    awaited = request;
    set_props("wanted", { data: request });
  }

  // What the server says that it does, from the second look on: most answers are there before.
  async function look() {
    const place = document.getElementById("doing"), seen = awaited;
    if (!place) return;
    if (!seen || place.dataset.seen !== `${seen.version}${seen.fine}`) {
      place.hidden = true;
      place.dataset.seen = seen ? `${seen.version}${seen.fine}` : "";
      return;
    }
    try {
      const doing = await (await fetch(`doing/${tab}`)).json();
      if (seen !== awaited) return;
      const share = Math.floor(100 * (doing.share ?? 0));
      place.querySelector("progress").value = doing.share ?? 0;
      place.querySelector("span").textContent =
        doing.words ? `${doing.words}: ${share} % after ${Math.round(doing.seconds)} s` : "Waiting until another curve is finished";
      place.hidden = false;
    } catch {
      place.hidden = true;
      set_props("message", { children: "The explorer has stopped. Start `stickslip explore` again to go on." });
    }
  }

  function stop() {
    version += 1;
    fetch(`stop/${tab}/${version}`, { method: "POST" }).catch(() => {});
    clearTimeout(fine);
    sent = -Infinity;
    awaited = null;
    stopped = version;
    document.getElementById("doing").hidden = true;
    set_props("message", { children: "Stopped. Change a value to solve again." });
  }

  function refine() {
    clearTimeout(fine);
    const request = last, rested = performance.now() - moved;
    fine = setTimeout(() => ask({ ...request, fine: true }), Math.max(FINE_AFTER - rested, 0));
  }

  dash.explorer = {
    paired(position, value, slider) {
      const id = dash.callback_context.triggered_id;
      if (id && id.type === "range") {
        const found = valueAt(Number(position) / slider.steps, slider);
        return [dash.no_update, found];
      }
      if (!Number.isFinite(Number(value)) || value === null || value === "") return [dash.no_update, dash.no_update];
      return [Math.round(slider.steps * shareOf(Number(value), slider)), dash.no_update];
    },

    want(values, output, scale, pins, sliders) {
      if (!started) {
        started = true;
        for (const range of document.querySelectorAll(".slider input[type=range]"))
          range.setAttribute("aria-label", range.closest(".slider").title);
        const { numbers, output: kept, linear } = read(sliders);
        pinned = Object.fromEntries(sliders.map(s => [s.name, numbers["pinned." + s.name] ?? s.value]));
        for (const slider of sliders)
          if (slider.name in numbers) set_props({ type: "number", name: slider.name }, { value: numbers[slider.name] });
        values = sliders.map((s, k) => numbers[s.name] ?? values[k]);
        if (kept) { set_props("output", { value: kept }); output = kept; }
        if (linear) { set_props("scale", { value: [] }); scale = []; }
      }
      const known = values.map((value, k) => value === null || value === undefined ? NaN : value);
      if (known.some(Number.isNaN)) {
        set_props("message", { children: "A number is missing. The curve still shows the last complete values." });
        return dash.no_update;
      }
      const named = Object.fromEntries(sliders.map((s, k) => [s.name, values[k]]));
      if (dash.callback_context.triggered_id === "pin") pinned = named;
      keep(values, sliders, output, scale.length > 0);
      version += 1;
      last = { values: named, pinned: { ...pinned }, output, log: scale.length > 0, version, tab, dark: dark.matches,
        narrow: innerWidth < NARROW };
      moved = performance.now();
      clearTimeout(fine);
      send();
      return dash.no_update;
    },

    reset(clicks, start) {
      for (const [name, value] of Object.entries(start)) set_props({ type: "number", name }, { value });
      return dash.no_update;
    },

    show(answer) {
      if (answer && awaited && answer.version === awaited.version && answer.fine === awaited.fine) awaited = null;
      const older = answer && (answer.version < shown.version || (answer.version === shown.version && shown.fine && !answer.fine));
      if (answer && !answer.fine) {
        sent = -Infinity;
        if (answer.version === version) refine(); else if (version !== stopped) send();
      }
      if (!answer || older) return Array(7).fill(dash.no_update);
      shown = answer;
      date();
      document.documentElement.dataset.version = `${answer.version}${answer.fine ? " fine" : ""}`;
      if (answer.failed) return [dash.no_update, dash.no_update, dash.no_update, dash.no_update, dash.no_update, answer.message, "failed"];
      const figure = answer.figure;
      if (innerWidth < NARROW) figure.layout = { ...figure.layout, ...BELOW };
      return [figure, ...answer.numbers, ...answer.changes, answer.message, answer.fine ? "" : "coarse"];
    },

    step(clicks) {
      const { by, figure } = dash.callback_context.triggered_id ?? {};
      if (clicks) step(document.querySelectorAll("#details .moving")[figure].querySelector(".js-plotly-plot"), by);
      return dash.no_update;
    },

    dated() { date(); return dash.no_update; },

    copied(code) {
      navigator.clipboard?.writeText(code).catch(() => {});
      return [code, false];
    },
  };

  setInterval(look, LOOK_EVERY);
  document.addEventListener("click", event => { if (event.target.id === "stop") stop(); });

  dark.addEventListener("change", () => {
    if (!last.values) return;
    version += 1;
    last = { ...last, version, dark: dark.matches };
    refine();
  });
})();
