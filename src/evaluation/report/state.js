// What is shown, and the pictures behind it.
"use strict";

const report = JSON.parse(byId("data").textContent);
const scores = report.evaluation;
const labels = report.labels;                  // of the pictures: the methods, then "reference"
const referenceIndex = labels.length - 1;
const metricNames = Object.keys(scores.metrics);

const state = {
  picture: 0,                                  // index of report.pictures
  method: 0,                                   // index of labels
  before: referenceIndex,                      // the method shown before: what the space bar flips to
  mode: "picture",
  exposure: 0,
  tone: "log",
  view: { scale: 0, x: 0, y: 0 },              // screen pixels a pixel; the pixel in the middle; scale 0: fit
  region: { x: 0, y: 0, width: 1, height: 1 },
};

const currentPicture = () => report.pictures[state.picture];

/** Decoded pictures of the frame that is shown: half floats of each label. Frames load when first chosen. */
let halfs = [];
const decodedFrames = new Map();

function loadPictures(index) {
  if (!decodedFrames.has(index)) {
    const { width, height } = report.pictures[index];
    const decode = (_, m) => decodePicture(byId(`picture-${index}-${m}`).textContent, width, height);
    decodedFrames.set(index, Promise.all(labels.map(decode)));
  }
  return decodedFrames.get(index);
}

/** Pictures as canvases, painted when first shown; changed settings start anew. */
const painted = new Map();
let shades = shadeTable(toneMaps.log, 0);

function forgetPainted() {
  painted.clear();
  shades = shadeTable(toneMaps[state.tone], state.exposure);
}

const errorCache = new Map();
function errorsOf(metric, method) {
  const key = `${metric} ${state.picture} ${method}`;
  if (!errorCache.has(key))
    errorCache.set(key, errorOfPixels(metric, scores[`${metric}_epsilon`], halfs[method], halfs[referenceIndex]));
  return errorCache.get(key);
}

function paintedCanvas(method) {
  const key = `${state.picture} ${method} ${state.mode}`;
  if (!painted.has(key)) {
    const { width, height } = currentPicture();
    const canvas = make("canvas", { width, height }), context = canvas.getContext("2d");
    const image = context.createImageData(width, height);
    if (state.mode === "picture") paintPicture(halfs[method], shades, image.data);
    else paintErrors(state.mode, errorsOf(state.mode, method), image.data);
    context.putImageData(image, 0, 0);
    painted.set(key, canvas);
  }
  return painted.get(key);
}

/** Mean error over the region, on the half floats of this page. */
function regionError(metric, method) {
  const errors = errorsOf(metric, method), { width } = currentPicture(), { region } = state;
  let sum = 0;
  for (let y = region.y; y < region.y + region.height; ++y)
    for (let x = region.x; x < region.x + region.width; ++x) sum += errors[y * width + x];
  return sum / (region.width * region.height);
}
