// A run's report: how it ended, where its time went, who waited for whom, errors and warnings.
import { duration, element } from "./dom.js";

export function report(run) {
  const { status } = run;
  const node = element("div", { className: "report" }, element("b", { textContent: run.name }));
  if (!status) return node;
  const rows = [];
  const row = (name, text) => rows.push(element("tr", {}, element("th", { textContent: name }), element("td", { textContent: text })));
  if (status.case) row("case", [status.case, ...status.overrides].join(" ").replace(/\d+\.\d{12,}/g, (n) => Number(Number(n).toPrecision(12))));
  row("state", [status.state, status.started && `begun ${status.started}`, status.ended && `ended ${status.ended}`].filter(Boolean).join(", "));
  if (run.running) {
    const waits = Object.entries(run.waits()).map(([whom, share]) => `for the ${whom} ${Math.round(100 * share)} %`);
    if (waits.length) row("coupler waits", `${waits.join(", ")} of the times looked at`);
  }
  for (const { process, wall, seconds } of status.summaries) row(process, processWords(wall, seconds));
  node.append(element("table", {}, ...rows));
  const messages = [...status.messages].reverse();
  // The reason of a failure comes first, and only once.
  if (status.reason) messages.unshift({ kind: status.exit === 6 ? "warning" : "error", time: "", text: status.reason });
  const list = element("ul", { className: "messages" });
  for (const { kind, time, text } of messages) list.append(element("li", { className: kind, textContent: `${time ? `${time} ` : ""}${text}` }));
  if (messages.length) node.append(list);
  return node;
}

function processWords(wall, seconds) {
  const parts = Object.entries(seconds)
    .filter(([, s]) => s >= 0.005 * (wall || 1))
    .sort((a, b) => b[1] - a[1])
    .map(([name, s]) => `${name.replaceAll("_", " ")} ${wall ? `${Math.round((100 * s) / wall)} %` : duration(s)}`);
  return `${duration(wall ?? 0)}: ${parts.join(", ")}`;
}
