// The picture of one run: camera, controls, particles of both phases, the mark of a selected particle.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Cloud, particleMaterial } from "./cloud.js";

THREE.ColorManagement.enabled = false; // colours are shown without conversion

const FAR_OFF = 1e9;

export class Stage {
  /// `moved` is called when the camera has been moved by hand.
  constructor(canvas, moved) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    const gl = this.renderer.getContext();
    this.largest = gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1]; // largest diameter of a point, pixels
    this.scene = new THREE.Scene();
    this.clouds = { solid: new Cloud(0), fluid: new Cloud(1) };
    for (const cloud of Object.values(this.clouds)) this.scene.add(cloud.points, ...cloud.arrows);
    this.mark = new THREE.Points(new THREE.BufferGeometry(), particleMaterial());
    this.mark.material.uniforms.ring.value = true;
    this.mark.material.uniforms.size.value = 1.6;
    this.mark.material.depthTest = false;
    this.mark.renderOrder = 100;
    this.mark.frustumCulled = false;
    this.mark.visible = false;
    this.scene.add(this.mark);
    this.box = new THREE.Box3Helper(new THREE.Box3(), 0x888888);
    this.box.visible = false;
    this.scene.add(this.box);
    this.flat = new THREE.OrthographicCamera(-1, 1, 1, -1, -FAR_OFF, FAR_OFF);
    this.deep = new THREE.PerspectiveCamera(35, 1, 0.01, 1000);
    this.deep.up.set(0, 0, 1);
    this.clip = new THREE.Vector4(0, 0, 0, 1);
    this.moved = moved;
    this.three = null;
    this.dirty = true;
  }

  get camera() {
    return this.three ? this.deep : this.flat;
  }

  /// Sets the controls: pan and zoom in 2D, and also orbit in 3D.
  setDimension(three) {
    if (this.three === three) return;
    this.three = three;
    this.controls?.dispose();
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.enableDamping = false;
    controls.enableRotate = three;
    controls.screenSpacePanning = true;
    controls.zoomToCursor = true;
    if (!three) {
      controls.mouseButtons = { LEFT: THREE.MOUSE.PAN, MIDDLE: THREE.MOUSE.DOLLY, RIGHT: THREE.MOUSE.PAN };
      controls.touches = { ONE: THREE.TOUCH.PAN, TWO: THREE.TOUCH.DOLLY_PAN };
    }
    controls.addEventListener("change", () => {
      this.dirty = true;
      if (!this.setting) this.moved(this.view());
    });
    this.controls = controls;
  }

  setFrame(phase, frame) {
    this.clouds[phase].setFrame(frame);
    if (frame.positions.length) this.setDimension(frame.three);
    this.box.visible = Boolean(this.three);
    if (this.box.visible) this.box.box.copy(this.bounds());
    this.dirty = true;
  }

  /// Corners of all particles.
  bounds() {
    const box = new THREE.Box3();
    for (const { frame, points } of Object.values(this.clouds))
      if (frame?.positions.length && points.visible) box.union(new THREE.Box3().setFromArray(frame.positions));
    return box;
  }

  /// Sets the camera so that all of `box` is visible.
  fit(box) {
    if (box.isEmpty() || this.three === null) return;
    const centre = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    if (this.three) {
      const distance = (0.62 * size.length()) / Math.sin(0.5 * THREE.MathUtils.degToRad(this.deep.fov)) / Math.min(1, this.deep.aspect);
      this.setView({ at: centre.toArray(), eye: centre.clone().add(new THREE.Vector3(0.5, -0.8, 0.4).normalize().multiplyScalar(distance)).toArray() });
    } else {
      const wide = Math.max(size.x / Math.max(this.aspect, 1e-6), size.y) || 1;
      this.setView({ at: centre.toArray(), height: 1.12 * wide });
    }
  }

  /// The camera in the scene's coordinates: {at, eye} in 3D, {at, height} in 2D.
  view() {
    if (!this.controls) return null;
    const at = this.controls.target.toArray();
    return this.three ? { at, eye: this.deep.position.toArray() } : { at, height: (this.flat.top - this.flat.bottom) / this.flat.zoom };
  }

  setView(view) {
    if (!this.controls || Boolean(view.eye) !== this.three) return;
    this.setting = true;
    this.controls.target.fromArray(view.at);
    if (this.three) {
      this.deep.position.fromArray(view.eye);
    } else {
      this.flat.position.set(view.at[0], view.at[1], 1);
      this.flat.zoom = (this.flat.top - this.flat.bottom) / view.height;
    }
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.setting = false;
    this.dirty = true;
  }

  /// Moves the camera by keys: fractions of the picture, and a zoom factor.
  move(right, up, closer) {
    const view = this.view();
    if (!view) return;
    if (this.three) {
      const arm = new THREE.Vector3().fromArray(view.eye).sub(new THREE.Vector3().fromArray(view.at));
      arm.applyAxisAngle(new THREE.Vector3(0, 0, 1), -2 * right);
      const side = new THREE.Vector3().crossVectors(arm, new THREE.Vector3(0, 0, 1)).normalize();
      const steep = Math.asin(THREE.MathUtils.clamp(arm.z / arm.length(), -1, 1)) - 2 * up; // the eye goes down as the scene turns up
      if (Math.abs(steep) < 1.55) arm.applyAxisAngle(side, -2 * up);
      arm.multiplyScalar(1 / closer);
      this.setView({ at: view.at, eye: arm.add(new THREE.Vector3().fromArray(view.at)).toArray() });
    } else {
      this.setView({ at: [view.at[0] + right * view.height, view.at[1] + up * view.height, view.at[2]], height: view.height / closer });
    }
    this.moved(this.view());
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.aspect = width / height;
    const view = this.view();
    [this.flat.left, this.flat.right, this.flat.top, this.flat.bottom] = [-this.aspect, this.aspect, 1, -1];
    this.deep.aspect = this.aspect;
    this.flat.updateProjectionMatrix();
    this.deep.updateProjectionMatrix();
    if (view) this.setView(view);
    this.dirty = true;
  }

  markParticle(phase, index, colour) {
    const frame = phase && this.clouds[phase].frame;
    const before = this.mark.visible;
    this.mark.visible = Boolean(frame && index < frame.radius.length);
    if (before || this.mark.visible) this.dirty = true;
    if (!this.mark.visible) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(frame.positions.slice(3 * index, 3 * index + 3), 3));
    geometry.setAttribute("radius", new THREE.BufferAttribute(frame.radius.slice(index, index + 1), 1));
    geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(1), 1));
    this.mark.geometry.dispose();
    this.mark.geometry = geometry;
    this.mark.material.uniforms.colour.value.set(...colour);
  }

  /// {phase, index} under a point of the canvas, CSS pixels from its corner.
  pick(x, y) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.camera.updateMatrixWorld();
    let best = null;
    for (const phase of ["fluid", "solid"]) {
      const found = this.clouds[phase].pick(this.camera, (2 * x) / width - 1, 1 - (2 * y) / height, width, height, this.clip);
      if (found && (!best || found.depth < best.depth - 1e-9)) best = { phase, ...found };
    }
    return best && { phase: best.phase, index: best.index };
  }

  render(background) {
    const size = this.renderer.getDrawingBufferSize(new THREE.Vector2());
    for (const cloud of Object.values(this.clouds)) cloud.setViewport(size.x, size.y);
    this.mark.material.uniforms.height.value = size.y;
    if (this.three) {
      const far = this.deep.position.distanceTo(this.controls.target);
      [this.deep.near, this.deep.far] = [far / 500, far * 100];
      this.deep.updateProjectionMatrix();
      this.deep.updateMatrixWorld();
      for (const cloud of Object.values(this.clouds)) if (cloud.frame?.positions.length && cloud.points.visible) cloud.arrange(this.deep, size.x, size.y, this.largest);
    }
    this.renderer.setClearColor(background);
    this.renderer.render(this.scene, this.camera);
    this.dirty = false;
  }

  dispose() {
    this.controls?.dispose();
    for (const cloud of Object.values(this.clouds)) cloud.dispose();
    this.renderer.dispose();
  }
}
