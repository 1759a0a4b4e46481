// Makes dist/index.html: the page with its script and style in it, equal bytes from equal sources. `--check` only compares.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync, mkdirSync } from "node:fs";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
const place = new URL("dist/index.html", here);

async function bundled(entry) {
  const result = await build({
    entryPoints: [entry],
    absWorkingDir: decodeURIComponent(here.pathname),
    bundle: true,
    write: false,
    minify: true,
    charset: "utf8",
    format: "iife",
    target: "es2022",
    legalComments: "eof",
    logLevel: "warning",
  });
  return result.outputFiles[0].text.trimEnd();
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

const script = await bundled("src/main.ts");
const style = await bundled("src/page.css");
const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; connect-src 'self'; img-src data: blob:; base-uri 'none'; form-action 'none'`;
const page = readFileSync(new URL("src/page.html", here), "utf8")
  .replace("POLICY", () => policy)
  .replace("/* STYLE */", () => style)
  .replace("/* SCRIPT */", () => script);

if (process.argv.includes("--check")) {
  if (readFileSync(place, "utf8") !== page) {
    console.error("dist/index.html is not what these sources make: run npm run build and commit it");
    process.exit(1);
  }
} else {
  mkdirSync(new URL("dist/", here), { recursive: true });
  writeFileSync(place, page);
  console.log(`dist/index.html: ${page.length} characters`);
}
