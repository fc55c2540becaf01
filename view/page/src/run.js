// One run: the content of its files, and its status.
import { ask, read } from "./server.js";

export const PHASES = ["solid", "fluid"]; // in the order of drawing
const SAMPLES = 120; // latest status requests of a run in progress that are kept, for its pace and its waits

export class Run {
  constructor(id, name) {
    this.id = id;
    this.name = name;
    this.status = null;
    this.phases = {}; // content of each phase's file
    this.errors = {}; // of reading each phase's file here
    this.unreadable = {}; // what the server says of each phase's file now
    this.tags = {};
    this.samples = [];
  }

  url(what) {
    return `/api/runs/${this.id}/${what}`;
  }

  get running() {
    return this.status?.state === "running";
  }

  /// Makes the worker open the files while the page starts; errors in them are reported later.
  prepare() {
    for (const phase of PHASES) read("describe", this.url(`${phase}.vtkhdf`)).catch(() => {});
  }

  /// Requests the status; returns whether the frames have changed.
  async refresh() {
    this.status = await ask(this.url("status"));
    if (this.running) this.sample(this.status.progress);
    let changed = false;
    for (const phase of PHASES) {
      const file = this.status.files[phase];
      this.unreadable[phase] = file?.error && `${phase}.vtkhdf: ${file.error}`;
      if (!file || file.error || file.tag === this.tags[phase]) continue;
      changed = (await this.reopen(phase, file.tag)) || changed;
    }
    return changed;
  }

  async reopen(phase, tag) {
    const before = this.phases[phase];
    const replaced = this.tags[phase] !== undefined && this.tags[phase].split("-")[0] !== tag.split("-")[0];
    try {
      const found = await read("reopen", this.url(`${phase}.vtkhdf`), { tag, replaced });
      // After a return to a checkpoint, later frames that have been read are invalid.
      if (before && found.steps < before.steps) await read("reopen", this.url(`${phase}.vtkhdf`), { tag, replaced: true });
      this.phases[phase] = found;
      this.tags[phase] = tag;
      delete this.errors[phase];
      return true;
    } catch (error) {
      // A file that is just being created is still empty.
      if (!(error.damaged && this.running && !before)) this.errors[phase] = complaint(`${phase}.vtkhdf`, error);
      if (error.damaged && !this.running) this.tags[phase] = tag; // a finished run's file does not change any more
      return false;
    }
  }

  sample(progress) {
    if (typeof progress.t !== "number") return;
    this.samples.push({ at: performance.now() / 1000, t: progress.t, waits: progress.waiting_for || "" });
    if (this.samples.length > SAMPLES) this.samples.shift();
  }

  /// Estimated seconds until its end, at the pace so far; null: unknown.
  remaining() {
    const [first, last] = [this.samples[0], this.samples.at(-1)];
    const pace = last && (last.t - first.t) / (last.at - first.at);
    return pace > 0 ? (this.status.progress.end - last.t) / pace : null;
  }

  /// For each participant, the fraction of status requests in which the coupler waited for it.
  waits() {
    const count = {};
    for (const { waits } of this.samples) if (waits) count[waits] = (count[waits] ?? 0) + 1 / this.samples.length;
    return count;
  }

  complaints() {
    return [...Object.values(this.unreadable), ...Object.values(this.errors)].filter(Boolean);
  }

  times() {
    return PHASES.flatMap((phase) => this.phases[phase]?.times ?? []);
  }

  /// The frame of a phase nearest to a time, -1 where there is none.
  stepAt(phase, time) {
    const times = this.phases[phase]?.times ?? [];
    let best = -1;
    for (let i = 0; i < times.length; ++i) if (best < 0 || Math.abs(times[i] - time) <= Math.abs(times[best] - time)) best = i;
    return best;
  }
}

export function complaint(name, error) {
  if (!error.damaged) return `${name}: ${error.message}`;
  return `${name}: this file is damaged: ${error.message}. If its run was broken off, \`poretwin run CASE --resume\` brings it back to its last ` +
    "checkpoint; otherwise take it from where it was copied, or run the case again.";
}
