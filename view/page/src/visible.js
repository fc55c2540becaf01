// Finds the spheres of a cloud that can be seen. In a body of a hundred thousand particles these are its surface; what lies
// behind need not be drawn, which saves some ten microseconds per sphere without a graphics card.

const SLICES = 4096; // of depth; the order within one is arbitrary
const ACROSS = 3; // cells along the radius of a middle-sized sphere, at most: finer cells find hardly more that is hidden
const TILE = 4; // cells along the side of a tile
const EDGE = 0.1; // pixels by which a driver may draw a disc too small or too large
const SMALLEST = 0.75; // pixels, radius of the smallest drawn point

/// Sorts indices by depth, in slices.
function frontToBack(depths, count, near, far) {
  const scale = (SLICES - 1) / Math.max(far - near, 1e-30);
  const starts = new Uint32Array(SLICES + 1);
  for (let i = 0; i < count; ++i) ++starts[Math.floor((depths[i] - near) * scale) + 1];
  for (let i = 0; i < SLICES; ++i) starts[i + 1] += starts[i];
  const order = new Uint32Array(count);
  for (let i = 0; i < count; ++i) order[starts[Math.floor((depths[i] - near) * scale)]++] = i;
  return order;
}

/// Indices of the spheres that may be visible, from front to back. `view`, `projection`: 4 x 4 matrices by columns, with a
/// perspective projection; `size`: factor on the radii; `width`, `height`: pixels; `clip`: normal and distance of a plane beyond
/// which nothing is drawn; `largest`: pixels, diameter of the largest point that the driver draws.
export function visible(positions, radii, size, { view, projection, width, height, clip, largest }) {
  const most = radii.length;
  const index = new Uint32Array(most);
  const xs = new Float32Array(most);
  const ys = new Float32Array(most);
  const depths = new Float32Array(most);
  const perDepth = 0.5 * size * height * projection[5]; // pixels per unit of radius, at depth 1
  let count = 0;
  let near = Infinity;
  let far = 0;
  for (let i = 0; i < most; ++i) {
    const x = positions[3 * i];
    const y = positions[3 * i + 1];
    const z = positions[3 * i + 2];
    if (clip[0] * x + clip[1] * y + clip[2] * z > clip[3]) continue;
    const depth = Math.fround(-(view[2] * x + view[6] * y + view[10] * z + view[14])); // rounded as it is stored
    if (!(depth > 0)) continue; // behind the eye
    const right = 0.5 * width * (1 + (projection[0] * (view[0] * x + view[4] * y + view[8] * z + view[12])) / depth);
    const down = 0.5 * height * (1 - (projection[5] * (view[1] * x + view[5] * y + view[9] * z + view[13])) / depth);
    const reach = Math.max((radii[i] * perDepth) / depth, SMALLEST);
    if (right < -reach || right > width + reach || down < -reach || down > height + reach) continue;
    index[count] = i;
    xs[count] = right;
    ys[count] = down;
    depths[count++] = depth;
    if (depth < near) near = depth;
    if (depth > far) far = depth;
  }
  if (!count) return index.subarray(0, 0);

  // A cell is covered by a disc that contains all its pixels; a tile is closed once all its cells are covered.
  const cell = Math.max(1, Math.floor((radii[index[count >> 1]] * perDepth) / (0.5 * (near + far)) / ACROSS));
  const margin = Math.SQRT1_2 * (cell - 1) + EDGE; // from the centre of a cell to the centres of its pixels
  const columns = Math.ceil(width / cell);
  const rows = Math.ceil(height / cell);
  const covered = new Uint8Array(columns * rows);
  const across = Math.ceil(columns / TILE);
  const open = new Uint8Array(across * Math.ceil(rows / TILE)); // number of cells of a tile that are not covered yet
  for (let row = 0; row < rows; ++row)
    for (let column = 0; column < columns; ++column) ++open[Math.floor(row / TILE) * across + Math.floor(column / TILE)];
  const behind = new Float32Array(open.length).fill(-Infinity); // depth of the last centre that covered part of the tile

  const hidden = (x, y, reach, front) => {
    const side = cell * TILE;
    const left = Math.floor(Math.max(0, x - reach) / side);
    const right = Math.floor(Math.min(width - 1, x + reach) / side);
    const bottom = Math.floor(Math.min(height - 1, y + reach) / side);
    for (let row = Math.floor(Math.max(0, y - reach) / side); row <= bottom; ++row)
      for (let tile = row * across + left, end = row * across + right; tile <= end; ++tile) if (open[tile] > 0 || behind[tile] > front) return false;
    return true;
  };
  const cover = (x, y, reach, depth) => {
    const bottom = Math.min(rows - 1, Math.floor((y + reach) / cell - 0.5));
    for (let row = Math.max(0, Math.ceil((y - reach) / cell - 0.5)); row <= bottom; ++row) {
      const half = Math.sqrt(Math.max(0, reach * reach - ((row + 0.5) * cell - y) ** 2));
      const right = Math.min(columns - 1, Math.floor((x + half) / cell - 0.5));
      for (let column = Math.max(0, Math.ceil((x - half) / cell - 0.5)); column <= right; ++column) {
        if (covered[row * columns + column]) continue;
        covered[row * columns + column] = 1;
        const tile = Math.floor(row / TILE) * across + Math.floor(column / TILE);
        --open[tile];
        behind[tile] = Math.max(behind[tile], depth);
      }
    }
  };

  const seen = new Uint32Array(count);
  let kept = 0;
  for (const i of frontToBack(depths, count, near, far)) {
    const x = xs[i];
    const y = ys[i];
    const depth = depths[i];
    const radius = radii[index[i]];
    const reach = Math.max((radius * perDepth) / depth, SMALLEST);
    if (hidden(x, y, reach + EDGE, depth - size * radius)) continue;
    seen[kept++] = index[i];
    // A driver may omit a point whose centre lies outside the picture, or draw a large one smaller.
    const drawn = Math.min(reach, 0.5 * largest) - margin;
    if (drawn > 0 && x >= 0 && x <= width && y >= 0 && y <= height) cover(x, y, drawn, depth);
  }
  return seen.slice(0, kept);
}
