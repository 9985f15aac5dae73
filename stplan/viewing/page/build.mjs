// Puts the page's modules, its style and three.js into one file that needs nothing else: built/page.html.
// The hash of the sources is in its first line, so that a test can tell whether it is up to date.

import { createHash } from "node:crypto";
import { copyFileSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const sources = readdirSync("source").sort().map((name) => `source/${name}`);
const hash = createHash("sha256");
for (const path of [...sources, "build.mjs", "package-lock.json"]) hash.update(readFileSync(path));

const { outputFiles } = await build({
  entryPoints: ["source/main.js"],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "inline",
  write: false,
});
const script = outputFiles[0].text.replaceAll("</script", "<\\/script");
const style = readFileSync("source/style.css", "utf8");
const page = readFileSync("source/page.html", "utf8")
  .replace("/* style */", () => style)
  .replace("/* script */", () => script);

mkdirSync("built", { recursive: true });
writeFileSync("built/page.html", `<!-- sources ${hash.digest("hex")} -->\n${page}`);
copyFileSync("node_modules/three/LICENSE", "built/three-license.txt");
