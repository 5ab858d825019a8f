// Scores, pairs, frames and formulas as tables.
"use strict";

const methodNames = report.order;
const scoreOf = (name) => scores.methods[name];
const heading = (text, attributes = {}) => make("th", { scope: "col", text, ...attributes });
const isBetter = (metric, a, b) => (scores.metrics[metric].better === "lower" ? a < b : a > b);
const metricTitle = (metric) => `${scores.metrics[metric].title} ${scores.metrics[metric].better === "lower" ? "↓" : "↑"}`;

function fillTable(id, headings, rows) {
  byId(id).replaceChildren(make("thead", {}, [make("tr", {}, headings)]), make("tbody", {}, rows));
}

const methodCell = (name) => make("th", { scope: "row", title: name }, [swatch(methodNames.indexOf(name)), name]);

/** The best of the numbers that exist; null when there is none. */
function bestOf(metric, values) {
  return values.reduce((best, value) => (value !== null && (best === null || isBetter(metric, value, best)) ? value : best), null);
}

/** A score with what stands below it, bold where it is the best of its column. */
function scoreCell(metric, value, best, below) {
  const text = formatScore(value, scores.metrics[metric].digits), isBest = value !== null && value === best;
  const cell = make("td", isBest ? { class: "best" } : {}, [isBest ? make("b", { text }) : text]);
  if (below) cell.append(make("small", { text: below }));
  return cell;
}

const secondsText = (method) => (method.seconds === undefined ? "–" : method.seconds.toFixed(3));

function fillScores() {
  const best = Object.fromEntries(metricNames.map((m) => [m, bestOf(m, methodNames.map((name) => scoreOf(name).mean[m]))]));
  const rows = methodNames.map((name) => {
    const method = scoreOf(name);
    const cells = metricNames.map((m) => scoreCell(m, method.mean[m], best[m], method.interval[m] ? formatInterval(method.interval[m], scores.metrics[m].digits) : ""));
    return make("tr", {}, [methodCell(name), ...cells, make("td", { text: secondsText(method) })]);
  });
  if (scores.floor) {
    const cells = metricNames.map((m) => scoreCell(m, scores.floor.mean[m], null, ""));
    rows.push(make("tr", {}, [make("th", { scope: "row", text: scores.floor.name }), ...cells, make("td", { text: "–" })]));
  }
  fillTable("score-table", [heading("method"), ...metricNames.map((m) => heading(metricTitle(m))), heading("s a frame")], rows);
  const broken = methodNames.filter((name) => scoreOf(name).not_finite > 0);
  const notes = [`Means over ${scores.frame_count} frames; below each the ${100 * scores.confidence} % confidence interval of the mean (Student's t). Bold: the best.`];
  if (scores.methods.blur?.sigma)
    notes.push(`blur is a Gaussian whose width is chosen for each metric: ${metricNames.map((m) => `${Number(scores.methods.blur.sigma[m]?.toPrecision(3))} px for ${scores.metrics[m].title}`).join(", ")}.`);
  if (scores.floor) notes.push(`${scores.floor.name}: ${scores.floor.text}.`);
  if (broken.length) notes.push(`No score, because values are NaN or infinite: ${broken.join(", ")}.`);
  byId("score-note").textContent = notes.join(" ");
}

function fillPairs() {
  const comparison = report.comparisons[Number(byId("baseline").value)];
  const others = methodNames.filter((name) => name !== comparison.baseline);
  const rows = others.flatMap((name) => metricNames.map((metric, i) => {
    const pair = comparison.methods[name][metric], { digits } = scores.metrics[metric];
    const wins = pair.interval !== null && (pair.interval[0] > 0 || pair.interval[1] < 0);
    const verdict = !wins ? "" : isBetter(metric, pair.mean_difference, 0) ? "good" : "bad";
    return make("tr", {}, [
      i === 0 ? methodCell(name) : make("td"),
      make("td", { class: "text", text: scores.metrics[metric].title }),
      make("td", { class: verdict, text: formatScore(pair.mean_difference, digits) }),
      make("td", { text: formatInterval(pair.interval, digits) }),
      make("td", { text: `${pair.better} : ${pair.worse}` }),
      make("td", { text: pair.p === null ? "–" : pair.p < 1e-4 ? pair.p.toExponential(1) : pair.p.toFixed(4) }),
    ]);
  }));
  fillTable("pair-table", [heading("method"), heading("metric", { class: "text" }), heading("difference"), heading(`${100 * scores.confidence} % interval`), heading("frames better : worse"), heading("p")], rows);
  byId("pair-note").textContent =
    `Difference: method − ${comparison.baseline}, mean over ${comparison.frame_count} frames; green and red where the interval leaves out 0, for better and worse. ` +
    "p: Wilcoxon's signed-rank test, two-sided, not corrected for the number of rows." +
    (scores.floor ? ` ${scores.floor.name}: ${metricNames.map((m) => `${scores.metrics[m].title} ${formatScore(scores.floor.mean[m], scores.metrics[m].digits)}`).join(", ")}.` : "") +
    (comparison.too_few_frames ? " These are too few frames: with fewer than 6 the test cannot come below 0.05." : "");
}

function fillFrames() {
  const metric = byId("frame-metric").value;
  const frames = scoreOf(methodNames[0]).frames.map((frame) => frame.name);
  const rows = frames.map((name, f) => {
    const picture = report.pictures.findIndex((entry) => entry.index === f);
    const values = methodNames.map((method) => scoreOf(method).frames[f][metric]);
    const best = bestOf(metric, values);
    const title = make("th", { scope: "row", title: name });
    if (picture >= 0) {
      const open = make("button", { type: "button", text: name });
      open.addEventListener("click", () => { selectFrame(picture); byId("pictures").scrollIntoView(); });
      title.append(open);
    } else title.textContent = name;
    const floor = scores.floor ? [scoreCell(metric, scores.floor.frames[f][metric], null, "")] : [];
    return make("tr", { class: picture === state.picture ? "current" : "" }, [title, ...values.map((value) => scoreCell(metric, value, best, "")), ...floor]);
  });
  fillTable("frame-table", [heading("frame"), ...methodNames.map((name) => heading(name)), ...(scores.floor ? [heading(scores.floor.name)] : [])], rows);
  byId("frame-note").textContent = report.pictures.length < frames.length
    ? `Pictures of ${report.pictures.length} of the ${frames.length} frames are in this file; their names open them.` : "";
}

function fillFormulas() {
  byId("formula-list").replaceChildren(...metricNames.flatMap((metric) => {
    const { title, formula, domain, better } = scores.metrics[metric];
    return [make("dt", { text: title }), make("dd", {}, [make("code", { text: formula }), make("small", { text: `on ${domain}; ${better} is better` })])];
  }));
}
