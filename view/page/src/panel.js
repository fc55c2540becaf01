// The picture of one run with its heading: state, progress, whom the run waits for, errors.
import { colourOf, duration, element, numbersOf } from "./dom.js";
import { shown, unitOf, withUnit } from "./fields.js";
import { annotate, inWords } from "./notes.js";
import { PHASES, complaint } from "./run.js";
import { read } from "./server.js";
import { Stage } from "./stage.js";

const BEHIND = 0.7; // fraction of its size with which soil around the water is drawn

export class Panel {
  /// `page`: {moved(view, panel), picked(panel, hit), origin: [x, y, z] or null}
  constructor(run, page) {
    this.run = run;
    this.page = page;
    this.frames = {};
    this.bars = [];
    this.state = element("span", { className: "badge" });
    this.progress = element("progress", { max: 1, hidden: true });
    this.words = element("span", { className: "soft" });
    this.canvas = element("canvas", { tabIndex: 0 });
    this.notes = element("canvas", { className: "notes", ariaHidden: "true" });
    this.notice = element("div", { className: "notice", hidden: true, role: "alert" });
    this.picture = element("div", { className: "picture" }, this.canvas, this.notes, this.notice);
    this.node = element("article", { className: "panel" },
      element("header", {}, element("b", { textContent: run.name }), this.state, this.progress, this.words), this.picture);
    this.node.dataset.run = run.name;
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(this.picture);
    this.listen();
  }

  /// Creates the stage on first use; null where there is no WebGL.
  openStage() {
    if (this.stage !== undefined) return;
    try {
      this.stage = new Stage(this.canvas, (view) => this.page.moved(view, this));
      this.resize();
    } catch {
      this.stage = null;
      this.lack = "This browser gives no WebGL 2, so particles cannot be drawn; gauges and messages are still shown. " +
        "Turn on hardware acceleration in its settings, or try another browser.";
    }
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.lack = "The graphics driver took the picture away. Load the page again.";
      this.tell();
    });
  }

  listen() {
    let down = null;
    this.canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
    this.canvas.addEventListener("pointerup", (event) => {
      if (!down || !this.stage || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      this.pick(event.offsetX, event.offsetY);
    });
  }

  pick(x, y) {
    this.page.picked(this, this.stage?.pick(x, y) ?? null);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.picture;
    if (!width || !height || !this.stage) return;
    this.stage.resize(width, height);
    const ratio = Math.min(window.devicePixelRatio, 2);
    [this.notes.width, this.notes.height] = [width * ratio, height * ratio];
    // A picture that was fitted stays fitted.
    if (this.page.fitted()) this.page.fit();
  }

  /// Reads the frames nearest to a time that are not loaded yet.
  async load(time, state) {
    this.time = time;
    this.failed = {};
    for (const phase of PHASES) {
      const step = this.run.stepAt(phase, time);
      if (step < 0 || this.stage === null) {
        this.frames[phase] = null;
        continue;
      }
      const look = state.phases[phase];
      const description = this.run.phases[phase];
      const colour = look.field ? { field: look.field, part: look.part } : null;
      const arrows = state.arrows.phase === phase ? state.arrows.field : null;
      const key = JSON.stringify([description.tag.split("-")[0], step, colour, arrows]);
      if (this.frames[phase]?.key === key) continue;
      try {
        const reading = read("frame", this.run.url(`${phase}.vtkhdf`), { step, origin: this.page.origin, colour, arrows });
        this.openStage(); // takes as long as reading, so that both run at the same time
        const frame = await reading;
        if (!this.stage) continue;
        if (frame.positions.length) this.page.origin ??= frame.origin;
        this.frames[phase] = { ...frame, key };
        this.stage.setFrame(phase, frame);
      } catch (error) {
        this.failed[phase] = complaint(`${phase}.vtkhdf`, error);
      }
    }
  }

  /// Sets colours, sizes and clip plane. `scales`: colour ranges of each phase's field, the same for all panels.
  dress(state, scales, clip, longest) {
    if (!this.stage) return this.tell();
    this.bars = [];
    this.stage.clip.copy(clip);
    for (const phase of PHASES) {
      const cloud = this.stage.clouds[phase];
      const look = state.phases[phase];
      const frame = this.frames[phase];
      // Soil in one colour would hide the colours of the water inside it, so that its spheres are drawn smaller.
      const behind = phase === "solid" && frame?.three && !frame.values && state.phases.fluid.show && this.frames.fluid?.positions.length > 0;
      cloud.setLook({ ...look, size: behind ? BEHIND * look.size : look.size, show: look.show && Boolean(frame) }, clip, numbersOf(colourOf("ink")), numbersOf(colourOf("picture")));
      if (!frame) continue;
      cloud.setScale(frame.values ? scales[phase] : null, numbersOf(colourOf(phase)));
      cloud.showArrows(Boolean(frame.vectors) && cloud.longest > 0);
      if (longest) cloud.setArrowScale(longest, state.arrows.length);
      const field = this.run.phases[phase].fields.find((f) => f.name === look.field);
      if (look.show && frame.values && field)
        this.bars.push({ phase, field: field.name, part: look.part, unit: unitOf(field), scale: scales[phase] });
    }
    const shownArrows = state.arrows.field && this.run.phases[state.arrows.phase]?.fields.find((f) => f.name === state.arrows.field);
    this.arrowText = shownArrows && longest ? withUnit(longest, unitOf(shownArrows)) : "";
    const counts = PHASES.filter((phase) => this.frames[phase]).map((phase) => `${this.frames[phase].radius.length} particles of the ${phase}`);
    this.canvas.ariaLabel = `${this.run.name} at ${withUnit(this.time ?? 0, "s")}: ${counts.join(", ")}; ${this.bars.map(inWords).join("; ")}`;
    this.stage.dirty = true;
    this.tell();
  }

  /// Shows state, progress and errors.
  tell() {
    const { run } = this;
    const { status } = run;
    if (!status) return;
    this.state.textContent = status.state;
    this.state.className = `badge ${status.state.split(" ").at(-1) === "doubt" ? "doubt" : status.state.split(" ")[0]}`;
    const { t, end, waiting_for: waits } = status.progress;
    this.progress.hidden = !(run.running && end > 0);
    if (!this.progress.hidden) this.progress.value = t / end;
    this.words.textContent = run.running ? progressWords(run, t, end, waits) : endWords(status);
    const complaints = [this.lack, this.trouble, ...run.complaints(), ...Object.values(this.failed ?? {})].filter(Boolean);
    const empty = complaints.length === 0 && run.times().length === 0;
    this.notice.hidden = complaints.length === 0 && !empty;
    this.notice.classList.toggle("calm", empty);
    this.notice.textContent = empty ? emptyWords(run) : [...new Set(complaints)].join("\n");
  }

  paint() {
    if (!this.stage?.dirty || !this.notes.width || this.stage.three === null) return;
    this.stage.render(colourOf("picture"));
    this.node.dataset.drawn = this.time;
    const context = this.notes.getContext("2d");
    const ratio = this.notes.width / this.picture.clientWidth;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.notes.width, this.notes.height);
    annotate(context, this.picture.clientWidth, this.picture.clientHeight, this.noteContent());
  }

  noteContent() {
    return { bars: this.bars, time: `t = ${shown(this.time ?? 0, 5)} s`, stage: this.stage, arrows: this.arrowText };
  }

  dispose() {
    this.watcher.disconnect();
    this.stage?.dispose();
    this.node.remove();
  }
}

function progressWords(run, t, end, waits) {
  if (t === undefined || !(end > 0)) return run.status.doing || "starting";
  const left = run.remaining();
  const parts = [`${Math.round((100 * t) / end)} %`, `t = ${shown(t)} of ${shown(end)} s`, `window ${run.status.progress.step}`, `dt = ${withUnit(run.status.progress.dt, "s")}`];
  if (left !== null) parts.push(`about ${duration(left)} left`);
  if (waits) parts.push(`the coupler waits for the ${waits}`);
  return parts.join(" · ");
}

function endWords(status) {
  return [status.case, status.wall !== null ? `took ${duration(status.wall)}` : ""].filter(Boolean).join(" · ");
}

function emptyWords(run) {
  return run.running ? "The run has written no frame yet." : "This run has written no frame.";
}
