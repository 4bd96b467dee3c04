"use strict";

/* Numbers of the figures: position and text of ticks, and text of values read out. */

const FEWEST = 3; // ticks of an axis
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

/** Round values at 1, 2 or 5 times a power of ten within a range: three or more of them. */
function linearTicks(low, high, count, whole) {
  for (let wanted = Math.max(count, FEWEST); ; wanted++) {
    const raw = (high - low) / wanted;
    const power = 10 ** Math.floor(Math.log10(raw));
    const multiple = [1, 2, 5, 10].find((m) => m * power >= raw * 0.999);
    const step = whole ? Math.max(1, Math.round(multiple * power)) : multiple * power;
    const ticks = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
      ticks.push(i * step);
    }
    if (ticks.length >= FEWEST || (whole && step === 1) || !(raw > 0)) return ticks;
  }
}

/** Ticks of a logarithmic range, as logarithms: decades, or more of each where those are few. */
function logTicks(low, high, count) {
  const inside = (every, multiples) => {
    const ticks = [];
    for (let e = every * Math.floor(low / every); e <= high; e += every) {
      for (const m of multiples) {
        const tick = e + Math.log10(m);
        if (tick >= low - 1e-9 && tick <= high + 1e-9) ticks.push(tick);
      }
    }
    return ticks;
  };
  for (let every = Math.max(1, Math.ceil((high - low) / count)); every >= 1; every--) {
    const ticks = inside(every, [1]);
    if (ticks.length >= FEWEST) return ticks;
  }
  for (const multiples of [[1, 2, 5], [1, 1.5, 2, 3, 5, 7]]) {
    const ticks = inside(1, multiples);
    if (ticks.length >= FEWEST) return ticks;
  }
  return linearTicks(10 ** low, 10 ** high, FEWEST).filter((t) => t > 0).map(Math.log10);
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
  if (value >= 0.01 && value < 1e5) return String(Number(value.toPrecision(6)));
  return powered(value, 6).replace(/^1 × /, "");
}

/** A number with a power of ten, rounded to at most `digits` digits. */
function powered(value, digits) {
  const [factor, exponent] = value.toExponential(digits - 1).split("e");
  return `${minus(String(Number(factor)))} × 10${raised(Number(exponent))}`;
}

/** A number as it is read out. */
function readout(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size && (size < 1e-3 || size >= 1e5)) return powered(value, 4);
  return minus(String(Number(value.toPrecision(5))));
}
