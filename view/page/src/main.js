// The page: which runs are shown, at which time, how. All of it follows from `state`, which a link contains.
import * as THREE from "three";
import { extent, scaleOf } from "./colour.js";
import { Controls } from "./controls.js";
import { byId, colourOf, element, numbersOf, toast } from "./dom.js";
import { shown, withUnit } from "./fields.js";
import { Gauges } from "./gauges.js";
import { listenToKeys, keyList } from "./keys.js";
import { Panel } from "./panel.js";
import { showParticle } from "./particle.js";
import { report } from "./report.js";
import { PHASES, Run } from "./run.js";
import { saveGif, savePicture, saveVideo } from "./saving.js";
import { ask } from "./server.js";
import { followTheme, otherTheme } from "./theme.js";
import { fromLink, toLink } from "./view_state.js";

const SIDE_BY_SIDE = 4;
const LOOK_EVERY = 1000; // ms between status requests of a run in progress
const LOOK_AT_ENDED = 5000;

const state = fromLink(location.hash);
let runs = [];
let panels = [];
let times = [];
let picked = null; // {panel, phase, index}
let playing = false;
let saving = null;

const page = {
  origin: null, // float32 positions are relative to it
  moved(view, panel) {
    keepCamera(view);
    for (const other of panels) if (other !== panel) other.stage?.setView(view);
  },
  picked(panel, hit) {
    pick(hit && { panel, ...hit });
  },
  fitted: () => state.camera === null,
  fit,
};

// ---- time

let index = 0;

function setTimes() {
  const before = times.length;
  const atEnd = index >= before - 1;
  times = [...new Set(panels.flatMap(({ run }) => run.times()))].sort((a, b) => a - b);
  // Times of several runs may differ by rounding.
  times = times.filter((t, i) => i === 0 || t - times[i - 1] > 1e-9 * Math.max(Math.abs(t), 1e-12));
  byId("time").max = Math.max(0, times.length - 1);
  if (times.length === 0) return;
  if (before === 0 && state.time === null && !state.follow) index = panels.some(({ run }) => run.running) ? times.length - 1 : 0;
  else if (state.follow && atEnd) index = times.length - 1;
  else index = nearest(state.time ?? times[0]);
  if (state.follow) index = times.length - 1;
  state.time = times[index];
}

function nearest(time) {
  let best = 0;
  for (let i = 1; i < times.length; ++i) if (Math.abs(times[i] - time) < Math.abs(times[best] - time)) best = i;
  return best;
}

function go(to) {
  if (!times.length) return Promise.resolve();
  index = Math.min(Math.max(0, to), times.length - 1);
  if (index < times.length - 1 && state.follow) {
    state.follow = false;
    byId("follow").checked = false;
  }
  state.time = times[index];
  return draw();
}

function play(on = !playing) {
  if (on === playing) return;
  playing = on;
  byId("play").ariaLabel = on ? "Pause" : "Play";
  byId("play-shape").setAttribute("d", on ? "M4 3h3v10H4zM9 3h3v10H9z" : "M4 3l9 5-9 5z");
  if (on) run();
  async function run() {
    if (index >= times.length - 1) await go(0);
    while (playing) {
      const due = performance.now() + 1000 / Number(byId("speed").value);
      if (index >= times.length - 1) return play(false);
      await go(index + 1);
      await new Promise((done) => setTimeout(done, Math.max(0, due - performance.now())));
    }
  }
}

// ---- drawing

let drawing = null;
let again = false;

/// Shows the state; resolves when it is drawn. During a drawing only the newest request is kept.
function draw() {
  again = true;
  drawing ??= (async () => {
    try {
      while (again) {
        again = false;
        await drawOnce();
      }
    } finally {
      drawing = null;
    }
  })();
  return drawing;
}

async function drawOnce() {
  showTime();
  await Promise.all(panels.map((panel) => panel.load(state.time, state)));
  const scales = {};
  for (const phase of PHASES) {
    const frames = panels.map((panel) => panel.frames[phase]).filter((frame) => frame?.values);
    scales[phase] = scaleOf(state.phases[phase], extent(frames.map((frame) => frame.values)));
  }
  const longest = Math.max(0, ...panels.map((panel) => panel.stage?.clouds[state.arrows.phase]?.longest ?? 0));
  if (panels.every((panel) => panel.stage?.three === null || !panel.placed)) place();
  const clip = clipPlane();
  for (const panel of panels) panel.dress(state, scales, clip, longest);
  controls.setScales(scales);
  showPick();
  gauges.setTime(state.time);
  await paint();
  keepLink();
}

let painting = null;

/// Paints once per screen refresh, however often it is called.
function paint() {
  painting ??= new Promise((done) =>
    // A page in the background gets no animation frames, but callers that wait for the picture must continue.
    (document.hidden ? setTimeout : requestAnimationFrame)(() => {
      painting = null;
      for (const panel of panels) panel.paint();
      done();
    }));
  return painting;
}

function showTime() {
  byId("time").value = index;
  const text = times.length ? `t = ${shown(times[index], 5)} s (${index + 1} of ${times.length})` : "no frames";
  byId("time-text").textContent = text;
  byId("time").ariaValueText = text;
}

// ---- camera and clip plane

/// Corners of all particles in the pictures of one kind (3D or not), or in all pictures.
function allBounds(three = null) {
  const box = new THREE.Box3();
  for (const { stage } of panels) if (stage && (three === null || stage.three === three)) box.union(stage.bounds());
  return box;
}

function fit() {
  state.camera = null;
  for (const { stage } of panels) stage?.fit(allBounds(stage.three));
  paint();
  keepLink();
}

const shift = (point, sign) => point.map((x, d) => x + sign * (page.origin?.[d] ?? 0));

/// The camera of a link is stored in the coordinates of the files.
function keepCamera(view) {
  state.camera = view && { ...view, at: shift(view.at, 1), ...(view.eye && { eye: shift(view.eye, 1) }) };
  paint();
  keepLink();
}

/// Sets the camera once there are particles: as the link says, else so that all are visible.
function place() {
  const there = panels.filter((panel) => panel.stage && panel.stage.three !== null);
  if (!there.length) return;
  for (const panel of there) panel.placed = true;
  if (!state.camera) return fit();
  const view = { ...state.camera, at: shift(state.camera.at, -1), ...(state.camera.eye && { eye: shift(state.camera.eye, -1) }) };
  for (const panel of there) panel.stage.setView(view);
}

function clipPlane() {
  const { axis, at, flip } = state.clip;
  byId("clip-text").textContent = "";
  const box = allBounds();
  if (!axis || box.isEmpty()) return new THREE.Vector4(0, 0, 0, 1);
  const d = "xyz".indexOf(axis);
  const [low, high] = [box.min.getComponent(d), box.max.getComponent(d)];
  const place = low + at * (high - low);
  byId("clip-text").textContent = withUnit(place + (page.origin?.[d] ?? 0), "m");
  const sign = flip ? -1 : 1;
  const normal = [0, 0, 0];
  normal[d] = sign;
  return new THREE.Vector4(...normal, sign * place);
}

// ---- a particle

function pick(hit) {
  picked = hit;
  showPick().then(() => hit && byId("particle").scrollIntoView({ block: "nearest" }));
  paint();
}

async function showPick() {
  for (const panel of panels)
    panel.stage?.markParticle(picked?.panel === panel ? picked.phase : null, picked?.index, numbersOf(colourOf("ink")));
  await showParticle(picked);
}

// ---- runs

async function findRuns() {
  const names = await ask("/api/runs");
  const before = runs.length;
  names.forEach((name, id) => (runs[id] ??= new Run(id, name)));
  if (runs.length !== before) listRuns();
}

function listRuns() {
  const wanted = byId("runs-filter").value.toLowerCase();
  byId("runs-title").textContent = runs.length === 1 ? "1 run" : `${panels.length || 1} of ${runs.length} runs`;
  byId("runs-list").replaceChildren(
    ...runs.filter((run) => run.name.toLowerCase().includes(wanted)).map((run) => {
      const box = element("input", { type: "checkbox", checked: panels.some((panel) => panel.run === run) });
      box.disabled = !box.checked && panels.length >= SIDE_BY_SIDE;
      box.addEventListener("change", () => {
        const names = panels.map((panel) => panel.run.name);
        state.runs = box.checked ? [...names, run.name] : names.filter((name) => name !== run.name);
        if (!state.runs.length) state.runs = names;
        showRuns();
      });
      return element("li", {}, element("label", {}, box, element("span", { textContent: run.name })));
    }),
  );
}

async function showRuns() {
  const chosen = state.runs.map((name) => runs.find((run) => run.name === name)).filter(Boolean);
  const missing = state.runs.filter((name) => !runs.some((run) => run.name === name));
  if (missing.length) toast(`not served here: ${missing.join(", ")}`);
  const wanted = (chosen.length ? chosen : runs.slice(0, 1)).slice(0, SIDE_BY_SIDE);
  state.runs = wanted.map((run) => run.name);
  for (const panel of panels) if (!wanted.includes(panel.run)) panel.dispose();
  if (picked && !wanted.includes(picked.panel.run)) picked = null;
  for (const run of wanted) if (!run.status) run.prepare();
  panels = wanted.map((run) => panels.find((panel) => panel.run === run) ?? new Panel(run, page));
  byId("stage").style.setProperty("--columns", panels.length > 1 ? 2 : 1);
  byId("stage").replaceChildren(...panels.map((panel) => panel.node));
  for (const panel of panels) panel.placed = false;
  listRuns();
  gauges.setRuns(wanted);
  await look(true);
}

function fieldsOf() {
  const fields = {};
  for (const phase of PHASES) {
    const all = new Map();
    for (const { run } of panels) for (const field of run.phases[phase]?.fields ?? []) all.set(field.name, field);
    fields[phase] = [...all.values()];
  }
  return fields;
}

/// Requests the status of the shown runs and draws what has changed.
async function look(all = false) {
  const due = panels.filter(({ run }) => all || run.running || performance.now() - (run.looked ?? 0) > LOOK_AT_ENDED);
  const news = await Promise.all(due.map(async (panel) => {
    const { run } = panel;
    run.looked = performance.now();
    try {
      const changed = await run.refresh();
      panel.trouble = "";
      return changed;
    } catch (error) {
      panel.trouble = error.message;
      return false;
    }
  }));
  if (news.some(Boolean) || all) {
    controls.setFields(fieldsOf());
    setTimes();
    await draw();
  }
  for (const panel of due) panel.tell();
  if (due.length) {
    const reports = panels.map(({ run }) => report(run));
    // Replaced only where it has changed, since screen readers read it aloud.
    if (reports.map((node) => node.textContent).join() !== byId("reports").textContent) byId("reports").replaceChildren(...reports);
    await gauges.refresh().catch((error) => toast(error.message));
  }
}

// ---- saving, links, theme

let linkTimer;
function keepLink() {
  clearTimeout(linkTimer);
  linkTimer = setTimeout(() => {
    state.gauges = gauges.chosen;
    history.replaceState(null, "", toLink(state));
  }, 300);
}

async function copyLink() {
  state.gauges = gauges.chosen;
  history.replaceState(null, "", toLink(state));
  try {
    await navigator.clipboard.writeText(location.href);
    toast("Copied. It opens this view in this browser while poretwin view runs.");
  } catch {
    toast("The address line holds the link to this view.");
  }
}

const fileName = () => `${panels.map(({ run }) => run.name.replaceAll("/", "-")).join("_")}`;

async function film(save) {
  if (saving) return void (saving.stop = true);
  play(false);
  const before = index;
  saving = { stop: false };
  try {
    await save(panels, fileName(), {
      frames: times.length, go, perSecond: Number(byId("speed").value),
      told: (i) => {
        toast(`Saving frame ${i + 1} of ${times.length}; Esc stops`);
        return !saving.stop;
      },
    });
    toast(saving.stop ? "Stopped" : "Saved");
  } catch (error) {
    toast(error.message);
  }
  saving = null;
  go(before);
}

function repaint() {
  gauges.repaint();
  if (panels.length) draw();
}

// ---- start

const controls = new Controls(state, draw);
const gauges = new Gauges(keepLink);
gauges.chosen = state.gauges;

const actions = {
  play: () => play(), back: () => go(index - 1), on: () => go(index + 1), first: () => go(0), last: () => go(times.length - 1),
  fit, theme: otherTheme,
  fluid: () => toggle("fluid"), solid: () => toggle("solid"), link: copyLink, help: () => byId("keys").showModal(),
  picture: () => savePicture(panels, fileName()).catch((error) => toast(error.message)),
  move: (right, up, closer) => panels[0]?.stage?.move(right, up, closer),
  pick: () => panels[0]?.pick(panels[0].picture.clientWidth / 2, panels[0].picture.clientHeight / 2),
  clip: () => {
    state.clip.axis = { "": "x", x: "y", y: "z", z: "" }[state.clip.axis];
    controls.show();
    draw();
  },
  escape: () => {
    if (saving) saving.stop = true;
    for (const menu of document.querySelectorAll(".menu[open]")) menu.open = false;
    pick(null);
  },
};

function toggle(phase) {
  state.phases[phase].show = !state.phases[phase].show;
  controls.show();
  draw();
}

function listen() {
  const click = (id, act) => byId(id).addEventListener("click", act);
  for (const name of ["first", "last", "play", "fit", "theme", "help"]) click(name, actions[name]);
  click("save-png", actions.picture);
  click("save-gif", () => film(saveGif));
  click("save-video", () => film(saveVideo));
  click("save-link", copyLink);
  byId("save").addEventListener("click", (event) => { if (event.target.tagName === "BUTTON") byId("save").open = false; });
  document.addEventListener("pointerdown", (event) => {
    for (const menu of document.querySelectorAll(".menu[open]")) if (!menu.contains(event.target)) menu.open = false;
  });
  byId("time").addEventListener("input", () => { play(false); go(Number(byId("time").value)); });
  byId("follow").checked = state.follow;
  byId("follow").addEventListener("change", () => { state.follow = byId("follow").checked; if (state.follow) actions.last(); });
  byId("runs-filter").addEventListener("input", listRuns);
  byId("runs").addEventListener("toggle", () => { if (byId("runs").open) findRuns().catch((error) => toast(error.message)); });
  byId("keys-list").replaceChildren(...keyList.flatMap(([keys, text]) => [element("dt", { textContent: keys }), element("dd", { textContent: text })]));
  listenToKeys(actions);
}

async function start() {
  followTheme(repaint);
  listen();
  await findRuns();
  await showRuns();
  for (;;) {
    await new Promise((done) => setTimeout(done, LOOK_EVERY));
    if (!document.hidden) await look().catch((error) => toast(error.message));
  }
}

start().catch((error) => byId("stage").replaceChildren(element("p", { className: "error", textContent: error.message })));
