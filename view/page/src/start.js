// Starts the worker that reads files first: it loads its library while the page, which is larger, is still being transferred.
import "./server.js";

import("./main.js");
