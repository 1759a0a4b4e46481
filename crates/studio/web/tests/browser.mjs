// A browser for the tests: Debian's chromium, headless, or with BROWSER=firefox its Firefox, which needs a display for
// WebGL (xvfb-run); both draw in software.
import { existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import playwright from "playwright-core";

const isFirefox = process.env.BROWSER === "firefox";

const downloads = mkdtempSync(join(tmpdir(), "wireloom-downloads-"));

export async function launch() {
  const names = isFirefox ? ["firefox-esr", "firefox"] : ["chromium", "chromium-browser", "google-chrome"];
  const executablePath = names.map((name) => `/usr/bin/${name}`).find((path) => existsSync(path));
  if (!executablePath) throw new Error(`no ${names[0]} here: apt-get install ${names[0]}`);
  // Playwright's own Firefox is a changed one; by WebDriver BiDi it drives any.
  if (isFirefox) {
    // It does not start as root in a home of somebody else.
    const env = { ...process.env, HOME: mkdtempSync(join(tmpdir(), "wireloom-home-")) };
    return playwright._bidiFirefox.launch({ executablePath, headless: false, env, firefoxUserPrefs: { "browser.download.folderList": 2, "browser.download.dir": downloads } });
  }
  return playwright.chromium.launch({ executablePath, headless: true, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking"] });
}

// Playwright asks a page by eval. Chromium lets its driver, Firefox goes by the policy of the page: there pages are given
// without theirs, and one test looks at a page that has it.
const withoutPolicy = (html) => html.replace(/<meta http-equiv="Content-Security-Policy"[^>]*>/, "");

/** A page, as wide as a screen. */
export async function newPage(browser, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, ...options });
  if (isFirefox) {
    // It draws more slowly.
    page.setDefaultTimeout(120_000);
    await page.route(/^http/, async (route) => {
      if (!route.request().isNavigationRequest()) return route.continue();
      const response = await route.fetch();
      return route.fulfill({ response, body: withoutPolicy(await response.text()) });
    });
  }
  return page;
}

/** Address of a page that lies in a file. */
export function local(file) {
  if (isFirefox) writeFileSync(file, withoutPolicy(readFileSync(file, "utf8")));
  return `file://${file}`;
}

/** Path of the file that a page saves for the user when this is done; Firefox tells its driver nothing of it. */
export async function downloaded(page, act) {
  if (!isFirefox) {
    const [download] = await Promise.all([page.waitForEvent("download"), act()]);
    const file = join(downloads, download.suggestedFilename());
    await download.saveAs(file);
    return file;
  }
  const before = readdirSync(downloads);
  await act();
  for (let waits = 0; waits < 600; waits++) {
    const [name] = readdirSync(downloads).filter((name) => !before.includes(name));
    const written = name && readdirSync(downloads).every((each) => !each.endsWith(".part"));
    if (written && readFileSync(join(downloads, name)).length) return join(downloads, name);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  throw new Error("the page has saved no file within 30 s");
}

/** Pictures of what tests saw, to be looked at. */
export const shots = fileURLToPath(new URL(`../../../../target/${isFirefox ? "firefox" : "studio"}-shots/`, import.meta.url));
mkdirSync(shots, { recursive: true });

/** Faults of a page, as they come. */
export function faults(page) {
  const found = [];
  page.on("pageerror", (error) => found.push(error.message));
  page.on("console", (message) => message.type() === "error" && found.push(message.text()));
  return found;
}

/** How many pixels of a picture are magenta (over a limit), orange (destroyed), and not grey. */
export async function pixels(browser, png) {
  const page = await newPage(browser);
  const counts = await page.evaluate(async (address) => {
    const image = new Image();
    image.src = address;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
    const counts = { magenta: 0, orange: 0, coloured: 0, width: image.width };
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
      if (r > 150 && g < 60 && b > 70) counts.magenta++;
      if (r > 170 && g > 60 && g < 150 && b < 40) counts.orange++;
      if (Math.max(r, g, b) - Math.min(r, g, b) > 60) counts.coloured++;
    }
    return counts;
  }, `data:image/png;base64,${png.toString("base64")}`);
  await page.close();
  return counts;
}

/** Waits until what has changed is drawn. */
export const settled = (page) => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(resolve, 50)))));

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** What axe finds by WCAG 2, levels A and AA, with the first places of each. */
export async function axed(page) {
  await page.evaluate(axe);
  return page.evaluate(async () => (await window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa"] })).violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.target.join(" ")).slice(0, 4).join("; ")}`));
}

/** Words whose contrast with what is behind them is below 4.5 (WCAG 2): every leaf with words in it. */
export const poorContrast = (page) =>
  page.evaluate(() => {
    const context = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const parse = (colour) => {
      context.clearRect(0, 0, 1, 1);
      context.fillStyle = colour;
      context.fillRect(0, 0, 1, 1);
      return [...context.getImageData(0, 0, 1, 1).data].map((x) => x / 255);
    };
    const over = (top, under) => top.slice(0, 3).map((x, i) => x * top[3] + under[i] * (1 - top[3]));
    const light = (colour) => {
      const [r, g, b] = colour.map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const behind = (element) => {
      const layers = [];
      for (let each = element; each; each = each.parentElement) layers.push(parse(getComputedStyle(each).backgroundColor));
      return layers.reverse().reduce((under, top) => over(top, under), [1, 1, 1]);
    };
    return [...document.querySelectorAll("header *, aside *, footer *, #tools *, #legend *, #labels *, #warning *")]
      .filter((each) => each.checkVisibility() && !each.disabled && [...each.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim()))
      // Words that are not drawn, such as the names of steps that are too short for them.
      .filter((each) => parse(getComputedStyle(each).color)[3] > 0)
      .map((each) => {
        const style = getComputedStyle(each);
        const back = behind(each);
        const ink = over(parse(each instanceof SVGElement ? style.fill : style.color), back);
        const [a, b] = [light(ink), light(back)].sort((x, y) => y - x);
        return { words: each.textContent.slice(0, 30), ratio: (a + 0.05) / (b + 0.05) };
      })
      .filter(({ ratio }) => ratio < 4.5);
  });
