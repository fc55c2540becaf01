// The annotations of a picture: colour bars, time, scale; the same on the page and in saved pictures.
import { table } from "./colour.js";
import { colourOf } from "./dom.js";
import { label, prefix, shown } from "./fields.js";

const FONT = '"DejaVu Sans", system-ui, sans-serif';

/// Draws into a canvas of width x height CSS pixels. `bars`: [{phase, field, part, unit, scale}].
export function annotate(context, width, height, { bars, time, title, stage, arrows }) {
  const small = width < 520;
  const size = small ? 11 : Math.min(16, Math.max(12, width / 90));
  context.font = `${size}px ${FONT}`;
  context.textBaseline = "alphabetic";
  const ink = colourOf("ink");
  const halo = colourOf("picture");
  const write = (text, x, y, align = "left") => {
    context.textAlign = align;
    context.lineWidth = 3;
    context.lineJoin = "round";
    context.strokeStyle = halo;
    context.strokeText(text, x, y);
    context.fillStyle = ink;
    context.fillText(text, x, y);
  };
  const margin = 0.9 * size;
  let top = margin + size;
  if (title) {
    write(title, margin, top);
    top += 1.5 * size;
  }
  if (time) write(time, width - margin, margin + size, "right");

  const long = Math.min(18 * size, 0.62 * width);
  for (const bar of bars) {
    drawBar(context, write, bar, margin, top, long, size);
    top += 3.9 * size;
  }
  if (arrows) write(`longest arrow: ${arrows}`, margin, top);
  if (stage?.three === false) drawScale(context, write, stage.view().height / height, width, height, size, ink);
  if (stage?.three) drawAxes(context, write, stage.camera, width - 3.2 * size, height - 3.2 * size, 2.2 * size, ink);
}

function drawBar(context, write, { phase, field, part, unit, scale }, x, y, long, size) {
  const [factor, sign] = scale.log ? [1, ""] : prefix(Math.max(Math.abs(scale.low), Math.abs(scale.high)), unit);
  const shownUnit = unit && unit !== "1" ? ` [${sign}${unit}]` : "";
  write(`${phase}: ${label(field, part)}${shownUnit}`, x, y);
  const colours = table(scale.map);
  const thick = 0.7 * size;
  for (let i = 0; i < 256; ++i) {
    context.fillStyle = `rgb(${colours[4 * i]} ${colours[4 * i + 1]} ${colours[4 * i + 2]})`;
    context.fillRect(x + (i / 256) * long, y + 0.45 * size, long / 256 + 0.6, thick);
  }
  const base = y + 0.45 * size + thick + 1.05 * size;
  const middle = scale.log ? Math.sqrt(scale.low * scale.high) : 0.5 * (scale.low + scale.high);
  write(shown(scale.low / factor, 3), x, base);
  // The middle of a signed range is zero except for rounding.
  write(shown(Math.abs(middle) < 1e-9 * (scale.high - scale.low) ? 0 : middle / factor, 3), x + 0.5 * long, base, "center");
  write(shown(scale.high / factor, 3), x + long, base, "right");
}

/// A length in the picture: 1, 2 or 5 times a power of ten, about a sixth of its width.
function drawScale(context, write, metres, width, height, size, ink) {
  const wanted = (metres * width) / 6;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [5, 2, 1].map((n) => n * power).find((l) => l <= wanted);
  const pixels = length / metres;
  const [factor, sign] = prefix(length, "m");
  const [x, y] = [width - 0.9 * size - pixels, height - 0.9 * size];
  context.fillStyle = ink;
  context.fillRect(x, y - 2, pixels, 2);
  context.fillRect(x, y - 7, 2, 7);
  context.fillRect(x + pixels - 2, y - 7, 2, 7);
  write(`${shown(length / factor)} ${sign}m`, x + pixels, y - 0.8 * size, "right");
}

function drawAxes(context, write, camera, x, y, long, ink) {
  const e = camera.matrixWorldInverse.elements;
  for (const [i, name] of ["x", "y", "z"].entries()) {
    const [dx, dy] = [e[4 * i] * long, -e[4 * i + 1] * long];
    context.strokeStyle = ink;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    context.stroke();
    write(name, x + 1.3 * dx, y + 1.3 * dy + 4, "center");
  }
}

export function inWords({ phase, field, part, unit, scale }) {
  return `${phase} by ${label(field, part)}, ${shown(scale.low)} to ${shown(scale.high)} ${unit === "1" ? "" : unit}`.trim();
}

