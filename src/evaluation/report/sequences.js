// Sequences as loops, all methods side by side, and one line of pixels over time, where flicker shows as stripes.
"use strict";

const kDifferenceGain = 4, kSliceHeight = 120;  // pixels of the slice's canvas, or one a frame

const clip = { index: 0, frame: 0, line: 0, mode: "picture", shown: [], painted: new Map(), timer: null };
const clipInfo = () => report.sequences.clips[clip.index];

/** What a mode makes of a value of a method, of the reference and of the frame before; 8 bits. */
const clipModes = {
  picture: (d) => d,
  difference: (d, r) => 128 + kDifferenceGain * (d - r),
  change: (d, r, before) => 128 + kDifferenceGain * (d - before),
};

/** A frame of a method as a canvas; painted when first shown. */
function paintedClip(method, frame) {
  const key = `${method} ${frame}`;
  if (!clip.painted.has(key)) {
    const { width, height } = clipInfo(), plane = width * height, value = clipModes[clip.mode];
    const canvas = make("canvas", { width, height }), context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    const shown = clip.shown[frame][method], reference = clip.shown[frame][referenceIndex], before = clip.shown[Math.max(frame - 1, 0)][method];
    for (let i = 0; i < plane; ++i) {
      for (let c = 0; c < 3; ++c) image.data[4 * i + c] = value(shown[c * plane + i], reference[c * plane + i], before[c * plane + i]);
      image.data[4 * i + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    clip.painted.set(key, canvas);
  }
  return clip.painted.get(key);
}

function drawClip() {
  if (clip.shown.length === 0) return;
  const { width, height } = clipInfo(), scale = Math.max(1, Math.floor(kCropWidth / width));
  for (const [m, figure] of [...byId("clips").children].entries()) {
    const canvas = figure.querySelector("canvas"), context = canvas.getContext("2d");
    if (canvas.width !== width * scale || canvas.height !== height * scale) [canvas.width, canvas.height] = [width * scale, height * scale];
    context.imageSmoothingEnabled = false;
    context.drawImage(paintedClip(m, clip.frame), 0, 0, width * scale, height * scale);
    context.fillStyle = "#fff8";
    context.fillRect(0, (clip.line + 0.5) * scale, width * scale, 1);
  }
  byId("clip-frame").value = clip.frame;
  byId("clip-name").textContent = clipInfo().frames[clip.frame];
}

/** The line of every frame, the first one on top. */
function drawSlices() {
  if (clip.shown.length === 0) return;
  const { width, frames } = clipInfo(), rows = Math.max(1, Math.floor(kSliceHeight / frames.length));
  for (const [m, figure] of [...byId("clips").children].entries()) {
    const canvas = figure.querySelectorAll("canvas")[1], context = canvas.getContext("2d");
    [canvas.width, canvas.height] = [width, rows * frames.length];
    context.imageSmoothingEnabled = false;
    for (let f = 0; f < frames.length; ++f) context.drawImage(paintedClip(m, f), 0, clip.line, width, 1, 0, f * rows, width, rows);
  }
  byId("clip-line").value = clip.line;
}

function setClipLine(line) {
  clip.line = Math.min(Math.max(Math.floor(line) || 0, 0), clipInfo().height - 1);
  drawClip();
  drawSlices();
}

function setClipFrame(frame) {
  clip.frame = ((Math.floor(frame) || 0) + clipInfo().frames.length) % clipInfo().frames.length;
  drawClip();
}

function setClipMode(mode) {
  clip.mode = mode;
  clip.painted.clear();
  for (const button of document.querySelectorAll("[data-clip-mode]")) button.setAttribute("aria-pressed", button.dataset.clipMode === mode);
  drawClip();
  drawSlices();
}

function playClip(playing) {
  clearInterval(clip.timer);
  clip.timer = playing ? setInterval(() => setClipFrame(clip.frame + 1), 1000 / Number(byId("clip-rate").value)) : null;
  byId("clip-play").textContent = playing ? "Pause" : "Play";
}

async function selectClip(index) {
  clip.index = index;
  markTab("clip-tabs", index);
  const { width, height, frames } = clipInfo();
  const shown = await Promise.all(frames.map((_, f) => Promise.all(labels.map((_, m) => decodeShown(byId(`clip-${index}-${f}-${m}`).textContent, width, height)))));
  if (clip.index !== index) return;  // another was chosen meanwhile
  Object.assign(clip, { shown, frame: 0, line: Math.floor(height / 2) });
  byId("clip-frame").max = frames.length - 1;
  byId("clip-line").max = height - 1;
  setClipMode(clip.mode);
  byId("sequences").dataset.ready = String(index);
}

function installClips() {
  byId("clips").replaceChildren(...labels.map((label) => {
    const picture = make("canvas", { role: "img", "aria-label": `Sequence of ${label}` });
    const slice = make("canvas", { role: "img", class: "slice", "aria-label": `One line of ${label} over time` });
    picture.addEventListener("click", (event) => setClipLine((event.offsetY / picture.clientHeight) * clipInfo().height));
    return make("figure", {}, [picture, slice, make("figcaption", { text: label })]);
  }));
  makeTabs("clip-tabs", report.sequences.clips.map(({ frames }) => `${frames[0]} + ${frames.length - 1}`), selectClip);
  for (const button of document.querySelectorAll("[data-clip-mode]")) button.addEventListener("click", () => setClipMode(button.dataset.clipMode));
  byId("clip-play").addEventListener("click", () => playClip(clip.timer === null));
  byId("clip-rate").addEventListener("change", () => { if (clip.timer !== null) playClip(true); });
  byId("clip-frame").addEventListener("input", (event) => { playClip(false); setClipFrame(Number(event.target.value)); });
  byId("clip-line").addEventListener("input", (event) => setClipLine(Number(event.target.value)));
  selectClip(0).catch((error) => showNotice(`The sequences of this file are damaged: ${error.message}`));
}

function installSequences() {
  const { sequences } = report;
  for (const element of document.querySelectorAll(".of-sequences")) element.hidden = !sequences;
  if (!sequences) return;
  fillScores(sequences.evaluation, "sequence-table", "sequence-note");
  // SVG that the program wrote, names escaped in it; as pictures they cannot run anything.
  byId("curves").replaceChildren(...sequences.curves.map(({ title, svg }) =>
    make("img", { class: "curve", alt: title, src: `data:image/svg+xml,${encodeURIComponent(svg)}` })));
  byId("player").hidden = sequences.clips.length === 0 || !("DecompressionStream" in window);
  if (!byId("player").hidden) installClips();
}
