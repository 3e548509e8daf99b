import { lastBefore, numbers } from "./data.js";

const SVG = "http://www.w3.org/2000/svg";
/** Side of the drawing, which is stretched to its place. */
const SIDE = 1000;
const SERIES = 6;

/** Small plots of a run over time; where one is pressed, the clock goes. */
export class Plots {
  constructor(place, panels, clock) {
    this.clock = clock;
    this.panels = panels.map((panel) => new Panel(place, panel, clock));
  }

  show(time) {
    for (const panel of this.panels) panel.show(time);
  }
}

class Panel {
  constructor(place, { title, unit, curves, dots }, clock) {
    this.clock = clock;
    this.curves = curves.map((curve, k) => ({ ...series(curve), name: `series-${k % SERIES}` }));
    this.dots = dots.map((dot, k) => ({ ...series(dot), name: k ? "silent" : "heard" }));
    const all = [...this.curves, ...this.dots];
    this.ticks = ticks(...limits(all));
    const figure = element("figure", { class: "panel" }, place);
    const caption = element("figcaption", {}, figure);
    element("strong", {}, caption, title);
    if (unit) element("span", { class: "unit" }, caption, `[${unit}]`);
    this.values = all.map((one) => legend(caption, one, all.length > 1));
    this.plot = element("div", { class: "plot", role: "img", "aria-label": describe(title, unit, all) }, figure);
    this.draw();
    this.cursor = element("div", { class: "cursor" }, this.plot);
    this.listen();
  }

  draw() {
    const { start, end } = this.clock;
    const [low, high] = [this.ticks.low, this.ticks.high];
    const x = (time) => (((time - start) / (end - start || 1)) * SIDE).toFixed(2);
    const y = (value) => (((high - value) / (high - low)) * SIDE).toFixed(2);
    const svg = drawn("svg", { viewBox: `0 0 ${SIDE} ${SIDE}`, preserveAspectRatio: "none", "aria-hidden": "true" }, this.plot);
    for (const tick of this.ticks.values) {
      drawn("path", { class: "rule", d: `M0 ${y(tick)}H${SIDE}` }, svg);
      const top = `${y(tick) / (SIDE / 100)}%`;
      element("span", { class: "tick across" }, this.plot, label(tick, this.ticks.step)).style.top = top;
    }
    const seconds = ticks(start, end, 5);
    for (const tick of seconds.values.filter((time) => time >= start && time <= end)) {
      drawn("path", { class: "rule", d: `M${x(tick)} 0V${SIDE}` }, svg);
      const left = `${x(tick) / (SIDE / 100)}%`;
      element("span", { class: "tick along" }, this.plot, label(tick, seconds.step)).style.left = left;
    }
    for (const { name, times, values } of this.curves) {
      const points = Array.from(times, (time, k) => `${x(time)} ${y(values[k])}`);
      drawn("path", { class: `curve ${name}`, d: `M${points.join("L")}` }, svg);
    }
    // a line of no length with a round end is a dot
    for (const { name, times, values } of this.dots) {
      drawn("path", { class: `dots ${name}`, d: Array.from(times, (time, k) => `M${x(time)} ${y(values[k])}h0`).join("") }, svg);
    }
  }

  listen() {
    const scrub = (event) => {
      const { left, width } = this.plot.getBoundingClientRect();
      this.clock.seek(this.clock.start + ((event.clientX - left) / width) * (this.clock.end - this.clock.start));
    };
    this.plot.addEventListener("pointerdown", (event) => {
      this.plot.setPointerCapture(event.pointerId);
      this.clock.pause();
      scrub(event);
    });
    this.plot.addEventListener("pointermove", (event) => {
      if (this.plot.hasPointerCapture(event.pointerId)) scrub(event);
    });
  }

  show(time) {
    const { start, end } = this.clock;
    this.cursor.style.left = `${((time - start) / (end - start || 1)) * 100}%`;
    this.curves.forEach((curve, k) => {
      this.values[k].textContent = label(between(curve, time), this.ticks.step / 50);
    });
  }
}

function series({ label: text, times, values }) {
  return { label: text, times: numbers(times), values: numbers(values) };
}

/** The value of a curve at a time, on the line between its neighbours. */
export function between({ times, values }, time) {
  const last = lastBefore(time, times.length, (k) => times[k]);
  if (last < 0) return values[0];
  if (last === times.length - 1) return values[last];
  const share = (time - times[last]) / (times[last + 1] - times[last]);
  return values[last] + share * (values[last + 1] - values[last]);
}

function limits(all) {
  let [low, high] = [Infinity, -Infinity];
  for (const { values } of all) {
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const margin = 0.04 * (high - low) || Math.abs(high) / 10 || 1;
  return [low - margin, high + margin];
}

/** Round values, 1, 2 or 5 times a power of ten apart, between two limits. */
export function ticks(low, high, most = 4) {
  const rough = (high - low || 1) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const first = Math.ceil(low / step - 1e-9);
  const count = Math.floor(high / step + 1e-9) - first + 1;
  return { low, high, step, values: Array.from({ length: count }, (_, k) => (first + k) * step) };
}

/** A number with the decimals that a step asks for. */
export function label(value, step) {
  if (step < 1e-9) return value.toExponential(1);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  // no minus before a zero
  return (Math.round(value * 10 ** decimals) / 10 ** decimals + 0).toFixed(decimals);
}

function describe(title, unit, all) {
  const names = all.map((one) => one.label).filter(Boolean).join(", ");
  return `${title}${unit ? ` in ${unit}` : ""}${names ? `: ${names}` : ""}, over time in s`;
}

function legend(place, { name, label: text }, named) {
  const entry = element("span", { class: `entry ${name}` }, place);
  if (named) element("span", {}, entry, text);
  return element("output", {}, entry);
}

function element(tag, attributes, place, text) {
  return append(document.createElement(tag), attributes, place, text);
}

function drawn(tag, attributes, place) {
  return append(document.createElementNS(SVG, tag), attributes, place);
}

function append(node, attributes, place, text = "") {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.textContent = text;
  place.append(node);
  return node;
}
