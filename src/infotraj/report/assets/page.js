"use strict";
(async () => {
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data-content").textContent);
  if (!("DecompressionStream" in window)) { byId("old").hidden = false; return; }
  const figures = await unpacking.json(byId("data-figures").textContent);
  await unpacking.script(byId("data-bokeh").textContent);
  const fall = data.fall, axes = data.traces.axes;
  const state = {flight: 0, mask: fall.rmse.length - 1, view: "wrench", given: true, window: null};

  const series = new Map();  // what the parts of data.traces hold
  for (const one of [...data.traces.flights, ...data.traces.windows]) if (one) series.set(one, await unpacking.series(one));
  const minus = (a, b) => a.map((x, i) => x - b[i]);

  // Each root goes into the element that names it. The series come first, so that the page can be used at once.
  const drawn = [];
  async function embed(id) {
    const roots = {}, rootIds = [], names = figures[id].roots.map((r) => r.attributes.name);
    for (const root of figures[id].roots) {
      const place = document.querySelector(`[data-root="${root.attributes.name}"]`);
      place.id = `root-${root.attributes.name}`;
      roots[root.id] = place.id;
      rootIds.push(root.id);
    }
    await Bokeh.embed.embed_items({[id]: figures[id]}, [{docid: String(id), roots, root_ids: rootIds}]);
    const made = names.map(named);
    drawn.push(...made);
    paint(made);
  }
  function named(name) {
    for (const one of Bokeh.documents) { const found = one.get_model_by_name(name); if (found) return found; }
    return null;
  }

  // Colours follow the page: light, dark, paper.
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const role = (m) => (m.tags || [])[0];
  function paint(some) {
    const ink = css("ink"), soft = css("soft"), line = css("line");
    for (const fig of some) {
      for (const axis of [...fig.left, ...fig.below]) {
        axis.axis_label_text_color = ink;
        axis.major_label_text_color = soft;
        axis.axis_line_color = soft;
        axis.major_tick_line_color = soft;
      }
      for (const part of fig.center) {
        if (part.type === "Grid" || part.grid_line_color !== undefined) { if (part.dimension === 1) part.grid_line_color = line; }
        if (["band", "place", "filter"].includes(role(part))) part.fill_color = css(role(part));
        if (role(part) === "axis") part.line_color = soft;
      }
      for (const r of fig.renderers) {
        if (["band", "place", "filter"].includes(role(r))) { r.fill_color = css(role(r)); continue; }
        if (!r.glyph || !role(r)) continue;
        const color = {value: css(role(r) === "point" ? "soft" : role(r))};
        if (r.glyph.type === "Line" || r.glyph.line_width !== undefined && !r.glyph.size) r.glyph.line_color = color;
        if (r.glyph.size) r.glyph.fill_color = color;
      }
    }
  }

  // The series that are shown, for the flight or window, and the ticked combination.
  function part() {
    if (state.window !== null && data.traces.windows[state.window]) return data.traces.windows[state.window];
    return data.traces.flights[state.flight];
  }
  function drawSeries() {
    const shown = series.get(part()), t = shown.t;
    for (const axis of axes) {
      const own = shown.axes[axis], factor = named(`trace-${axis}`).tags[0];
      const drawn = (line) => line.map((x) => factor * x);
      const measured = drawn(own.measured), given = drawn(own.model[0]), ticked = drawn(own.model[state.mask]);
      const left = (k) => own.left ? drawn(own.left[k]) : minus(measured, drawn(own.model[k]));
      named(`series-${axis}`).data = {t, measured, given, ticked, left_given: left(0), left_ticked: left(state.mask)};
    }
    byId("bucket").textContent = shown.bucket === null ? "" :
      `This series is long: each ${Number((1000 * shown.bucket).toPrecision(2))} ms of it is drawn by its lowest and highest ` +
      "value, so that no peak is lost; the windows above are drawn closer.";
  }
  function drawView() {
    for (const axis of axes) {
      const fig = named(`trace-${axis}`), left = state.view === "left";
      for (const r of fig.renderers) if (r.tags && r.tags[1]) r.visible = r.tags[1].startsWith("left_") === left && (state.given || role(r) !== "given");
      for (const p of [...fig.center, ...fig.renderers]) if (role(p) === "band") p.visible = left;
    }
  }
  const sig = (x) => {
    if (x === null || !isFinite(x)) return "–";
    return x !== 0 && (Math.abs(x) < 1e-4 || Math.abs(x) >= 1e4) ? x.toExponential(2) : String(Number(x.toPrecision(3)));
  };
  function drawBars() {
    for (const table of document.querySelectorAll("table.bars")) {
      const axis = table.dataset.axis, top = Number(table.dataset.top), factor = Number(table.dataset.factor);
      const at = (key) => fall[key][state.mask][axis], row = table.querySelector("tr.now");
      if (!row) continue;
      row.dataset.value = at("rmse");
      row.querySelector(".fill").style.width = `${100 * at("rmse") / top}%`;
      const interval = row.querySelector(".interval");
      interval.style.left = `${100 * at("low") / top}%`;
      interval.style.width = `${100 * (at("high") - at("low")) / top}%`;
      const value = row.querySelector(".value"), small = document.createElement("small");
      small.textContent = `${sig(factor * at("low"))} – ${sig(factor * at("high"))}`;
      value.replaceChildren(sig(factor * at("rmse")), small);
    }
    for (const box of document.querySelectorAll("input[data-bit]")) box.checked = Boolean(state.mask >> Number(box.dataset.bit) & 1);
  }
  function say() {
    const names = fall.boxes.filter((_, k) => state.mask >> k & 1).map((b) => b.label);
    byId("shown").textContent = `${data.flights[state.flight].name}; in the model: ${names.join(", ") || "nothing beyond it"}.`;
  }
  const span = () => { const {t} = series.get(part()); return [t[0], t[t.length - 1]]; };
  function moveTo(start, end) {
    const [low, high] = span(), width = Math.min(end - start, high - low);
    const from = Math.max(low, Math.min(start, high - width));
    time.setv({start: from, end: from + width});
  }
  function whole() { const [low, high] = span(); time.setv({start: low, end: high, reset_start: low, reset_end: high}); }
  function draw() { drawSeries(); drawView(); drawBars(); say(); }

  function tick(bit, on) {
    state.mask = on ? state.mask | 1 << bit : state.mask & ~(1 << bit);
    drawSeries(); drawBars(); say();
  }
  function showFlight(k) { state.flight = k; state.window = null; byId("flight").value = String(k); drawSeries(); whole(); say(); }
  function showWindow(k) {
    const w = data.windows[k];
    state.flight = w.flight; state.window = k; byId("flight").value = String(w.flight);
    drawSeries();
    if (part() === data.traces.flights[w.flight]) state.window = null;
    moveTo(w.from - 2, w.to + 2);
    say();
    byId("traces-title").scrollIntoView();
  }
  const moves = {
    in: (a, b) => moveTo(a + (b - a) / 4, b - (b - a) / 4), out: (a, b) => moveTo(a - (b - a) / 2, b + (b - a) / 2),
    back: (a, b) => moveTo(a - (b - a) / 2, b - (b - a) / 2), on: (a, b) => moveTo(a + (b - a) / 2, b + (b - a) / 2),
    all: () => { state.window = null; drawSeries(); whole(); say(); },
  };
  document.addEventListener("change", (event) => {
    const from = event.target;
    if (from.dataset.bit !== undefined) tick(Number(from.dataset.bit), from.checked);
    else if (from.id === "flight") showFlight(Number(from.value));
    else if (from.id === "given") { state.given = from.checked; drawView(); }
    else if (from.name === "view") { state.view = from.value; drawView(); }
  });
  document.addEventListener("click", (event) => {
    const from = event.target.closest("button");
    if (!from) return;
    if (from.dataset.window !== undefined) showWindow(Number(from.dataset.window));
    else if (from.dataset.move) moves[from.dataset.move](time.start, time.end);
    else if (from.classList.contains("copy")) {
      navigator.clipboard?.writeText(from.previousElementSibling.textContent);
      from.textContent = "Copied";
    }
  });
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", () => paint(drawn));
  // On paper: the colours of paper, and nothing folded.
  let folded = [];
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const d of folded) d.open = true;
    // A canvas keeps the width and the colours that it has on the screen: it is made as wide as the paper (more would
    // blur it), and what was drawn for the dark is turned to its negative with the same hues.
    // Two of a narrow window stand side by side.
    for (const plot of document.querySelectorAll(".plot")) {
      const narrow = plot.clientWidth < 500, grid = plot.closest(".grid");
      grid?.classList.toggle("narrow", narrow);
      const room = narrow || grid?.classList.contains("three") ? 330 : 680;
      plot.style.zoom = Math.min(1.3, room / Math.max(1, plot.clientWidth));
      plot.style.filter = dark.matches ? "invert(1) hue-rotate(180deg)" : "";
    }
  });
  addEventListener("afterprint", () => {
    for (const plot of document.querySelectorAll(".plot")) plot.style.zoom = plot.style.filter = "";
    for (const d of folded) d.open = false;
  });
  await embed(0);
  const time = axes.length ? named(`trace-${axes[0]}`).x_range : null;
  // A finger that moves over a figure scrolls the page.
  if (matchMedia("(pointer: coarse)").matches) for (const fig of drawn) fig.toolbar.active_drag = null;
  if (time) { draw(); whole(); }
  window.infotraj = {state, data, tick, showFlight, showWindow, moveTo, model: named,
    ticked: () => fall.boxes.filter((_, k) => state.mask >> k & 1).flatMap((b) => b.effects)};
  const root = document.documentElement;
  root.dataset.ready = "yes";
  for (let id = 1; id < figures.length; id++) {
    await new Promise((done) => setTimeout(done));
    if (figures[id].roots.length) await embed(id);
  }
  root.dataset.complete = "yes";
})();
