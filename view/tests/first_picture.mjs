// Measures the time to the first picture of a frame with 100,000 particles: first_picture.mjs PROGRAM FOLDER [REPEATS]. Each
// repeat starts a new Chromium without a graphics card and with empty caches; the time runs from opening the link until pixels of
// the picture can be read, so that it includes drawing. FOLDER keeps playwright-core and the run made here.
import fs from "node:fs";
import path from "node:path";
import { firstPicture, launch, makeRun, serve } from "./browser.mjs";

const [program, place] = process.argv.slice(2, 4).map((name) => path.resolve(name));
const repeats = Number(process.argv[4] ?? 5);
const SETTLED = 1000; // ms until a browser that has just started is idle

/// CPU seconds of the child processes: the browser and the server.
function cpuSeconds() {
  const parents = new Map();
  const ticks = new Map();
  for (const pid of fs.readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const fields = fs.readFileSync(`/proc/${pid}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
      parents.set(pid, fields[1]);
      ticks.set(pid, Number(fields[11]) + Number(fields[12]));
    } catch {
      // it has ended meanwhile
    }
  }
  const ours = (pid) => pid !== undefined && (parents.get(pid) === String(process.pid) || ours(parents.get(pid)));
  return [...ticks].reduce((sum, [pid, used]) => sum + (ours(pid) ? used : 0), 0) / 100;
}

async function measure(server) {
  const browser = await launch(place);
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
  await page.goto("about:blank");
  await page.waitForTimeout(SETTLED);
  const before = cpuSeconds();
  const wall = await firstPicture(page, server.link);
  const result = { wall, cpu: cpuSeconds() - before };
  await browser.close();
  return result;
}

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];
const line = ({ wall, cpu }) => `${wall.toFixed(2)} s, ${cpu.toFixed(2)} CPU s`;

const runs = path.join(place, "first_picture");
makeRun(path.join(runs, "large"), "100000", "2");
const server = await serve(program, runs);
const results = [];
for (let i = 0; i < repeats; ++i) {
  results.push(await measure(server));
  console.log(line(results.at(-1)));
}
console.log(`median of ${repeats}: ${line(Object.fromEntries(Object.keys(results[0]).map((key) => [key, median(results.map((r) => r[key]))])))}`);
server.stop();
