// Frames of one phase; a step's rows are found through the offsets, as VTKHDF readers do.
import h5wasm from "h5wasm";
import { RangeFile } from "./range_file.js";

/// The file is damaged, as opposed to changed during the read.
export class Damaged extends Error {}

// Compiled while the page finds out what to read.
const library = h5wasm.ready.then((module) => {
  module.activate_throwing_error_handler();
  return module;
});

export async function openFrames(url) {
  const { FS } = await library;
  const file = new RangeFile(url);
  return new Frames(file, FS);
}

/// The innermost entry of the library's error stack is the cause: "  #012: H5Gent.c line 42 in H5G_ent(): bad symbol table".
function causeOf(text) {
  const entries = [...text.matchAll(/^ *#\d+: .*?\(\): (.+)$/gm)];
  return (entries.at(-1)?.[1] ?? text.split("\n")[0]).trim();
}

class Frames {
  constructor(file, FS) {
    this.file = file;
    this.FS = FS;
    const path = file.mount(FS);
    this.guarded(() => {
      this.hdf = new h5wasm.File(path, "r");
      const root = this.get("VTKHDF");
      if (!root || !this.get("VTKHDF/Steps")) throw new Error("no group /VTKHDF/Steps");
      this.steps = Number(this.get("VTKHDF/Steps").attrs["NSteps"].value);
      const column = (name) => (this.steps ? Array.from(this.get(name).slice([[0, this.steps]]), Number) : []);
      this.times = column("VTKHDF/Steps/Values");
      this.counts = column("VTKHDF/NumberOfPoints");
      this.first = column("VTKHDF/Steps/PointOffsets");
      this.fields = this.steps ? this.get("VTKHDF/PointData").keys().map((name) => this.declaration(name)) : [];
    });
  }

  get tag() {
    return this.file.tag;
  }

  get(name) {
    return this.hdf.get(name);
  }

  declaration(name) {
    const data = this.get(`VTKHDF/PointData/${name}`);
    const text = (key) => (data.attrs[key] ? String(data.attrs[key].value) : "");
    return { name, unit: text("unit"), description: text("description"), components: data.shape[1] ?? 1 };
  }

  /// Runs a read. Where it fails, the error of the file itself comes first: the library knows only that there was one.
  guarded(read) {
    let result;
    try {
      result = read();
    } catch (error) {
      throw this.file.failure ?? new Damaged(causeOf(String(error.message ?? error)));
    }
    if (this.file.failure) throw this.file.failure;
    return result;
  }

  expectStep(step) {
    if (step >= this.steps) throw new Error(`frame ${step} is not there any more: the run was taken back to a checkpoint`);
  }

  /// Numbers of a data set for one frame, row by row.
  rows(name, step) {
    this.expectStep(step);
    const range = [this.first[step], this.first[step] + this.counts[step]];
    if (range[0] === range[1]) return new Float64Array(0);
    return this.guarded(() => {
      const data = this.get(name);
      return data.shape.length > 1 ? data.slice([range, [0, data.shape[1]]]) : data.slice([range]);
    });
  }

  /// All fields of one particle.
  particle(step, index) {
    this.expectStep(step);
    const row = this.first[step] + index;
    const read = (name) =>
      this.guarded(() => {
        const data = this.get(name);
        const columns = data.shape[1];
        return Array.from(columns ? data.slice([[row, row + 1], [0, columns]]) : data.slice([[row, row + 1]]));
      });
    return {
      position: read("VTKHDF/Points"),
      fields: this.fields.map((field) => ({ ...field, values: read(`VTKHDF/PointData/${field.name}`) })),
    };
  }

  close() {
    try {
      this.hdf?.close();
    } catch {
      // it was never open, or is damaged: nothing can be closed
    }
    this.file.unmount(this.FS);
  }
}
