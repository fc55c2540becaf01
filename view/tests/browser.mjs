// Common parts of the browser test and of the measurement of the first picture: playwright-core, Debian's Chromium, the server.
import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

export const here = path.dirname(fileURLToPath(import.meta.url));
export const python = "/usr/bin/python3";
const SOFTWARE_GRAPHICS = ["--no-sandbox", "--enable-unsafe-swiftshader"]; // WebGL without a graphics card

/// playwright-core in the version of the lock file, installed in the folder `place`.
function playwright(place) {
  fs.mkdirSync(place, { recursive: true });
  const lock = fs.readFileSync(path.join(here, "package-lock.json"));
  const done = path.join(place, "installed.json");
  if (!fs.existsSync(done) || !fs.readFileSync(done).equals(lock)) {
    for (const name of ["package.json", "package-lock.json"]) fs.copyFileSync(path.join(here, name), path.join(place, name));
    execFileSync("npm", ["ci", "--ignore-scripts", "--no-audit", "--no-fund"], { cwd: place, stdio: "pipe" });
    fs.writeFileSync(done, lock);
  }
  return createRequire(path.join(place, "package.json"))("playwright-core");
}

/// Starts a Chromium that draws without a graphics card.
export function launch(place, args = SOFTWARE_GRAPHICS) {
  return playwright(place).chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args });
}

/// Makes a run folder without a run: see made_run.py.
export function makeRun(folder, ...options) {
  execFileSync(python, [path.join(here, "made_run.py"), folder, ...options]);
}

/// Starts `poretwin view` on a folder of runs: {address, link, stop}; `link` is the newest valid link.
export async function serve(program, runs) {
  const server = spawn(program, ["view", runs, "--port", "0"], { stdio: ["ignore", "pipe", "inherit"] });
  let text = "";
  const links = () => [...text.matchAll(/(http:\S+)\?token=\S+/g)];
  await new Promise((done, failed) => {
    server.stdout.on("data", (piece) => {
      text += piece;
      if (links().length) done();
    });
    server.on("exit", () => failed(new Error(`poretwin view ended: ${text}`)));
  });
  const stop = () => {
    server.removeAllListeners("exit");
    server.kill("SIGINT");
  };
  return { address: links()[0][1], get link() { return links().at(-1)[0]; }, stop };
}

/// Opens a link; returns the seconds until the picture is drawn. Reading one of its pixels waits for all of it.
export async function firstPicture(page, link) {
  const start = performance.now();
  await page.goto(link);
  await page.evaluate(async () => {
    while (document.querySelector(".panel")?.dataset.drawn === undefined) await new Promise((done) => setTimeout(done, 5));
    const gl = document.querySelector(".panel canvas").getContext("webgl2");
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  });
  return (performance.now() - start) / 1000;
}
