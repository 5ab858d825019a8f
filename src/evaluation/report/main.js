// Tabs, keys and settings; the last file of the script.
"use strict";

const modes = ["picture", "relmse", "smape"];

/** Tabs that arrow keys walk through; `choose` gets the index. */
function makeTabs(id, names, choose, keyOf) {
  byId(id).replaceChildren(...names.map((name, i) => {
    const key = keyOf ? [make("span", { class: "key", text: keyOf(i), "aria-hidden": "true" })] : [];
    const tab = make("button", { type: "button", role: "tab", title: name }, [...key, name]);
    tab.addEventListener("click", () => choose(i));
    return tab;
  }));
}

function markTab(id, chosen) {
  for (const [i, tab] of [...byId(id).children].entries()) {
    tab.setAttribute("aria-selected", i === chosen);
    tab.tabIndex = i === chosen ? 0 : -1;
  }
}

function showStatus() {
  const picture = currentPicture(), label = labels[state.method], method = scores.methods[label];
  const parts = [label, picture.frame, `${picture.width}×${picture.height}`];
  if (picture.full_width !== picture.width || picture.full_height !== picture.height)
    parts[2] += ` in the middle of ${picture.full_width}×${picture.full_height}`;
  if (state.method !== referenceIndex && method)
    for (const metric of metricNames) parts.push(`${scores.metrics[metric].title} ${formatScore(method.frames[picture.index][metric], scores.metrics[metric].digits)}`);
  byId("status").textContent = parts.join(" · ");
  viewCanvas.setAttribute("aria-label", `${state.mode === "picture" ? "Picture" : `${scores.metrics[state.mode].title} map`} of ${label}, frame ${picture.frame}`);
}

/** Everything that depends on the state, except the long tables. */
function redraw() {
  markTab("frame-tabs", state.picture);
  markTab("method-tabs", state.method);
  for (const button of document.querySelectorAll("[data-mode]")) button.setAttribute("aria-pressed", button.dataset.mode === state.mode);
  byId("exposure").value = state.exposure;
  byId("exposure-value").textContent = `${state.exposure > 0 ? "+" : ""}${state.exposure} EV`;
  byId("legend").hidden = state.mode === "picture";
  if (state.mode !== "picture") {
    byId("legend-low").textContent = errorMaps[state.mode].low;
    byId("legend-high").textContent = errorMaps[state.mode].high;
  }
  showStatus();
  drawView();
  drawCrops();
  showValues();
}

function selectMethod(index) {
  if (index < 0 || index >= labels.length || index === state.method) return;
  state.before = state.method;
  state.method = index;
  redraw();
}

let wantedFrame = 0;

async function selectFrame(index) {
  if (index < 0 || index >= report.pictures.length) return;
  wantedFrame = index;
  const loaded = await loadPictures(index);
  if (wantedFrame !== index) return;  // another was chosen meanwhile
  const before = currentPicture();
  state.picture = index;
  halfs = loaded;
  const { width, height } = currentPicture();
  if (state.view.scale === 0 || before.width !== width || before.height !== height) {
    fitView();
    resetRegion();
  }
  redraw();
  fillFrames();
  document.body.dataset.ready = String(index);
}

function setMode(mode) {
  state.mode = mode;
  redraw();
}

function setExposure(value) {
  state.exposure = Math.min(Math.max(value, -10), 10);
  forgetPainted();
  redraw();
}

const actions = {
  ArrowLeft: () => selectMethod((state.method + labels.length - 1) % labels.length),
  ArrowRight: () => selectMethod((state.method + 1) % labels.length),
  ArrowUp: () => selectFrame(wantedFrame - 1),
  ArrowDown: () => selectFrame(wantedFrame + 1),
  " ": () => selectMethod(state.before),
  0: () => selectMethod(referenceIndex),
  e: () => setMode(modes[(modes.indexOf(state.mode) + 1) % modes.length]),
  "[": () => setExposure(state.exposure - 0.5),
  "]": () => setExposure(state.exposure + 0.5),
  "+": () => zoomTo(state.view.scale * 2),
  "=": () => zoomTo(state.view.scale * 2),
  "-": () => zoomTo(state.view.scale / 2),
  f: fitView,
};
for (let i = 1; i <= 9; ++i) actions[i] = () => selectMethod(i - 1);

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in actions)) return;
  // What has a use for keys of its own keeps them; outside the pictures, arrows and the space bar scroll.
  if (event.target.closest("input, select, textarea, summary, a, button:not([role=tab])")) return;
  const onScreen = byId("canvas-frame").getBoundingClientRect();
  if (onScreen.bottom < 0 && (event.key.startsWith("Arrow") || event.key === " ")) return;
  event.preventDefault();
  if (event.type === "keydown") actions[event.key]();
}

function installSettings() {
  for (const button of document.querySelectorAll("[data-mode]")) button.addEventListener("click", () => setMode(button.dataset.mode));
  byId("exposure").addEventListener("input", (event) => setExposure(Number(event.target.value)));
  byId("exposure-reset").addEventListener("click", () => setExposure(0));
  byId("tone").addEventListener("change", (event) => {
    state.tone = event.target.value;
    setExposure(state.exposure);
  });
  const bar = byId("legend-bar").getContext("2d");
  for (let x = 0; x < 160; ++x) {
    bar.fillStyle = `rgb(${falseColour(x / 159).map(Math.round).join(",")})`;
    bar.fillRect(x, 0, 1, 10);
  }
  const options = (id, values, texts, change) => {
    byId(id).replaceChildren(...values.map((value, i) => make("option", { value, text: texts[i] })));
    byId(id).addEventListener("change", change);
  };
  const titles = metricNames.map((metric) => scores.metrics[metric].title);
  options("baseline", methodNames.map((_, i) => i), methodNames, showPairs);
  options("cost-metric", metricNames, titles, drawCost);
  options("frame-metric", metricNames, titles, fillFrames);
  byId("baseline").value = methodNames.indexOf(scores.comparison.baseline);
  document.addEventListener("keydown", onKey);
  document.addEventListener("keyup", onKey);  // or the space bar would also press the tab that has the focus
}

function showPairs() {
  const baseline = Number(byId("baseline").value);
  fillPairs(scores, report.comparisons[baseline], "pair-table", "pair-note");
  if (report.sequences) fillPairs(report.sequences.evaluation, report.sequences.comparisons[baseline], "sequence-pair-table", "sequence-pair-note");
}

function start() {
  byId("subject").textContent = `${scores.data} · split ${scores.split} · ${scores.frame_count} frames · ${report.sequences ? `${report.sequences.evaluation.frame_count} sequences · ` : ""}${methodNames.length} methods`;
  document.title = `Denoisers compared: ${scores.data}`;
  byId("made-by").textContent = `Made by ld_eval ${report.version}. One file, nothing is loaded from elsewhere.`;
  installSettings();
  fillScores(scores, "score-table", "score-note");
  showPairs();
  fillCost();
  drawCost();
  fillFrames();
  fillFormulas();
  installSequences();
  makeTabs("frame-tabs", report.pictures.map((picture) => picture.frame), selectFrame);
  makeTabs("method-tabs", labels, selectMethod, (i) => (i === referenceIndex ? "0" : i < 9 ? String(i + 1) : ""));
  if (report.pictures.length === 0) {
    byId("pictures").hidden = true;
    document.body.dataset.ready = "none";
    return;
  }
  if (!("DecompressionStream" in window)) {
    showNotice("This browser cannot unpack the pictures; the tables below are complete. Chromium from 80, Firefox from 113 and Safari from 16.4 can.");
    return;
  }
  state.method = Math.min(2, referenceIndex);
  makeCrops();
  installViewer();
  selectFrame(0).catch((error) => showNotice(`The pictures of this file are damaged: ${error.message}`));
}

start();
