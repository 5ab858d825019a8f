// Elements and numbers. Names of methods and frames reach the page as text only, never as HTML.
"use strict";

const byId = (id) => document.getElementById(id);

/** An element with attributes (or "text", "class") and children. */
function make(tag, attributes = {}, children = []) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") element.textContent = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

function makeSvg(tag, attributes = {}, text = "") {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  return element;
}

/** As the tables of ld_eval: fixed decimals, or an exponent where they would show nothing. */
function formatScore(value, digits) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  return value === 0 || (size < 1e5 && size >= 10 ** (1 - digits)) ? value.toFixed(digits) : value.toExponential(2);
}

function formatInterval(interval, digits) {
  return interval ? `${formatScore(interval[0], digits)} … ${formatScore(interval[1], digits)}` : "–";
}

/** 17.3 M, 12.1 k. */
function formatCount(value) {
  if (value === undefined) return "–";
  for (const [unit, size] of [["G", 1e9], ["M", 1e6], ["k", 1e3]])
    if (value >= size) return `${(value / size).toPrecision(3)} ${unit}`;
  return value.toPrecision(3);
}

function formatRadiance(value) {
  if (!Number.isFinite(value)) return String(value);
  return value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5) ? String(Number(value.toPrecision(4))) : value.toExponential(2);
}

// Okabe and Ito's colours, which people who confuse colours can tell apart.
const methodColours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a7a00", "#7f7f7f"];

function swatch(index) {
  const dot = make("span", { class: "swatch", "aria-hidden": "true" });
  dot.style.background = methodColours[index % methodColours.length];
  return dot;
}

function showNotice(text) {
  byId("notice").textContent = text;
  byId("notice").hidden = false;
}
