// A file on the server, in the form that the HDF5 library in the worker reads: by synchronous HTTP range requests, since the
// library cannot wait. All ranges belong to one flush of the writer (If-Match); after another flush `failure` says so.

const BLOCK = 1 << 16;
const CACHE = 512; // blocks of all files together: 32 MiB
const AHEAD = 16; // blocks per request in sequential reads: a frame's data are contiguous

export class Changed extends Error {}

const cache = new Map(); // "file number:block" -> bytes, the most recently used last
let opened = 0;

function request(method, url, headers = {}) {
  const http = new XMLHttpRequest();
  http.open(method, url, false);
  http.responseType = "arraybuffer";
  for (const [name, value] of Object.entries(headers)) http.setRequestHeader(name, value);
  try {
    http.send();
  } catch {
    throw new Error("the server does not answer: is `poretwin view` still running?");
  }
  return http;
}

function complaint(http) {
  try {
    return JSON.parse(new TextDecoder().decode(http.response)).error;
  } catch {
    return `the server answered ${http.status}`;
  }
}

export class RangeFile {
  constructor(url) {
    this.url = url;
    this.number = ++opened;
    const http = request("HEAD", url);
    if (http.status === 404) throw new Error("there are no frames yet");
    if (http.status !== 200) throw new Error(`the server answered ${http.status}`);
    this.tag = http.getResponseHeader("ETag");
    this.length = Number(http.getResponseHeader("Content-Length"));
    this.failure = null;
  }

  /// Mounts it as a file of Emscripten's file system.
  mount(FS) {
    this.path = `/${this.number}.vtkhdf`;
    const node = FS.createFile("/", this.path.slice(1), {}, true, false);
    Object.defineProperty(node, "usedBytes", { get: () => this.length });
    node.stream_ops = {
      ...node.stream_ops,
      read: (stream, buffer, offset, count, position) => {
        try {
          return this.read(buffer, offset, count, position);
        } catch (error) {
          this.failure ??= error; // the library itself reports only an input/output error
          throw new FS.ErrnoError(29);
        }
      },
    };
    return this.path;
  }

  unmount(FS) {
    FS.unlink(this.path);
    for (const key of cache.keys()) if (key.startsWith(`${this.number}:`)) cache.delete(key);
  }

  read(buffer, offset, count, position) {
    const end = Math.min(position + count, this.length);
    if (position >= end) return 0;
    const last = Math.floor((end - 1) / BLOCK);
    for (let block = Math.floor(position / BLOCK); block <= last; ++block) {
      const bytes = this.block(block, last);
      const from = Math.max(position - block * BLOCK, 0);
      const to = Math.min(end - block * BLOCK, bytes.length);
      buffer.set(bytes.subarray(from, to), offset + block * BLOCK + from - position);
    }
    return end - position;
  }

  /// One block. Missing blocks up to `last` are requested with it, and more in sequential reads.
  block(block, last) {
    const key = `${this.number}:${block}`;
    const there = cache.get(key);
    if (there) {
      cache.delete(key);
      cache.set(key, there);
      return there;
    }
    let missing = block;
    if (cache.has(`${this.number}:${block - 1}`)) last = Math.max(last, block + AHEAD - 1);
    last = Math.min(last, Math.floor((this.length - 1) / BLOCK));
    while (missing < last && !cache.has(`${this.number}:${missing + 1}`)) ++missing;
    const first = block * BLOCK;
    const http = request("GET", this.url, {
      Range: `bytes=${first}-${Math.min((missing + 1) * BLOCK, this.length) - 1}`,
      "If-Match": this.tag,
    });
    if (http.status === 412) throw new Changed();
    if (http.status !== 206) throw new Error(complaint(http));
    const bytes = new Uint8Array(http.response);
    for (let at = 0; at < bytes.length; at += BLOCK)
      cache.set(`${this.number}:${block + at / BLOCK}`, bytes.slice(at, at + BLOCK));
    const result = cache.get(key);
    while (cache.size > CACHE) cache.delete(cache.keys().next().value);
    return result;
  }
}
