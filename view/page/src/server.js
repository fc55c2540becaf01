// Requests to the server, and to the worker that reads the files.

export async function ask(path) {
  let answer;
  try {
    answer = await fetch(path, { cache: "no-store" });
  } catch {
    throw new Error("the server does not answer: is `poretwin view` still running?");
  }
  if (answer.status === 403) throw new Error("the server was started anew: open the address it printed");
  const data = await answer.json();
  if (!answer.ok) throw new Error(data.error ?? `the server answered ${answer.status}`);
  return data;
}

const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
const waiting = new Map();
let number = 0;

worker.onmessage = ({ data }) => {
  const { done, failed } = waiting.get(data.id);
  waiting.delete(data.id);
  if (data.error === undefined) return done(data.result);
  const error = new Error(data.error);
  error.damaged = data.damaged;
  failed(error);
};
worker.onerror = () => {
  for (const { failed } of waiting.values()) failed(new Error("the reader of the files failed: load the page again"));
  waiting.clear();
};

export function read(operation, url, options = {}) {
  return new Promise((done, failed) => {
    waiting.set(++number, { done, failed });
    worker.postMessage({ id: number, operation, url, ...options });
  });
}
