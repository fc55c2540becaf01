// The numbers that are drawn of a field: itself, a component, or a number computed from its components; names and units.

const VECTOR = ["x", "y", "z"];
const TENSOR = ["xx", "yy", "zz", "xy", "yz", "xz"];

/// The parts of a field with this number of components; the first is the one initially shown.
export function partsOf(components) {
  if (components === 3) return ["magnitude", ...VECTOR];
  if (components === 6) return ["mean", "deviatoric", ...TENSOR];
  return [""];
}

export function componentNames(components) {
  return components === 3 ? VECTOR : components === 6 ? TENSOR : [""];
}

const magnitude = (v, i) => Math.hypot(v[i], v[i + 1], v[i + 2]);
const mean = (v, i) => (v[i] + v[i + 1] + v[i + 2]) / 3;

/// sqrt(3 J2), von Mises' equivalent stress.
function deviatoric(v, i) {
  const p = mean(v, i);
  const normal = (v[i] - p) ** 2 + (v[i + 1] - p) ** 2 + (v[i + 2] - p) ** 2;
  const shear = v[i + 3] ** 2 + v[i + 4] ** 2 + v[i + 5] ** 2;
  return Math.sqrt(1.5 * (normal + 2 * shear));
}

/// One number per particle.
export function scalars(values, components, part) {
  const one = { magnitude, mean, deviatoric }[part];
  const index = Math.max(0, componentNames(components).indexOf(part));
  const result = new Float32Array(values.length / components);
  for (let i = 0; i < result.length; ++i) result[i] = one ? one(values, i * components) : values[i * components + index];
  return result;
}

/// Units of fields in files that do not contain them.
const UNITS = {
  pore_pressure: "Pa", pressure: "Pa", effective_stress: "Pa", velocity: "m/s", relative_flux: "m/s", displacement: "m",
  void_fraction: "1", degree_of_saturation: "1", accumulated_plastic_strain: "1", mobilised_friction: "degrees",
};

export function unitOf(field) {
  return field.unit || UNITS[field.name] || "";
}

/// The most informative fields of each phase, the best first.
export const MAIN_FIELDS = {
  fluid: ["pore_pressure", "velocity"],
  solid: ["effective_stress", "accumulated_plastic_strain", "displacement"],
};

export const readable = (name) => name.replaceAll("_", " ");

export function label(field, part) {
  const text = readable(field);
  if (part === "magnitude") return `|${text}|`;
  return part ? `${text}, ${part}` : text;
}

/// A factor and prefix that keep numbers short: [1e3, "k"].
export function prefix(largest, unit) {
  if (!["Pa", "m", "m/s", "N", "s"].includes(unit) || !(largest > 0)) return [1, ""];
  for (const [factor, sign] of [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"]])
    if (largest >= factor) return unit === "s" && factor > 1 ? [1, ""] : [factor, sign];
  return [1, ""];
}

export function shown(value, digits = 4) {
  if (value === null || Number.isNaN(value)) return "no value";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return String(Number(value.toPrecision(digits)));
  return value.toExponential(digits - 1).replace(/\.?0*e\+?/, "e");
}

export function withUnit(value, unit) {
  const [factor, sign] = prefix(Math.abs(value), unit);
  const plain = unit === "1" || unit === "";
  return plain || value === null || Number.isNaN(value) ? shown(value) : `${shown(value / factor)} ${sign}${unit}`;
}
