// The particles of one phase and their arrows, as objects of a scene.
import * as THREE from "three";
import { NO_VALUE, table } from "./colour.js";
import { arrowFragment, arrowVertex, particleFragment, particleVertex } from "./shaders.js";
import { visible } from "./visible.js";

const NAN = -3e38; // represents "no value": comparisons with NaN differ between drivers
const ARROWS_ALONG = 48; // largest number of arrows along the longest side

const tables = new Map();

function texture(map) {
  if (!tables.has(map)) {
    const made = new THREE.DataTexture(table(map), 256, 1);
    made.magFilter = made.minFilter = THREE.NearestFilter;
    made.needsUpdate = true;
    tables.set(map, made);
  }
  return tables.get(map);
}

export function particleMaterial() {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: particleVertex,
    fragmentShader: particleFragment,
    transparent: true,
    uniforms: {
      size: { value: 1 }, height: { value: 1 }, clip: { value: new THREE.Vector4(0, 0, 0, 1) },
      colours: { value: texture("viridis") }, range: { value: new THREE.Vector2(0, 1) }, logarithmic: { value: false },
      plain: { value: true }, colour: { value: new THREE.Vector3(0.5, 0.5, 0.5) }, noValue: { value: new THREE.Vector3(...NO_VALUE) },
      opacity: { value: 1 }, sphere: { value: false }, ring: { value: false },
    },
  });
}

function arrowMaterial(rim) {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: arrowVertex,
    fragmentShader: arrowFragment,
    side: THREE.DoubleSide,
    transparent: true, // drawn after the particles, which are transparent, too
    uniforms: {
      scale: { value: 1 }, viewport: { value: new THREE.Vector2(1, 1) }, width: { value: 1.6 }, rim: { value: rim },
      clip: { value: new THREE.Vector4(0, 0, 0, 1) }, colour: { value: new THREE.Vector3(0, 0, 0) },
    },
  });
}

/// Two triangle strips, shaft and head; z distinguishes them.
const ARROW = new Float32Array([
  0, -1, 0, 1, -1, 0, 1, 1, 0, 0, -1, 0, 1, 1, 0, 0, 1, 0, //
  0, -1, 1, 1, 0, 1, 0, 1, 1,
]);

export class Cloud {
  constructor(order) {
    this.material = particleMaterial();
    this.points = new THREE.Points(new THREE.BufferGeometry(), this.material);
    this.points.frustumCulled = false;
    this.points.renderOrder = order;
    // Drawn twice: a rim in the colour of the background, so that arrows stand out from any colour, then the arrow itself.
    this.arrows = [0.8, 0].map((rim, i) => {
      const mesh = new THREE.Mesh(new THREE.InstancedBufferGeometry(), arrowMaterial(rim));
      mesh.frustumCulled = false;
      mesh.renderOrder = 10 + 2 * order + i;
      mesh.visible = false;
      return mesh;
    });
    this.frame = null;
  }

  setFrame(frame) {
    this.frame = frame;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(frame.positions, 3));
    geometry.setAttribute("radius", new THREE.BufferAttribute(frame.radius, 1));
    const values = new Float32Array(frame.radius.length);
    if (frame.values) for (let i = 0; i < values.length; ++i) values[i] = Number.isFinite(frame.values[i]) ? frame.values[i] : NAN;
    geometry.setAttribute("value", new THREE.BufferAttribute(values, 1));
    this.points.geometry.dispose();
    this.points.geometry = geometry;
    this.material.uniforms.sphere.value = frame.three;
    this.material.transparent = !frame.three;
    for (const { material } of [this.points, ...this.arrows]) {
      material.depthTest = frame.three;
      material.depthWrite = frame.three;
    }
    this.layArrows();
  }

  /// In 3D: leaves out hidden particles.
  arrange(camera, width, height, largest) {
    const { positions, radius } = this.frame;
    const { size, clip } = this.material.uniforms;
    const seen = visible(positions, radius, size.value, {
      view: camera.matrixWorldInverse.elements, projection: camera.projectionMatrix.elements, width, height, clip: clip.value.toArray(), largest,
    });
    this.points.geometry.setIndex(new THREE.BufferAttribute(seen, 1));
  }

  /// Sets how particles are coloured: {map, low, high, log}, or null for one colour.
  setScale(scale, colour) {
    const u = this.material.uniforms;
    u.plain.value = scale === null;
    u.colour.value.set(...colour);
    if (scale === null) return;
    u.colours.value = texture(scale.map);
    u.range.value.set(scale.low, scale.high);
    u.logarithmic.value = scale.log;
  }

  setLook({ show, size, opacity }, clip, ink, ground) {
    this.points.visible = show;
    this.material.uniforms.size.value = size;
    this.material.uniforms.opacity.value = opacity;
    for (const { material } of [this.points, ...this.arrows]) material.uniforms.clip.value.copy(clip);
    for (const [i, colour] of [ground, ink].entries()) this.arrows[i].material.uniforms.colour.value.set(...colour);
  }

  setViewport(width, height) {
    this.material.uniforms.height.value = height;
    for (const { material } of this.arrows) {
      material.uniforms.viewport.value.set(width, height);
      material.uniforms.width.value = Math.max(1.4, height / 500);
    }
  }

  /// Chooses one particle per cell of a grid for an arrow, so that arrows do not overlap.
  layArrows() {
    const { vectors, positions } = this.frame;
    this.longest = 0;
    if (!vectors || !positions.length) {
      this.showArrows(false);
      return;
    }
    const box = new THREE.Box3().setFromArray(positions);
    const size = box.getSize(new THREE.Vector3());
    this.cell = Math.max(size.x, size.y, size.z, 1e-9) / ARROWS_ALONG;
    const taken = new Set();
    const starts = [];
    const kept = [];
    for (let i = 0; i < positions.length; i += 3) {
      const length = Math.hypot(vectors[i], vectors[i + 1], vectors[i + 2]);
      if (!Number.isFinite(length)) continue;
      const [a, b, c] = [0, 1, 2].map((d) => Math.floor((positions[i + d] - box.min.getComponent(d)) / this.cell));
      const place = a + 64 * (b + 64 * c);
      if (taken.has(place)) continue;
      taken.add(place);
      this.longest = Math.max(this.longest, length);
      for (let d = 0; d < 3; ++d) {
        starts.push(positions[i + d]);
        kept.push(vectors[i + d]);
      }
    }
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(ARROW, 3));
    geometry.setAttribute("start", new THREE.InstancedBufferAttribute(new Float32Array(starts), 3));
    geometry.setAttribute("vector", new THREE.InstancedBufferAttribute(new Float32Array(kept), 3));
    geometry.instanceCount = starts.length / 3;
    this.arrows[0].geometry.dispose();
    for (const mesh of this.arrows) mesh.geometry = geometry;
    this.showArrows(this.longest > 0);
  }

  showArrows(on) {
    for (const mesh of this.arrows) mesh.visible = on;
  }

  /// Sets the length of arrows: a vector of length `longest` is drawn `cells` cells long.
  setArrowScale(longest, cells) {
    for (const mesh of this.arrows) if (mesh.visible) mesh.material.uniforms.scale.value = (2.5 * cells * this.cell) / longest;
  }

  /// The particle whose picture contains the point (in normalised device coordinates) and is nearest to the eye: {index, depth}.
  pick(camera, x, y, width, height, clip) {
    if (!this.points.visible || !this.frame) return null;
    const { positions, radius, three } = this.frame;
    const cover = three ? 1 : 1.5; // in 2D, gaps between particles belong to the nearest one
    const matrix = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const point = new THREE.Vector4();
    const size = this.material.uniforms.size.value;
    let best = null;
    for (let i = 0; i < radius.length; ++i) {
      const [px, py, pz] = [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]];
      if (clip.x * px + clip.y * py + clip.z * pz > clip.w) continue;
      point.set(px, py, pz, 1).applyMatrix4(matrix);
      if (point.w <= 0) continue;
      const reach = Math.max((cover * radius[i] * size * camera.projectionMatrix.elements[5] * 0.5 * height) / point.w, 4);
      const off = Math.hypot((point.x / point.w - x) * 0.5 * width, (point.y / point.w - y) * 0.5 * height);
      if (off > reach) continue;
      const depth = point.z / point.w;
      // In 2D all particles have the same depth: the nearest centre counts.
      if (!best || depth < best.depth - 1e-9 || (Math.abs(depth - best.depth) <= 1e-9 && off < best.off)) best = { index: i, depth, off };
    }
    return best;
  }

  dispose() {
    for (const { geometry, material } of [this.points, ...this.arrows]) {
      geometry.dispose();
      material.dispose();
    }
  }
}
