// The form beside the pictures: fields and colours of each phase, arrows, clip plane. It changes the state of the view.
import { MAP_NAMES } from "./colour.js";
import { byId, element, option } from "./dom.js";
import { MAIN_FIELDS, label, partsOf, readable, unitOf } from "./fields.js";
import { PHASES } from "./run.js";

export class Controls {
  constructor(state, changed) {
    this.state = state;
    this.changed = changed;
    this.forms = {};
    for (const phase of [...PHASES].reverse()) this.forms[phase] = this.phaseForm(phase);
    const listen = (id, event, act) => byId(id).addEventListener(event, () => { act(byId(id)); changed(); });
    listen("arrow-field", "change", ({ value }) => {
      const [phase, field] = value.split("|");
      Object.assign(state.arrows, { phase, field: field ?? "" });
    });
    listen("arrow-size", "input", ({ value }) => (state.arrows.length = Number(value)));
    listen("clip-axis", "change", ({ value }) => (state.clip.axis = value));
    listen("clip-at", "input", ({ value }) => (state.clip.at = Number(value)));
    listen("clip-flip", "change", ({ checked }) => (state.clip.flip = checked));
  }

  phaseForm(phase) {
    const look = this.state.phases[phase];
    const on = (node, event, act) => {
      node.addEventListener(event, () => { act(); this.show(); this.changed(); });
      return node;
    };
    const name = phase === "fluid" ? "Fluid" : "Solid";
    const form = {};
    form.show = on(element("input", { type: "checkbox" }), "change", () => (look.show = form.show.checked));
    form.field = on(element("select", { ariaLabel: `Field of the ${phase}` }), "change", () => {
      [look.field, look.part] = form.field.value.split("|");
      look.range = null;
      look.log = false;
    });
    form.map = on(element("select", { ariaLabel: `Colour map of the ${phase}` }, option("auto", "automatic"), ...MAP_NAMES.map((map) => option(map, map))),
      "change", () => (look.map = form.map.value));
    form.kind = on(element("select", { ariaLabel: `Range of the ${phase}` }, option("frame", "of each frame"), option("fixed", "fixed")),
      "change", () => (look.range = form.kind.value === "fixed" ? [this.scales?.[phase]?.low ?? 0, this.scales?.[phase]?.high ?? 1] : null));
    const end = (i, text) => {
      const input = element("input", { type: "number", step: "any", ariaLabel: `${text} value of the ${phase}` });
      return on(input, "change", () => {
        if (input.value !== "") look.range = look.range.map((v, k) => (k === i ? Number(input.value) : v));
      });
    };
    [form.low, form.high] = [end(0, "Lowest"), end(1, "Highest")];
    form.ends = element("div", { className: "range" }, form.low, "to", form.high);
    form.unit = element("span", { className: "soft" });
    form.ends.append(form.unit);
    form.log = on(element("input", { type: "checkbox" }), "change", () => (look.log = form.log.checked));
    form.size = on(element("input", { type: "range", min: 0.1, max: 3, step: 0.05 }), "input", () => (look.size = Number(form.size.value)));
    form.opacity = on(element("input", { type: "range", min: 0.05, max: 1, step: 0.05 }), "input", () => (look.opacity = Number(form.opacity.value)));
    const row = (text, ...inputs) => element("label", {}, text, ...inputs);
    form.colours = element("div", { className: "colours" }, row("Colours", form.map), row("Range", form.kind), form.ends,
      element("label", { className: "inline" }, form.log, "logarithmic"));
    form.colours.style.display = "contents";
    form.node = element("fieldset", {}, element("legend", {}, element("label", { className: "inline" }, form.show, name)),
      row("Field", form.field), form.colours, row("Size", form.size), row("Opacity", form.opacity));
    form.node.dataset.phase = phase;
    byId("phases").append(form.node);
    return form;
  }

  /// Sets the fields that the files contain, {phase: fields}, and chooses the most informative one where none is chosen.
  setFields(fields) {
    this.fields = fields;
    for (const phase of PHASES) {
      const look = this.state.phases[phase];
      const there = fields[phase] ?? [];
      this.forms[phase].node.hidden = there.length === 0;
      if (there.length === 0) continue;
      if (look.field === null || (look.field && !there.some((field) => field.name === look.field))) {
        // Beside a field of the water, the soil is shown in one colour.
        const beside = phase === "solid" && fields.fluid?.length;
        const main = MAIN_FIELDS[phase].map((name) => there.find((field) => field.name === name)).find(Boolean) ?? there[0];
        [look.field, look.part] = beside ? ["", ""] : [main.name, partsOf(main.components)[0]];
      }
      this.forms[phase].field.replaceChildren(
        option("|", "one colour"),
        ...there.flatMap((field) => partsOf(field.components).map((part) => Object.assign(option(`${field.name}|${part}`, label(field.name, part)), { title: field.description }))),
      );
    }
    const vectors = PHASES.flatMap((phase) => (fields[phase] ?? []).filter((field) => field.components === 3).map((field) => [phase, field.name]));
    byId("arrow-field").replaceChildren(option("|", "none"), ...vectors.map(([phase, name]) => option(`${phase}|${name}`, `${readable(name)} of the ${phase}`)));
    this.show();
  }

  /// Sets the colour ranges of the present pictures.
  setScales(scales) {
    this.scales = scales;
    this.show();
  }

  /// Shows the state in the form.
  show() {
    const set = (input, value) => {
      if (input !== document.activeElement) input.value = value;
    };
    for (const phase of PHASES) {
      const look = this.state.phases[phase];
      const form = this.forms[phase];
      const field = this.fields?.[phase]?.find((f) => f.name === look.field);
      form.show.checked = look.show;
      form.field.value = `${look.field ?? ""}|${look.part}`;
      form.map.value = look.map;
      form.kind.value = look.range ? "fixed" : "frame";
      form.log.checked = look.log;
      set(form.size, look.size);
      set(form.opacity, look.opacity);
      form.colours.hidden = !field;
      form.colours.style.display = field ? "contents" : "none";
      const scale = this.scales?.[phase];
      const [low, high] = look.range ?? [scale?.low, scale?.high];
      for (const [input, value] of [[form.low, low], [form.high, high]]) {
        input.disabled = !look.range;
        set(input, value === undefined ? "" : Number(value.toPrecision(5)));
      }
      form.unit.textContent = field && unitOf(field) !== "1" ? unitOf(field) : "";
    }
    byId("arrow-field").value = `${this.state.arrows.phase}|${this.state.arrows.field}`;
    set(byId("arrow-size"), this.state.arrows.length);
    byId("clip-axis").value = this.state.clip.axis;
    set(byId("clip-at"), this.state.clip.at);
    byId("clip-flip").checked = this.state.clip.flip;
    for (const id of ["clip-at", "clip-flip"]) byId(id).disabled = !this.state.clip.axis;
    byId("arrow-size").disabled = !this.state.arrows.field;
  }
}
