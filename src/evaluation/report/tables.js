// Scores, pairs, frames and formulas as tables.
"use strict";

const methodNames = report.order;
const scoreOf = (name) => scores.methods[name];
const heading = (text, attributes = {}) => make("th", { scope: "col", text, ...attributes });

/** What is better of a metric: `kind` is its entry in `metrics` of an evaluation. */
const betterThan = { lower: (a, b) => a < b, higher: (a, b) => a > b, "nearer to 1": (a, b) => Math.abs(a - 1) < Math.abs(b - 1) };
const isBetter = (kind, a, b) => betterThan[kind.better](a, b);
const arrows = { lower: "↓", higher: "↑", "nearer to 1": "→ 1" };
const metricTitle = (kind) => `${kind.title} ${arrows[kind.better]}`;

function fillTable(id, headings, rows) {
  byId(id).replaceChildren(make("thead", {}, [make("tr", {}, headings)]), make("tbody", {}, rows));
}

const methodCell = (name) => make("th", { scope: "row", title: name }, [swatch(methodNames.indexOf(name)), name]);

/** The best of the numbers that exist; null when there is none. */
function bestOf(kind, values) {
  return values.reduce((best, value) => (value !== null && (best === null || isBetter(kind, value, best)) ? value : best), null);
}

/** A score with what stands below it, bold where it is the best of its column. */
function scoreCell(kind, value, best, below) {
  const text = formatScore(value, kind.digits), isBest = value !== null && value === best;
  const cell = make("td", isBest ? { class: "best" } : {}, [isBest ? make("b", { text }) : text]);
  if (below) cell.append(make("small", { text: below }));
  return cell;
}

const secondsText = (method) => (method.seconds === undefined ? "–" : method.seconds.toFixed(3));

/** The means of an evaluation, of frames or of sequences, into the table and the note of these ids. */
function fillScores(evaluation, table, note) {
  const { metrics, methods, floor } = evaluation, names = Object.keys(metrics);
  const best = Object.fromEntries(names.map((m) => [m, bestOf(metrics[m], methodNames.map((name) => methods[name].mean[m]))]));
  const rows = methodNames.map((name) => {
    const method = methods[name];
    const cells = names.map((m) => scoreCell(metrics[m], method.mean[m], best[m], method.interval[m] ? formatInterval(method.interval[m], metrics[m].digits) : ""));
    return make("tr", {}, [methodCell(name), ...cells, make("td", { text: secondsText(method) })]);
  });
  if (floor) {
    const cells = names.map((m) => scoreCell(metrics[m], floor.mean[m], null, ""));
    rows.push(make("tr", {}, [make("th", { scope: "row", text: floor.name }), ...cells, make("td", { text: "–" })]));
  }
  fillTable(table, [heading("method"), ...names.map((m) => heading(metricTitle(metrics[m]))), heading("s a frame")], rows);
  const broken = methodNames.filter((name) => methods[name].not_finite > 0);
  const notes = [`Means over ${evaluation.frame_count} ${evaluation.unit}s; below each the ${100 * evaluation.confidence} % confidence interval of the mean (Student's t). Bold: the best.`];
  if (methods.blur?.sigma)
    notes.push(`blur is a Gaussian whose width is chosen for each metric: ${names.map((m) => `${Number(methods.blur.sigma[m]?.toPrecision(3))} px for ${metrics[m].title}`).join(", ")}.`);
  if (floor) notes.push(`${floor.name}: ${floor.text}.`);
  if (broken.length) notes.push(`No score, because values are NaN or infinite: ${broken.join(", ")}.`);
  byId(note).textContent = notes.join(" ");
}

/** The same of each method against the baseline of `comparison`. */
function fillPairs(evaluation, comparison, table, note) {
  const { metrics, floor, unit } = evaluation, names = Object.keys(metrics);
  const others = methodNames.filter((name) => name !== comparison.baseline);
  const rows = others.flatMap((name) => names.map((metric, i) => {
    const pair = comparison.methods[name][metric], { digits } = metrics[metric];
    const wins = pair.interval !== null && (pair.interval[0] > 0 || pair.interval[1] < 0);
    const verdict = !wins || metrics[metric].better === "nearer to 1" ? "" : isBetter(metrics[metric], pair.mean_difference, 0) ? "good" : "bad";
    return make("tr", {}, [
      i === 0 ? methodCell(name) : make("td"),
      make("td", { class: "text", text: metrics[metric].title }),
      make("td", { class: verdict, text: formatScore(pair.mean_difference, digits) }),
      make("td", { text: formatInterval(pair.interval, digits) }),
      make("td", { text: `${pair.better} : ${pair.worse}` }),
      make("td", { text: pair.p === null ? "–" : pair.p < 1e-4 ? pair.p.toExponential(1) : pair.p.toFixed(4) }),
    ]);
  }));
  fillTable(table, [heading("method"), heading("metric", { class: "text" }), heading("difference"), heading(`${100 * evaluation.confidence} % interval`), heading(`${unit}s better : worse`), heading("p")], rows);
  byId(note).textContent =
    `Difference: method − ${comparison.baseline}, mean over ${comparison.frame_count} ${unit}s; green and red where the interval leaves out 0, for better and worse. ` +
    "p: Wilcoxon's signed-rank test, two-sided, not corrected for the number of rows." +
    (floor ? ` ${floor.name}: ${names.map((m) => `${metrics[m].title} ${formatScore(floor.mean[m], metrics[m].digits)}`).join(", ")}.` : "") +
    (comparison.too_few_frames ? ` These are too few ${unit}s: with fewer than 6 the test cannot come below 0.05.` : "");
}

function fillFrames() {
  const metric = byId("frame-metric").value;
  const frames = scoreOf(methodNames[0]).frames.map((frame) => frame.name);
  const rows = frames.map((name, f) => {
    const picture = report.pictures.findIndex((entry) => entry.index === f);
    const values = methodNames.map((method) => scoreOf(method).frames[f][metric]);
    const kind = scores.metrics[metric], best = bestOf(kind, values);
    const title = make("th", { scope: "row", title: name });
    if (picture >= 0) {
      const open = make("button", { type: "button", text: name });
      open.addEventListener("click", () => { selectFrame(picture); byId("pictures").scrollIntoView(); });
      title.append(open);
    } else title.textContent = name;
    const floor = scores.floor ? [scoreCell(kind, scores.floor.frames[f][metric], null, "")] : [];
    return make("tr", { class: picture === state.picture ? "current" : "" }, [title, ...values.map((value) => scoreCell(kind, value, best, "")), ...floor]);
  });
  fillTable("frame-table", [heading("frame"), ...methodNames.map((name) => heading(name)), ...(scores.floor ? [heading(scores.floor.name)] : [])], rows);
  byId("frame-note").textContent = report.pictures.length < frames.length
    ? `Pictures of ${report.pictures.length} of the ${frames.length} frames are in this file; their names open them.` : "";
}

function fillFormulas() {
  const kinds = { ...scores.metrics, ...report.sequences?.evaluation.metrics };
  byId("formula-list").replaceChildren(...Object.values(kinds).flatMap(({ title, formula, domain, better }) =>
    [make("dt", { text: title }), make("dd", {}, [make("code", { text: formula }), make("small", { text: `on ${domain}; ${better} is better` })])]));
}
