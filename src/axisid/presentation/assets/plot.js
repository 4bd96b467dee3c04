"use strict";

/* A figure: panels above one another with x in common, as SVG, so that they print as vectors and
   take their colours from the style sheet. No library, no network.

   Data come in as typed arrays; on a logarithmic axis they are turned into logarithms once, and all
   that follows is linear. */

const PANEL_HEIGHT = 132, LEAST_HEIGHT = 210;
const PRINTED_WIDTH = 680, PRINTED_HALF = 328, PRINTED_LOWER = 0.4;
const SMALLEST_ZOOM = 1e-5; // of the whole range
const STEP = 1.4; // of one notch of the wheel, one key
const BOX = 6; // pixels from which a drag is a box

class Plot {
  /**
   * @param {HTMLElement} root  filled with the figure; its `data-from` and `data-to` say what is seen
   * @param {object} data  one entry of the page's `plots`, its arrays decoded
   */
  constructor(root, data) {
    this.root = root;
    this.data = data;
    this.build();
    this.whole = this.extent();
    this.x = [...this.whole];
    this.armed = true;
    new ResizeObserver(() => this.render()).observe(root);
    const half = root.closest("figure").classList.contains("half");
    const printed = half ? PRINTED_HALF : PRINTED_WIDTH;
    window.addEventListener("beforeprint", () => this.render(printed, PRINTED_LOWER));
    window.addEventListener("afterprint", () => this.render());
    this.render();
  }

  extent() {
    let low = Infinity, high = -Infinity;
    for (const { series } of this.panels) {
      for (const { x } of series) {
        for (const value of x) {
          if (value < low) low = value;
          if (value > high) high = value;
        }
      }
    }
    if (low === Infinity) return [0, 1];
    if (high === low) return [low - 0.5, low + 0.5];
    const roomy = this.panels.some((p) => p.series.some((s) => s.kind !== "line"))
      || this.panels[0].series[0].x.length <= MARKED;
    const margin = roomy ? 0.03 * (high - low) : 0;
    return [low - margin, high + margin];
  }

  build() {
    const { root } = this;
    root.tabIndex = 0;
    root.setAttribute("role", "application");
    root.setAttribute("aria-roledescription", "figure with zoom");
    const tools = html("div", "tools", root.closest("figure").querySelector(".figure-head"));
    for (const [sign, name, act] of [
      ["−", "Zoom out", () => this.zoom(1 / STEP)],
      ["+", "Zoom in", () => this.zoom(STEP)],
      ["Reset", "Show everything", () => this.reset()],
    ]) {
      const button = html("button", "tool", tools, sign);
      button.type = "button";
      button.title = name;
      button.setAttribute("aria-label", name);
      button.addEventListener("click", act);
    }
    this.panels = this.data.panels.map((panel) => new Panel(this, panel));
    for (const panel of this.panels) {
      const listen = (kind, act) => panel.svg.addEventListener(kind, act);
      listen("pointerdown", (event) => this.onDown(event, panel));
      listen("pointermove", (event) => this.onMove(event, panel));
      listen("pointerup", (event) => this.onUp(event, panel));
      listen("pointercancel", () => this.endDrag());
      listen("dblclick", () => this.reset());
    }
    const foot = html("div", "x-label", root);
    html("span", "", foot, this.data.x_label);
    this.position = html("output", "", foot);
    root.addEventListener("wheel", (event) => this.onWheel(event), { passive: false });
    root.addEventListener("keydown", (event) => this.onKey(event));
    root.addEventListener("pointerleave", () => this.point(null));
    // A wheel that scrolls the page past a still pointer goes on scrolling; once the pointer has
    // moved over the figure, the wheel zooms.
    window.addEventListener("scroll", () => { this.armed = false; }, { passive: true });
  }

  // What is seen.

  reset() {
    this.x = [...this.whole];
    for (const panel of this.panels) panel.zoomed = null;
    this.render();
  }

  see(low, high) {
    const [first, last] = this.whole;
    const least = SMALLEST_ZOOM * (last - first);
    const span = clamp(high - low, least, last - first);
    const start = clamp(low, first, last - span);
    this.x = [start, start + span];
    this.render();
  }

  /** Magnify about a share of the width. */
  zoom(factor, share = 0.5) {
    const [low, high] = this.x;
    const about = low + share * (high - low);
    this.see(about - (about - low) / factor, about + (high - about) / factor);
  }

  pan(share) {
    const [low, high] = this.x;
    this.see(low + share * (high - low), high + share * (high - low));
  }

  isWhole() {
    const span = this.whole[1] - this.whole[0];
    return this.x[1] - this.x[0] >= span * (1 - 1e-9);
  }

  // Input.

  onWheel(event) {
    if (event.target.closest("svg") === null || (!this.armed && !event.ctrlKey)) return;
    const inward = event.deltaY < 0;
    if (!inward && this.isWhole()) return; // the page scrolls on
    event.preventDefault();
    if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      this.pan(event.deltaX / this.inner);
      return;
    }
    const share = this.share(event, event.target.closest("svg"));
    this.zoom(inward ? STEP : 1 / STEP, clamp(share, 0, 1));
  }

  onKey(event) {
    const acts = {
      ArrowLeft: () => this.pan(-0.2),
      ArrowRight: () => this.pan(0.2),
      "+": () => this.zoom(STEP),
      "=": () => this.zoom(STEP),
      "-": () => this.zoom(1 / STEP),
      0: () => this.reset(),
      Home: () => this.reset(),
      Escape: () => this.reset(),
    };
    const act = acts[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  }

  onDown(event, panel) {
    if (event.button !== 0) return;
    this.root.focus({ preventScroll: true });
    panel.svg.setPointerCapture(event.pointerId);
    const { x, y } = this.local(event, panel);
    const pans = event.shiftKey || event.pointerType === "touch";
    this.drag = { x, y, pans, panel, from: [...this.x] };
  }

  onMove(event, panel) {
    if (event.movementX || event.movementY) this.armed = true;
    const { x, y } = this.local(event, panel);
    const { drag } = this;
    if (!drag) return this.point(this.value(x), panel, y);
    if (drag.pans) {
      const shift = ((drag.x - x) / this.inner) * (drag.from[1] - drag.from[0]);
      return this.see(drag.from[0] + shift, drag.from[1] + shift);
    }
    drag.box ??= element("rect", { class: "box" }, panel.svg);
    const wide = Math.abs(x - drag.x) > BOX, tall = Math.abs(y - drag.y) > 2 * BOX;
    const place = {
      x: wide ? Math.min(x, drag.x) : LEFT,
      width: wide ? Math.abs(x - drag.x) : this.inner,
      y: tall ? Math.min(y, drag.y) : panel.top,
      height: tall ? Math.abs(y - drag.y) : panel.height - panel.top,
    };
    drag.box.setAttribute("visibility", wide || tall ? "visible" : "hidden");
    for (const [key, value] of Object.entries(place)) drag.box.setAttribute(key, value);
    return undefined;
  }

  onUp(event, panel) {
    const { drag } = this;
    this.endDrag();
    if (!drag || drag.pans) return;
    const { x, y } = this.local(event, panel);
    const wide = Math.abs(x - drag.x) > BOX, tall = Math.abs(y - drag.y) > 2 * BOX;
    if (tall) panel.zoomed = [panel.toY(Math.max(y, drag.y)), panel.toY(Math.min(y, drag.y))];
    if (wide) this.see(this.value(Math.min(x, drag.x)), this.value(Math.max(x, drag.x)));
    else if (tall) this.render();
  }

  endDrag() {
    this.drag?.box?.remove();
    this.drag = null;
  }

  local(event, panel) {
    const frame = panel.svg.getBoundingClientRect();
    return { x: event.clientX - frame.left, y: event.clientY - frame.top };
  }

  share(event, svg) {
    return (event.clientX - svg.getBoundingClientRect().left - LEFT) / this.inner;
  }

  value(pixel) {
    const [low, high] = this.x;
    return low + (clamp(pixel - LEFT, 0, this.inner) / this.inner) * (high - low);
  }

  /** Read out the values nearest to x, or nothing. */
  point(x) {
    this.position.textContent = "";
    if (x === null) {
      for (const panel of this.panels) panel.unpoint();
      return;
    }
    const [at] = this.panels.map((panel) => panel.point(x));
    this.position.textContent = readout(this.data.log ? 10 ** at : at);
  }

  // Drawing.

  render(width = this.root.clientWidth, lower = 1) {
    if (width < LEFT + RIGHT + 40) return; // not laid out, or on its way to paper
    this.width = width;
    this.inner = width - LEFT - RIGHT;
    this.px = (x) => LEFT + ((x - this.x[0]) / (this.x[1] - this.x[0])) * this.inner;
    const weights = this.panels.reduce((sum, panel) => sum + panel.weight, 0);
    const unit = lower * Math.max(PANEL_HEIGHT, LEAST_HEIGHT / weights);
    for (const panel of this.panels) panel.draw(Math.round(unit * panel.weight));
    const scale = this.data.log ? (x) => 10 ** x : (x) => x;
    this.root.dataset.from = scale(this.x[0]);
    this.root.dataset.to = scale(this.x[1]);
    this.root.classList.toggle("zoomed", !this.isWhole() || this.panels.some((p) => p.zoomed));
    this.point(null);
  }
}
