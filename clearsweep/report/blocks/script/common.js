"use strict";
// What the interactive parts share: numbers out of the page, numbers into text, colours of the page's style.

/** Return the data that stands in the page under an id. */
function dataOf(id) {
  return JSON.parse(document.getElementById(id).textContent);
}

/** Return the numbers of a text that holds them as little-endian 32-bit floats, in base 64. */
function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), char => char.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float64Array.from({length: bytes.length / 4}, (_, i) => Number(view.getFloat32(4 * i, true).toPrecision(7)));
}

/** Return a number as text with four significant digits, never 1e5; a dash where there is none. */
function numberText(value) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(4)))));
  if (power >= 6 || power < -4) {
    const raised = [...String(power)].map(char => "⁰¹²³⁴⁵⁶⁷⁸⁹"[char] || "⁻").join("");
    return `${minus((value / 10 ** power).toFixed(3))} × 10${raised}`;
  }
  return minus(value.toFixed(Math.max(3 - power, 0)).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, ""));
}

function minus(text) {
  return text.replace("-", "−");
}

/** Return the colour that the page's style gives a name. */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Return a new element with attributes, and children: elements or text. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name, value);
    else if (value !== null && value !== false) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

/** Make a canvas as sharp as the screen, `width` by `height` in CSS pixels; return what draws on it. */
function sharp(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  return context;
}

/** Call `draw` now, and whenever the element changes its width or the page its colours. */
function redrawn(watched, draw) {
  let width = 0;
  new ResizeObserver(() => {
    if (watched.clientWidth !== width) {
      width = watched.clientWidth;
      requestAnimationFrame(draw); // not now: what is drawn changes heights, which the observer would be told of again
    }
  }).observe(watched);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}
