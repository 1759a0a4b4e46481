// A browser for the tests: Debian's chromium, headless, with WebGL in software.
import { existsSync, mkdirSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((each) => existsSync(each));

export async function launch() {
  if (!executablePath) throw new Error("no chromium here: apt-get install chromium");
  return chromium.launch({ executablePath, headless: true, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking"] });
}

/** Pictures of what tests saw, to be looked at. */
export const shots = fileURLToPath(new URL("../../../../target/studio-shots/", import.meta.url));
mkdirSync(shots, { recursive: true });

/** Faults of a page, as they come. */
export function faults(page) {
  const found = [];
  page.on("pageerror", (error) => found.push(error.message));
  page.on("console", (message) => message.type() === "error" && found.push(message.text()));
  return found;
}
