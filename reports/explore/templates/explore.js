"use strict";
// The page of `takagi explore`: sliders, the design that the server answers with, and its picture.

const byId = (id) => document.getElementById(id);
// Only in this window: the server answers the newest one.
const page = Array.from(crypto.getRandomValues(new Uint32Array(4)), (k) => k.toString(36)).join("-");
const WIDTH = 560, HEIGHT = 430, LEFT = 62, BOTTOM = 46, TOP = 12, RIGHT = 12;

const NOTHING = { gains: { columns: [], labels: [], rows: [] }, claims: [] };

let axes = [], panels = [], steps = [], plane = 0, shown = null, asking = null, ended = false;

// ---------------------------------------------------------------- the server

async function post(path, body, signal) {
  const options = { method: "POST", headers: { "Content-Type": "application/json" }, signal };
  const response = await fetch(path, { ...options, body: JSON.stringify({ page, ...body }) });
  const answer = await response.json();
  if (!response.ok) {
    ended = response.status === 409;
    throw new Error(answer.error);
  }
  return answer;
}

function tell(error) {
  if (error.name === "AbortError") return;
  const lost = error instanceof TypeError;
  byId("problem").textContent = lost
    ? "takagi explore does not answer: start it again in the terminal, and open its new address."
    : error.message;
  byId("problem").hidden = false;
}

async function turn() {
  if (asking) asking.abort();
  asking = new AbortController();
  const { signal } = asking, here = [...steps];
  try {
    let answer = await post("turn", { steps: here }, signal);
    show(answer, here);
    if (!answer.exact) {
      answer = await post("turn", { steps: here, exact: true }, signal);
      if (!answer.stale) show(answer, here);
    }
    byId("problem").hidden = true;
  } catch (error) {
    tell(error);
  }
}

async function follow() {
  try {
    const { ready, total } = await (await fetch("progress")).json();
    byId("progress").textContent = axes[0].name === "wind"
      ? `${total} wind cells`
      : ready < total ? `precomputing: ${ready} of ${total} designs` : `${total} designs precomputed`;
    if (ready < total && !ended) setTimeout(follow, 1000);
  } catch (error) {
    tell(error);
  }
}

// ---------------------------------------------------------------- elements

function made(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

function slider(axis, index) {
  const id = `axis-${axis.name}`;
  const input = made("input", {
    id, type: "range", min: 0, max: axis.words.length - 1, step: 1, value: 0,
  });
  const output = made("output", { for: id });
  const write = () => {
    output.textContent = axis.words[steps[index]];
    input.setAttribute("aria-valuetext", axis.words[steps[index]]);
  };
  input.addEventListener("input", () => {
    steps[index] = Number(input.value);
    write();
    turn();
  });
  write();
  return made("div", { class: "axis" }, made("label", { for: id }, axis.label), output, input);
}

// ---------------------------------------------------------------- the answer

function where(at) {
  return axes.map((axis, k) => `${axis.label.toLowerCase()} ${axis.words[at[k]]}`).join("; ");
}

function show(answer, here) {
  const { cell, exact } = answer, none = "none" in cell;
  const badge = byId("badge"), pending = byId("pending");
  badge.className = `badge ${none ? "DISPROVED" : cell.proved && exact ? "PROVED" : "part"}`;
  badge.textContent = none ? "NO DESIGN" : exact ? cell.verdict : `${cell.verdict} for another position`;
  byId("origin").textContent = answer.origin;
  const about = answer.expected ? `, in about ${Math.max(1, Math.round(answer.expected))} s` : "";
  pending.textContent = `Shown is the nearest design, for ${where(answer.shown)}. `
    + `The one that you ask for is being made${about}.`;
  pending.hidden = exact;
  byId("answer").dataset.at = exact ? here.join("-") : "";
  byId("sentence").textContent = none ? cell.none : cell.sentence;
  byId("command").textContent = answer.command;
  byId("copied").textContent = "";
  // Where there is no design nothing stays: it would be of another one.
  shown = none ? null : cell;
  for (const id of ["figures", "picture", "gain-box"]) {
    byId(id).hidden = none;
    byId(id).classList.toggle("stale", !exact);
  }
  showRows(none ? [] : cell.rows);
  showGains(none ? NOTHING : cell);
  draw();
}

function showRows(rows) {
  byId("rows").replaceChildren(...rows.flatMap((row) => {
    const basis = made("span", { class: "basis" }, ` ${row.basis}`);
    const less = row.shortfall ? [made("span", { class: "shortfall" }, ` ← ${row.shortfall}`)] : [];
    return [made("dt", {}, row.name), made("dd", {}, row.text, basis, ...less)];
  }));
}

function showGains(cell) {
  const { columns, labels, rows } = cell.gains, heads = ["", ...columns];
  byId("law").textContent = axes[0].name === "wind"
    ? "Of the cell's lower and upper wind; between them they are interpolated."
    : "u = u* − Σ hᵢ Kᵢ (x − x*), in SI units, as the gain file has them.";
  byId("gains").replaceChildren(
    made("thead", {}, made("tr", {}, ...heads.map((head) => head
      ? made("th", { scope: "col" }, head) : made("td")))),
    made("tbody", {}, ...rows.map((row, k) => made("tr", {},
      made("th", { scope: "row" }, labels[k]), ...row.map((value) => made("td", {}, value))))),
  );
  byId("claims").replaceChildren(...cell.claims.map(([name, verdict]) => made("li", {}, `${verdict}: ${name}`)));
  byId("notes").replaceChildren(...(cell.notes || []).map((note) => made("li", {}, note)));
}

// ---------------------------------------------------------------- pictures

const short = (value) => String(Number(value.toPrecision(3)));

function ticks(low, high, most) {
  const rough = (high - low) / most, size = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * size).find((k) => k >= rough);
  const first = Math.ceil(low / step), count = Math.floor(high / step) - first + 1;
  return Array.from({ length: count }, (_, k) => (first + k) * step);
}

function scales(low, high, width, height) {
  return {
    x: (value) => LEFT + (value - low[0]) / (high[0] - low[0]) * (width - LEFT - RIGHT),
    y: (value) => height - BOTTOM - (value - low[1]) / (high[1] - low[1]) * (height - BOTTOM - TOP),
  };
}

function frame(to, low, high, words, width, height) {
  const parts = [];
  for (const value of ticks(low[0], high[0], 6)) {
    const at = to.x(value);
    parts.push(svg("line", { class: "grid", x1: at, x2: at, y1: TOP, y2: height - BOTTOM }));
    parts.push(svg("text", { x: at, y: height - BOTTOM + 17, "text-anchor": "middle" }, short(value)));
  }
  for (const value of ticks(low[1], high[1], height > 300 ? 6 : 3)) {
    const at = to.y(value);
    parts.push(svg("line", { class: "grid", x1: LEFT, x2: width - RIGHT, y1: at, y2: at }));
    parts.push(svg("text", { x: LEFT - 6, y: at + 4, "text-anchor": "end" }, short(value)));
  }
  const middle = [(LEFT + width - RIGHT) / 2, (TOP + height - BOTTOM) / 2];
  parts.push(svg("text", { x: middle[0], y: height - 8, "text-anchor": "middle" }, words[0]));
  parts.push(svg("text", {
    x: 14, y: middle[1], "text-anchor": "middle", transform: `rotate(-90 14 ${middle[1]})`,
  }, words[1]));
  parts.push(svg("rect", {
    class: "frame", x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: height - BOTTOM - TOP,
  }));
  return parts;
}

function path(to, xs, ys) {
  let pen = "M", text = "";
  xs.forEach((x, k) => {
    if (ys[k] === null) { pen = "M"; return; }
    text += `${pen}${to.x(x).toFixed(1)} ${to.y(ys[k]).toFixed(1)}`;
    pen = "L";
  });
  return text;
}

function legend(entries) {
  byId("legend").replaceChildren(...entries.map(([kind, words]) => {
    const line = kind === "dot"
      ? svg("circle", { class: kind, cx: 14, cy: 6, r: 3.5 })
      : svg("path", { class: kind, d: kind === "safe" ? "M2 2H26V10H2Z" : "M0 6H28" });
    const swatch = svg("svg", { viewBox: "0 0 28 12", "aria-hidden": "true" }, line);
    return made("li", {}, swatch, words);
  }));
}

function draw() {
  if (!shown) { byId("drawing").replaceChildren(); return; }
  if (panels.length) { drawPanels(shown.at); return; }
  const planes = shown.planes;
  byId("choose").hidden = planes.length < 2;
  if (!planes.length) {
    byId("drawing").replaceChildren();
    legend([]);
    byId("caption").textContent = "There is no plane of two states to draw.";
    return;
  }
  plane = Math.min(plane, planes.length - 1);
  const names = planes.map((one) => one.axes.join(" and "));
  const options = names.map((name, k) => made("option", { value: k }, name));
  if (byId("plane").childElementCount !== names.length) byId("plane").replaceChildren(...options);
  byId("plane").value = plane;
  drawPlane(planes[plane]);
}

function drawPlane(one) {
  const curves = [one.safe, one.set, ...one.motions].filter(Boolean);
  const reach = [0, 1].map((k) => Math.max(one.covered[k], ...curves.map((c) => Math.max(...c[k].map(Math.abs)))));
  const near = [0, 1].map((k) => (one.range[k] || []).filter((end) => Math.abs(end) < 4 * reach[k]));
  const high = [0, 1].map((k) => Math.max(1.15 * reach[k], ...near[k].map((end) => 1.08 * Math.abs(end))));
  const low = high.map((value) => -value), to = scales(low, high, WIDTH, HEIGHT);
  const parts = frame(to, low, high, one.axes, WIDTH, HEIGHT), entries = [];
  const kind = one.proved ? "safe" : "open";
  if (one.safe) {
    parts.push(svg("path", { class: kind, d: `${path(to, ...one.safe)}Z` }));
    const whole = one.set ? ", other states at rest" : "";
    entries.push([kind, one.proved ? `proved safe starts${whole}` : "ellipsoid, not proved"]);
  }
  if (one.set) {
    parts.push(svg("path", { class: one.proved ? "set" : "open", d: `${path(to, ...one.set)}Z` }));
    entries.push([one.proved ? "set" : "open", one.proved ? "projection of the set, never left" : "its projection"]);
  }
  for (const end of near[0]) parts.push(svg("line", { class: "range", x1: to.x(end), x2: to.x(end), y1: TOP, y2: HEIGHT - BOTTOM }));
  for (const end of near[1]) parts.push(svg("line", { class: "range", x1: LEFT, x2: WIDTH - RIGHT, y1: to.y(end), y2: to.y(end) }));
  if (near.flat().length) entries.push(["range", "range in the file"]);
  if (one.covered.some((half) => half > 0)) {
    const [x, y] = one.covered, size = [to.x(x) - to.x(-x), to.y(-y) - to.y(y)];
    parts.push(svg("rect", { class: "covered", x: to.x(-x), y: to.y(y), width: Math.max(size[0], 1), height: Math.max(size[1], 1) }));
    entries.push(["covered", "starts to be covered"]);
  }
  for (const line of one.motions) {
    parts.push(svg("path", { class: "motion", d: path(to, ...line) }));
    parts.push(svg("circle", { class: "dot", cx: to.x(line[0][0]), cy: to.y(line[1][0]), r: 3 }));
  }
  if (one.motions.length) entries.push(["motion", "motion, simulated"]);
  const sizes = one.safe ? [0, 1].map((k) => short(Math.max(...one.safe[k].map(Math.abs)))) : ["-", "-"];
  const words = `${one.proved ? "Proved set" : "Ellipsoid that is not proved"} of ${one.axes.join(" and ")}: `
    + `it reaches ${sizes[0]} and ${sizes[1]}; ${one.motions.length} simulated motions`;
  byId("drawing").replaceChildren(svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": words }, ...parts));
  legend(entries);
  byId("caption").textContent = "Deviations from rest, in the units of the file.";
}

function drawPanels(at) {
  const height = 190;
  const drawings = panels.map((panel) => {
    const xs = panel.lines.flatMap((line) => line.x), ys = panel.lines.flatMap((line) => line.y).filter((y) => y !== null);
    const low = [Math.min(...xs), Math.min(0, ...ys)], high = [Math.max(...xs), 1.08 * Math.max(...ys)];
    const to = scales(low, high, WIDTH, height);
    const parts = frame(to, low, high, ["schedule wind [m/s]", `[${panel.unit}]`], WIDTH, height);
    panel.lines.forEach((line, k) => parts.push(svg("path", { class: `line${k}`, d: path(to, line.x, line.y) })));
    parts.push(svg("rect", {
      class: "cursor", x: to.x(at[0]), y: TOP, width: Math.max(to.x(at[1]) - to.x(at[0]), 2), height: height - TOP - BOTTOM,
    }));
    const names = panel.lines.map((line) => line.name).join(", ");
    const words = `${panel.title} over wind: ${names}; marked from ${at[0]} to ${at[1]} m/s`;
    const heading = made("p", { class: "panel" }, `${panel.title}: ${panel.lines.map((line, k) => `${line.name}${k ? " (dashed)" : ""}`).join(", ")}`);
    return [heading, svg("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": words }, ...parts)];
  });
  byId("drawing").replaceChildren(...drawings.flat());
  byId("caption").textContent = "The band marks the cell.";
}

// ---------------------------------------------------------------- start

async function copy() {
  try {
    await navigator.clipboard.writeText(byId("command").textContent);
    byId("copied").textContent = "Copied.";
  } catch {
    getSelection().selectAllChildren(byId("command"));
    byId("copied").textContent = "Selected: copy it by Ctrl-C.";
  }
}

async function start() {
  try {
    const answer = await post("open", {});
    ({ axes, panels } = answer);
    steps = axes.map(() => 0);
    document.title = `${answer.title}: takagi explore`;
    byId("title").textContent = answer.title;
    byId("sliders").replaceChildren(...axes.map(slider));
    byId("copy").addEventListener("click", copy);
    byId("plane").addEventListener("change", () => { plane = Number(byId("plane").value); draw(); });
    await turn();
    follow();
  } catch (error) {
    tell(error);
  }
}

start();
