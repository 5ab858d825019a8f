// From radiance and errors to what a screen shows.
"use strict";

const srgb = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const toneMaps = {
  log: (x) => (x > 0 ? Math.min(srgb(Math.log1p(x)), 1) : 0),
  srgb: (x) => (x > 0 ? Math.min(srgb(Math.min(x, 1)), 1) : 0),
};

/** The shade of every half float: a picture is then one look-up for each value. */
function shadeTable(toneMap, exposure) {
  const gain = 2 ** exposure, shades = new Uint8ClampedArray(kHalfCount);
  for (let bits = 0; bits < 0x7c00; ++bits) shades[bits] = 255 * toneMap(halfValues[bits] * gain);
  return shades;
}

/** The picture as pixels of a canvas; what is not finite shows as magenta. */
function paintPicture(halfs, shades, pixels) {
  const plane = halfs.length / 3;
  for (let i = 0; i < plane; ++i) {
    const r = halfs[i], g = halfs[plane + i], b = halfs[2 * plane + i], out = 4 * i;
    const finite = isFiniteHalf(r) && isFiniteHalf(g) && isFiniteHalf(b);
    pixels[out] = finite ? shades[r] : 255;
    pixels[out + 1] = finite ? shades[g] : 0;
    pixels[out + 2] = finite ? shades[b] : 255;
    pixels[out + 3] = 255;
  }
}

/** What a pixel adds to each metric, and the range that its map shows, on a logarithmic scale. */
const errorMaps = {
  relmse: { term: (d, r, epsilon) => ((d - r) * (d - r)) / (r * r + epsilon), low: 1e-4, high: 10 },
  smape: { term: (d, r, epsilon) => Math.abs(d - r) / (Math.abs(d) + Math.abs(r) + epsilon), low: 1e-3, high: 1 },
};

/** Mean over the channels for each pixel; NaN where the picture is not finite. */
function errorOfPixels(name, epsilon, denoised, reference) {
  const { term } = errorMaps[name], plane = denoised.length / 3, errors = new Float32Array(plane);
  for (let i = 0; i < plane; ++i) {
    let sum = 0;
    for (let c = 0; c < 3; ++c) sum += term(halfValues[denoised[c * plane + i]], halfValues[reference[c * plane + i]], epsilon);
    errors[i] = Number.isFinite(sum) ? sum / 3 : NaN;
  }
  return errors;
}

// Nine stops of matplotlib's "inferno" (CC0): brighter is always more.
const stops = [[0, 0, 4], [31, 12, 72], [85, 15, 109], [136, 34, 106], [186, 54, 85], [227, 89, 51], [249, 140, 10], [249, 201, 50], [252, 255, 164]];

/** Colour of t in [0, 1]. */
function falseColour(t) {
  const place = Math.min(Math.max(t, 0), 1) * (stops.length - 1), i = Math.min(Math.floor(place), stops.length - 2);
  return stops[i].map((low, c) => low + (stops[i + 1][c] - low) * (place - i));
}

const falseColours = Array.from({ length: 256 }, (_, i) => falseColour(i / 255));

/** What is not finite shows as green, which the scale does not have. */
function paintErrors(name, errors, pixels) {
  const { low, high } = errorMaps[name], scale = 255 / Math.log(high / low);
  for (let i = 0; i < errors.length; ++i) {
    const level = errors[i] > low ? Math.min(Math.round(scale * Math.log(errors[i] / low)), 255) : 0;
    const colour = Number.isNaN(errors[i]) ? [0, 255, 0] : falseColours[level];
    pixels.set(colour, 4 * i);
    pixels[4 * i + 3] = 255;
  }
}
