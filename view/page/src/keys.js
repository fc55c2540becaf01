// The keyboard: all that the mouse can do.

export const keyList = [
  ["space", "play, pause"],
  ["← →", "one frame back, on"],
  ["Home End", "first, last frame"],
  ["Shift + arrows", "pan (2D), turn (3D)"],
  ["+ −", "closer, farther"],
  ["R", "show all of it"],
  ["F S", "fluid, solid on or off"],
  ["C", "clip plane: none, x, y, z"],
  ["X", "pick the particle in the middle of the first picture"],
  ["P", "save the picture"],
  ["L", "copy a link to this view"],
  ["T", "light, dark"],
  ["Esc", "forget the particle, close menus, stop saving"],
];

const STEP = 0.06; // fraction of the picture
const ZOOM = 1.25;

export function listenToKeys(actions) {
  const keys = {
    " ": actions.play, ArrowLeft: actions.back, ArrowRight: actions.on, Home: actions.first, End: actions.last,
    "+": () => actions.move(0, 0, ZOOM), "=": () => actions.move(0, 0, ZOOM), "-": () => actions.move(0, 0, 1 / ZOOM),
    r: actions.fit, f: actions.fluid, s: actions.solid, c: actions.clip, x: actions.pick, p: actions.picture, l: actions.link, t: actions.theme,
    "?": actions.help, Escape: actions.escape,
  };
  const moves = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP] };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
    // Keys typed into an input belong to it; a slider keeps the arrow keys, a button the space bar.
    const tag = event.target.tagName;
    const typing = tag === "SELECT" || (tag === "INPUT" && event.target.type !== "checkbox") || tag === "TEXTAREA";
    if (typing && event.key !== "Escape") return;
    if ((tag === "BUTTON" || tag === "SUMMARY" || tag === "INPUT") && (event.key === " " || event.key === "Enter")) return;
    const move = event.shiftKey && moves[event.key];
    const act = move ? () => actions.move(...move, 1) : keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
