// Reads files outside the page's thread, so that the page stays responsive. Each request gets one answer.
import { Changed } from "./range_file.js";
import { Damaged, openFrames } from "./vtkhdf.js";
import { scalars } from "./fields.js";

const DECODED = 96 << 20; // bytes of decoded numbers that are kept for all runs together
const ATTEMPTS = 10; // a file that is being written may change under a read

const files = new Map(); // url -> Frames
const decoded = new Map(); // "url tag-free key" -> typed array, the most recently used last
let held = 0;

async function framesOf(url) {
  if (!files.has(url)) files.set(url, await openFrames(url));
  return files.get(url);
}

function forget(url) {
  files.get(url)?.close();
  files.delete(url);
}

function forgetNumbers(url) {
  for (const [key, numbers] of decoded)
    if (key.startsWith(`${url} `)) {
      held -= numbers.byteLength;
      decoded.delete(key);
    }
}

/// The numbers of a frame, from memory where possible: a written frame does not change, except after `reopen`.
function kept(frames, url, name, step) {
  const key = `${url} ${step} ${name}`;
  let numbers = decoded.get(key);
  if (numbers) decoded.delete(key);
  else {
    numbers = frames.rows(name, step);
    held += numbers.byteLength;
  }
  decoded.set(key, numbers);
  for (const [old, its] of decoded) {
    if (held <= DECODED || old === key) break;
    held -= its.byteLength;
    decoded.delete(old);
  }
  return numbers;
}

function lowest(points) {
  const low = [Infinity, Infinity, Infinity];
  for (let i = 0; i < points.length; ++i) low[i % 3] = Math.min(low[i % 3], points[i]);
  return low.map((x) => (Number.isFinite(x) ? x : 0));
}

/// Volume of particles where a solver does not give it: equal for all, from their number per volume of the box around them.
function evenVolume(points, three) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  let volume = 1;
  for (let d = 0; d < (three ? 3 : 2); ++d) volume *= Math.max(high[d] - low[d], 1e-9);
  return volume / Math.max(points.length / 3, 1);
}

function radii(points, volumes, three) {
  const even = volumes ? 0 : evenVolume(points, three);
  const radius = new Float32Array(points.length / 3);
  for (let i = 0; i < radius.length; ++i) {
    const volume = volumes ? volumes[i] : even;
    radius[i] = three ? Math.cbrt((3 * volume) / (4 * Math.PI)) : Math.sqrt(volume / Math.PI);
  }
  return radius;
}

const operations = {
  describe(frames) {
    const { steps, times, counts, fields, tag } = frames;
    return { steps, times, counts, fields, tag };
  },

  /// Positions relative to `origin` (float32 is too coarse far from zero), radii, and the drawn values.
  frame(frames, url, { step, origin, colour, arrows }) {
    const points = kept(frames, url, "VTKHDF/Points", step);
    const from = origin ?? lowest(points);
    const positions = new Float32Array(points.length);
    let three = false;
    for (let i = 0; i < points.length; ++i) {
      positions[i] = points[i] - from[i % 3];
      if (i % 3 === 2 && points[i] !== points[2]) three = true;
    }
    const field = (name) => frames.fields.find((f) => f.name === name);
    const volumes = field("volume") && kept(frames, url, "VTKHDF/PointData/volume", step);
    const result = { step, origin: from, three, positions, radius: radii(points, volumes, three), values: null, vectors: null };
    if (colour && field(colour.field))
      result.values = scalars(kept(frames, url, `VTKHDF/PointData/${colour.field}`, step), field(colour.field).components, colour.part);
    if (arrows && field(arrows)?.components === 3)
      result.vectors = Float32Array.from(kept(frames, url, `VTKHDF/PointData/${arrows}`, step));
    return result;
  },

  particle(frames, url, { step, index }) {
    return frames.particle(step, index);
  },
};

async function answer({ operation, url, ...rest }) {
  if (operation === "reopen") {
    // Opens the present state of the file, unless it is open already.
    if (files.get(url)?.tag !== `"${rest.tag}"`) forget(url);
    if (rest.replaced) forgetNumbers(url);
    operation = "describe";
  }
  for (let attempt = 1; ; ++attempt) {
    try {
      return operations[operation](await framesOf(url), url, rest);
    } catch (error) {
      forget(url);
      if (!(error instanceof Changed)) throw error;
      if (attempt === ATTEMPTS) throw new Error("the file changes faster than it can be read");
      await new Promise((done) => setTimeout(done, 20 * attempt));
    }
  }
}

// One request after the other: a file must not be closed while another request reads it.
let last = Promise.resolve();
self.onmessage = ({ data }) => {
  last = last.then(async () => {
    try {
      self.postMessage({ id: data.id, result: await answer(data) });
    } catch (error) {
      self.postMessage({ id: data.id, error: error.message, damaged: error instanceof Damaged });
    }
  });
};
