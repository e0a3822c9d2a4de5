// Judges GLB files with the Khronos validator. Prints one line of JSON for each file named ("-" is the
// standard input): {"file": ..., "issues": [...]}, every issue with its severity (0 error, 1 warning,
// 2 information, 3 hint), code, message and JSON pointer.
import { readFileSync } from "node:fs";
import { validateBytes } from "gltf-validator";

for (const file of process.argv.slice(2)) {
  const bytes = new Uint8Array(readFileSync(file === "-" ? 0 : file));
  const report = await validateBytes(bytes, { format: "glb", maxIssues: 0, writeTimestamp: false });
  console.log(JSON.stringify({ file, issues: report.issues.messages }));
}
