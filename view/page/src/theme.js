// Light or dark: as the system has it, until it is chosen here.

const dark = matchMedia("(prefers-color-scheme: dark)");
let changed = () => {};

function apply() {
  document.documentElement.dataset.theme = localStorage.getItem("theme") ?? (dark.matches ? "dark" : "light");
  changed();
}

export function followTheme(repaint) {
  apply();
  changed = repaint;
  dark.addEventListener("change", apply);
}

export function otherTheme() {
  localStorage.setItem("theme", document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  apply();
}
