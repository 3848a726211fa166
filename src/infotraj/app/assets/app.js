"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  const asked = new Set(), healthy = new Set(), queue = [];
  let state = null, shown = "", answered = null, failed = null, timer = null;
  const steps = ["reading and checking", "diagnosing", "computing where it fails", "report.html"];

  function say(text) { byId("error").textContent = text || ""; byId("error").hidden = !text; }
  async function call(what, body) {
    say("");
    const reply = await fetch(what, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(body || {})})
      .catch(() => null);
    if (!reply) { say("The server does not answer. Is it still running?"); return null; }
    const found = await reply.json();
    if (!reply.ok) { say(found.error); return null; }
    await refresh();
    return found;
  }
  async function refresh() {
    clearTimeout(timer);
    const reply = await fetch("state").catch(() => null);
    if (!reply || !reply.ok) { say("The server does not answer, or has begun anew. Open its address again."); timer = setTimeout(refresh, 3000); return; }
    state = await reply.json();
    draw();
    if (!running() && queue.length) { const next = queue.shift(); await call("check", {name: next}); return; }
    timer = setTimeout(refresh, running() ? 400 : 4000);
  }
  const running = () => state && state.job && state.job.state === "running";

  function cell(row, ...parts) { const td = document.createElement("td"); td.append(...parts); row.append(td); }
  function box(set, other, name, label) {
    const input = document.createElement("input");
    input.type = "checkbox"; input.checked = set.has(name);
    input.setAttribute("aria-label", `${label} ${name}`);
    input.addEventListener("change", () => {
      if (input.checked) { set.add(name); other.delete(name); } else set.delete(name);
      shown = ""; draw();
    });
    return input;
  }
  function drawFiles() {
    const key = JSON.stringify([state.listed, state.files, [...asked], [...healthy], running()]);
    if (key === shown) return;
    shown = key;
    const focused = document.activeElement && document.activeElement.getAttribute("aria-label");
    const body = byId("files").tBodies[0], rows = [];
    for (const file of state.listed.filter((f) => f.kind !== "model" || (state.files[f.name] || {}).outcome === "rejected")) {
      const row = document.createElement("tr"), head = document.createElement("th");
      head.scope = "row"; head.textContent = file.name; row.append(head);
      row.dataset.name = file.name;
      const refused = (state.files[file.name] || {}).outcome === "rejected";
      if (refused) { asked.delete(file.name); healthy.delete(file.name); }
      if (file.kind === "flight" && !refused) { cell(row, box(asked, healthy, file.name, "Ask")); cell(row, box(healthy, asked, file.name, "Healthy")); }
      else { cell(row, "–"); cell(row, "–"); }
      const said = state.files[file.name];
      if (said) {
        const outcome = document.createElement("span");
        outcome.className = said.outcome; outcome.textContent = said.outcome;
        const details = document.createElement("details"), summary = document.createElement("summary"), text = document.createElement("pre");
        summary.append(outcome); text.textContent = said.report; details.append(summary, text);
        details.open = said.outcome === "rejected";
        cell(row, details);
      } else cell(row, "not looked at");
      const look = document.createElement("button");
      look.type = "button"; look.textContent = file.kind === "log" ? "Import and check" : "Check";
      look.setAttribute("aria-label", `${look.textContent} ${file.name}`);
      look.addEventListener("click", () => check(file.name));
      cell(row, look);
      rows.push(row);
    }
    body.replaceChildren(...rows);
    if (focused) { const again = document.querySelector(`[aria-label="${CSS.escape(focused)}"]`); if (again) again.focus(); }
    const select = byId("model"), before = select.value;
    const models = state.listed.filter((f) => f.kind === "model" && (state.files[f.name] || {}).outcome !== "rejected").map((f) => f.name);
    select.replaceChildren(...models.map((name) => { const o = document.createElement("option"); o.value = o.textContent = name; return o; }));
    if (models.includes(before)) select.value = before;
  }
  function draw() {
    byId("folder").textContent = state.folder;
    drawFiles();
    const said = state.files[byId("model").value];
    byId("model-said").textContent = said ? said.report : "";
    const job = state.job;
    byId("cancel").disabled = !running();
    byId("diagnose").disabled = running();
    byId("save").disabled = running() || !(state.answer && !state.answer.reference);
    byId("record").disabled = running();
    byId("progress").hidden = !job;
    if (job) {
      const at = job.said.reduce((k, line) => Math.max(k, 1 + steps.findIndex((s) => line.includes(s))), 0);
      const bar = byId("bar");
      if (job.kind === "diagnosis") { bar.max = steps.length; bar.value = job.state === "done" ? steps.length : Math.max(0, at - 0.5); }
      else if (running()) bar.removeAttribute("value"); else { bar.max = 1; bar.value = 1; }
      const last = job.said.filter((l) => !l.startsWith("next:")).at(-1) || "";
      byId("step").textContent = `${job.kind} ${job.state}, ${job.seconds.toFixed(0)} s${job.state === "running" && last ? `: ${last}` : ""}`;
      const mark = job.state === "failed" ? `${job.kind} ${job.said.join(" ")}` : null;
      if (mark && mark !== failed) say(job.said.filter((l) => /^(error|rejected)/.test(l)).join(" ") || last);
      failed = mark;
    }
    byId("answer").hidden = !state.answer;
    byId("note").textContent = state.note;
    byId("viewer").hidden = !state.viewer;
    if (state.viewer) byId("viewer").href = state.viewer;
    const mark = state.answer ? state.answer.number : null;
    if (state.answer && mark !== answered) {
      byId("summary").textContent = state.answer.summary;
      byId("report").src = `report?n=${mark}`;
    }
    answered = mark;
  }
  function check(name) { queue.push(name); if (!running()) refresh(); }
  async function upload(files) {
    for (const file of files) {
      if (file.size > state.upload_limit) { say(`${file.name}: too large; expected at most ${state.upload_limit / 1e6} MB. Cut it.`); continue; }
      say("");
      const reply = await fetch(`upload?name=${encodeURIComponent(file.name)}`, {method: "POST", body: file}).catch(() => null);
      const found = reply ? await reply.json().catch(() => ({})) : {};
      if (!reply || !reply.ok) { say(found.error || `${file.name}: was not taken`); continue; }
      asked.add(/\.(csv|parquet)$/.test(found.name) ? found.name : found.name.replace(/\.[^.]+$/, ".parquet"));
      queue.push(found.name);
    }
    await refresh();
  }
  const drop = byId("drop");
  for (const kind of ["dragover", "dragleave", "drop"]) drop.addEventListener(kind, (event) => {
    event.preventDefault();
    drop.classList.toggle("over", kind === "dragover");
    if (kind === "drop") upload([...event.dataTransfer.files]);
  });
  byId("choose").addEventListener("change", (event) => { upload([...event.target.files]); event.target.value = ""; });
  byId("model").addEventListener("change", draw);
  byId("diagnose").addEventListener("click", () => {
    const there = new Set(state.listed.map((f) => f.name)), kept = (set) => [...set].filter((n) => there.has(n));
    call("diagnose", {model: byId("model").value, flights: kept(asked), healthy: kept(healthy)});
  });
  byId("cancel").addEventListener("click", () => call("cancel"));
  byId("record").addEventListener("click", () => call("record"));
  byId("save").addEventListener("click", () => {
    const page = byId("report").contentWindow.infotraj;
    if (!page) { say("The report is still being drawn."); return; }
    if (!page.ticked().length) { say("Nothing is ticked. Tick one of the effects in the report first."); return; }
    call("save", {name: byId("new-name").value, effects: page.ticked()});
  });
  refresh();
})();
