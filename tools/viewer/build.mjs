// Writes src/cablewright/apps/web/viewer/viewer.js and the licence of three.js beside it: `npm ci && node build.mjs`.
// The versions in package-lock.json decide the bytes; `node build.mjs --check` fails where the committed file differs.
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, "../../src/cablewright/apps/web/viewer");
const version = JSON.parse(readFileSync(join(here, "node_modules/three/package.json"), "utf8")).version;
const made = await build({
  absWorkingDir: here,
  entryPoints: ["src/main.js"],
  alias: { three: "./node_modules/three/src/Three.js" }, // the sources, of which esbuild keeps what is used
  banner: { js: `/* Built by tools/viewer/build.mjs. Contains three.js ${version}, MIT: see LICENSE-three.txt */` },
  bundle: true,
  charset: "ascii",
  define: { __THREE_DEVTOOLS__: "undefined" },
  format: "iife",
  legalComments: "none",
  minify: true,
  target: "es2022",
  write: false,
});
const files = {
  "viewer.js": made.outputFiles[0].text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--"),
  "LICENSE-three.txt": readFileSync(join(here, "node_modules/three/LICENSE"), "utf8"),
};
let different = false;
for (const [name, text] of Object.entries(files)) {
  const path = join(target, name);
  if (!process.argv.includes("--check")) writeFileSync(path, text);
  else if (readFileSync(path, "utf8") !== text) { different = true; console.error(`${path} is not what the sources give`); }
  console.log(`${name}: ${text.length} bytes`);
}
process.exit(different ? 1 : 0);
