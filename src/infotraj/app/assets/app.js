"use strict";
(() => {
  const byId = (id) => document.getElementById(id);
  // What a reload of the page does not end. looks: what is to be looked at; queue: what was asked for by hand.
  const held = JSON.parse(sessionStorage.getItem(location.pathname) || "{}");
  const [asked, healthy, wanted, looks] = [held.asked, held.healthy, held.wanted, held.looks].map((names) => new Set(names));
  const queue = held.queue || [], chosen = new Map(), met = new Set();  // met: mappings that are to be looked at
  let picked = held.picked;  // the model that the user chose
  window.addEventListener("pagehide", () => sessionStorage.setItem(location.pathname, JSON.stringify(
    {asked: [...asked], healthy: [...healthy], wanted: [...wanted], looks: [...looks], queue, picked})));
  let state = null, shown = "", answered = null, failed = null, timer = null, against = null, knew = false, sending = false, turn = 0;
  const steps = ["reading and checking", "diagnosing", "computing where it fails", "report.html"];

  function say(text) { byId("error").textContent = text || ""; byId("error").hidden = !text; }
  function add(text) { say([byId("error").textContent, text].filter(Boolean).join(" ")); }
  // What was said stands until the user does the next thing, also while what was dropped with it is being looked at.
  for (const kind of ["click", "change", "drop"]) document.addEventListener(kind, () => say(""), true);
  const LOST = "The server does not answer, or has begun anew. Open its address again.";
  async function call(what, body) {
    sending = true;
    const reply = await fetch(what, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(body || {})})
      .catch(() => null);
    const found = reply && await reply.json().catch(() => ({}));
    sending = false;
    if (reply && !reply.ok) say(found.error);
    await refresh();
    return reply && reply.ok ? found : null;
  }
  async function refresh() {
    clearTimeout(timer);
    if (sending) return;  // it is done as soon as that is answered
    const mine = ++turn, reply = await fetch("state").catch(() => null);
    const found = reply && reply.ok ? await reply.json().catch(() => null) : null;
    if (sending || mine !== turn) return;  // this is old
    if (!found) { say(LOST); timer = setTimeout(refresh, 3000); return; }
    if (byId("error").textContent === LOST) say("");
    state = found;
    draw();
    const next = running() ? null : following();
    if (next) { const [what, body] = next; await call(what, {model: model(), ...body}); return; }
    timer = setTimeout(refresh, running() ? 400 : 4000);
  }
  // What is done next: what was asked for by hand; then looking at the model, at what is ticked, at the rest.
  function following() {
    if (queue.length) return queue.shift();
    for (const name of [model(), ...asked, ...healthy, ...looks]) if (looks.delete(name) && stale(name)) return ["check", {name}];
    return null;
  }
  // Not looked at, or a flight that was looked at for another vehicle.
  function stale(name) {
    const said = state.files[name];
    return !said || (said.model !== model() && state.listed.some((f) => f.name === name && f.kind === "flight"));
  }
  const model = () => byId("model").value || null;
  const bad = (name) => (state.files[name] || {}).outcome === "rejected";
  const running = () => state && state.job && state.job.state === "running";

  function cell(row, ...parts) { const td = document.createElement("td"); td.append(...parts); row.append(td); }
  function box(set, other, name, label) {
    const input = document.createElement("input");
    input.type = "checkbox"; input.checked = set.has(name);
    input.setAttribute("aria-label", `${label} ${name}`);
    input.addEventListener("change", () => {
      if (input.checked) { set.add(name); other.delete(name); looks.add(name); } else set.delete(name);
      shown = ""; draw(); refresh();
    });
    const seen = document.createElement("span");  // where there is no room for a head of the table
    seen.className = "narrow"; seen.setAttribute("aria-hidden", "true"); seen.textContent = label;
    const both = document.createElement("label");
    both.append(input, seen);
    return both;
  }
  // One box for all flights that are not the healthy ones: ticked where all are asked, half where some are.
  function drawAll(able) {
    const all = byId("ask-all"), ticked = able.filter((name) => asked.has(name)).length;
    all.disabled = !able.length;
    all.checked = ticked > 0 && ticked === able.length;
    all.indeterminate = ticked > 0 && ticked < able.length;
    all.onchange = () => {
      for (const name of able) { if (all.checked) { asked.add(name); looks.add(name); } else asked.delete(name); }
      shown = ""; draw(); refresh();
    };
  }
  function button(text, name, action) {
    const made = document.createElement("button");
    made.type = "button"; made.textContent = text;
    made.setAttribute("aria-label", `${text} ${name}`);
    made.addEventListener("click", action);
    return made;
  }
  // A log that no mapping made usable: another one of its kind, of the folder or shipped; at last those not yet looked at.
  function mappings(file, said) {
    const label = document.createElement("label"), select = document.createElement("select");
    const own = state.listed.filter((f) => f.kind === "mapping").map((f) => f.name), unread = own.filter((name) => !state.files[name]);
    for (const name of own) {
      if (!unread.includes(name)) met.delete(name);
      else if (!met.has(name)) { met.add(name); looks.add(name); }
    }
    const fit = own.filter((name) => state.files[name] && (state.files[name].reads.includes(said.kind) || chosen.get(file.name) === name));
    for (const name of [...fit, ...said.mappings, ...unread]) select.append(new Option(name, name));
    if (chosen.has(file.name)) select.value = chosen.get(file.name);
    select.addEventListener("change", () => chosen.set(file.name, select.value));
    select.setAttribute("aria-label", `Mapping of ${file.name}`);
    label.append("Read it by the mapping ", select);
    const line = document.createElement("p");
    line.append(label, " ", button("Import", file.name, () => {
      chosen.set(file.name, select.value);
      ask("check", {name: file.name, mapping: select.value});
    }));
    return line;
  }
  function remedy(file, said) {
    const line = document.createElement("p"), code = document.createElement("code");
    code.textContent = said.fix.join(", ");
    line.append("A setting mends this in a new flight beside it: ", code, " ",
      button("Fix", file.name, () => { wanted.add(file.name); ask("fix", {name: file.name}); }));
    return line;
  }
  // What was dropped, and what was mended, is asked once it is usable.
  function follow() {
    for (const name of wanted) {
      const made = (state.files[name] || {}).fixed || (state.files[name] || {}).name;
      if (!made) continue;
      wanted.delete(name);
      if (state.listed.some((f) => f.name === made && f.kind === "flight") && !healthy.has(made)) asked.add(made);
    }
  }
  // The model that is chosen is looked at, again when its file changes; for it what is ticked, or will be once it is usable.
  function recheck() {
    const known = Boolean(state.files[model()]);
    if (model() && !known && (knew || model() !== against)) looks.add(model());
    knew = known;
    if (model() === against) return;
    against = model();
    for (const set of [asked, healthy, wanted]) for (const {name, kind} of state.listed) if (kind === "flight" && set.has(name)) looks.add(name);
  }
  function drawFiles() {
    follow();
    const key = JSON.stringify([state.listed, state.files, [...asked], [...healthy], running()]);
    if (key === shown) return;
    shown = key;
    const focused = document.activeElement && document.activeElement.getAttribute("aria-label");
    const body = byId("files").tBodies[0], rows = [], able = [];
    const none = {outcome: ""};
    for (const file of state.listed) {
      const said = state.files[file.name] || none, refused = said.outcome === "rejected";
      if (["model", "mapping"].includes(file.kind) && !refused) continue;
      const row = document.createElement("tr"), head = document.createElement("th");
      head.scope = "row"; head.textContent = file.name; row.append(head);
      row.dataset.name = file.name;
      const elsewhere = said.name && said.name !== file.name;
      row.classList.toggle("taken", Boolean(elsewhere || said.fixed));
      if (refused && asked.has(file.name)) wanted.add(file.name);  // it may be one of another vehicle
      if (refused || elsewhere) { asked.delete(file.name); healthy.delete(file.name); }
      if (file.kind === "flight" && !refused && !elsewhere) { able.push(file.name); cell(row, box(asked, healthy, file.name, "Ask")); cell(row, box(healthy, asked, file.name, "Healthy")); }
      else for (let k = 0; k < 2; k++) { cell(row, "–"); row.lastChild.className = "none"; }
      if (said !== none) {
        const outcome = document.createElement("span");
        outcome.className = said.outcome; outcome.textContent = said.outcome;
        const details = document.createElement("details"), summary = document.createElement("summary"), text = document.createElement("pre");
        const other = said.fixed || (elsewhere && said.name);
        const flown = said.model ? ` for ${said.model}` : refused ? "" : ", without a vehicle";
        summary.append(outcome, flown, other ? `, ${said.fixed ? "mended as" : "imported as"} ${other}` : "");
        text.textContent = said.report; details.append(summary, text);
        details.open = refused && !said.fixed;
        cell(row, details);
        if (said.fix.length) row.lastChild.append(remedy(file, said));
        if (refused && said.mappings.length && !said.fixed) row.lastChild.append(mappings(file, said));
      } else cell(row, "not looked at");
      cell(row, button(file.kind === "log" ? "Import and check" : "Check", file.name, () => ask("check", {name: file.name})));
      rows.push(row);
    }
    body.replaceChildren(...rows);
    byId("files").parentElement.hidden = !rows.length;
    byId("nothing").hidden = Boolean(rows.length);
    drawAll(able.filter((name) => !healthy.has(name)));
    if (focused) { const again = document.querySelector(`[aria-label="${CSS.escape(focused)}"]`); if (again) again.focus(); }
    const select = byId("model"), before = select.value;
    // First vehicle files, then those with effects, such as were saved here, at last what cannot be read.
    const rank = (file) => bad(file.name) ? 2 : file.effects ? 1 : 0;
    const models = state.listed.filter((f) => f.kind === "model").sort((a, b) => rank(a) - rank(b)).map((f) => f.name);
    select.replaceChildren(...models.map((name) => new Option(name, name)));
    if (models.length) select.value = models.find((n) => n === picked) || models.find((n) => n === before && !bad(n)) || models[0];
  }
  function draw() {
    byId("folder").textContent = state.folder;
    drawFiles();
    recheck();
    const said = state.files[model()];
    byId("model-said").textContent = said ? said.report : "";
    byId("model-said").classList.toggle("rejected", bad(model()));
    const job = state.job;
    // No one waits until all files are looked at: what is asked for comes first.
    const busy = (running() && job.kind !== "check") || queue.some(([what]) => what !== "check");
    byId("cancel").disabled = !running() && !queue.length && !looks.size;
    byId("diagnose").disabled = busy || bad(model());
    byId("save").disabled = busy || !(state.answer && !state.answer.reference);
    byId("record").disabled = busy;
    byId("design").disabled = busy;
    byId("next-flight").hidden = Boolean(state.answer && state.answer.reference);
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
      document.title = `infotraj: ${state.answer.summary}`;
      byId("report").src = `report?n=${mark}`;
    }
    answered = mark;
  }
  function ask(what, body) { queue.push([what, body]); draw(); refresh(); }
  // quiet: of a file that may be none of ours nothing is said.
  async function send(file, more, quiet) {
    if (file.size > state.upload_limit) { if (!quiet) add(`${file.name}: too large; expected at most ${state.upload_limit / 1e6} MB. Cut it.`); return null; }
    const reply = await fetch(`upload?name=${encodeURIComponent(file.name)}${more || ""}`, {method: "POST", body: file}).catch(() => null);
    const found = reply ? await reply.json().catch(() => ({})) : {};
    if (!reply || !reply.ok) { if (!quiet) add(found.error || `${file.name}: was not taken`); return null; }
    return found;
  }
  // A ROS 2 bag is a folder: its metadata first, then its parts, then all of it under one name.
  async function sendBag(folder, files) {
    const metadata = (f) => f.name === "metadata.yaml";
    for (const file of [...files.filter(metadata), ...files.filter((f) => !metadata(f))]) if (!await send(file, "&bag")) return null;
    return call("bag", {name: folder});
  }
  async function upload(dropped) {
    if (!state) await begun;
    if (!state) return;
    const folders = new Map(), single = [];
    for (const {folder, file} of dropped) {
      if (!folder) single.push(file);
      else folders.set(folder, [...(folders.get(folder) || []), file]);
    }
    const bags = [], unsure = [];
    for (const [folder, files] of folders) {
      const parts = files.filter((f) => f.name === "metadata.yaml" || /\.(mcap|db3)$/.test(f.name));
      if (parts.length > 1 && parts.some((f) => f.name === "metadata.yaml")) bags.push([folder, parts]);
      else {
        single.push(...files.filter((f) => state.suffixes.some((s) => f.name.toLowerCase().endsWith(s))));
        unsure.push(...files.filter((f) => !f.name.includes(".")));
      }
    }
    let count = single.length;
    const took = (found) => { if (found) { count += 1; wanted.add(found.name); looks.add(found.name); } };
    const isModel = (file) => /\.ya?ml$/i.test(file.name);  // what a log is held against comes first
    for (const file of single.filter(isModel)) took(await send(file));
    for (const [folder, parts] of bags) took(await sendBag(folder, parts));
    for (const file of unsure) took(await send(file, "", true));
    for (const file of single.filter((f) => !isModel(f))) took(await send(file));
    if (dropped.length && !count) say("No log, flight or vehicle file is in that folder.");
    await refresh();
  }
  async function inside(entry, folder) {
    if (entry.isFile) return [{folder, file: await new Promise((take, fail) => entry.file(take, fail))}];
    const reader = entry.createReader(), held = [];
    for (;;) {
      const some = await new Promise((take, fail) => reader.readEntries(take, fail));
      if (!some.length) break;
      held.push(...some);
    }
    return (await Promise.all(held.map((e) => inside(e, folder ? `${folder}/${entry.name}` : entry.name)))).flat();
  }
  const drop = byId("drop");
  for (const kind of ["dragover", "dragleave", "drop"]) drop.addEventListener(kind, async (event) => {
    event.preventDefault();
    drop.classList.toggle("over", kind === "dragover");
    if (kind !== "drop") return;
    const entries = [...event.dataTransfer.items].map((i) => i.webkitGetAsEntry()).filter(Boolean);
    const held = entries.length ? entries.map((e) => inside(e, "")) : [[...event.dataTransfer.files].map((file) => ({folder: "", file}))];
    const dropped = await Promise.all(held).catch((error) => { say(`It cannot be read: ${error.message || error}`); return []; });
    await upload(dropped.flat());
  });
  byId("choose").addEventListener("change", (event) => { upload([...event.target.files].map((file) => ({folder: "", file}))); event.target.value = ""; });
  byId("choose-folder").addEventListener("change", (event) => {
    upload([...event.target.files].map((file) => ({folder: file.webkitRelativePath.split("/").slice(0, -1).join("/"), file})));
    event.target.value = "";
  });
  byId("model").addEventListener("change", () => { picked = model(); draw(); refresh(); });
  byId("diagnose").addEventListener("click", () => {
    const there = new Set(state.listed.map((f) => f.name)), kept = (set) => [...set].filter((n) => there.has(n));
    ask("diagnose", {flights: kept(asked), healthy: kept(healthy)});
  });
  byId("cancel").addEventListener("click", () => { queue.length = 0; looks.clear(); call("cancel"); });
  byId("design").addEventListener("click", () => ask("design", {box: byId("box").value.trim(), seconds: byId("seconds").value.trim()}));
  byId("record").addEventListener("click", () => ask("record"));
  byId("save").addEventListener("click", () => {
    const page = byId("report").contentWindow.infotraj;
    if (!page) { say("The report is still being drawn."); return; }
    if (!page.ticked().length) { say("Nothing is ticked. Tick one of the effects in the report first."); return; }
    ask("save", {name: byId("new-name").value, effects: page.ticked()});
  });
  const begun = refresh();
})();
