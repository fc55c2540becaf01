// Colour maps: perceptually uniform ones, and a diverging one for fields of both signs. Each has seventeen colours with linear
// interpolation between them.

const MAPS = {
  viridis: "440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1fa088 28ae80 3fbc73 5ec962 84d44b addc30 d8e219 fde725",
  cividis: "00224e 002e6a 1a386f 32436d 434e6c 535a6d 61656f 6f7073 7d7c78 8c8878 9b9476 aba072 bcae6c cdbb63 dec958 f0d846 fee838",
  diverging: "3b4cc0 4e68d8 6282ea 779af7 8db0fe a3c2fe b9d0f9 ccd9ed dddcdc ecd3c5 f5c4ac f7b093 f4987a eb7d62 dd5f4b ca3b37 b40426",
};

export const MAP_NAMES = Object.keys(MAPS);
export const NO_VALUE = [0.55, 0.55, 0.55];

/// 256 RGBA colours of a map.
export function table(name) {
  const points = MAPS[name].split(" ").map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  const colours = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; ++i) {
    const x = (i / 255) * (points.length - 1);
    const left = Math.min(Math.floor(x), points.length - 2);
    for (let c = 0; c < 3; ++c) colours[4 * i + c] = points[left][c] + (x - left) * (points[left + 1][c] - points[left][c]);
    colours[4 * i + 3] = 255;
  }
  return colours;
}

/// Smallest and largest number of several arrays; NaN is ignored; null where there is no number.
export function extent(arrays) {
  let low = Infinity;
  let high = -Infinity;
  for (const values of arrays)
    for (const value of values)
      if (Number.isFinite(value)) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
  return low <= high ? [low, high] : null;
}

/// Whether both signs matter, as opposed to a little noise around zero.
export function signed([low, high]) {
  return Math.min(-low, high) > 0.05 * Math.max(-low, high);
}

/// Range and map with which a field is drawn. `choice`: {map, range, log}; map may be "auto"; range null: that of the frame.
export function scaleOf(choice, found) {
  const frame = found ?? [0, 1];
  const diverging = !choice.log && (choice.map === "diverging" || (choice.map === "auto" && signed(choice.range ?? frame)));
  const map = choice.map === "auto" ? (diverging ? "diverging" : "viridis") : choice.map;
  let [low, high] = choice.range ?? frame;
  if (!choice.range && diverging) {
    const most = Math.max(-low, high);
    [low, high] = [-most, most];
  }
  if (choice.log) {
    high = high > 0 ? high : 1;
    low = choice.range && low > 0 ? low : Math.max(low, 1e-4 * high);
  }
  if (!(high > low)) {
    // A constant field: its value in the middle of the bar.
    const half = Math.abs(low) * 1e-3 || 1;
    [low, high] = choice.log ? [low / 10, low * 10] : [low - half, high + half];
  }
  return { map, low, high, log: Boolean(choice.log) };
}
