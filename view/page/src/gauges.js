// Gauges against time, one chart for each, with all runs in one chart, their references as points and the time of the picture.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { byId, colourOf, element } from "./dom.js";
import { label, shown } from "./fields.js";
import { ask } from "./server.js";

const LINES = ["#1f77b4", "#e07b00", "#2ca02c", "#b04fc4"];
const AT_START = 4;
const MOST = 60; // largest number of charts

/// The readings of one run, and its reference values.
class Readings {
  constructor(run) {
    this.run = run;
    this.begin();
  }

  begin() {
    this.started = this.run.status?.started;
    this.series = new Map();
    this.cursor = {};
    this.references = [];
  }

  /// Reads new readings; returns whether there were any.
  async refresh() {
    let news = false;
    if (this.started !== this.run.status?.started) this.begin(); // another run is in the same folder now
    for (let more = true; more; ) {
      const query = new URLSearchParams(this.cursor);
      const answer = await ask(this.run.url(`gauges?${query}`));
      this.cursor = answer.cursor;
      more = answer.more;
      const before = this.series.size;
      for (const [name, { unit, time, value }] of Object.entries(answer.series)) {
        news = true;
        this.add(name, unit, time, value);
      }
      if (this.series.size > before) await this.findReferences();
    }
    return news;
  }

  add(name, unit, time, value) {
    const here = this.series.get(name) ?? { unit, time: [], value: [] };
    this.series.set(name, here);
    // A resumed run repeats the readings after its checkpoint.
    while (here.time.length && here.time.at(-1) >= time[0]) {
      here.time.pop();
      here.value.pop();
    }
    for (let i = 0; i < time.length; ++i) {
      here.time.push(time[i]);
      here.value.push(value[i]);
    }
  }

  async findReferences() {
    const query = new URLSearchParams([...this.series.keys()].map((name) => ["gauge", name]));
    this.references = await ask(this.run.url(`references?${query}`));
  }

  marks(name) {
    const ended = !this.run.running;
    const last = this.series.get(name)?.time.at(-1);
    // References beyond the run's end would only compress its curve.
    const end = ended ? 1.1 * last : (this.run.status.progress.end ?? Infinity);
    return this.references
      .filter((mark) => mark.gauge === name && (mark.time === null ? ended : mark.time - mark.time_error <= end))
      .map((mark) => ({ ...mark, time: mark.time ?? last }));
  }
}

export class Gauges {
  /// `chosen`: names of gauges, or null for those with references.
  constructor(changed) {
    this.readings = [];
    this.charts = new Map();
    this.chosen = null;
    this.time = null;
    this.changed = changed;
    byId("gauge-filter").addEventListener("input", () => this.list());
    this.watcher = new ResizeObserver(() => this.fitCharts());
    this.watcher.observe(byId("charts"));
  }

  setRuns(runs) {
    this.readings = runs.map((run) => this.readings.find((r) => r.run === run) ?? new Readings(run));
    this.clear();
  }

  clear() {
    for (const { plot, node } of this.charts.values()) {
      plot.destroy();
      node.remove();
    }
    this.charts.clear();
  }

  async refresh() {
    const news = await Promise.all(this.readings.map((readings) => readings.refresh()));
    if (news.some(Boolean) || this.names === undefined) {
      this.list();
      this.draw();
    }
  }

  all() {
    return [...new Set(this.readings.flatMap((readings) => [...readings.series.keys()]))];
  }

  /// The gauges that are shown: those chosen, else those with references, else the first.
  selection() {
    const names = this.all();
    if (this.chosen) return this.chosen.filter((name) => names.includes(name)).slice(0, MOST);
    const held = names.filter((name) => !name.includes("[") && this.readings.some((readings) => readings.marks(name).length));
    const some = names.filter((name) => this.readings.some((r) => r.series.get(name)?.value.some((v) => v !== null)));
    return [...new Set([...held, ...some])].slice(0, AT_START);
  }

  list() {
    const names = this.all();
    const selection = this.selection();
    const wanted = byId("gauge-filter").value.toLowerCase();
    this.names = names.length;
    byId("gauge-title").textContent = names.length ? `${selection.length} of ${names.length} shown: choose` : "This run has no gauges yet";
    byId("gauge-list").replaceChildren(
      ...names.filter((name) => name.toLowerCase().includes(wanted)).map((name) => {
        const box = element("input", { type: "checkbox", checked: selection.includes(name) });
        box.addEventListener("change", () => {
          this.chosen = box.checked ? [...this.selection(), name] : this.selection().filter((other) => other !== name);
          this.list();
          this.draw();
          this.changed();
        });
        return element("li", {}, element("label", {}, box, element("span", { textContent: name })));
      }),
    );
  }

  draw() {
    const selection = this.selection();
    for (const [name, { plot, node }] of this.charts)
      if (!selection.includes(name)) {
        plot.destroy();
        node.remove();
        this.charts.delete(name);
      }
    for (const name of selection) {
      if (!this.charts.has(name)) this.charts.set(name, this.chart(name));
      const chart = this.charts.get(name);
      byId("charts").append(chart.node);
      chart.marks = this.readings.map((readings) => readings.marks(name));
      chart.plot.setData(this.dataOf(name, chart.marks));
      this.explain(chart);
    }
    this.fitCharts();
  }

  /// Times of all runs and of the references in one column, as uPlot requires.
  dataOf(name, marks) {
    const tables = this.readings.map((readings) => {
      const series = readings.series.get(name);
      return series ? [series.time, series.value] : [[], []];
    });
    const points = marks.flat().sort((a, b) => a.time - b.time);
    const once = points.filter((mark, i) => i === 0 || mark.time !== points[i - 1].time);
    tables.push([once.map((mark) => mark.time), once.map((mark) => mark.value)]);
    return uPlot.join(tables);
  }

  chart(name) {
    const unit = this.readings.map((readings) => readings.series.get(name)?.unit).find((u) => u) ?? "";
    const key = element("div", { className: "key" });
    const value = element("span", { className: "soft" });
    const title = element("h3", { textContent: `${label(name)}${unit && unit !== "1" ? ` [${unit}]` : ""} ` }, value);
    const place = element("div");
    const node = element("div", { className: "chart" }, title, place, key);
    node.dataset.gauge = name;
    const chart = { node, key, value, marks: [], unit, name };
    const axis = { stroke: () => colourOf("soft"), grid: { stroke: () => colourOf("line"), width: 1 }, ticks: { stroke: () => colourOf("line"), width: 1 },
                   font: '11px "DejaVu Sans", system-ui, sans-serif' };
    // As many digits as distinguish neighbouring ticks.
    const format = (_, ticks, axis, space, step) => ticks.map((v) => shown(v, Math.max(1, Math.ceil(Math.log10(Math.max(Math.abs(v), step) / step) + 1.01))));
    chart.plot = new uPlot({
      width: byId("charts").clientWidth || 320, height: 170,
      legend: { show: false },
      cursor: { y: false, points: { size: 6 } },
      scales: { x: { time: false }, y: { range: (_, low, high) => this.withMarks(chart, low, high) } },
      axes: [{ ...axis, values: format, size: 32, label: "time [s]", labelSize: 16, labelFont: axis.font }, { ...axis, values: format, size: 58 }],
      series: [{}, ...this.readings.map((_, i) => ({ stroke: LINES[i], width: 1.6, points: { show: false }, spanGaps: true })),
               { stroke: () => colourOf("ink"), paths: () => null, points: { show: true, size: 7, fill: () => colourOf("sheet") } }],
      hooks: { draw: [(plot) => this.drawExtras(plot, chart)], setCursor: [(plot) => this.readValue(plot, chart)] },
    }, [[]], place);
    return chart;
  }

  withMarks({ marks }, low, high) {
    for (const mark of marks.flat()) {
      low = Math.min(low ?? Infinity, mark.value - mark.value_error);
      high = Math.max(high ?? -Infinity, mark.value + mark.value_error);
    }
    if (low === null || high === null || !Number.isFinite(low)) return [0, 1];
    const room = 0.06 * (high - low) || Math.abs(high) * 0.1 || 1;
    return [low - room, high + room];
  }

  /// Draws the allowed errors of references, and the time of the picture.
  drawExtras(plot, { marks }) {
    const { ctx, bbox } = plot;
    const at = (t) => plot.valToPos(t, "x", true);
    const up = (v) => plot.valToPos(v, "y", true);
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.strokeStyle = colourOf("ink");
    ctx.lineWidth = devicePixelRatio;
    ctx.beginPath();
    for (const mark of marks.flat()) {
      ctx.moveTo(at(mark.time - mark.time_error), up(mark.value));
      ctx.lineTo(at(mark.time + mark.time_error), up(mark.value));
      ctx.moveTo(at(mark.time), up(mark.value - mark.value_error));
      ctx.lineTo(at(mark.time), up(mark.value + mark.value_error));
    }
    ctx.stroke();
    if (this.time !== null) {
      ctx.strokeStyle = colourOf("accent");
      ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
      ctx.beginPath();
      ctx.moveTo(at(this.time), bbox.top);
      ctx.lineTo(at(this.time), bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.restore();
  }

  readValue(plot, chart) {
    const i = plot.cursor.idx;
    const values = i === null || i === undefined ? [] : plot.data.slice(1, 1 + this.readings.length).map((column) => column[i]);
    chart.value.textContent = values.some((v) => v !== null && v !== undefined)
      ? `${values.map((v) => (v === null || v === undefined ? "-" : shown(v))).join(", ")} at ${shown(plot.data[0][i])} s` : "";
  }

  explain({ key, marks, name }) {
    const lines = this.readings.length < 2 ? [] : this.readings.flatMap(({ run, series }, i) =>
      series.has(name) ? [element("span", {}, colouredLine(LINES[i]), element("span", { textContent: run.name }))] : []);
    const what = [...new Set(marks.flat().map((mark) => mark.text))];
    if (what.length) lines.push(element("span", { title: what.join("\n") }, element("i", { className: "dot" }), `reference: ${what.length > 2 ? `${what[0]}, and ${what.length - 1} more` : what.join("; ")}`));
    key.replaceChildren(...lines);
  }

  setTime(time) {
    this.time = time;
    for (const { plot } of this.charts.values()) plot.redraw(false);
  }

  fitCharts() {
    for (const { plot, node } of this.charts.values())
      if (node.clientWidth && plot.width !== node.clientWidth) plot.setSize({ width: node.clientWidth, height: 170 });
  }

  repaint() {
    for (const { plot } of this.charts.values()) plot.redraw(false, true);
  }
}

function colouredLine(colour) {
  const line = element("i");
  line.style.background = colour;
  return line;
}
