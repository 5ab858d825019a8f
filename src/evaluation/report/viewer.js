// The large picture: zoom, pan, the region and the values under the cursor. All methods and frames share one
// view, so that what is compared stays in place.
"use strict";

const viewCanvas = byId("view");
const kLargestScale = 128, kSmallestScale = 0.05;

/** The scale at which the whole picture is seen: whole numbers where it is enlarged. */
function fitScale() {
  const { width, height } = currentPicture();
  const scale = Math.min(viewCanvas.clientWidth / width, viewCanvas.clientHeight / height);
  return scale >= 1 ? Math.floor(scale) : scale;
}

function fitView() {
  const { width, height } = currentPicture();
  state.view = { scale: fitScale(), x: width / 2, y: height / 2 };
  drawView();
}

/** Zooms so that what lies under the place (in screen pixels of the canvas) stays there. */
function zoomTo(scale, place = { x: viewCanvas.clientWidth / 2, y: viewCanvas.clientHeight / 2 }) {
  const before = pictureAt(place), { view } = state;
  view.scale = Math.min(Math.max(scale, kSmallestScale), kLargestScale);
  const after = pictureAt(place);
  view.x += before.x - after.x;
  view.y += before.y - after.y;
  drawView();
}

/** From screen pixels of the canvas to (fractional) pixels of the picture. */
function pictureAt({ x, y }) {
  const { view } = state;
  return { x: view.x + (x - viewCanvas.clientWidth / 2) / view.scale, y: view.y + (y - viewCanvas.clientHeight / 2) / view.scale };
}

function drawView() {
  const ratio = window.devicePixelRatio || 1, { view, region } = state;
  const width = Math.round(viewCanvas.clientWidth * ratio), height = Math.round(viewCanvas.clientHeight * ratio);
  if (viewCanvas.width !== width || viewCanvas.height !== height) {
    viewCanvas.width = width;
    viewCanvas.height = height;
  }
  const context = viewCanvas.getContext("2d"), picture = currentPicture(), scale = view.scale * ratio;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, width, height);
  if (halfs.length === 0) return;
  const left = Math.round(width / 2 - view.x * scale), top = Math.round(height / 2 - view.y * scale);
  context.imageSmoothingEnabled = scale < 1;
  context.imageSmoothingQuality = "high";
  context.drawImage(paintedCanvas(state.method), left, top, picture.width * scale, picture.height * scale);

  const frame = [left + region.x * scale - 0.5, top + region.y * scale - 0.5, region.width * scale + 1, region.height * scale + 1];
  context.lineWidth = 1;
  for (const [colour, dash] of [["#000c", []], ["#fffc", [5, 5]]]) {
    context.strokeStyle = colour;
    context.setLineDash(dash);
    context.strokeRect(...frame);
  }
  byId("zoom-value").textContent = `${Number(view.scale.toPrecision(3))}×`;
}

/** The pixel under the cursor, kept so that its values follow a change of frame. */
let cursor = null;

function showValues() {
  const { width, height } = currentPicture(), plane = width * height;
  const inside = cursor !== null && cursor.x >= 0 && cursor.y >= 0 && cursor.x < width && cursor.y < height;
  byId("pixel-place").textContent = inside ? `x ${cursor.x}, y ${cursor.y}` : "";
  const rows = labels.map((label, m) => {
    const cells = [0, 1, 2].map((c) =>
      make("td", { text: inside && halfs.length ? formatRadiance(halfValues[halfs[m][c * plane + cursor.y * width + cursor.x]]) : "–" }));
    const row = make("tr", m === state.method ? { class: "current" } : {}, [make("th", { scope: "row", text: label, title: label }), ...cells]);
    return row;
  });
  byId("pixel-values").tBodies[0].replaceChildren(...rows);
}

/** Cut to the picture, whole pixels, at least one. */
function setRegion({ x, y, width, height }) {
  const picture = currentPicture(), whole = (value) => Math.floor(value) || 0;
  const left = Math.min(Math.max(whole(x), 0), picture.width - 1), top = Math.min(Math.max(whole(y), 0), picture.height - 1);
  state.region = {
    x: left,
    y: top,
    width: Math.min(Math.max(whole(width), 1), picture.width - left),
    height: Math.min(Math.max(whole(height), 1), picture.height - top),
  };
  for (const [name, value] of Object.entries(state.region)) byId(`region-${name}`).value = value;
  drawView();
  drawCrops();
}

/** The middle of the picture, a third as wide. */
function resetRegion() {
  const { width, height } = currentPicture(), size = Math.max(Math.round(Math.min(width, height) / 3), 1);
  setRegion({ x: (width - size) / 2, y: (height - size) / 2, width: size, height: size });
}

function installViewer() {
  const place = (event) => {
    const box = viewCanvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  let drag = null;
  viewCanvas.addEventListener("pointerdown", (event) => {
    viewCanvas.setPointerCapture(event.pointerId);
    drag = { from: place(event), pixel: pictureAt(place(event)), choose: event.shiftKey };
  });
  viewCanvas.addEventListener("pointermove", (event) => {
    const here = pictureAt(place(event));
    cursor = { x: Math.floor(here.x), y: Math.floor(here.y) };
    if (drag !== null && drag.choose) {
      const x = Math.min(drag.pixel.x, here.x), y = Math.min(drag.pixel.y, here.y);
      const right = Math.max(drag.pixel.x, here.x), bottom = Math.max(drag.pixel.y, here.y);
      setRegion({ x, y, width: Math.ceil(right) - Math.floor(x), height: Math.ceil(bottom) - Math.floor(y) });
    } else if (drag !== null) {
      state.view.x += drag.pixel.x - here.x;
      state.view.y += drag.pixel.y - here.y;
      drawView();
    }
    showValues();
  });
  for (const name of ["pointerup", "pointercancel"]) viewCanvas.addEventListener(name, () => { drag = null; });
  viewCanvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomTo(state.view.scale * 2 ** (-event.deltaY / 240), place(event));
  }, { passive: false });
  viewCanvas.addEventListener("dblclick", fitView);

  byId("zoom-in").addEventListener("click", () => zoomTo(state.view.scale * 2));
  byId("zoom-out").addEventListener("click", () => zoomTo(state.view.scale / 2));
  byId("zoom-one").addEventListener("click", () => zoomTo(1));
  byId("zoom-fit").addEventListener("click", fitView);
  const sides = ["x", "y", "width", "height"];
  for (const side of sides)
    byId(`region-${side}`).addEventListener("change", () =>
      setRegion(Object.fromEntries(sides.map((name) => [name, Number(byId(`region-${name}`).value)]))));
  new ResizeObserver(drawView).observe(viewCanvas);
}
