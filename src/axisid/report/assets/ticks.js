"use strict";

/* Numbers of the figures: where ticks stand, how they are written, how values are read out. */

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/** Index of the first value that is not below `x`, in an ascending array. */
function lowerBound(values, x) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < x) low = middle + 1; else high = middle;
  }
  return low;
}

/** Round values at 1, 2 or 5 times a power of ten within a range. */
function linearTicks(low, high, count, whole) {
  const raw = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const multiple = [1, 2, 5, 10].find((m) => m * power >= raw * 0.999);
  const step = whole ? Math.max(1, Math.round(multiple * power)) : multiple * power;
  const ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    ticks.push(i * step);
  }
  return ticks;
}

/** Ticks of a logarithmic range, as logarithms: decades, or 1, 2 and 5 where there are few. */
function logTicks(low, high, count) {
  const ticks = [];
  const every = Math.max(1, Math.ceil((high - low) / Math.max(count, 1)));
  const multiples = high - low < 3 ? [1, 2, 5] : [1];
  for (let e = Math.floor(low); e <= Math.ceil(high); e++) {
    if (e % every) continue;
    for (const m of multiples) {
      const tick = e + Math.log10(m);
      if (tick >= low - 1e-9 && tick <= high + 1e-9) ticks.push(tick);
    }
  }
  return ticks.length > 1 ? ticks : [low, high];
}

const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const raised = (n) =>
  (n < 0 ? "⁻" : "") + [...String(Math.abs(n))].map((d) => SUPERSCRIPT[d]).join("");
const minus = (text) => text.replace("-", "−");

/** Texts of linear ticks, and the power of ten that was taken out of them. */
function tickTexts(ticks) {
  const largest = Math.max(...ticks.map(Math.abs), 0);
  const exponent = largest ? Math.floor(Math.log10(largest) + 1e-9) : 0;
  const power = exponent < -2 || exponent > 4 ? 3 * Math.floor(exponent / 3) : 0;
  const scale = 10 ** power;
  const step = (ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : largest || 1) / scale;
  const digits = clamp(-Math.floor(Math.log10(step) + 1e-9), 0, 12);
  return { texts: ticks.map((t) => minus((t / scale).toFixed(digits))), power };
}

function logText(tick) {
  const value = 10 ** tick;
  const exponent = Math.round(tick);
  const decade = Math.abs(tick - exponent) < 1e-9;
  if (value >= 0.01 && value < 1e5) return String(Number(value.toPrecision(3)));
  return decade ? `10${raised(exponent)}` : minus(value.toExponential(0));
}

/** A number as it is read out. */
function readout(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size && (size < 1e-3 || size >= 1e5)) return minus(value.toExponential(3));
  return minus(String(Number(value.toPrecision(5))));
}
