// Time beside quality: a plot and a table.
"use strict";

const plot = { width: 620, height: 320, left: 64, right: 110, top: 30, bottom: 42 };

/** Three to six round values between low and high, and a little beyond. */
function ticks(low, high) {
  const rough = (high - low) / 4 || Math.abs(high) || 1, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const result = [];
  for (let value = Math.floor(low / step) * step; value < high + step; value += step) result.push(Number(value.toPrecision(6)));
  return result;
}

function drawCost() {
  const metric = byId("cost-metric").value, { title, digits } = scores.metrics[metric];
  const timed = methodNames.filter((name) => scoreOf(name).seconds > 0 && scoreOf(name).mean[metric] !== null);
  if (timed.length === 0) {
    byId("cost-plot").replaceChildren(make("p", { class: "hint", text: "No method was timed in this evaluation." }));
    return;
  }
  const svg = makeSvg("svg", { viewBox: `0 0 ${plot.width} ${plot.height}`, role: "img", "aria-label": `${title} against seconds a frame` });
  const seconds = timed.map((name) => scoreOf(name).seconds), shown = methodNames.filter((name) => scoreOf(name).mean[metric] !== null);
  const times = ticks(0, Math.max(...seconds) * 1.05), values = ticks(...["min", "max"].map((end) => Math[end](...shown.map((name) => scoreOf(name).mean[metric]))));
  const scale = (domain, from, to) => (value) => from + ((value - domain[0]) / (domain[domain.length - 1] - domain[0])) * (to - from);
  const x = scale(times, plot.left, plot.width - plot.right), y = scale(values, plot.height - plot.bottom, plot.top);

  for (const value of values) {
    svg.append(makeSvg("line", { x1: plot.left, x2: plot.width - plot.right, y1: y(value), y2: y(value), class: "axis" }));
    svg.append(makeSvg("text", { x: plot.left - 8, y: y(value) + 4, "text-anchor": "end", class: "muted" }, String(value)));
  }
  for (const value of times)
    svg.append(makeSvg("text", { x: x(value), y: plot.height - plot.bottom + 18, "text-anchor": "middle", class: "muted" }, String(value)));
  svg.append(makeSvg("text", { x: (plot.left + plot.width - plot.right) / 2, y: plot.height - 6, "text-anchor": "middle" }, "seconds a frame"));
  svg.append(makeSvg("text", { x: 4, y: 14 }, `${title}, ${scores.metrics[metric].better} is better`));

  const taken = [];
  for (const name of shown) {
    const method = scoreOf(name), colour = methodColours[methodNames.indexOf(name) % methodColours.length], level = y(method.mean[metric]);
    const hasTime = timed.includes(name), place = hasTime ? x(method.seconds) : plot.width - plot.right;
    const mark = hasTime ? makeSvg("circle", { cx: place, cy: level, r: 6, fill: colour })
      : makeSvg("line", { x1: plot.left, x2: place, y1: level, y2: level, stroke: colour, "stroke-dasharray": "5 4" });
    mark.append(makeSvg("title", {}, `${name}: ${formatScore(method.mean[metric], digits)}${hasTime ? `, ${secondsText(method)} s a frame` : ""}`));
    svg.append(mark, labelOf(name, place, level, taken));
  }
  byId("cost-plot").replaceChildren(svg);
}

/** The name beside its mark, where no other name stands: to the right, else further down or up. */
function labelOf(name, place, level, taken) {
  const text = name.length > 16 ? `${name.slice(0, 15)}…` : name, width = 7 * text.length, height = 14;
  const free = (y) => taken.every((box) => Math.abs(box.y - y) >= height || place + 10 > box.right || place + 10 + width < box.left);
  const spot = [0, 14, -14, 28, -28, 42, -42].map((offset) => level + 4 + offset).find(free) ?? level + 4;
  taken.push({ left: place + 10, right: place + 10 + width, y: spot });
  return makeSvg("text", { x: place + 10, y: spot }, text);
}

function fillCost() {
  const rows = methodNames.map((name) => {
    const method = scoreOf(name);
    return make("tr", {}, [methodCell(name), make("td", { text: secondsText(method) }), make("td", { text: formatCount(method.parameters) }), make("td", { text: formatCount(method.multiply_adds_per_pixel) })]);
  });
  fillTable("cost-table", [heading("method"), heading("s a frame"), heading("parameters"), heading("multiply-adds a pixel")], rows);
}
