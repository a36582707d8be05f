"use strict";

// A slider's position runs from 0 to 1; the value between `low` and `high` by itself or by its logarithm.
const SLIDERS = [
  { name: "k1", text: "stretch stiffness k₁", low: 20, high: 1e6, log: true, start: 1e4 },
  { name: "k2", text: "shear stiffness k₂", low: 5, high: 1e6, log: true, start: 1e4 },
  { name: "gamma3", text: "rotational drag γ₃", low: 1e-6, high: 1, log: true, start: 1e-4 },
  { name: "gamma1", text: "axial drag γ₁", low: 0.05, high: 2, log: false, start: 0.5 },
  { name: "force", text: "follower force", low: 0, high: 200, log: false, start: 40 },
];
const ORBITS_AFTER = 400; // ms of rest
const $ = (id) => document.getElementById(id);

function format(x, digits = 6) {
  const rounded = Number(x.toPrecision(digits));
  return rounded !== 0 && Math.abs(rounded) < 1e-3 ? rounded.toExponential() : rounded.toString();
}

let current = null; // the state that is shown
let branches = []; // of orbits, of the current rod
let newest = 0; // number of the newest question; older answers are dropped
let waiting = false; // for an answer: one question at a time, the next with what the sliders then say
let resting = null;
const PAGE = Math.random().toString(36).slice(2); // tells the server whose question it is

function valueOf(slider, position) {
  const { low, high, log } = slider;
  const value = log ? low * (high / low) ** position : low + (high - low) * position;
  return Number(value.toPrecision(4));
}

function positionOf(slider, value) {
  const { low, high, log } = slider;
  return log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
}

function buildControls() {
  for (const slider of SLIDERS) {
    const label = document.createElement("label");
    label.innerHTML = `${slider.text} <output id="${slider.name}-value"></output>
      <input type="range" id="${slider.name}" min="0" max="1" step="any">`;
    $("controls").append(label);
    $(slider.name).value = positionOf(slider, slider.start);
    $(slider.name).addEventListener("input", () => ask(slider.name !== "force"));
  }
}

function values() {
  const rod = {};
  for (const slider of SLIDERS) {
    rod[slider.name] = valueOf(slider, Number($(slider.name).value));
  }
  // the straight rod exists for force < k1 only
  rod.force = Math.min(rod.force, 0.999 * rod.k1);
  for (const slider of SLIDERS) $(`${slider.name}-value`).textContent = format(rod[slider.name], 4);
  return rod;
}

async function fetched(path, parameters) {
  const answer = await fetch(`${path}?${new URLSearchParams(parameters)}`);
  const content = await answer.json();
  if (!answer.ok) throw new Error(content.error);
  return content;
}

async function ask(rodChanged) {
  const number = ++newest;
  const rod = values();
  if (rodChanged) branches = [];
  clearTimeout(resting);
  if (waiting) return;
  waiting = true;
  try {
    current = await fetched("state", { ...rod, page: PAGE, question: number });
    show();
    if (number === newest && !branches.length) resting = setTimeout(() => askOrbits(number, rod), ORBITS_AFTER);
  } catch (error) {
    say(error.message, true);
  }
  waiting = false;
  if (number !== newest) ask(false);
}

async function askOrbits(number, rod) {
  const thresholds = current.thresholds;
  const found = [];
  let failure = "";
  if (thresholds.length) $("orbit-note").textContent = "computing orbits of the full nonlinear rod …";
  for (let i = 0; i < thresholds.length; i++) {
    // a branch that joins two thresholds is asked for once
    if (found.some((b) => b.joins !== null && Math.abs(b.joins / thresholds[i].force - 1) < 1e-6)) continue;
    try {
      const branch = await fetched("orbits", { ...rod, threshold: i, page: PAGE, question: number });
      if (number !== newest) return;
      found.push(branch);
      branches = [...found];
      showAmplitude();
    } catch (error) {
      failure = `${error.message}. `;
    }
    if (number !== newest) return;
  }
  const count = found.reduce((sum, branch) => sum + branch.points.length, 0);
  $("orbit-note").textContent = failure + (count
    ? `${count} orbits of the full nonlinear rod: dots, hollow where unstable; lines: theory, dashed where unstable`
    : "");
}

function say(text, isError = false) {
  $("message").textContent = text;
  $("message").className = isError ? "error" : "";
}

// ---- plots: SVG, drawn anew each time

class Plot {
  constructor(id, x, y, labels) {
    this.svg = $(id);
    this.svg.replaceChildren();
    const box = this.svg.getBoundingClientRect();
    [this.width, this.height] = [Math.max(box.width, 200), Math.max(box.height, 150)];
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    [this.left, this.right, this.top, this.bottom] = [58, this.width - 12, 8, this.height - 34];
    [this.x, this.y] = [x, y];
    this.ticks(labels);
  }
  at([x, y]) {
    const u = (x - this.x[0]) / (this.x[1] - this.x[0]);
    const v = (y - this.y[0]) / (this.y[1] - this.y[0]);
    return [this.left + u * (this.right - this.left), this.bottom - v * (this.bottom - this.top)];
  }
  add(tag, attributes, text) {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    if (text !== undefined) element.textContent = text;
    this.svg.append(element);
    return element;
  }
  line(points, kind) {
    const inside = points.map((p) => this.at(p).map((v) => Math.max(-1e5, Math.min(1e5, v)).toFixed(1)));
    const clip = `clip-${this.svg.id}`;
    if (!this.svg.querySelector("clipPath")) {
      const area = this.add("clipPath", { id: clip });
      const box = { x: this.left, y: this.top, width: this.right - this.left, height: this.bottom - this.top };
      area.append(this.add("rect", box));
    }
    return this.add("polyline", { points: inside.join(" "), class: kind, "clip-path": `url(#${clip})` });
  }
  dot(point, kind, r = 3) {
    const [cx, cy] = this.at(point);
    if (cx < this.left - 1 || cx > this.right + 1 || cy < this.top - 1 || cy > this.bottom + 1) return;
    this.add("circle", { cx, cy, r, class: kind });
  }
  ticks([xLabel, yLabel]) {
    this.add("path", { class: "axis", d: `M${this.left},${this.top}V${this.bottom}H${this.right}` });
    for (const x of ticksOf(this.x)) {
      this.add("text", { x: this.at([x, 0])[0], y: this.bottom + 14, "text-anchor": "middle" }, format(x, 4));
    }
    for (const y of ticksOf(this.y)) {
      this.add("text", { x: this.left - 5, y: this.at([0, y])[1] + 4, "text-anchor": "end" }, format(y, 4));
    }
    this.add("text", { x: (this.left + this.right) / 2, y: this.height - 4, "text-anchor": "middle" }, xLabel);
    const middle = (this.top + this.bottom) / 2;
    this.add("text", { x: 11, y: middle, transform: `rotate(-90 11 ${middle})`, "text-anchor": "middle" }, yLabel);
    if (this.y[0] < 0 && this.y[1] > 0) this.line([[this.x[0], 0], [this.x[1], 0]], "zero");
  }
}

function ticksOf([low, high], most = 6) {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high * (1 + 1e-12); i++) ticks.push(i * step);
  return ticks;
}

function show() {
  const { thresholds, predictions, searched, buckling } = current;
  $("thresholds").replaceChildren(
    ...thresholds.map((t, i) => {
      const row = document.createElement("tr");
      const p = predictions[i];
      const cells = [
        i + 1, format(t.force, 8), format(t.omega, 8), t.crossing, complex(t.alpha), complex(t.beta), t.criticality,
        p.exists ? `${format(p.A_tip)} ${p.stable ? "stable" : "unstable"}` : "–", p.exists ? format(p.omega) : "–",
      ];
      row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
      row.children[6].className = t.criticality;
      return row;
    }),
  );
  const calm = buckling.length ? "" : ": the straight rod is stable";
  const buckles = buckling.length ? `A real eigenvalue crosses at force ${buckling.map((f) => format(f)).join(", ")}: buckling. ` : "";
  say(buckles + (thresholds.length ? "" : `No threshold up to force ${format(searched)}${calm}.`));
  showSpectrum();
  showPlane();
  showAmplitude();
  showMode();
}

function complex([re, im]) {
  return `${format(re)} ${im < 0 ? "−" : "+"} ${format(Math.abs(im))}i`;
}

function showSpectrum() {
  const { force, growth } = current.spectrum;
  const leading = growth.map((row) => Math.max(...row));
  const high = Math.max(1, ...leading);
  const range = [-Math.max(high, 3 * Math.abs(leading[0])), 1.1 * high];
  const plot = new Plot("spectrum", [0, force[force.length - 1]], range, ["force", "Re λ"]);
  for (const row of [0, 1, 2, 3, 4, 5]) plot.line(growth.map((g, i) => [force[i], [...g].sort((a, b) => b - a)[row]]), "other");
  plot.line(leading.map((g, i) => [force[i], g]), "curve");
  plot.line([[current.force, range[0]], [current.force, range[1]]], "now");
  for (const t of current.thresholds) plot.dot([t.force, 0], "point", 4);
}

function showPlane() {
  const shown = current.eigenvalues;
  // strongly damped modes lie far to the left: those that oscillate, or the slowest, set the scale
  const pairs = shown.filter((z) => z[1] !== 0);
  const size = (z) => Math.hypot(...z);
  const reach = 1.2 * (pairs.length ? Math.max(...pairs.map(size)) : 3 * Math.min(...shown.map(size)));
  const [re, im] = [reach, reach];
  const plot = new Plot("plane", [-re, re], [-im, im], ["Re λ", "Im λ"]);
  plot.line([[0, -im], [0, im]], "zero");
  for (const z of shown) plot.dot(z, z[0] > 0 ? "point" : "orbit", 4);
}

function showAmplitude() {
  const { thresholds, spectrum, force } = current;
  const end = spectrum.force[spectrum.force.length - 1];
  const orbits = branches.flatMap((branch) => branch.points);
  const high = Math.max(0.1, ...orbits.map((p) => p[1])) * 1.1;
  const plot = new Plot("amplitude", [0, end], [0, Math.min(high, 1.2)], ["force", "amplitude of the tip"]);
  for (const t of thresholds) {
    const side = Math.sign(t.A_tip2_slope);
    const reach = Math.max((plot.y[1] ** 2 / Math.abs(t.A_tip2_slope)), 1e-9);
    const points = Array.from({ length: 60 }, (_, i) => {
      const d = reach * (i / 59) ** 2;
      return [t.force + side * d, Math.sqrt(Math.abs(t.A_tip2_slope) * d)];
    });
    plot.line(points, t.criticality === "supercritical" ? "theory" : "theory dashed");
  }
  for (const [f, amplitude, stable] of orbits) plot.dot([f, amplitude], stable ? "orbit" : "orbit unstable", 2.5);
  plot.line([[force, plot.y[0]], [force, plot.y[1]]], "now");
}

// ---- the mode, beating with the predicted amplitude (or a small one where the branch does not exist here)

let beating = null;

function showMode() {
  const first = current.thresholds.findIndex((_, i) => current.predictions[i].exists);
  const chosen = first >= 0 ? first : 0;
  const t = current.thresholds[chosen];
  cancelAnimationFrame(beating);
  if (!t) {
    $("mode-title").textContent = "Critical mode: none";
    $("mode").replaceChildren();
    return;
  }
  const exists = first >= 0;
  const amplitude = exists ? Math.min(current.predictions[chosen].A_tip, 0.5) : 0.1;
  $("mode-title").textContent = `Critical mode of threshold ${chosen + 1}` + (exists ? ", at the predicted amplitude" : ", at amplitude 0.1");
  const plot = new Plot("mode", [0, 1.05], [-1.3 * amplitude, 1.3 * amplitude], ["u", "y"]);
  const at = (phase) => t.mode.u.map((u, i) => {
    const [re, im] = t.mode.Y[i];
    return [u, amplitude * (re * Math.cos(phase) - im * Math.sin(phase))];
  });
  for (let i = 0; i < 12; i++) plot.line(at((2 * Math.PI * i) / 12), "other");
  const moving = plot.line(at(0), "curve");
  const beat = (now) => {
    const points = at((2 * Math.PI * now) / 1500);
    moving.setAttribute("points", points.map((p) => plot.at(p).map((v) => v.toFixed(1))).join(" "));
    beating = requestAnimationFrame(beat);
  };
  beating = requestAnimationFrame(beat);
}

async function begin() {
  const { title, parameters } = await fetched("about", {});
  $("title").textContent = document.title = title;
  const own = parameters.map((p) => ({ ...p, text: p.name, log: false }));
  SLIDERS.splice(SLIDERS.length - 1, 0, ...own);
  buildControls();
  addEventListener("resize", () => current && show());
  ask(true);
}

begin().catch((error) => say(error.message, true));
