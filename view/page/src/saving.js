// Saves pictures and animations of the page, with their annotations.
import { GIFEncoder, applyPalette, quantize } from "gifenc";
import { colourOf, download } from "./dom.js";
import { annotate } from "./notes.js";

const GIF_WIDTH = 900; // largest width, pixels
const SECONDS_OF_LAST = 1; // time for which the last frame is shown

/// All panels side by side, at most as wide as on the page, or `most` pixels.
export function compose(panels, most = Infinity) {
  const there = panels.filter((panel) => panel.stage);
  if (!there.length) throw new Error("there is no picture to save");
  const columns = there.length > 2 ? 2 : there.length;
  const [width, height] = [there[0].picture.clientWidth, there[0].picture.clientHeight];
  const rows = Math.ceil(there.length / columns);
  const ratio = Math.min(Math.min(window.devicePixelRatio, 2), most / (columns * width));
  const canvas = document.createElement("canvas");
  // Video formats require even numbers.
  [canvas.width, canvas.height] = [columns * width * ratio, rows * height * ratio].map((n) => 2 * Math.floor(n / 2));
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.fillStyle = colourOf("picture");
  context.fillRect(0, 0, canvas.width, canvas.height);
  for (const [i, panel] of there.entries()) {
    panel.stage.dirty = true;
    panel.paint();
    context.setTransform(ratio, 0, 0, ratio, (i % columns) * width * ratio, Math.floor(i / columns) * height * ratio);
    context.drawImage(panel.canvas, 0, 0, width, height);
    annotate(context, width, height, { ...panel.noteContent(), title: panel.run.name });
  }
  return canvas;
}

export async function savePicture(panels, name) {
  const blob = await new Promise((done) => compose(panels).toBlob(done, "image/png"));
  download(blob, `${name}.png`);
}

/// `frames`: their number; `go(i)` shows one and resolves when it is drawn; `told(i)` reports the progress, false: stop.
export async function saveGif(panels, name, { frames, go, told, perSecond }) {
  const gif = GIFEncoder();
  for (let i = 0; i < frames; ++i) {
    if (!told(i)) return;
    await go(i);
    const canvas = compose(panels, GIF_WIDTH);
    const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const palette = quantize(data, 256);
    gif.writeFrame(applyPalette(data, palette), width, height, { palette, delay: 1000 * (i === frames - 1 ? SECONDS_OF_LAST : 1 / perSecond) });
  }
  gif.finish();
  download(new Blob([gif.bytes()], { type: "image/gif" }), `${name}.gif`);
}

/// The browser records in real time, so that saving takes at least as long as the film.
export async function saveVideo(panels, name, { frames, go, told, perSecond }) {
  if (!window.MediaRecorder) throw new Error("this browser records no video; save a GIF");
  await go(0);
  const film = compose(panels);
  const context = film.getContext("2d");
  const stream = film.captureStream(0);
  const type = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"].find((kind) => MediaRecorder.isTypeSupported(kind));
  if (!type) throw new Error("this browser records no video; save a GIF");
  const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 12e6 });
  const pieces = [];
  recorder.ondataavailable = ({ data }) => pieces.push(data);
  const ended = new Promise((done) => (recorder.onstop = done));
  recorder.start();
  let stopped = false;
  for (let i = 0; i < frames && !stopped; ++i) {
    const due = performance.now() + 1000 * (i === frames - 1 ? SECONDS_OF_LAST : 1 / perSecond);
    stopped = !told(i);
    await go(i);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(compose(panels), 0, 0, film.width, film.height);
    stream.getVideoTracks()[0].requestFrame();
    await new Promise((done) => setTimeout(done, Math.max(0, due - performance.now())));
  }
  recorder.stop();
  await ended;
  if (!stopped) download(new Blob(pieces, { type }), `${name}.${type.includes("mp4") ? "mp4" : "webm"}`);
}
