// Light or dark theme: the system's, until one is chosen on the page.

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
