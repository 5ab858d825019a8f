// The region of every method, side by side.
"use strict";

const kCropWidth = 380;  // pixels of the canvas; shown smaller where the page is narrow

function makeCrops() {
  byId("crops").replaceChildren(...labels.map((label, m) => {
    const canvas = make("canvas", { role: "img", "aria-label": `Region of ${label}` });
    const caption = make("figcaption", { text: label }, [make("small")]);
    const figure = make("figure", {}, [canvas, caption]);
    figure.addEventListener("click", () => selectMethod(m));
    return figure;
  }));
}

function drawCrops() {
  const { region } = state;
  const scale = Math.max(kCropWidth / region.width, 0.01), error = state.mode === "picture" ? "smape" : state.mode;
  for (const [m, figure] of [...byId("crops").children].entries()) {
    figure.classList.toggle("chosen", m === state.method);
    if (halfs.length === 0) continue;
    const canvas = figure.firstChild, context = canvas.getContext("2d");
    canvas.width = kCropWidth;
    canvas.height = Math.max(Math.round(region.height * scale), 1);
    context.imageSmoothingEnabled = scale < 1;
    context.drawImage(paintedCanvas(m), region.x, region.y, region.width, region.height, 0, 0, canvas.width, canvas.height);
    const { title, digits } = scores.metrics[error];
    figure.querySelector("small").textContent = m === referenceIndex ? "" : `${title} here ${formatRegionError(regionError(error, m), digits)}`;
  }
}

const formatRegionError = (value, digits) => (Number.isFinite(value) ? formatScore(value, digits) : "none: not finite");
