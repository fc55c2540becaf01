// The state of the view, and its form as the fragment of a link. Links are checked: they may come from anywhere.
import { MAP_NAMES } from "./colour.js";
import { PHASES } from "./run.js";

export function initial() {
  const phase = { show: true, field: null, part: "", map: "auto", range: null, log: false, size: 1, opacity: 1 };
  return {
    runs: [], time: null, follow: false, camera: null,
    phases: Object.fromEntries(PHASES.map((name) => [name, { ...phase }])),
    arrows: { phase: "", field: "", length: 1 },
    clip: { axis: "", at: 0.5, flip: false },
    gauges: null,
  };
}

export function toLink(state) {
  return "#" + encodeURIComponent(JSON.stringify(state, (_, value) => (typeof value === "number" ? Number(value.toPrecision(7)) : value)));
}

const number = (value, low, high, otherwise) => (Number.isFinite(value) ? Math.min(high, Math.max(low, value)) : otherwise);
const text = (value, otherwise) => (typeof value === "string" && value.length < 300 ? value : otherwise);
const one = (value, allowed, otherwise) => (allowed.includes(value) ? value : otherwise);
const point = (value) => Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);
const texts = (value, most) => (Array.isArray(value) ? value.filter((name) => text(name, "")).slice(0, most) : null);

export function fromLink(fragment) {
  const state = initial();
  let given;
  try {
    given = JSON.parse(decodeURIComponent(fragment.slice(1)));
  } catch {
    return state;
  }
  if (typeof given !== "object" || given === null) return state;
  state.runs = texts(given.runs, 4) ?? [];
  state.time = Number.isFinite(given.time) ? given.time : null;
  state.follow = given.follow === true;
  state.gauges = texts(given.gauges, 60);
  const { camera } = given;
  if (point(camera?.at) && (point(camera.eye) || camera.height > 0))
    state.camera = camera.eye ? { at: camera.at, eye: camera.eye } : { at: camera.at, height: camera.height };
  for (const name of PHASES) {
    const phase = given.phases?.[name];
    if (typeof phase !== "object" || phase === null) continue;
    const here = state.phases[name];
    here.show = phase.show !== false;
    here.field = text(phase.field, null);
    here.part = text(phase.part, "");
    here.map = one(phase.map, ["auto", ...MAP_NAMES], "auto");
    here.log = phase.log === true;
    here.size = number(phase.size, 0.1, 3, 1);
    here.opacity = number(phase.opacity, 0.05, 1, 1);
    if (Array.isArray(phase.range) && phase.range.length === 2 && phase.range.every(Number.isFinite)) here.range = phase.range;
  }
  state.arrows.phase = one(given.arrows?.phase, ["", ...PHASES], "");
  state.arrows.field = text(given.arrows?.field, "");
  state.arrows.length = number(given.arrows?.length, 0.2, 4, 1);
  state.clip.axis = one(given.clip?.axis, ["", "x", "y", "z"], "");
  state.clip.at = number(given.clip?.at, 0, 1, 0.5);
  state.clip.flip = given.clip?.flip === true;
  return state;
}
