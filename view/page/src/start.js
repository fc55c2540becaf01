// The worker that reads files first: it loads its library while the page itself, which is larger, is still on its way.
import "./server.js";

import("./main.js");
