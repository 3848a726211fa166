"use strict";
// What squeezing.py wrote, read again. Before page.js, which uses it.
const unpacking = (() => {
  async function inflated(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  }
  // Columns of whole steps: differences from row to row, either sign by turns, the lowest bytes of all columns first.
  async function columns(text, steps) {
    const bytes = new Uint8Array(await inflated(text)), size = bytes.length / 4, rows = size / steps.length;
    return steps.map((step, c) => {
      const out = new Float64Array(rows);
      for (let r = 0, at = c * rows, whole = 0; r < rows; r++, at++) {
        const turned = bytes[at] | bytes[size + at] << 8 | bytes[2 * size + at] << 16 | bytes[3 * size + at] << 24;
        whole = whole + (turned >>> 1 ^ -(turned & 1)) | 0;
        out[r] = whole === -2147483648 ? NaN : whole * step;
      }
      return out;
    });
  }
  // The series of a flight or a window: t, and of each axis the measured one, the models', and what is left.
  async function series(part) {
    const names = Object.keys(part.steps), each = 1 + (part.left ? 2 : 1) * part.models;
    if (!names.length) return {t: new Float64Array(0), bucket: part.bucket, axes: {}};
    const steps = names.flatMap((name) => name === "t" ? [part.steps.t] : Array(each).fill(part.steps[name]));
    const held = await columns(part.numbers, steps), axes = {};
    names.slice(1).forEach((name, k) => {
      const own = held.slice(1 + k * each, 1 + (k + 1) * each), left = own.slice(1 + part.models);
      axes[name] = {measured: own[0], model: own.slice(1, 1 + part.models), left: part.left ? left : null};
    });
    return {t: held[0], bucket: part.bucket, axes};
  }
  async function script(text) {
    const made = document.createElement("script");
    made.textContent = new TextDecoder().decode(await inflated(text));
    document.head.append(made);
  }
  async function json(text) { return JSON.parse(new TextDecoder().decode(await inflated(text))); }
  return {series, script, json};
})();
