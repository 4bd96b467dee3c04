"use strict";

/* One panel of a figure: its heading and legend, and its drawing. */

const LEFT = 62, RIGHT = 14, TOP = 8, BOTTOM = 24; // pixels around a drawing
const NAMED = 14; // pixels above it for the names of marks
const MARKED = 40; // points up to which a line shows them

function element(name, attributes = {}, parent = null, text = null) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== null) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

function html(name, className, parent = null, text = null) {
  const made = document.createElement(name);
  made.className = className;
  if (text !== null) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

const logarithms = (values, log) =>
  log && values ? Float64Array.from(values, (v) => (v > 0 ? Math.log10(v) : NaN)) : values;

function isAscending(values) {
  for (let i = 1; i < values.length; i++) if (!(values[i] >= values[i - 1])) return false;
  return true;
}

class Panel {
  /**
   * @param {Plot} plot  whose `x`, `px` and `inner` say what is seen
   * @param {object} data  one entry of its `panels`
   */
  constructor(plot, data) {
    this.plot = plot;
    this.levels = logarithms(data.levels, data.log);
    this.log = data.log;
    this.weight = data.weight;
    this.span = data.span && data.span.map((y) => (data.log ? Math.log10(y) : y));
    this.named = plot.data.panels[0] === data && plot.data.marks.length ? NAMED : 0;
    this.top = TOP + this.named;
    this.zoomed = null; // the range of y that was chosen, if one was
    this.series = data.series.map((s) => ({
      ...s,
      hidden: s.aside,
      x: logarithms(s.x, plot.data.log),
      y: logarithms(s.y, data.log),
      low: logarithms(s.low, data.log),
      high: logarithms(s.high, data.log),
      ascending: isAscending(s.x),
    }));
    const box = html("div", "panel", plot.root);
    const head = html("div", "panel-head", box);
    html("span", "y-label", head, data.label);
    this.power = html("span", "power", head);
    const legend = html("span", "legend", head);
    for (const series of this.series) {
      if (series.label || this.series.length === 1) this.buildKey(series, legend);
    }
    if (plot.data.panels[0] === data && plot.data.shaded.length) {
      const key = html("span", "key unnamed", legend);
      html("span", "swatch shade", key);
      html("span", "", key, plot.data.shade);
    }
    this.svg = element("svg", { "aria-hidden": "true" }, box);
  }

  /** A name of the legend, which shows or hides its curve and reads out its value. */
  buildKey(series, legend) {
    const key = html("button", `key tone-${series.tone}`, legend);
    key.type = "button";
    html("span", `swatch ${series.kind}${series.broad ? " broad" : ""}${series.dashed ? " dashed" : ""}`, key);
    html("span", "", key, series.label);
    series.value = html("output", "value", key);
    if (!series.label) {
      key.disabled = true;
      key.classList.add("unnamed");
      return;
    }
    key.title = "Show or hide";
    key.setAttribute("aria-pressed", String(!series.hidden));
    key.addEventListener("click", () => {
      series.hidden = !series.hidden;
      key.setAttribute("aria-pressed", String(!series.hidden));
      this.plot.render();
    });
  }

  /** Read out the values nearest to x; return the x of the first, or `x` if there is none. */
  point(x) {
    this.unpoint();
    let at = null;
    for (const series of this.series) {
      if (series.hidden || !series.ascending || !series.x.length) continue;
      const after = clamp(lowerBound(series.x, x), 0, series.x.length - 1);
      const before = Math.max(after - 1, 0);
      const near = x - series.x[before] < series.x[after] - x ? before : after;
      at ??= series.x[near];
      const y = series.y[near];
      if (series.value) series.value.textContent = readout(this.log ? 10 ** y : y);
      const cx = this.plot.px(series.x[near]), cy = this.py(y);
      if (Number.isFinite(cy) && cx >= LEFT && cx <= LEFT + this.plot.inner) {
        element("circle", { cx, cy, r: 3, class: `dot tone-${series.tone}` }, this.cross);
      }
    }
    const px = this.plot.px(at ?? x);
    const line = { x1: px, x2: px, y1: this.top, y2: this.height, class: "cross" };
    this.cross.prepend(element("line", line));
    return at ?? x;
  }

  unpoint() {
    this.cross?.replaceChildren();
    for (const { value } of this.series) if (value) value.textContent = "";
  }

  /** Draw everything anew, `height` pixels high down to the axis. */
  draw(tall) {
    const { plot } = this, height = tall + this.named;
    const last = this === plot.panels[plot.panels.length - 1];
    const total = height + (last ? BOTTOM : 6);
    this.height = height;
    const [low, high] = this.zoomed ?? this.span ?? this.range();
    this.py = (y) => height - ((y - low) / (high - low)) * (height - this.top);
    this.toY = (pixel) => low + ((height - clamp(pixel, this.top, height)) / (height - this.top)) * (high - low);
    const svg = this.svg;
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${plot.width} ${total}`);
    svg.setAttribute("width", plot.width);
    svg.setAttribute("height", total);
    const id = `clip-${plot.data.name}-${plot.panels.indexOf(this)}`;
    const frame = { x: LEFT, y: this.top - 4, width: plot.inner, height: height - this.top + 4 };
    element("rect", frame, element("clipPath", { id }, element("defs", {}, svg)));
    element("rect", { ...frame, class: "ground" }, svg);
    const inside = element("g", { "clip-path": `url(#${id})` }, svg);
    this.drawRanges(inside);
    this.drawAxes(svg, low, high, last);
    svg.append(inside);
    const layers = [...this.series].sort((a, b) => b.broad - a.broad); // the broad ones lowest
    for (const series of layers) if (!series.hidden) this.drawSeries(series, inside);
    this.drawLevels(inside);
    this.drawMarks(svg);
    this.cross = element("g", { class: "crosshair" }, svg);
  }

  /** What of y is seen: all that lies in the visible stretch of x, with a margin. */
  range() {
    let low = Infinity, high = -Infinity;
    const take = (value) => {
      if (value < low) low = value;
      if (value > high) high = value;
    };
    for (const s of this.series) {
      if (s.hidden) continue;
      const [first, last] = this.visible(s);
      for (let i = first; i < last; i++) {
        if (!s.ascending && (s.x[i] < this.plot.x[0] || s.x[i] > this.plot.x[1])) continue;
        take(s.y[i]);
        if (s.low) { take(s.low[i]); take(s.high[i]); }
      }
      if (s.kind === "stems") take(0);
    }
    for (const level of this.levels) take(level);
    if (!(high >= low)) return [0, 1];
    if (high === low) return [low - (Math.abs(low) || 1), high + (Math.abs(high) || 1)];
    const margin = 0.05 * (high - low);
    return [low - margin, high + margin];
  }

  /** Indices of a series in the visible stretch, and one beyond at each end. */
  visible(series) {
    if (!series.ascending) return [0, series.x.length];
    return [
      Math.max(lowerBound(series.x, this.plot.x[0]) - 1, 0),
      Math.min(lowerBound(series.x, this.plot.x[1]) + 1, series.x.length),
    ];
  }

  drawRanges(parent) {
    for (const [first, last] of this.plot.data.shaded) {
      const x = this.plot.px(first);
      const width = Math.max(this.plot.px(last) - x, 0);
      const frame = { x, width, y: this.top - 4, height: this.height - this.top + 4, class: "shaded" };
      element("rect", frame, parent);
    }
  }

  drawAxes(svg, low, high, last) {
    const rows = Math.max(3, Math.round(this.height / 28));
    const ticks = this.log ? logTicks(low, high, rows) : linearTicks(low, high, rows);
    const { texts, power } = this.log ? { texts: ticks.map(logText), power: 0 } : tickTexts(ticks);
    this.power.textContent = power ? `× 10${raised(power)}` : "";
    ticks.forEach((tick, i) => {
      const y = this.py(tick);
      if (y < this.top - 5 || y > this.height + 1) return;
      element("line", { x1: LEFT, x2: LEFT + this.plot.inner, y1: y, y2: y, class: "grid" }, svg);
      element("text", { x: LEFT - 8, y: y + 3.5, class: "tick y" }, svg, texts[i]);
    });
    const columns = Math.max(3, Math.round(this.plot.inner / 85));
    const [first, end] = this.plot.x;
    const places = this.plot.data.log
      ? logTicks(first, end, columns) : linearTicks(first, end, columns, this.plot.data.whole);
    const names = this.plot.data.log ? places.map(logText) : tickTexts(places).texts;
    const shift = this.plot.data.log ? 0 : tickTexts(places).power;
    places.forEach((tick, i) => {
      const x = this.plot.px(tick);
      if (x < LEFT - 1 || x > LEFT + this.plot.inner + 1) return;
      element("line", { x1: x, x2: x, y1: this.top - 4, y2: this.height, class: "grid" }, svg);
      if (last) element("text", { x, y: this.height + 16, class: "tick x" }, svg, names[i]);
    });
    if (last && shift) {
      const place = { x: LEFT + this.plot.inner, y: this.height + 16, class: "tick y" };
      element("text", place, svg, `× 10${raised(shift)}`);
    }
    const base = { x1: LEFT, x2: LEFT + this.plot.inner, y1: this.height, y2: this.height };
    element("line", { ...base, class: "axis" }, svg);
  }

  drawSeries(series, parent) {
    const look = `tone-${series.tone}${series.broad ? " broad" : ""}${series.dashed ? " dashed" : ""}`;
    const [first, last] = this.visible(series);
    if (series.kind === "stems") {
      let path = "";
      const zero = this.py(0);
      for (let i = first; i < last; i++) {
        path += `M${this.plot.px(series.x[i]).toFixed(1)} ${zero.toFixed(1)}V${this.py(series.y[i]).toFixed(1)}`;
      }
      element("path", { d: path, class: `stems ${look}` }, parent);
      const base = { x1: LEFT, x2: LEFT + this.plot.inner, y1: zero, y2: zero, class: "axis" };
      element("line", base, parent);
      return;
    }
    if (series.low) this.drawSpread(series, parent, first, last, look);
    if (series.kind === "points" || (series.x.length <= MARKED && !series.broad)) {
      element("path", { d: this.dots(series, first, last), class: `points ${look}` }, parent);
    }
    if (series.kind === "line") {
      const d = this.curve(series.x, series.y, first, last);
      element("path", { d, class: `curve ${look}` }, parent);
    }
  }

  drawSpread(series, parent, first, last, look) {
    if (series.kind === "points") {
      let path = "";
      for (let i = first; i < last; i++) {
        const x = this.plot.px(series.x[i]).toFixed(1);
        path += `M${x} ${this.py(series.low[i]).toFixed(1)}V${this.py(series.high[i]).toFixed(1)}`;
      }
      element("path", { d: path, class: `whiskers ${look}` }, parent);
      return;
    }
    if (series.dashed) {
      for (const bound of [series.low, series.high]) {
        const d = this.curve(series.x, bound, first, last);
        element("path", { d, class: `bound ${look}` }, parent);
      }
      return;
    }
    let path = "", there = [], back = [];
    const close = () => {
      if (there.length) path += `M${[...there, ...back.reverse()].join("L")}Z`;
      there = [];
      back = [];
    };
    for (let i = first; i < last; i++) {
      const low = this.py(series.low[i]), high = this.py(series.high[i]);
      if (!Number.isFinite(low + high)) { close(); continue; }
      const x = this.plot.px(series.x[i]).toFixed(1);
      there.push(`${x} ${high.toFixed(1)}`);
      back.push(`${x} ${low.toFixed(1)}`);
    }
    close();
    if (path) element("path", { d: path, class: `band ${look}` }, parent);
  }

  /** Points as strokes of no length with round ends: one element however many there are. */
  dots(series, first, last) {
    let path = "";
    for (let i = first; i < last; i++) {
      const y = this.py(series.y[i]);
      if (Number.isFinite(y)) path += `M${this.plot.px(series.x[i]).toFixed(1)} ${y.toFixed(1)}h0`;
    }
    return path;
  }

  /** A line; where a pixel has many points, their first, least, largest and last. */
  curve(xs, ys, first, last) {
    const dense = last - first > 4 * this.plot.inner;
    let path = "", open = false, column = NaN;
    let entry = 0, least = 0, largest = 0, exit = 0;
    const add = (x, y) => {
      if (!Number.isFinite(y)) { open = false; return; }
      path += `${open ? "L" : "M"}${x.toFixed(1)} ${this.py(y).toFixed(1)}`;
      open = true;
    };
    const close = () => {
      if (Number.isNaN(column)) return;
      add(column, entry);
      if (least < Math.min(entry, exit)) add(column, least);
      if (largest > Math.max(entry, exit)) add(column, largest);
      if (exit !== entry || largest !== least) add(column, exit);
    };
    for (let i = first; i < last; i++) {
      const y = ys[i], x = this.plot.px(xs[i]);
      if (!dense) { add(x, y); continue; }
      if (Number.isNaN(y)) { close(); column = NaN; open = false; continue; }
      const here = Math.round(x);
      if (here !== column) {
        close();
        column = here;
        entry = least = largest = y;
      }
      if (y < least) least = y;
      if (y > largest) largest = y;
      exit = y;
    }
    if (dense) close();
    return path;
  }

  drawLevels(parent) {
    for (const level of this.levels) {
      const y = this.py(level);
      element("line", { x1: LEFT, x2: LEFT + this.plot.inner, y1: y, y2: y, class: "level" }, parent);
    }
  }

  /** To which side of its line a name stands: two of them apart, none beyond the edges. */
  anchor(place, x) {
    const { inner, data } = this.plot;
    if (x < LEFT + 0.1 * inner) return "start";
    if (x > LEFT + 0.9 * inner) return "end";
    if (data.marks.length !== 2) return "middle";
    return place === Math.min(...data.marks.map(([at]) => at)) ? "end" : "start";
  }

  drawMarks(svg) {
    for (const [place, name] of this.plot.data.marks) {
      const x = this.plot.px(this.plot.data.log ? Math.log10(place) : place);
      if (x < LEFT || x > LEFT + this.plot.inner) continue;
      element("line", { x1: x, x2: x, y1: this.top - 4, y2: this.height, class: "level" }, svg);
      if (!this.named) continue;
      const frame = { x, y: this.top - 8, "text-anchor": this.anchor(place, x) };
      element("text", { ...frame, class: "mark" }, svg, name);
    }
  }
}
