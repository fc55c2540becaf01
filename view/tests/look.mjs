// Opens the link that `poretwin view` printed in a browser, and prints how long the first picture took: look.mjs FOLDER LINK.
// Without LINK it only prepares FOLDER, which keeps playwright-core.
import path from "node:path";
import { firstPicture, launch } from "./browser.mjs";

const [place, link] = process.argv.slice(2);
const browser = await launch(path.resolve(place));
if (link) {
  const page = await browser.newPage();
  const seconds = await firstPicture(page, link);
  console.log(`${await page.locator(".panel canvas").first().getAttribute("aria-label")}; first picture after ${seconds.toFixed(2)} s`);
}
await browser.close();
