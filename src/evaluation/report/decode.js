// Pictures come as half floats: planes R, G, B; each row holds differences of the values' bits; the high bytes
// of all stand before the low ones; zlib; base64.
"use strict";

const kHalfCount = 65536;

/** The value of every half float. */
const halfValues = (() => {
  const values = new Float32Array(kHalfCount);
  for (let bits = 0; bits < kHalfCount; ++bits) {
    const exponent = (bits >> 10) & 31, fraction = bits & 1023, sign = bits & 0x8000 ? -1 : 1;
    if (exponent === 31) values[bits] = fraction ? NaN : sign * Infinity;
    else if (exponent === 0) values[bits] = sign * fraction * 2 ** -24;
    else values[bits] = sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
  }
  return values;
})();

const isFiniteHalf = (bits) => (bits & 0x7c00) !== 0x7c00;

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function unpack(text) {
  const packed = atob(text), bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; ++i) bytes[i] = packed.charCodeAt(i);
  return inflate(bytes);
}

/** What a screen shows, 8 bits, [3, height, width]; differences in each row. */
async function decodeShown(text, width, height) {
  const shown = await unpack(text), count = 3 * width * height;
  if (shown.length !== count) throw new Error(`a picture of ${shown.length} bytes; expected ${count}`);
  for (let start = 0; start < count; start += width)
    for (let i = start + 1; i < start + width; ++i) shown[i] += shown[i - 1];
  return shown;
}

/** The bits of the half floats, [3, height, width]. */
async function decodePicture(text, width, height) {
  const split = await unpack(text);
  const count = 3 * width * height;
  if (split.length !== 2 * count) throw new Error(`a picture of ${split.length} bytes; expected ${2 * count}`);
  const halfs = new Uint16Array(count);
  for (let start = 0; start < count; start += width) {
    let previous = 0;
    for (let i = start; i < start + width; ++i) {
      previous = (previous + ((split[i] << 8) | split[count + i])) & 0xffff;
      halfs[i] = previous;
    }
  }
  return halfs;
}
