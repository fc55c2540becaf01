// All fields of the selected particle.
import { byId, element } from "./dom.js";
import { componentNames, label, shown, unitOf, withUnit } from "./fields.js";
import { read } from "./server.js";

function fill(...nodes) {
  byId("particle").replaceChildren(element("legend", { textContent: "Particle" }), ...nodes);
}

const hint = (textContent) => fill(element("p", { className: "hint", textContent }));

let asked = 0;

/// `picked`: {panel, phase, index}, or null.
export async function showParticle(picked) {
  const mine = ++asked;
  if (!picked) return hint("Click a particle for all its fields.");
  const { panel, phase, index } = picked;
  const frame = panel.frames[phase];
  if (!frame || index >= frame.radius.length) return hint("The picked particle is not in this frame.");
  let particle;
  try {
    particle = await read("particle", panel.run.url(`${phase}.vtkhdf`), { step: frame.step, index });
  } catch (error) {
    if (mine === asked) fill(element("p", { className: "error", textContent: error.message }));
    return;
  }
  if (mine !== asked) return; // another particle was selected meanwhile
  const rows = particle.fields.flatMap((field) =>
    componentNames(field.components).map((part, i) =>
      element("tr", { title: field.description }, element("th", { textContent: label(field.name, part) }),
        element("td", { className: "number", textContent: withUnit(Number(field.values[i]), unitOf(field)) }))));
  const place = particle.position.map((x) => shown(x)).join(", ");
  fill(element("p", { className: "soft", textContent: `number ${index} of the ${phase} in ${panel.run.name}, at (${place}) m` }), element("table", {}, ...rows));
}
